"""Runs behind the figures of chapter 5: forced, swept and free response at the tuned pretension."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cabledrive.modal.tuning import tuned_pretension
from cabledrive.parameters import Drive
from cabledrive.reduction.autoparametric import autoparametric_model
from cabledrive.reduction.averaging import averaged_coefficients
from cabledrive.reduction.threshold import pulley_amplitude
from cabledrive.simulation import Pluck, Recording, Scheme, SimulationResult, Sine, Start, simulate
from cabledrive.simulation.run import whole
from reproduction.averaged_against_exact import (
    ForcedCase,
    averaged_motion,
    disagreement,
    envelope,
    exact_motion,
)
from reproduction.exchange import exchange_period, largest_exchange
from reproduction.tension_sweep import Sweep, onset, onset_by_growth_integral, swept_amplitude

Array = NDArray[np.float64]

GAMMA, PULLEY_DAMPING = 1.0, 4.0
"""Dampings of the figures [1/s]: estimates, none is printed for configuration 2."""

TORQUE = 0.02
PLUCKS = (2e-3, 1e-3)
FREE_PLUCKS = (3e-3, 1e-3)
SWEEP_RATE, FLOOR, LEVEL = 1.0, 1e-5, 1e-3


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ForcedResponse:
    """Figs. 5.4 and 5.6: load angle and midpoint under the torque, by the exact loop.

    Attributes
    ----------
    time, load_angle, midpoint : ndarray, shape (n,)
        [s], [rad], [m].
    errors : (float, float)
        Disagreement of the averaged equations, load angle and midpoint.
    fallen : float
        Lowest value of the load angle's envelope after its peak, over the peak: what the cable has taken.
    """

    time: Array
    load_angle: Array
    midpoint: Array
    errors: tuple[float, float]
    fallen: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SweptResponse:
    """Fig. 5.5: amplitude while the tension rises slowly, from a stated floor.

    Attributes
    ----------
    ratio, amplitude : ndarray, shape (n,)
        Frequency ratio gamma, and [m].
    edge, predicted, found : float
        Gamma at the edge of the instability region, and at the onset by growth integral and by Hill's
        equation.
    """

    ratio: Array
    amplitude: Array
    edge: float
    predicted: float
    found: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FreeResponse:
    """Fig. 5.7: load angle and midpoints after unequal plucks, by the exact loop, with the shares of energy.

    Attributes
    ----------
    time, load_angle : ndarray, shape (n,)
    midpoints : ndarray, shape (2, n)
        Upper and lower [m].
    shares : dict of str to ndarray, shape (m,)
        Of the energy above rest: "upper span", "lower span", "pulleys and along the cable"; means over 50 ms.
    share_time : ndarray, shape (m,)
    period, stroke : float
        Closed form without damping [s], [rad].
    """

    time: Array
    load_angle: Array
    midpoints: Array
    shares: dict[str, Array]
    share_time: Array
    period: float
    stroke: float


def tuned_drive(drive: Drive) -> Drive:
    """The drive at its tuned pretension, without weight, with the dampings of the figures.

    ``drive``: a loop without carriages, such as configuration 2.
    """
    cable = replace(drive.cable, pretension=tuned_pretension(drive), transverse_damping=GAMMA)
    still = replace(drive, cable=cable, layout=replace(drive.layout, gravity=0.0))
    model = autoparametric_model(still)
    load = drive.load_pulley
    friction = PULLEY_DAMPING * model.modal_mass * (load.radius / model.rims[1]) ** 2
    return replace(still, pulley=(drive.drive_pulley, replace(load, viscous_friction=friction)))


def forced_response(drive: Drive, duration: float = 2.0) -> ForcedResponse:
    """Torque at the pulley mode's frequency, triangular plucks, as in Sections 5.2.1 and 5.2.2.

    ``drive``: of `tuned_drive`; ``duration`` [s].
    """
    case = ForcedCase(drive=drive, torque=TORQUE, plucks=PLUCKS, duration=duration, shape="triangle")
    seen = exact_motion(case, segments=100, rate=3000.0)
    window = 4 * np.pi / autoparametric_model(drive).natural
    load = envelope(seen.time, seen.load_angle, window)
    peak = int(np.argmax(load))
    return ForcedResponse(
        time=seen.time,
        load_angle=seen.load_angle,
        midpoint=seen.midpoint,
        errors=disagreement(case, seen, averaged_motion(case, seen.time)),
        fallen=float(np.min(load[peak:]) / load[peak]),
    )


def swept_response(drive: Drive) -> SweptResponse:
    """Slow rise of the tension through the tuning while the torque goes on, as in Fig. 5.5.

    ``drive``: of `tuned_drive`.
    """
    c = averaged_coefficients(autoparametric_model(drive), torque=TORQUE, drift=False)
    sweep = Sweep(
        pumping=float(abs(c.pump[0]) * pulley_amplitude(c)),
        damping=GAMMA,
        rate=SWEEP_RATE,
        floor=FLOOR,
        level=LEVEL,
        half_forcing=0.5 * float(c.forcing),
    )
    detuning, amplitude = swept_amplitude(sweep)

    def _ratio(delta: float | Array) -> Array:
        nu = sweep.half_forcing
        return np.asarray(np.sqrt(nu**2 + 2 * nu * np.asarray(delta)) / (2 * nu))

    return SweptResponse(
        ratio=_ratio(detuning),
        amplitude=amplitude,
        edge=float(_ratio(sweep.entry)),
        predicted=float(_ratio(onset_by_growth_integral(sweep))),
        found=float(_ratio(onset(detuning, amplitude, sweep.level))),
    )


def free_response(drive: Drive, duration: float = 1.5) -> FreeResponse:
    """Both spans plucked unequally and let go, as in Section 5.3.

    ``drive``: of `tuned_drive`; ``duration`` [s].
    """
    plucks = tuple(Pluck(height=a, span=s) for a, s in zip(FREE_PLUCKS, ("upper", "lower"), strict=True))
    result = whole(
        simulate(
            drive,
            duration,
            torque=Sine(amplitude=0.0, frequency=1.0),
            start=Start(plucks=plucks),
            scheme=Scheme(segments=100),
            recording=Recording(rate=3000.0),
        )
    )
    model = autoparametric_model(drive)
    first_sines = 8 / np.pi**2 * np.array(FREE_PLUCKS)
    share_time, shares = _shares(result)
    return FreeResponse(
        time=result.time,
        load_angle=result.channel("load_angle"),
        midpoints=np.array([result.midpoint(span)[:, 2] for span in ("upper", "lower")]),
        shares=shares,
        share_time=share_time,
        period=exchange_period(model, *first_sines),
        stroke=largest_exchange(model, *first_sines) * abs(model.rims[1]) / model.load_radius,
    )


def _shares(result: SimulationResult, width: float = 0.05) -> tuple[Array, dict[str, Array]]:
    """Means over windows; a transverse mode holds as much energy in strain as in motion."""
    per = round(width / (result.time[1] - result.time[0]))
    whole = result.time.size // per

    def _mean(x: Array) -> Array:
        return np.asarray(x[: whole * per].reshape(whole, per).mean(axis=1))

    upper, lower = (2 * _mean(result.channel(f"transverse_energy_{span}")) for span in ("upper", "lower"))
    parts = ("axial_energy_upper", "axial_energy_lower", "drive_energy", "load_energy")
    along = 2 * sum(_mean(result.channel(name)) for name in parts)
    total = upper + lower + along
    names = ("upper span", "lower span", "pulleys and along the cable")
    return _mean(result.time), {
        name: part / total for name, part in zip(names, (upper, lower, along), strict=True)
    }
