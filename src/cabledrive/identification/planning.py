"""What a test will identify, before it is run: predicted standard errors, limits, and the 1:2 resonance.

The axis is moved under the planned torque with guessed parameters; `predicted_errors` gives the rest.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import isfinite

import numpy as np
from numpy.typing import NDArray

from cabledrive.identification.predicted_errors import NAMES, AxisGuess, Instruments, predicted_errors
from cabledrive.parameters import InputRefused
from cabledrive.reduction.friction_integration import integrate_rigid_axis

WEAK = "will not be identifiable"
"""Of a parameter whose standard error is more than half of it; in the finding."""

Array = NDArray[np.float64]

LIMITS = ("torque", "speed", "stroke")
BISECTIONS = 24


@dataclass(frozen=True, slots=True, kw_only=True)
class TestPlan:
    """What a test will identify.

    Attributes
    ----------
    standard_errors : dict of str to float
        Of each parameter, in its unit.
    relative_errors : dict of str to float
        Over the size of the guess; infinite where that is zero.
    peaks : dict of str to float
        Largest "torque", "speed" and "stroke" (from end to end) that the test will reach.
    moving : float
        Share of the time that the axis does not stick.
    findings : tuple of str
        Limits that are passed, parameters that will not be identified.
    """

    __test__ = False  # no test of pytest's

    standard_errors: dict[str, float]
    relative_errors: dict[str, float]
    peaks: dict[str, float]
    moving: float
    findings: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PlannedMotion:
    """The axis under the planned torque.

    Attributes
    ----------
    angle, speed : ndarray, shape (samples,)
        [rad, rad/s].
    """

    angle: Array
    speed: Array = field(repr=False)


def planned_motion(torque: Array, interval: float, guess: AxisGuess) -> PlannedMotion:
    """Move the guessed axis under the planned torque.

    ``torque``, shape (samples,) [N m]; ``interval`` [s].
    """
    values = np.array([guess.inertia, guess.viscous, guess.coulomb, guess.offset])
    speed, _ = integrate_rigid_axis(values, np.asarray(torque, dtype=float), interval)
    steps = 0.5 * (speed[1:] + speed[:-1]) * interval
    return PlannedMotion(angle=np.concatenate([[0.0], np.cumsum(steps)]), speed=speed)


def plan_test(
    torque: Array,
    interval: float,
    guess: AxisGuess,
    instruments: Instruments | None = None,
    limits: Mapping[str, float] | None = None,
) -> TestPlan:
    """Predict the standard error of each parameter, and what the test asks of the machine.

    Parameters
    ----------
    torque : ndarray, shape (samples,)
        [N m].
    interval : float
        [s].
    guess : AxisGuess
    instruments : Instruments, optional
    limits : mapping of str to float, optional
        Largest "torque", "speed", "stroke" that the machine bears.

    Returns
    -------
    TestPlan

    Raises
    ------
    InputRefused
        If a limit is unknown, or the torque does not move the axis.
    """
    instruments = instruments or Instruments()
    motion = planned_motion(torque, interval, guess)
    moving = float(np.mean(motion.speed != 0.0))
    if moving < 0.02:
        raise InputRefused(
            f"largest torque {np.abs(torque).max():.4g} N m does not move the axis against its Coulomb "
            f"friction of {guess.coulomb:.4g} N m: raise the amplitude"
        )
    peaks = peaks_of(torque, motion)
    errors = predicted_errors(motion.speed, interval, guess, instruments)
    sizes = (guess.inertia, guess.viscous, guess.coulomb, guess.offset)
    relative = {
        name: errors[name] / abs(size) if size else float("inf")
        for name, size in zip(NAMES, sizes, strict=True)
    }
    findings = [
        f"{name} reaches {peaks[name]:.4g}, above its limit of {limit:.4g}"
        for name, limit in checked_limits(limits).items()
        if peaks[name] > limit
    ]
    findings += [
        f"{name} {WEAK}: its standard error is {100 * share:.3g} % of it"
        for name, share in relative.items()
        if share > 0.5 and isfinite(share)
    ]
    return TestPlan(
        standard_errors=errors,
        relative_errors=relative,
        peaks=peaks,
        moving=moving,
        findings=tuple(findings),
    )


def peaks_of(torque: Array, motion: PlannedMotion) -> dict[str, float]:
    """What a test asks of the machine.

    ``torque``, shape (samples,).
    """
    return {
        "torque": float(np.abs(torque).max()),
        "speed": float(np.abs(motion.speed).max()),
        "stroke": float(np.ptp(motion.angle)),
    }


def checked_limits(limits: Mapping[str, float] | None) -> dict[str, float]:
    """Limits that are known and positive.

    Raises `InputRefused` if one is neither torque, speed nor stroke, or not positive.
    """
    for name, limit in (limits or {}).items():
        if name not in LIMITS or not limit > 0.0:
            raise InputRefused(f"limit {name} = {limit:g}: give {', '.join(LIMITS)}, each positive")
    return dict(limits or {})


def largest_amplitude(torque: Array, interval: float, guess: AxisGuess, limits: Mapping[str, float]) -> float:
    """Factor by which a torque can be multiplied without passing a limit.

    ``torque``, shape (samples,) [N m]; ``interval`` [s]; ``limits``: as in `plan_test`.
    Returns the largest below the first that passes a limit; found to 1e-4 of itself.
    """
    limits = checked_limits(limits)

    def within(scale: float) -> bool:
        peaks = peaks_of(scale * torque, planned_motion(scale * torque, interval, guess))
        return all(peaks[name] <= limit for name, limit in limits.items())

    low, high = 0.0, 1.0
    while within(high) and high < 1e6:
        low, high = high, 2.0 * high
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if within(middle) else (low, middle)
        if high - low < 1e-4 * high:
            break
    return low
