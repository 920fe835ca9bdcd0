r"""The averaged equations beside the exact loop: the same motion by both, and their difference.

Free exchange in closed form: two plucks a > b in one plane, no damping, tuned. With A, B the amplitudes of
the spans, AB stays and half the logarithm of A/B swings in a well of hyperbolic cosine: the spans swap their
amplitudes and swap them back.
"""

from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import numpy as np
from scipy.integrate import solve_ivp
from scipy.special import ellipk

from cabledrive.parameters import Drive
from cabledrive.parameters.arrays import Array, Complex
from cabledrive.reduction.autoparametric import AutoparametricModel, autoparametric_model
from cabledrive.reduction.averaging import (
    AveragedCoefficients,
    averaged_coefficients,
    averaged_rates,
    plucked,
    reconstruct,
    triangle_stretch,
)
from cabledrive.simulation import Pluck, Recording, Scheme, Sine, Start, simulate
from cabledrive.simulation.run import whole

HARMONICS = np.arange(3, 40, 2)
FIRST_SINE = 8 / np.pi**2  # of a triangle of height one


@dataclass(frozen=True, slots=True, kw_only=True)
class ForcedCase:
    """A forced motion of a loop without carriages from plucks."""

    drive: Drive
    torque: float  # amplitude [N m]
    plucks: tuple[float, float]  # of the upper and the lower span [m]
    duration: float = 1.0  # [s]
    shape: Literal["half-sine", "triangle"] = "half-sine"
    forcing: float | None = None  # Omega [rad/s]; the pulley mode's own unless given

    @property
    def omega(self) -> float:
        """Angular frequency of the torque [rad/s]."""
        return self.forcing or autoparametric_model(self.drive).natural


class SeenMotion(NamedTuple):
    """What the rig would show, each of shape (n,)."""

    time: Array  # [s]
    load_angle: Array  # [rad]
    midpoint: Array  # of the upper span, in w [m]


def exact_motion(case: ForcedCase, segments: int = 200, rate: float = 4000.0) -> SeenMotion:
    """The motion of the nonlinear loop itself; ``segments`` per span, ``rate`` of the records [Hz]."""
    heights = (pair for pair in zip(case.plucks, ("upper", "lower"), strict=True) if pair[0] != 0.0)
    start = Start(plucks=tuple(Pluck(height=height, span=span, shape=case.shape) for height, span in heights))
    torque = Sine(amplitude=case.torque, frequency=case.omega / (2 * np.pi))
    scheme, recorded = Scheme(segments=segments), Recording(rate=rate)
    run = simulate(case.drive, case.duration, torque=torque, start=start, scheme=scheme, recording=recorded)
    result = whole(run)
    angle, midpoint = result.channel("load_angle"), result.midpoint("upper")[:, 2]
    return SeenMotion(time=result.time, load_angle=angle, midpoint=midpoint)


def averaged_motion(case: ForcedCase, time: Array, *, second: bool = True) -> SeenMotion:
    """The same motion at times (n,) [s] by the averaged equations and the rigid rotation, Eq. (A.21)."""
    model, plucks = autoparametric_model(case.drive, number=1), np.array(case.plucks)
    passive = triangle_stretch(plucks) if case.shape == "triangle" else np.zeros(2)
    first = plucks * (FIRST_SINE if case.shape == "triangle" else 1.0)
    c = averaged_coefficients(model, torque=case.torque, forcing=case.forcing, passive=passive)
    start = plucked(c, first, second=second)
    state = averaged_history(c, start, time, second=second)
    lanes = averaged_coefficients(model, torque=[case.torque], forcing=case.forcing, passive=passive)
    motion = reconstruct(lanes, state, time, second=second)  # type: ignore[arg-type]  # one time a lane
    across = motion.a[0]
    if case.shape == "triangle":
        size = np.abs(state[1:]) ** 2 + passive[:, None] * np.exp(-c.transverse_damping[:, None] * time)
        across = across + _harmonics(case.plucks[0], model, c, time, size, state[0])
    # the rigid rotation under a sine that starts at t = 0; the pulley mode's friction is left out
    decay, speed = model.rigid_damping / model.rigid_mass, case.torque * model.rigid_arm / model.rigid_mass
    drift = -np.expm1(-decay * time) / decay if decay > 0.0 else time
    rim = model.rims[1] * motion.q + speed / case.omega * (drift - np.sin(case.omega * time) / case.omega)
    return SeenMotion(time=time, load_angle=rim / model.load_radius, midpoint=across)


