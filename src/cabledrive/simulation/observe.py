"""What is counted each step of a loop or a line, and what a record holds, compiled."""

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.compiled import for_kernels, njit_in_place, njit_strict
from cabledrive.simulation import channels as column
from cabledrive.simulation import plan as at
from cabledrive.simulation.plan import Plan, State, Workspace

SHAFTS = 3


@njit_strict
@for_kernels
def add_to(tallies: Array, number: int, amount: float) -> None:
    """Add to a tally, with what rounding took away last time (compensated summation).

    Callers write int(NAME): a named constant by itself would be compiled into a version of its own.
    """
    amount -= tallies[1, number]
    total = tallies[0, number] + amount
    tallies[1, number] = (total - tallies[0, number]) - amount
    tallies[0, number] = total


@njit_in_place
@for_kernels
def tally_shafts(plan: Plan, push: float, shaft: Array, tallies: Array) -> None:
    """Work of the torque, and what friction and joint damping take over the step."""
    viscous, coulomb = 0.0, 0.0
    for i in range(SHAFTS):
        shaft[at.RIGHT, i] = 0.5 * (shaft[at.OLD, i] + shaft[at.NEW, i])
        viscous += plan.shaft[at.VISCOUS, i] * shaft[at.RIGHT, i] ** 2
        coulomb += shaft[at.FRICTION, i] * shaft[at.RIGHT, i]
    twist_rate = shaft[at.RIGHT, 0] - shaft[at.RIGHT, 2]
    add_to(tallies, int(column.TORQUE_WORK), plan.step * push * shaft[at.RIGHT, plan.driven])
    add_to(tallies, int(column.VISCOUS_LOSS), plan.step * viscous)
    add_to(tallies, int(column.COULOMB_LOSS), plan.step * coulomb)
    add_to(tallies, int(column.JOINT_LOSS), plan.step * plan.joint_damping * twist_rate * twist_rate)


@njit_in_place
@for_kernels
def keep_extremes(plan: Plan, state: State) -> None:
    """Least and largest place of each shaft's rim, largest size of v and w at each midpoint, every step."""
    x, motor, extremes = state.x, state.motor, state.extremes
    for k in range(3):
        place = x[0, 0] if k == 0 else x[0, plan.segments] if k == 1 else motor[0]
        extremes[2 * k] = min(extremes[2 * k], place)
        extremes[2 * k + 1] = max(extremes[2 * k + 1], place)
    for span in range(plan.spans):
        i, share = int(plan.probe[span, 0]), plan.probe[span, 1]
        for axis in range(1, 3):
            size = abs((1.0 - share) * x[axis, i] + share * x[axis, i + 1])
            extremes[5 + 2 * span + axis] = max(extremes[5 + 2 * span + axis], size)


@njit_in_place
@for_kernels
def copy_rows(source: Array, target: Array) -> None:
    """Copy an array of rows into another of the same shape."""
    for row in range(source.shape[0]):
        for i in range(source.shape[1]):
            target[row, i] = source[row, i]


@njit_in_place
@for_kernels
def keep_before(state: State, work: Workspace) -> None:
    """Keep what a record needs from before the kick."""
    copy_rows(state.x, work.before[0])
    copy_rows(state.x_t, work.before[1])
    copy_rows(state.tallies, work.before_tallies)
    work.before_motor[0], work.before_motor[1] = state.motor[0], state.motor[1]


@njit_in_place
@for_kernels
def observe(plan: Plan, state: State, work: Workspace, torque: float, row: Array) -> None:
    """Write one row, see `cabledrive.simulation.channels`.

    ``work`` holds displacements, velocities and tallies from before the kick, components, tension and energy.
    The energy in the balance is the mean of those of the two half steps beside t_j::

        H(t_j) + |d|^2 / 2 - step / 2 d . F,  d = (velocity after - velocity before) / 2,  F = -dV/dx,

    which leapfrog keeps to round-off for a linear drive, and to a bounded remainder for the others.
    """
    row[:] = 0.0
    x, energy = work.before[0], observe_cable(plan, state.x_t, work, row)
    energy += observe_shafts(plan, state, work, row)
    row[column.TORQUE] = torque
    for k in range(column.AXIAL, column.WEIGHT_ENERGY + 1):
        energy += row[k]
    for k in range(column.TALLIES):
        row[column.WORK + k] = 0.5 * (work.before_tallies[0, k] + state.tallies[0, k])
        energy += (
            -row[column.WORK + k] if k in (column.TORQUE_WORK, column.FORCE_WORK) else row[column.WORK + k]
        )
    row[column.BALANCE] = energy
    for probe in range(plan.probe.shape[0]):
        i, share = int(plan.probe[probe, 0]), plan.probe[probe, 1]
        for axis in range(3):
            row[column.WIDTH + 3 * probe + axis] = (1.0 - share) * x[axis, i] + share * x[axis, i + 1]


