"""Motion wanted of a body between two motors, with the tensions and torques that it asks for."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.fields import nearest
from cabledrive.parameters.route import posed
from cabledrive.reduction.two_motors import TwoMotorMachine
from cabledrive.reduction.two_motors_kernels import TwoMotors, line_at
from cabledrive.rig.two_motors.design import TensionDesign
from cabledrive.trajectories import Trajectory, pulse

ORDER = 9
USED = 0.8
"""Part of torque, speed and tension below rest that the motion may use where its rise is chosen."""
LONGEST_RISE = 600.0
_HALVINGS = 40


@dataclass(frozen=True, kw_only=True, eq=False)
class Plan:
    """A motion and what it asks for.

    Attributes
    ----------
    trajectory : Trajectory
        Of the part of the way, from 0 to 1.
    table : ndarray, shape (samples, 3 m + 2)
        As `cabledrive.control.tension_position.step` takes it.
    tension, torque, speed : ndarray, shape (samples, 2)
        Of lines [N], drums [N m] and [rad/s].
    """

    trajectory: Trajectory
    table: Array
    tension: Array
    torque: Array
    speed: Array

    def used(self, machine: TwoMotorMachine, design: TensionDesign) -> float:
        """Largest part of what tension, torque and speed allow; above 1: it cannot be followed."""
        gains, numbers = design.gains, machine.numbers
        room = (machine.tension - self.tension) / (machine.tension - gains.low)
        parts = [room.max(), (np.abs(self.torque) / numbers.limit).max()]
        limits = [motor.speed_limit for motor in machine.drive.motor]
        parts += [
            np.abs(self.speed[:, i]).max() / limit for i, limit in enumerate(limits) if limit is not None
        ]
        return float(max(parts))


def way_of(machine: TwoMotorMachine, moves: Mapping[str, float]) -> Array:
    """How far each coordinate goes, shape (m,) [m].

    Raises `InputRefused` if there is no such coordinate, or nothing moves.
    """
    for name, value in moves.items():
        if name not in machine.names:
            raise InputRefused(
                f'move = "{name[:60]}" is no coordinate of the body{nearest(name[:60], list(machine.names))}'
            )
        if not np.isfinite(value):
            raise InputRefused(f"move {name} = {value} m must be finite: give a distance")
    return np.array([moves.get(name, 0.0) for name in machine.names])


def plan_motion(
    machine: TwoMotorMachine,
    design: TensionDesign,
    way: Array,
    *,
    rise: float | None,
    dwell: float,
    pulses: int,
    order: int = ORDER,
) -> Plan:
    """Go a way and back, smoothly; ``rise`` None: the shortest that uses at most `USED` of what is allowed.

    Raises `InputRefused` if the way leaves the lines, or no rise is long enough.
    """

    def planned(rise: float) -> Plan:
        trajectory = pulse(1.0, rise, dwell, pulses=pulses, order=order)
        return _plan(machine, design, way, trajectory)

    _check_way(machine, way)
    if rise is not None:
        return planned(rise)
    single = [0.01, LONGEST_RISE]

    def asks(rise: float) -> float:
        return _plan(machine, design, way, pulse(1.0, rise, 0.0, order=order), samples=400).used(
            machine, design
        )

    if asks(single[1]) > USED:
        raise InputRefused(
            f"move: even in {LONGEST_RISE:.0f} s it takes more than {USED:.0%} of what torque and least "
            "tension allow: go less far, or lower the least tension"
        )
    for _ in range(_HALVINGS):
        middle = float(np.sqrt(single[0] * single[1]))
        single[asks(middle) <= USED] = middle
    return planned(float(f"{single[1]:.3g}") * 1.01)


def _check_way(machine: TwoMotorMachine, way: Array) -> None:
    """Refuse a way on which the machine of the file cannot be."""
    drive = machine.drive
    at = dict(zip(("x", "y"), drive.body[0].at, strict=True))
    for share in (0.25, 0.5, 0.75, 1.0):
        pose = {
            name: at[name.rpartition(".")[2]] + share * float(distance)
            for name, distance in zip(machine.names, way, strict=True)
        }
        try:
            posed(drive, pose)
        except InputRefused as refusal:
            raise InputRefused(f"move: {refusal}") from None
    if not way.any():
        raise InputRefused("move: no coordinate moves: give a distance, such as camera.x=2m")


def _plan(
    machine: TwoMotorMachine,
    design: TensionDesign,
    way: Array,
    trajectory: Trajectory,
    samples: int | None = None,
) -> Plan:
    """Tables over the samples of the run, or over as many as are given."""
    numbers, gains = machine.numbers, design.gains
    count = round(trajectory.duration / gains.interval) + 1 if samples is None else samples
    time = np.linspace(0.0, trajectory.duration, count)
    step = time[1]
    s = trajectory(time, 2)
    q, v, a = (s[k][:, None] * way for k in range(3))
    along, length, free = lines_along(numbers, q)
    friction = numbers.viscous * v + numbers.coulomb * np.tanh(1e3 * v)
    smooth = held_tensions(gains.preferred, along, numbers.force - numbers.mass * a - numbers.viscous * v)
    tension = held_tensions(gains.preferred, along, numbers.force - numbers.mass * a - friction)
    rate = np.gradient(smooth, step, axis=0)
    bent = np.gradient(rate, step, axis=0)
    stretch = tension * free / numbers.rigidity
    speed = np.gradient(stretch - length, step, axis=0) / numbers.drum
    acceleration = np.gradient(
        np.gradient(smooth * free / numbers.rigidity - length, step, axis=0), step, axis=0
    )
    torque = (
        numbers.drum * tension
        + numbers.inertia * acceleration / numbers.drum
        + numbers.turning_viscous * speed
        + numbers.turning_coulomb * np.tanh(speed / gains.sliding)
    )
    lead = 2.0 * rate / gains.filter + bent / gains.filter**2
    return Plan(
        trajectory=trajectory,
        table=np.ascontiguousarray(np.hstack([q, v, a, lead])),
        tension=tension,
        torque=torque,
        speed=speed,
    )


def lines_along(machine: TwoMotors, q: Array) -> tuple[Array, Array, Array]:
    """Slopes dL/dq, shape (samples, 2, m), L and free lengths, shape (samples, 2) [m]."""
    along = np.zeros((len(q), 2, q.shape[1]))
    length, free = np.zeros((len(q), 2)), np.zeros((len(q), 2))
    for k, place in enumerate(q):
        for i in range(2):
            length[k, i], free[k, i], _ = line_at(machine, i, place, along[k, i])
    return along, length, free


def held_tensions(preferred: Array, along: Array, force: Array) -> Array:
    """Tensions nearest to the preferred ones that put a force on the body, shape (samples, 2)."""
    missing = force - np.einsum("kim,i->km", along, preferred)
    return preferred + np.einsum("kim,km->ki", np.linalg.pinv(along.transpose(0, 2, 1)), missing)