def _harmonics(
    pluck: float, model: AutoparametricModel, c: AveragedCoefficients, time: Array, size: Array, q: Complex
) -> Array:
    """Sines 3, 5, ... of the upper span at midspan: they decay, follow the tension, bear side bands of q."""
    shift = (0.5 * c.cubic - c.static)[0] @ size + c.drift[0] * np.exp(-float(c.drift_decay) * time)
    rate = model.transverse[0] + shift
    phase = np.concatenate(([0.0], np.cumsum(0.5 * (rate[1:] + rate[:-1]) * np.diff(time))))
    height = FIRST_SINE * pluck * np.exp(-0.5 * float(c.transverse_damping[0]) * time)
    omega, m = float(c.forcing), HARMONICS[:, None]
    strength = m**2 * c.pump[0] * q * np.exp(1j * omega * time) / omega
    side = 1.0 + strength / (m + 1) - strength.conj() / (m - 1)
    return height * np.sum((side * np.exp(1j * m * phase)).real / m**2, axis=0)


def averaged_history(
    c: AveragedCoefficients, start: Complex, times: Array, *, second: bool = True
) -> Complex:
    """Slow amplitudes from `start`, shape (1 + J,) [m], at times (n,) [s] from 0 on; shape (1 + J, n)."""

    def rates(time: float, state: Complex) -> Complex:
        return averaged_rates(c, state, time, second=second)

    span = (0.0, float(times[-1]))
    found = solve_ivp(rates, span, start.astype(complex), "DOP853", times, rtol=1e-10, atol=1e-14)
    return np.asarray(found.y)


def envelope(time: Array, signal: Array, window: float) -> Array:
    """Largest size of a signal in each window [s], its linear trend removed; shape (windows,)."""
    level = signal - np.polyval(np.polyfit(time, signal, 1), time)
    number = np.floor((time - time[0]) / window).astype(int)
    peaks = np.zeros(number.max() + 1)
    np.maximum.at(peaks, number, np.abs(level))
    return peaks[: int(np.floor((time[-1] - time[0]) / window))]


def disagreement(case: ForcedCase, exact: SeenMotion, other: SeenMotion) -> tuple[float, float]:
    """Largest difference of two motions' envelopes over the largest envelope, of load angle and midpoint.

    A peak is taken over two periods of the forcing; both motions are at the same times.
    """
    errors = []
    for name in ("load_angle", "midpoint"):
        signals = (getattr(motion, name) for motion in (exact, other))
        true, found = (envelope(exact.time, signal, 4 * np.pi / case.omega) for signal in signals)
        errors.append(float(np.max(np.abs(found - true)) / np.max(true)))
    return errors[0], errors[1]


def own_sensitivity(case: ForcedCase, time: Array) -> float:
    """How much a change of the plucks by a thousandth changes the motion: the larger of the disagreements."""
    nudged = replace(case, plucks=(case.plucks[0] * 1.001, case.plucks[1]))
    return max(disagreement(case, averaged_motion(case, time), averaged_motion(nudged, time)))


def exchange_period(model: AutoparametricModel, first: float, second: float) -> float:
    r"""Time in which two unequal plucks swap and swap back, Eq. (A.30).

    .. math:: T = \frac{2K(m)}{\sqrt{\alpha k\,ab}}, \qquad m = -\frac{(a - b)^2}{4ab}

    with the complete elliptic integral K of parameter m; of a tuned model whose dampings and detunings are
    left out, and plucks a and b [m].
    Returns [s]; infinite where one span alone was plucked, all its energy ending in the pulleys.
    """
    a, b = abs(first), abs(second)
    if a * b == 0.0:
        return float("inf")
    c = averaged_coefficients(model)
    rate = float(np.sqrt(c.feedback[0] * c.pump[0] * a * b))
    return float(2.0 * ellipk(-((a - b) ** 2) / (4 * a * b)) / rate)


def largest_exchange(model: AutoparametricModel, first: float, second: float) -> float:
    r"""Largest displacement [m] of the pulley mode while two plucks [m] swap, tuned, undamped, Eq. (A.31).

    .. math:: q_{\max} = \sqrt{\frac{m_t}{4M}}\,|a - b|

    """
    return float(np.sqrt(model.transverse_mass[0] / (4 * model.modal_mass)) * abs(abs(first) - abs(second)))