@njit_in_place
def observe_cable(plan: Plan, after: Array, work: Workspace, row: Array) -> float:
    """Tensions and energies of the spans, and of their weight; their part of the balance's correction."""
    n, h, p, node = plan.segments, plan.segment[at.SPACING], work.p, plan.node
    x, old = work.before[0], work.before[1]
    correction = 0.0
    for span in range(plan.spans):
        first, last, length, least = span * n, (span + 1) * n, 0.0, work.q[at.TENSION, span * n]
        for i in range(first, last):
            length += h[i]
            row[column.MEAN_TENSION + span] += work.q[at.TENSION, i] * h[i]
            row[column.STRAIN + span] += work.q[at.ENERGY, i] * h[i]
            least = min(least, work.q[at.TENSION, i])
        row[column.MEAN_TENSION + span] /= length
        row[column.LEAST_TENSION + span] = least
        for axis in range(3):
            kinetic = 0.0
            for i in range(first, last + 1):  # half cells at its rims
                left, before = (h[i - 1], p[axis, i - 1]) if i > first else (0.0, 0.0)
                right, behind = (h[i], p[axis, i]) if i < last else (0.0, 0.0)
                half = 0.25 * plan.density * (left + right)
                half += 0.5 * node[at.CARRIAGE_MASS, i] if first < i < last else 0.0
                change = 0.5 * (after[axis, i] - old[axis, i])
                kinetic += half * (old[axis, i] + change) ** 2
                correction += half * change * change - 0.5 * plan.step * change * (behind - before)
            row[column.AXIAL + span if axis == 0 else column.TRANSVERSE + span] += kinetic
    for i in range(x.shape[1] - 1 if plan.closed else x.shape[1]):
        weight_u, weight_w = node[at.WEIGHT_U, i], node[at.WEIGHT_W, i]
        row[column.WEIGHT_ENERGY] -= weight_u * x[0, i] + weight_w * x[2, i]
        rate = weight_u * (after[0, i] - old[0, i]) + weight_w * (after[2, i] - old[2, i])
        correction -= 0.25 * plan.step * rate
    return correction


@njit_in_place
def observe_shafts(plan: Plan, state: State, work: Workspace, row: Array) -> float:
    """Angles, speeds and energies of shafts, joint and holding spring; their part of the correction."""
    x, old, correction, drive_change, change = work.before[0], work.before[1], 0.0, 0.0, 0.0
    after, motor = state.x_t, state.motor
    for k in range(3):
        node = 0 if k == 0 else plan.segments
        place = x[0, node] if k < 2 else work.before_motor[0]
        speed = old[0, node] if k < 2 else work.before_motor[1]
        change = 0.5 * ((after[0, node] if k < 2 else motor[1]) - speed)
        speed += change
        half, held = 0.5 * plan.shaft[at.RIM_MASS, k], plan.shaft[at.HOLDING, k] * place
        row[column.ANGLE + k], row[column.SPEED + k] = (
            place / plan.shaft[at.RADIUS, k],
            speed / plan.shaft[at.RADIUS, k],
        )
        row[column.SHAFT_ENERGY + k] = half * speed * speed
        row[column.JOINT_ENERGY] += 0.5 * held * place
        correction += half * change * change + 0.5 * plan.step * held * change
        if k == 0:
            drive_change = change
    if plan.driven == 2:
        twist = x[0, 0] - work.before_motor[0]
        row[column.JOINT_ENERGY] += 0.5 * plan.joint_stiffness * twist * twist
        return correction + 0.5 * plan.step * plan.joint_stiffness * twist * (drive_change - change)
    row[column.ANGLE + 2], row[column.SPEED + 2] = row[column.ANGLE], row[column.SPEED]
    return correction
