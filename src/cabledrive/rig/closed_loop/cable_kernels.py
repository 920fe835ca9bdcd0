"""The closed loop of the rig on the distributed cable, compiled: steps of the cable for each sample."""

from math import exp, isfinite
from typing import NamedTuple

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.compiled import njit_in_place
from cabledrive.rig.closed_loop.loop_numbers import (
    DIVERGED,
    WENT_SLACK,
    Control,
    LoopState,
    RigNumbers,
    decide,
    farthest,
    finish_sample,
)
from cabledrive.simulation.channels import MEAN_TENSION
from cabledrive.simulation.kernels import integrate
from cabledrive.simulation.plan import WEIGHT_U, Plan, State, Workspace

HANGS = 0.01  # share of the pretension below which a span hangs from its ends: it sags rather than pushes


class CableNumbers(NamedTuple):
    """What the loop needs to know of the cable beside its plan."""

    shafts: int  # Motor, drive, load; the last two where the joint is rigid
    radius: float  # of the drive pulley [m]
    steps: int  # steps of the cable per sample
    rate: float  # bandwidth of the torque loop [rad/s]; 0: none
    offset: float  # constant torque of the motor [N m]
    weight: float  # of the cable at the load's rim, along the span [N]
    zeros: Array  # (shafts,): angles at the start [rad]
    middle: Array  # (2,): largest v and w at the start, either way [m]


class CableRun(NamedTuple):
    """The cable while it moves: plan, nodes, which look into the state of the loop, and work space."""

    plan: Plan
    cable: State
    work: Workspace
    numbers: CableNumbers
    tensions: Array  # (samples or 0, 2): gets the mean ones of the spans [N]
    # row, torques, forces, fields: (1, columns), (steps,), (steps, 0), (0, 3, nodes): of the integration
    row: Array
    torques: Array
    forces: Array
    fields: Array


@njit_in_place
def read_shafts(plan: Plan, cable: State, numbers: CableNumbers, x: Array) -> None:
    """Angles of the shafts at a sample, and their speeds half a step of the cable before, into ``x``."""
    n, far = numbers.shafts, plan.segments
    for shaft in range(n):
        if shaft < n - 2:
            place, speed = cable.motor[0], cable.motor[1]
        elif shaft == n - 2:
            place, speed = cable.x[0, 0], cable.x_t[0, 0]
        else:
            place, speed = cable.x[0, far], cable.x_t[0, far]
        x[shaft] = place / numbers.radius - numbers.zeros[shaft]
        x[n + shaft] = speed / numbers.radius


@njit_in_place
def look_at_cable(plan: Plan, cable: State, numbers: CableNumbers, x: Array, score: Array) -> None:
    """Largest twist, how far the middle of a span is from the mean of its ends, and sway."""
    n, u, far = numbers.shafts, cable.x, plan.segments
    score[7] = max(score[7], abs(x[n - 2] - x[n - 1]))
    for span in range(plan.spans):
        start = span * far
        middle = 0.5 * (u[0, start + far // 2] + u[0, start + (far + 1) // 2])
        score[11] = max(score[11], abs(middle - 0.5 * (u[0, start] + u[0, start + far])))
    for axis in range(1, 3):
        for i in range(u.shape[1]):
            score[12] = max(score[12], abs(u[axis, i]) - numbers.middle[axis - 1])


@njit_in_place
def act(c: CableRun, rig: RigNumbers, commands: Array, shaft: float, push: float) -> float:
    """Write the torque on the motor at each step of a sample; returns that of the torque loop at its end.

    The older command acts until the delay has passed. A step of the cable spreads its torque half a step to
    both sides; so does the share of each command.
    """
    numbers, torques, older, newer = c.numbers, c.torques, commands[0], commands[1]
    step = rig.interval / numbers.steps
    keep = exp(-numbers.rate * step)
    for j in range(numbers.steps):
        if numbers.rate > 0.0:
            torques[j] = shaft
            share = min(max(rig.late_part / step - j, 0.0), 1.0)
            shaft = keep * shaft + (1.0 - keep) * (share * older + (1.0 - share) * newer)
        else:
            share = min(max(rig.late_part / step - j + 0.5, 0.0), 1.0)
            torques[j] = share * older + (1.0 - share) * newer
            shaft = newer
        torques[j] += push
    return shaft


@njit_in_place
def cable_ends(c: CableRun, gone: float, s: LoopState) -> int:
    """Read the shafts and look at the cable at a sample; why the run ends here, 0 where it goes on."""
    x, n = s.x, c.numbers.shafts
    read_shafts(c.plan, c.cable, c.numbers, x)
    if not isfinite(x[n - 1]) or abs(x[n - 1]) > gone:
        return DIVERGED
    look_at_cable(c.plan, c.cable, c.numbers, x, s.summary)
    return 0


@njit_in_place
def move_cable(c: CableRun, rig: RigNumbers, k: int, s: LoopState) -> int:
    """Move the cable to the next sample; why the run ends after it, 0 where it goes on."""
    x, n, plan, numbers, row = s.x, c.numbers.shafts, c.plan, c.numbers, c.row
    x[2 * n] = act(c, rig, s.controller.commands, x[2 * n], numbers.offset + rig.forces[k, 0])
    plan.node[WEIGHT_U, plan.segments] = numbers.weight + rig.forces[k, 1] / numbers.radius
    given = plan, c.cable, c.work, c.torques, c.forces, numbers.steps, row, c.fields
    code = integrate(None, numbers.zeros, None, None, False, *given)
    plan.node[WEIGHT_U, plan.segments] = numbers.weight
    if c.tensions.shape[0] > 0:
        c.tensions[k, 0], c.tensions[k, 1] = row[0, MEAN_TENSION], row[0, MEAN_TENSION + 1]
    least = HANGS * plan.pretension
    if row[0, MEAN_TENSION] < least or (plan.closed and row[0, MEAN_TENSION + 1] < least):
        s.summary[9] += 1.0
        if plan.stop_when_slack:
            code = 1
    if code == 0:
        return 0
    return WENT_SLACK if code == 1 else DIVERGED


@njit_in_place
def run_cable(c: CableRun, control: Control, first: int, last: int, s: LoopState, log: Array) -> int:
    """Run samples ``first`` to ``last`` - 1; returns the sample at which the run ended."""
    x, n, gone, rig = s.x, c.numbers.shafts, farthest(control.target), control.rig
    for k in range(first, last):
        s.discrete[1] = cable_ends(c, gone, s)
        if s.discrete[1] != 0:
            return k
        wanted, command, sigma = decide(control, k, x, s)
        slip = 0 if x[n] == 0.0 else 1
        finish_sample(control, k, s, log, x[: 2 * n + 1], wanted, command, sigma, slip)
        s.discrete[1] = move_cable(c, rig, k, s)
        if s.discrete[1] != 0:
            return k + 1
    return last
