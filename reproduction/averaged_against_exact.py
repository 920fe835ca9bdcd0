"""The averaged equations validated against the exact loop: the same motion by both, and their difference."""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from cabledrive.parameters import Drive
from cabledrive.reduction.autoparametric import AutoparametricModel, autoparametric_model
from cabledrive.reduction.averaging import (
    AveragedCoefficients,
    averaged_coefficients,
    averaged_rates,
    plucked,
    rigid_rotation,
    triangle_stretch,
)
from cabledrive.simulation import Pluck, Recording, Scheme, Sine, Start, simulate
from cabledrive.simulation.run import whole

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Shape = Literal["half-sine", "triangle"]

WINDOW = 2.0
"""Periods of the forcing over which a peak is taken."""

AVERAGED_STEP = 1e-3
HARMONICS = np.arange(3, 40, 2)


@dataclass(frozen=True, slots=True, kw_only=True)
class ForcedCase:
    """A forced motion from plucks.

    Attributes
    ----------
    drive : Drive
        A loop without carriages.
    torque : float
        Amplitude [N m].
    plucks : (float, float)
        Of the upper and the lower span [m].
    duration : float
        [s].
    shape : {"half-sine", "triangle"}
    forcing : float or None
        Omega [rad/s]; the pulley mode's own unless given.
    """

    drive: Drive
    torque: float
    plucks: tuple[float, float]
    duration: float = 1.0
    shape: Shape = "half-sine"
    forcing: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SeenMotion:
    """What the rig would show.

    Attributes
    ----------
    time : ndarray, shape (n,)
        [s].
    load_angle : ndarray, shape (n,)
        [rad].
    midpoint : ndarray, shape (n,)
        Of the upper span, in w [m].
    """

    time: Array
    load_angle: Array
    midpoint: Array


def exact_motion(case: ForcedCase, segments: int = 200, rate: float = 4000.0) -> SeenMotion:
    """The motion of the nonlinear loop itself.

    ``segments``: per span; ``rate``: records per second [Hz].
    """
    omega = case.forcing or autoparametric_model(case.drive).natural
    shapes = [
        Pluck(height=height, span=span, shape=case.shape)
        for height, span in zip(case.plucks, ("upper", "lower"), strict=True)
        if height != 0.0
    ]
    result = whole(
        simulate(
            case.drive,
            case.duration,
            torque=Sine(amplitude=case.torque, frequency=omega / (2 * np.pi)),
            start=Start(plucks=tuple(shapes)),
            scheme=Scheme(segments=segments),
            recording=Recording(rate=rate),
        )
    )
    return SeenMotion(
        time=result.time, load_angle=result.channel("load_angle"), midpoint=result.midpoint("upper")[:, 2]
    )


def averaged_motion(case: ForcedCase, time: Array, *, second: bool = True) -> SeenMotion:
    """The same motion by the averaged equations, put together again.

    ``time``, shape (n,) [s]; ``second``: to second order.
    """
    model = autoparametric_model(case.drive, number=1)
    c, first = _coefficients(case, model)
    coarse, states = averaged_history(c, plucked(c, first, second=second), case.duration, second=second)
    state = np.array([_between(time, coarse, row) for row in states])
    omega = float(c.forcing)
    q, z, wave = state[0], state[1:], np.exp(0.5j * omega * time)
    passive = c.passive[:, None] * np.exp(-float(c.transverse_damping) * time)
    q0 = float(c.drift_offset) * np.exp(-float(c.drift_decay) * time) - c.offset @ (np.abs(z) ** 2 + passive)
    along = (q * wave**2).real + q0
    third = (c.pump[0] / (2 * omega) * q * z[0] * wave**3).real if second else 0.0
    across = (z[0] * wave).real + third
    if case.shape == "triangle":
        across = across + _harmonics(case, model, c, time, np.abs(z) ** 2 + passive, q)
    rim = model.rims[1] * along + rigid_rotation(model, time, case.torque, omega)
    return SeenMotion(time=time, load_angle=rim / model.load_radius, midpoint=across)


def _between(time: Array, coarse: Array, row: Complex) -> Complex:
    from scipy.interpolate import CubicSpline

    return np.asarray(CubicSpline(coarse, row)(time))


