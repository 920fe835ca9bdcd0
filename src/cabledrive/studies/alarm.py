r"""The alarm: does a planned motion pump the cable, when, how far, and what would help?

First the linear response of the pulley mode to the planned torque; then Hill's equation of every transverse
mode along the motion, Eq. (A.32), without averaging and without assuming that anything is slow; then, where
that says danger, the nonlinear oscillators.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cabledrive.parameters import Drive, InputRefused
from cabledrive.studies.parametric_growth import hill_gain, nonlinear_largest, tongue_dwell
from cabledrive.studies.planned_motion import Course, PlannedMotion, course_of

Array = NDArray[np.float64]

MARGIN = 0.5
"""Margin in the logarithm of the gain: what Hill's equation may be wrong by."""

NUMBERS = (1, 2, 3)
SAFE, SATURATES, ALARM = "safe", "saturates", "alarm"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ModeAlarm:
    """What a motion does to one transverse mode.

    Attributes
    ----------
    span : str
    section : (float, float)
        At the start [m].
    number : int
    gain : float
        Logarithm of the largest growth from a standing floor by Hill's equation.
    start, end : float
        When that growth begins and is reached [s].
    dwell : float
        Time inside the tongue [s].
    largest : float
        Amplitude from the floor: nonlinear where Hill says danger, else the floor times the gain [m].
    """

    span: str
    section: tuple[float, float]
    number: int
    gain: float
    start: float
    end: float
    dwell: float
    largest: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class AlarmResult:
    """The verdict on a motion.

    Attributes
    ----------
    verdict : {"safe", "saturates", "alarm"}
        "saturates": the linear growth would pass the limit, the exchange of energy ends before.
    floor, limit : float
        Amplitude that is always there, and the largest that is allowed [m].
    modes : tuple of ModeAlarm
        The most endangered first.
    largest_pulley : float
        Largest q of the linear response [m].
    slack : bool
        Whether the linear response alone takes a span's tension away.
    remedy : str
    """

    verdict: str
    floor: float
    limit: float
    modes: tuple[ModeAlarm, ...]
    largest_pulley: float
    slack: bool
    remedy: str


def alarm(drive: Drive, motion: PlannedMotion, *, floor: float = 1e-5, limit: float = 5e-4) -> AlarmResult:
    """Whether a motion makes transverse vibrations grow beyond a limit.

    Parameters
    ----------
    drive : Drive
    motion : PlannedMotion
    floor : float, default 1e-5
        Transverse amplitude that is always there [m].
    limit : float, default 5e-4
        Largest allowed amplitude [m].

    Returns
    -------
    AlarmResult

    Raises
    ------
    InputRefused
        If the drive has no pulley mode, the motion does not fit it, or floor and limit are not 0 < floor <
        limit.
    """
    if not 0.0 < floor < limit:
        raise InputRefused(f"floor = {floor:.4g} m must be above 0 and below limit = {limit:.4g} m")
    found: list[ModeAlarm] = []
    largest, slack, danger = 0.0, False, False
    for number in NUMBERS:
        course = course_of(drive, motion, number)
        largest = max(largest, float(np.max(np.abs(course.q))))
        slack = slack or bool(np.any(np.abs(course.q) > course.slack))
        modes = [_mode_alarm(course, j, floor, limit) for j in range(course.across.shape[0])]
        danger = danger or any(floor * np.exp(mode.gain + MARGIN) > limit for mode in modes)
        found += modes
    found.sort(key=lambda mode: (-mode.largest, -mode.gain))
    verdict = SAFE if not danger else ALARM if found[0].largest > limit else SATURATES
    return AlarmResult(
        verdict=verdict,
        floor=floor,
        limit=limit,
        modes=tuple(found),
        largest_pulley=largest,
        slack=slack,
        remedy=_remedy(verdict, found[0], floor, limit),
    )


def _mode_alarm(course: Course, mode: int, floor: float, limit: float) -> ModeAlarm:
    gain, start, end = hill_gain(course, mode)
    label = course.models[0].modes[mode]
    if floor * np.exp(gain + MARGIN) > limit:
        largest = float(nonlinear_largest(course, mode, start, floor)[mode])
    else:
        largest = floor * float(np.exp(gain))
    return ModeAlarm(
        span=label.span,
        section=label.section,
        number=label.number,
        gain=gain,
        start=float(start * course.h),
        end=float(end * course.h),
        dwell=tongue_dwell(course, mode),
        largest=largest,
    )


def _remedy(verdict: str, worst: ModeAlarm, floor: float, limit: float) -> str:
    if verdict == SAFE:
        return "none needed"
    less = worst.gain + MARGIN - np.log(limit / floor)
    duration = max(worst.end - worst.start, 1e-9)
    return (
        f"between {worst.start:.3g} s and {worst.end:.3g} s mode {worst.number} of the {worst.span} span "
        f"grows: damp the cable by {2 * less / duration:.3g} 1/s more, take "
        f"{100 * less / (worst.gain + MARGIN):.3g} % off the torque's ripple there, or move the pretension "
        "away from this pair's tuning"
    )
