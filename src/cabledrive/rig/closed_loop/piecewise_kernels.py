"""Compiled motion of a lumped chain with backlash in its joint and spans that cannot push.

The chain is linear as long as joint and spans keep their state. Each internal step goes by the piece in which
it starts: joint closed or open, both spans taut or one slack. A closed joint is a spring about half the
backlash, and with one span slack the cable is a spring of half the stiffness about the twist at which it went
slack: in both cases the linear chain with one angle shifted.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.compiled import njit_in_place
from cabledrive.rig.closed_loop.plant_kernels import advance

Array = NDArray[np.float64]


class PiecewiseNumbers(NamedTuple):
    """Linear pieces of a lumped chain; empty for one that is linear.

    Attributes
    ----------
    rates : ndarray, shape (4 or 0, m, m + 3)
        As in `PlantNumbers`; all closed and taut, joint open, one span slack, both.
    tables : ndarray, shape (4 or 0, 2, m, m + 4)
    play : float
        Half the backlash of the first link [rad]; 0: none.
    slack : float
        Twist of the last link beyond which one span is slack [rad]; infinite: never.
    """

    rates: Array
    tables: Array
    play: float
    slack: float


@njit_in_place
def side_of(value: float, limit: float) -> float:
    """-1, 0 or 1: beyond which of its two limits a value lies."""
    if abs(value) < limit:
        return 0.0
    return 1.0 if value > 0.0 else -1.0


@njit_in_place
def advance_piecewise(
    piecewise: PiecewiseNumbers,
    scalars: Array,
    x: Array,
    slip: int,
    u: float,
    motor: float,
    load: float,
    time: float,
    terms: Array,
    work: Array,
) -> int:
    """Move the chain on under a constant command, piece by piece; ``x`` is changed, the new slip returned."""
    far = x.size // 2 - 1
    step, done = scalars[0], 0.0
    while done < time * (1.0 - 1e-12):
        part = min(step, time - done)
        closed = side_of(x[0] - x[1], piecewise.play) if piecewise.play > 0.0 else 0.0
        slack = side_of(x[far - 1] - x[far], piecewise.slack)
        piece = (1 if piecewise.play > 0.0 and closed == 0.0 else 0) + (2 if slack != 0.0 else 0)
        forth = closed * piecewise.play
        back = slack * piecewise.slack if slack != 0.0 else 0.0
        x[0] -= forth
        x[far] -= back
        rates, tables = piecewise.rates[piece], piecewise.tables[piece]
        slip = advance(rates, tables, scalars, x, slip, u, motor, load, part, terms, work)
        x[0] += forth
        x[far] += back
        done += part
    return slip