def _coefficients(case: ForcedCase, model: AutoparametricModel) -> tuple[AveragedCoefficients, Array]:
    """Coefficients, and the first sine of each pluck."""
    plucks = np.array(case.plucks)
    if case.shape == "half-sine":
        return averaged_coefficients(model, torque=case.torque, forcing=case.forcing), plucks
    passive = triangle_stretch(plucks)
    c = averaged_coefficients(model, torque=case.torque, forcing=case.forcing, passive=passive)
    return c, 8 / np.pi**2 * plucks


def _harmonics(
    case: ForcedCase,
    model: AutoparametricModel,
    c: AveragedCoefficients,
    time: Array,
    size: Array,
    q: Complex,
) -> Array:
    """Sines 3, 5, ... of the upper span at midspan: they decay, follow the tension, bear side bands of q."""
    shift = (0.5 * c.cubic - c.static)[0] @ size + c.drift[0] * np.exp(-float(c.drift_decay) * time)
    rate = model.transverse[0] + shift
    phase = np.concatenate(([0.0], np.cumsum(0.5 * (rate[1:] + rate[:-1]) * np.diff(time))))
    height = 8 / np.pi**2 * case.plucks[0] * np.exp(-0.5 * float(c.transverse_damping) * time)
    omega, m = float(c.forcing), HARMONICS[:, None]
    strength = m**2 * c.pump[0] * q * np.exp(1j * omega * time) / omega
    side = 1.0 + strength / (m + 1) - strength.conj() / (m - 1)
    return height * np.sum((side * np.exp(1j * m * phase)).real / m**2, axis=0)


def averaged_history(
    c: AveragedCoefficients,
    start: Complex,
    duration: float,
    *,
    second: bool = True,
    step: float = AVERAGED_STEP,
) -> tuple[Array, Complex]:
    """Slow amplitudes in time, by Runge-Kutta steps of fourth order.

    ``start``, shape (1 + J, ...); ``duration`` [s]; ``second``: to second order; ``step``: largest step [s].
    Returns ``time``, shape (n,) [s]; ``states``, shape (1 + J, n, ...) [m].
    """
    steps = int(np.ceil(duration / step))
    h, states = duration / steps, [start]
    for n in range(steps):
        t, state = n * h, states[-1]
        one = averaged_rates(c, state, t, second=second)
        two = averaged_rates(c, state + 0.5 * h * one, t + 0.5 * h, second=second)
        three = averaged_rates(c, state + 0.5 * h * two, t + 0.5 * h, second=second)
        four = averaged_rates(c, state + h * three, t + h, second=second)
        states.append(state + h / 6 * (one + 2 * two + 2 * three + four))
    return np.asarray(h * np.arange(steps + 1), dtype=float), np.swapaxes(np.array(states), 0, 1)


def envelope(time: Array, signal: Array, window: float) -> Array:
    """Largest size of a signal in one window after another, its linear trend removed.

    ``time``, ``signal``, shape (n,); ``window`` [s].
    Returns shape (windows,).
    """
    level = signal - np.polyval(np.polyfit(time, signal, 1), time)
    number = np.floor((time - time[0]) / window).astype(int)
    whole = int(np.floor((time[-1] - time[0]) / window))
    peaks = np.zeros(number.max() + 1)
    np.maximum.at(peaks, number, np.abs(level))
    return peaks[:whole]


def disagreement(case: ForcedCase, exact: SeenMotion, other: SeenMotion) -> tuple[float, float]:
    """Largest difference of two motions' envelopes over the largest envelope.

    ``exact``, ``other``: at the same times.
    """
    omega = case.forcing or autoparametric_model(case.drive).natural
    window = WINDOW * 2 * np.pi / omega
    errors = []
    for name in ("load_angle", "midpoint"):
        true, found = (envelope(exact.time, getattr(motion, name), window) for motion in (exact, other))
        errors.append(float(np.max(np.abs(found - true)) / np.max(true)))
    return errors[0], errors[1]


def own_sensitivity(case: ForcedCase, time: Array) -> float:
    """How much a change of the plucks by a thousandth changes the motion: the set's own sharpness.

    ``time``, shape (n,) [s].
    Returns larger of the two disagreements.
    """
    first, second = case.plucks
    nudged = replace(case, plucks=(first * 1.001, second))
    return max(disagreement(case, averaged_motion(case, time), averaged_motion(nudged, time)))
