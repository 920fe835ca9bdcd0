"""Components, tension and energy of segments under the packaged cable laws; where spans go slack."""

from math import sqrt
from typing import Any

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.compiled import njit_in_place, njit_inner
from cabledrive.simulation import plan as at
from cabledrive.simulation.plan import Plan, State, Workspace

C0, C1, C2, C3, C4, C5, C6, C7 = at.SERIES


Rope = tuple[int, bool, float, float]
"""Law, whether it goes slack, pretension [N], EA [N]."""


@njit_inner
def rope_of(plan: Plan, piece: int) -> Rope:
    """What the laws take of one rope of a piece."""
    return plan.law, plan.tension_only, plan.piece[piece, at.PRETENSION], plan.piece[piece, at.RIGIDITY]


@njit_inner
def components(law: Any, numbers: Array, plan: Plan, x: Array, p: Array) -> int:
    """Components above the pretension of all segments, into ``p``; the number of slack ones."""
    inverse, slack = plan.segment[at.INVERSE_SPACING], 0
    if law is None:
        for piece in range(plan.nodes.shape[0]):
            here = plan.nodes[piece, 0], plan.nodes[piece, 1]
            slack += segment_tensions(rope_of(plan, piece), here, x, inverse, p)
        return slack
    return law(numbers, x, inverse, p)


@njit_in_place
def law_components(law: Any, numbers: Array, x: Array, inverse: Array, p: Array) -> int:
    """Components of all segments under a law of one's own, from Python."""
    return law(numbers, x, inverse, p)


@njit_inner
def segment_tensions(rope: Rope, here: tuple[int, int], x: Array, inverse: Array, p: Array) -> int:
    """Components above the pretension of segments from one to before another; the number of slack ones."""
    law, tension_only, pretension, rigidity = rope
    slack_strain = -pretension / (rigidity + pretension)
    if law == at.EXACT:
        slack = _exact(True, rope, here, x, inverse, p)
        if slack > 0:  # or out of the range of the series
            slack = _exact(False, rope, here, x, inverse, p)
    else:
        slack = _truncated(rope, here, x, inverse, p)
    if slack > 0 and tension_only:
        for i in range(here[0], here[1]):
            if segment_strain(law, x, inverse, i) < slack_strain:
                p[0, i], p[1, i], p[2, i] = -pretension, 0.0, 0.0
    return slack


@njit_inner
def taut_range(pretension: float, rigidity: float) -> tuple[float, float, float]:
    """The z at which a rope is slack; middle and reach of those at which it is taut and the series holds."""
    slack_z = (1.0 - pretension / (rigidity + pretension)) ** 2 - 1.0
    lowest = max(slack_z, -at.LARGEST_Z)
    return slack_z, 0.5 * (at.LARGEST_Z + lowest), 0.5 * (at.LARGEST_Z - lowest)


@njit_inner
def series(factor: float, z: float) -> float:
    """The gain of the exact law near z = 0, over EA z and times a factor."""
    return factor * (C0 + z * (C1 + z * (C2 + z * (C3 + z * (C4 + z * (C5 + z * (C6 + z * C7)))))))


@njit_in_place
def _exact(by_series: bool, rope: Rope, here: tuple[int, int], x: Array, inverse: Array, p: Array) -> int:
    """Exact law, without root and division where ``by_series``; how many are slack or out of its range."""
    _, _, pretension, rigidity = rope
    slack_z, centre, reach = taut_range(pretension, rigidity)
    outside, start, one = 0, np.uintp(here[0]), np.uintp(1)  # an index that might be negative is slow
    for number in range(np.uintp(here[1]) - start):
        i = start + number
        h, after = inverse[i], i + one
        u_x, v_x, w_x = (x[0, after] - x[0, i]) * h, (x[1, after] - x[1, i]) * h, (x[2, after] - x[2, i]) * h
        z = u_x * (2.0 + u_x) + v_x * v_x + w_x * w_x
        if by_series:
            gain = series(rigidity * z, z)
            outside += abs(z - centre) > reach
        else:
            gain = rigidity * z / (1.0 + z + sqrt(1.0 + z))
            outside += z < slack_z
        across = pretension + gain
        p[0, i], p[1, i], p[2, i] = pretension * u_x + gain * (1.0 + u_x), across * v_x, across * w_x
    return outside


@njit_in_place
def _truncated(rope: Rope, here: tuple[int, int], x: Array, inverse: Array, p: Array) -> int:
    """Weak, consistently weak and linear law."""
    law, _, pretension, rigidity = rope
    stiffness, slack = rigidity + pretension, 0
    slack_strain = -pretension / stiffness
    start, one = np.uintp(here[0]), np.uintp(1)
    for number in range(np.uintp(here[1]) - start):
        i = start + number
        h, after = inverse[i], i + one
        u_x, v_x, w_x = (x[0, after] - x[0, i]) * h, (x[1, after] - x[1, i]) * h, (x[2, after] - x[2, i]) * h
        strain = u_x + 0.5 * (v_x * v_x + w_x * w_x)
        if law == at.WEAK:
            gain = rigidity * strain / (1.0 + strain)
            along, across = pretension * u_x + gain * (1.0 + u_x), pretension + gain
        elif law == at.WEAK_CONSISTENT:
            along = stiffness * strain
            across = pretension + along
        else:
            strain = u_x
            along, across = stiffness * u_x, pretension
        p[0, i], p[1, i], p[2, i] = along, across * v_x, across * w_x
        slack += strain < slack_strain
    return slack


