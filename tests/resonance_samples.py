"""Models of internal resonance that the tests share."""

from dataclasses import replace
from functools import cache

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import cabledrive as cd
from cabledrive.reduction.autoparametric import AutoparametricModel, at_pretension, autoparametric_model
from cabledrive.reduction.averaging import averaged_coefficients
from cabledrive.reduction.transverse_sections import TransverseMode
from cabledrive.studies.resonance import resonance
from network_samples import without_gravity

TUNED = cd.load_drive(
    "dissertation-2", overrides=["cable.pretension=3.2837727209", "layout.gravity=0"]
).listed
LOAD_SHARE = 1.3043e5
"""c_q per viscous friction of the load pulley [1/s / (N m s)]."""


def damped(transverse, pulley, drive=TUNED):
    """The tuned drive with Gamma and c_q [1/s], the latter by friction at the load pulley."""
    load = replace(drive.load_pulley, viscous_friction=pulley / LOAD_SHARE)
    cable = replace(drive.cable, transverse_damping=transverse)
    return replace(drive, cable=cable, pulley=(drive.drive_pulley, load))


def bare_model(modes=1, **changes):
    """Oscillators of unit masses: W = 2, w = 1, G = 1, no cubic terms, no damping."""
    signs = np.array([1.0, -1.0] * modes)[:modes]
    fields = dict(
        natural=2.0,
        modal_mass=1.0,
        modal_damping=0.0,
        rims=(0.0, 1.0),
        torque_arm=1.0,
        rigid_arm=0.0,
        rigid_mass=np.inf,
        rigid_damping=0.0,
        cross_damping=0.0,
        coulomb_force=0.0,
        modes=tuple(
            TransverseMode(span="upper", plane="w", section=(0.0, 1.0), number=1) for _ in range(modes)
        ),
        transverse=np.ones(modes),
        transverse_mass=np.ones(modes),
        transverse_damping=0.0,
        cable_share=np.ones(modes),
        coupling=signs,
        stiffening=np.zeros((modes, modes)),
        slack_amplitude=1.0,
        uneven=np.zeros(modes),
        load_radius=1.0,
        pretension=1.0,
        axial_rigidity=100.0,
        tension_offset=np.zeros(modes),
    )
    return AutoparametricModel(**(fields | changes))


def settings(transverse, pulley, pulley_detuning, transverse_detuning, force, cubic=True):
    """Averaged coefficients of configuration 2 with given dampings, detunings [1/s] and f [m/s], no drift."""
    c = _tuned_coefficients()
    share = 1.0 if cubic else 0.0
    return c._replace(
        transverse_damping=np.array([transverse, transverse]),
        damping=np.array(pulley),
        detuning=np.array(pulley_detuning),
        transverse_detuning=np.array([transverse_detuning, transverse_detuning]),
        force=np.array(force + 0j),
        cubic=share * c.cubic,
        static=share * c.static,
    )


@cache
def _tuned_coefficients():
    return averaged_coefficients(autoparametric_model(TUNED), torque=0.01, drift=False)


def one_span(c):
    """The same coefficients without the second section."""
    single = ("feedback", "pump", "drift", "transverse_detuning", "transverse_damping")
    cut = {name: getattr(c, name)[:1] for name in single}
    return c._replace(**cut, cubic=c.cubic[:1, :1], static=c.static[:1, :1])


def settings_pair(c):
    """Coefficients of two equal spans, whatever round-off makes of their detunings."""
    mean = np.full(2, float(np.mean(c.transverse_detuning)))
    return c._replace(force=np.abs(c.force) + 0j, transverse_detuning=mean)


def at_detunings(drive, transverse, pulley):
    """The drive at a pretension, and a forcing frequency, with given detunings [rad/s]."""
    model = autoparametric_model(drive)
    natural = model.natural
    forcing = brentq(lambda f: (natural**2 - f**2) / (2 * f) - pulley, 0.5 * natural, 1.5 * natural)
    wanted = np.sqrt(forcing**2 / 4 + forcing * transverse)
    tension = brentq(lambda t: at_pretension(model, t).transverse[0] - wanted, 1.0, 8.0)
    return replace(drive, cable=replace(drive.cable, pretension=tension)), forcing


def floquet(stiffness, damping, period):
    """Largest multiplier of a'' + damping a' + stiffness(t) a = 0 over a period."""

    def rates(t, y):
        return [y[1], -damping * y[1] - stiffness(t) * y[0], y[3], -damping * y[3] - stiffness(t) * y[2]]

    end = solve_ivp(rates, (0, period), [1, 0, 0, 1], rtol=1e-12, atol=1e-14, method="DOP853").y[:, -1]
    return np.max(np.abs(np.linalg.eigvals(end.reshape(2, 2))))


def real(state):
    return np.concatenate((state.real, state.imag))


def complex_of(x):
    return x[: x.size // 2] + 1j * x[x.size // 2 :]


def damped_loop():
    """The rig of the resonance near its tuning, with viscous losses only."""
    drive = without_gravity(cd.load_drive("dissertation-2").listed)
    tuned = resonance(drive).tuned_pretension
    cable = replace(drive.cable, pretension=1.004 * tuned, transverse_damping=2.0, axial_damping=0.02)
    pulleys = tuple(replace(pulley, viscous_friction=2e-5, coulomb_friction=0.0) for pulley in drive.pulley)
    return replace(drive, cable=cable, pulley=pulleys)


def averaged_step(slow, state, t, h):
    """State of the averaged equations a step of Runge and Kutta after the instant t."""
    one = slow.rates(state, t)
    two = slow.rates(state + 0.5 * h * one, t + 0.5 * h)
    three = slow.rates(state + 0.5 * h * two, t + 0.5 * h)
    four = slow.rates(state + h * three, t + h)
    return state + h / 6 * (one + 2 * two + 2 * three + four)


def envelope(signal, window=250):
    """Peaks of windows of two forcing periods, linear trend removed."""
    x = np.linspace(-1.0, 1.0, signal.size)
    flat = np.abs(signal - np.polyval(np.polyfit(x, signal, 1), x))
    return flat[: flat.size // window * window].reshape(-1, window).max(axis=1)
