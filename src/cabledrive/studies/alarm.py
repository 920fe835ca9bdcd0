r"""The alarm: does a planned motion pump the cable, when, how far, and what would help?

First the linear response of the pulley mode to the planned torque; then Hill's equation of every transverse
mode along the motion, Eq. (A.32), without averaging and without assuming that anything is slow; then, where
that says danger, the nonlinear oscillators.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cabledrive.parameters import Drive, InputRefused
from cabledrive.reduction.autoparametric import AutoparametricModel, autoparametric_model
from cabledrive.reduction.motion_kernels import linear_response, march_from, transitions

Array = NDArray[np.float64]

KNOTS = 33
STEPS_PER_PERIOD = 40
BLOCKS_PER_SECOND = 40.0
MARGIN = 0.5
"""Margin in the logarithm of the gain: what Hill's equation may be wrong by."""

NUMBERS = (1, 2, 3)
SAFE, SATURATES, ALARM = "safe", "saturates", "alarm"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PlannedMotion:
    """A motion, sampled.

    Attributes
    ----------
    time : ndarray, shape (n,)
        From 0, ascending [s].
    torque : ndarray, shape (n,)
        [N m].
    pretension : ndarray, shape (n,), or None
        [N]; the drive's own unless given.
    carriage : ndarray, shape (n,), or None
        Position of the first carriage [m].
    load_torque : ndarray, shape (n,), or None
        Slowly changing torque on the load pulley [N m]; it splits the span tensions.
    """

    time: Array
    torque: Array
    pretension: Array | None = None
    carriage: Array | None = None
    load_torque: Array | None = None

    def __post_init__(self) -> None:
        n = np.asarray(self.time).size
        if n < 2 or not np.all(np.diff(self.time) > 0.0) or self.time[0] != 0.0:
            raise InputRefused("motion: time must start at 0 and ascend: give two instants or more")
        for name in ("torque", "pretension", "carriage", "load_torque"):
            values = getattr(self, name)
            if values is not None and (np.shape(values) != (n,) or not np.all(np.isfinite(values))):
                raise InputRefused(f"motion: {name} must be {n} finite numbers, one for each time")


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


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Course:
    """Coefficients at every step of a motion, for the sections with one number of mode."""

    models: list[AutoparametricModel]
    h: float
    time: Array
    natural: Array
    damping: Array
    force: Array
    push: Array
    across: Array
    lift: Array
    cubic: Array
    gamma: float
    slack: Array
    q: Array
    p: Array


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


def course_of(drive: Drive, motion: PlannedMotion, number: int) -> _Course:
    """Everything a march along a motion needs, and the linear response of the pulley mode.

    Parameters
    ----------
    drive : Drive
    motion : PlannedMotion
    number : int
        Of the transverse mode of every section.

    Returns
    -------
    _Course
    """
    constant = all(values is None for values in (motion.pretension, motion.carriage, motion.load_torque))
    knots = np.linspace(0.0, motion.time[-1], 2 if constant else KNOTS)
    models = [_model_at(drive, motion, t, number) for t in knots]
    fastest = max(max(model.natural, 2 * float(model.transverse.max())) for model in models)
    steps = int(np.ceil(motion.time[-1] * fastest * STEPS_PER_PERIOD / (2 * np.pi)))
    h = motion.time[-1] / steps
    time = h * np.arange(steps)

    def _along(values: ArrayLike) -> Array:
        return _between(knots, np.asarray(values, dtype=float), time)

    force = np.interp(time, motion.time, motion.torque)
    natural, damping = _along([m.natural for m in models]), _along([m.modal_damping for m in models])
    force = force * _along([m.torque_arm / m.modal_mass for m in models])
    q, p = np.empty(steps), np.empty(steps)
    linear_response(natural, damping, force, h, q, p)
    return _Course(
        models=models,
        h=h,
        time=time,
        natural=natural,
        damping=damping,
        force=force,
        push=_along([m.coupling / m.modal_mass for m in models]),
        across=_along([m.transverse for m in models]),
        lift=_along([2 * m.coupling / m.transverse_mass for m in models]),
        cubic=np.mean([(m.stiffening.T / m.transverse_mass).T for m in models], axis=0),
        gamma=models[0].transverse_damping,
        slack=_along([m.slack_amplitude for m in models]),
        q=q,
        p=p,
    )