@njit_inner
def transverse_stretch(law: int, u_x: float, v_x: float, w_x: float) -> float:
    """What the slopes add to the stretch of one segment."""
    slopes = v_x * v_x + w_x * w_x
    if law == at.EXACT:
        return slopes / (sqrt((1.0 + u_x) ** 2 + slopes) + 1.0 + u_x)
    return 0.5 * slopes


@njit_inner
def gradients(x: Array, inverse: Array, i: int) -> tuple[float, float, float]:
    """Slopes of one segment."""
    h = inverse[i]
    return (x[0, i + 1] - x[0, i]) * h, (x[1, i + 1] - x[1, i]) * h, (x[2, i + 1] - x[2, i]) * h


@njit_inner
def segment_strain(law: int, x: Array, inverse: Array, i: int) -> float:
    """Apparent strain of one segment."""
    u_x, v_x, w_x = gradients(x, inverse, i)
    return u_x if law == at.LINEAR else u_x + transverse_stretch(law, u_x, v_x, w_x)


@njit_inner
def segment_energy(rope: Rope, x: Array, inverse: Array, i: int) -> tuple[float, float]:
    """Tension and energy per length of one segment under a packaged law."""
    law, tension_only, pretension, rigidity = rope
    stiffness = pretension + rigidity
    u_x, v_x, w_x = gradients(x, inverse, i)
    slopes = transverse_stretch(law, u_x, v_x, w_x)
    strain = u_x if law == at.LINEAR else u_x + slopes
    pull = pretension + stiffness * strain
    if tension_only and pull < 0.0:
        return 0.0, -pretension * (0.5 * pretension / stiffness + u_x)
    return pull, pretension * slopes + 0.5 * stiffness * strain * strain


@njit_inner
def strains(plan: Plan, x: Array, tension: Array, stored: Array) -> None:
    """Tension and energy per length of all segments."""
    for piece in range(plan.nodes.shape[0]):
        rope = rope_of(plan, piece)
        for i in range(plan.nodes[piece, 0], plan.nodes[piece, 1]):
            tension[i], stored[i] = segment_energy(rope, x, plan.segment[at.INVERSE_SPACING], i)


@njit_inner
def strain_directions(plan: Plan, x: Array, direction: Array) -> None:
    """Derivative of the strain of each segment, along which it is damped; zero where it is slack."""
    inverse = plan.segment[at.INVERSE_SPACING]
    for piece in range(plan.nodes.shape[0]):
        limit = plan.piece[piece, at.SLACK_STRAIN]
        for i in range(plan.nodes[piece, 0], plan.nodes[piece, 1]):
            u_x, v_x, w_x = gradients(x, inverse, i)
            along, sideways = 1.0, 0.0 if plan.law == at.LINEAR else 1.0
            if plan.law == at.EXACT:
                sideways = 1.0 / sqrt((1.0 + u_x) ** 2 + v_x * v_x + w_x * w_x)
                along = (1.0 + u_x) * sideways
            if plan.tension_only and segment_strain(plan.law, x, inverse, i) < limit:
                along, sideways = 0.0, 0.0
            direction[0, i], direction[1, i], direction[2, i] = along, sideways * v_x, sideways * w_x


@njit_inner
def note_slack(plan: Plan, state: State) -> None:
    """Note where and when a piece goes slack that was taut at the step before."""
    for piece in range(plan.nodes.shape[0]):
        least, place, limit = 0.0, -1, plan.piece[piece, at.SLACK_STRAIN]
        for i in range(plan.nodes[piece, 0], plan.nodes[piece, 1]):
            above = segment_strain(plan.law, state.x, plan.segment[at.INVERSE_SPACING], i) - limit
            if above < least:
                least, place = above, i - plan.nodes[piece, 0]
        if place >= 0 and state.slack[piece] == 0:
            if state.counts[at.EVENTS] < at.MOST_EVENTS:
                event = state.events[state.counts[at.EVENTS]]
                event[0], event[1], event[2] = state.counts[at.STEPS], piece, place
                event[3] = (plan.piece[piece, at.RIGIDITY] + plan.piece[piece, at.PRETENSION]) * least
            state.counts[at.EVENTS] += 1
        state.slack[piece] = 1 if place >= 0 else 0


@njit_inner
def end_pulls(plan: Plan, p: Array, work: Workspace) -> None:
    """Components beside both ends of all pieces."""
    for piece in range(plan.nodes.shape[0]):
        for axis in range(3):
            work.pull[piece, 0, axis] = p[axis, plan.nodes[piece, 0]]
            work.pull[piece, 1, axis] = p[axis, plan.nodes[piece, 1] - 1]


@njit_inner
def add_pulls(plan: Plan, work: Workspace, force: Array) -> None:
    """Add what the ends of all pieces do to the coordinates."""
    for piece in range(plan.nodes.shape[0]):
        for side in range(2):
            sign = plan.piece[piece, at.ROPES] if side == 0 else -plan.piece[piece, at.ROPES]
            for axis in range(3):
                row = 6 * piece + 3 * side + axis
                pull = sign * work.pull[piece, side, axis]
                for entry in range(plan.row_start[row], plan.row_start[row + 1]):
                    force[plan.row_column[entry]] += plan.row_value[entry] * pull
