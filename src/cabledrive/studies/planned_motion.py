"""A planned motion, and what the drive is along it: tuning, coupling, response of the pulley mode."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cabledrive.parameters import Drive, InputRefused
from cabledrive.reduction.autoparametric import AutoparametricModel, autoparametric_model
from cabledrive.reduction.motion_kernels import linear_response

Array = NDArray[np.float64]

KNOTS = 33
STEPS_PER_PERIOD = 40
FEWEST_STEPS, MOST_STEPS = 4, 10_000_000
"""Of a march along a motion; the arrays of the most take some gigabytes."""


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

    @property
    def changes(self) -> bool:
        """Whether pretension, carriages or load torque change along it."""
        columns = (self.pretension, self.carriage, self.load_torque)
        return any(values is not None and np.ptp(values) > 0.0 for values in columns)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Course:
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


def course_of(drive: Drive, motion: PlannedMotion, number: int) -> Course:
    """Everything a march along a motion needs, and the linear response of the pulley mode.

    Parameters
    ----------
    drive : Drive
    motion : PlannedMotion
    number : int
        Of the transverse mode of every section.

    Returns
    -------
    Course

    Raises
    ------
    InputRefused
        If the motion is too short or too long to be marched along.
    """
    constant = all(values is None for values in (motion.pretension, motion.carriage, motion.load_torque))
    knots = np.linspace(0.0, motion.time[-1], 2 if constant else KNOTS)
    models = [_model_at(drive, motion, t, number) for t in knots]
    fastest = max(max(model.natural, 2 * float(model.transverse.max())) for model in models)
    per_second = fastest * STEPS_PER_PERIOD / (2 * np.pi)
    wanted = float(np.ceil(motion.time[-1] * per_second))
    if not FEWEST_STEPS <= wanted <= MOST_STEPS:
        raise InputRefused(
            f"motion: lasts {motion.time[-1]:.4g} s, which takes {wanted:.3g} steps; it is judged from "
            f"{FEWEST_STEPS / per_second:.3g} s to {MOST_STEPS / per_second:.4g} s: plan one of that length"
        )
    steps = int(wanted)
    h = motion.time[-1] / steps
    time = h * np.arange(steps)

    def _along(values: ArrayLike) -> Array:
        return _between(knots, np.asarray(values, dtype=float), time)

    force = np.interp(time, motion.time, motion.torque)
    natural, damping = _along([m.natural for m in models]), _along([m.modal_damping for m in models])
    held_back = _along([m.cross_damping / m.modal_mass for m in models]) * _rim_speed(models[0], force, h)
    force = force * _along([m.torque_arm / m.modal_mass for m in models]) - held_back
    q, p = np.empty(steps), np.empty(steps)
    linear_response(natural, damping, force, h, q, p)
    return Course(
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


def _rim_speed(model: AutoparametricModel, torque: Array, h: float) -> Array:
    """Speed of the rigid rotation under a torque, without the small pull of q.

    With viscous friction that is not spread like the inertia it splits the tensions of the spans.
    """
    from scipy.signal import lfilter

    if model.rigid_arm == 0.0:
        return np.zeros_like(torque)
    kept = np.exp(-h * model.rigid_damping / model.rigid_mass)
    return np.asarray(lfilter([0.0, h * model.rigid_arm / model.rigid_mass], [1.0, -kept], torque))


def drive_along(drive: Drive, motion: PlannedMotion, t: float) -> Drive:
    """The drive with the pretension and the carriage places that a motion has at an instant.

    Parameters
    ----------
    drive : Drive
    motion : PlannedMotion
    t : float
        [s].

    Returns
    -------
    Drive

    Raises
    ------
    InputRefused
        If the motion moves a carriage that the drive has not.
    """
    if motion.pretension is not None:
        tension = float(np.interp(t, motion.time, motion.pretension))
        drive = replace(drive, cable=replace(drive.cable, pretension=tension))
    if motion.carriage is not None:
        if not drive.carriage:
            raise InputRefused("motion: carriage positions are given, but the drive has none: leave them out")
        place = float(np.interp(t, motion.time, motion.carriage))
        drive = with_carriage_at(drive, place)
    return drive


def with_carriage_at(drive: Drive, place: float) -> Drive:
    """The drive with its first carriage at a place, and those that move together with it moved as far.

    Parameters
    ----------
    drive : Drive
    place : float
        Position of the first carriage [m].

    Returns
    -------
    Drive
    """
    moved = place - drive.carriage[0].position
    carriages = list(drive.carriage)
    for number, direction in drive.moving_with(0).items():
        own = carriages[number]
        position = place if number == 0 else own.position + direction * moved
        carriages[number] = replace(own, position=position)
    return replace(drive, carriage=tuple(carriages))


def _model_at(drive: Drive, motion: PlannedMotion, t: float, number: int) -> AutoparametricModel:
    drive = drive_along(drive, motion, t)
    load = 0.0 if motion.load_torque is None else float(np.interp(t, motion.time, motion.load_torque))
    return autoparametric_model(drive, number=number, load_torque=load)


def _between(knots: Array, values: Array, time: Array) -> Array:
    """Values at every step, smooth through the knots, last axis time."""
    from scipy.interpolate import PchipInterpolator

    if np.all(values == values[:1]):
        return np.ascontiguousarray(np.repeat(values[0][..., None], time.size, axis=-1))
    return np.ascontiguousarray(np.moveaxis(PchipInterpolator(knots, values)(time), 0, -1))