def _model_at(drive: Drive, motion: PlannedMotion, t: float, number: int) -> AutoparametricModel:
    if motion.pretension is not None:
        tension = float(np.interp(t, motion.time, motion.pretension))
        drive = replace(drive, cable=replace(drive.cable, pretension=tension))
    if motion.carriage is not None:
        if not drive.carriage:
            raise InputRefused("motion: carriage positions are given, but the drive has none: leave them out")
        place = float(np.interp(t, motion.time, motion.carriage))
        drive = replace(drive, carriage=(replace(drive.carriage[0], position=place), *drive.carriage[1:]))
    load = 0.0 if motion.load_torque is None else float(np.interp(t, motion.time, motion.load_torque))
    return autoparametric_model(drive, number=number, load_torque=load)


def _between(knots: Array, values: Array, time: Array) -> Array:
    """Values at every step, smooth through the knots, last axis time."""
    from scipy.interpolate import PchipInterpolator

    if np.all(values == values[:1]):
        return np.ascontiguousarray(np.repeat(values[0][..., None], time.size, axis=-1))
    return np.ascontiguousarray(np.moveaxis(PchipInterpolator(knots, values)(time), 0, -1))


def _mode_alarm(course: _Course, mode: int, floor: float, limit: float) -> ModeAlarm:
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


def hill_gain(course: _Course, mode: int) -> tuple[float, int, int]:
    r"""Largest growth by Hill's equation from any start to any end of the motion, Eq. (A.33).

    .. math:: \ln\max_{t_0 < t_1}\sigma_{\max}\big[\Phi(t_1)\Phi(t_0)^{-1}\big]

    with the transition matrix of amplitude and rate over frequency.

    Parameters
    ----------
    course : _Course
    mode : int

    Returns
    -------
    gain : float
        0 or more.
    start, end : int
        Steps.
    """
    blocks = max(2, int(course.time.size * course.h * BLOCKS_PER_SECOND))
    edges = np.unique(np.linspace(0, course.time.size, blocks + 1).astype(np.int64))
    steps = np.empty((edges.size - 1, 2, 2))
    transitions(course.across[mode], course.lift[mode], course.q, course.gamma, course.h, edges, steps)
    best, where = 0.0, (0, 0)
    running = np.broadcast_to(np.eye(2), (steps.shape[0], 2, 2)).copy()
    scale = np.zeros(steps.shape[0])
    for last, step in enumerate(steps):
        running[: last + 1] = step @ running[: last + 1]
        size = np.abs(running[: last + 1]).max(axis=(1, 2))
        running[: last + 1] /= size[:, None, None]
        scale[: last + 1] += np.log(size)
        gains = np.log(np.linalg.norm(running[: last + 1], 2, axis=(1, 2))) + scale[: last + 1]
        first = int(np.argmax(gains))
        if gains[first] > best:
            best, where = float(gains[first]), (int(edges[first]), int(edges[last + 1]))
    return best, *where


def nonlinear_largest(course: _Course, mode: int, start: int, floor: float) -> Array:
    """Largest amplitude of every mode when the floor stands at a step, by the oscillators, over two phases.

    Parameters
    ----------
    course : _Course
    mode : int
        The one that has the floor; the others a third of it.
    start : int
        Step.
    floor : float
        [m].

    Returns
    -------
    ndarray, shape (modes,)
        [m].
    """
    modes = course.across.shape[0]
    top = np.zeros(modes)
    share = np.where(np.arange(modes) == mode, 1.0, 1.0 / 3.0)
    for phase in (0.25 * np.pi, 0.75 * np.pi):
        a = floor * share * np.cos(phase)
        b = floor * share * np.sin(phase) * course.across[:, start]
        march_from(
            start,
            course.natural,
            course.damping,
            course.force,
            course.push,
            course.across,
            course.lift,
            course.cubic,
            course.gamma,
            course.h,
            course.q[start],
            course.p[start],
            a,
            b,
            top,
        )
    return top


def tongue_dwell(course: _Course, mode: int) -> float:
    """Time that the motion spends inside the tongue, by the envelope and the frequency of the pulley mode.

    Parameters
    ----------
    course : _Course
    mode : int

    Returns
    -------
    float
        [s].
    """
    from scipy.signal import hilbert

    turning = hilbert(course.q - np.mean(course.q))
    omega = np.gradient(np.unwrap(np.angle(turning)), course.h)
    smooth = np.full(2 * STEPS_PER_PERIOD, 0.5 / STEPS_PER_PERIOD)
    omega = np.maximum(np.convolve(omega, smooth, "same"), 1e-9)
    pumping = 0.5 * np.abs(course.lift[mode] * turning) / omega
    growth = np.sqrt(np.maximum(pumping**2 - (course.across[mode] - 0.5 * omega) ** 2, 0.0))
    inside = growth > 0.5 * course.gamma
    return float(np.sum(inside) * course.h)


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
