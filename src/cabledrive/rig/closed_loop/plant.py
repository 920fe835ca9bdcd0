"""The plant of the rig: a lumped chain made ready for exact steps."""

from dataclasses import replace
from math import inf

import numpy as np
from numpy.typing import NDArray

from cabledrive.parameters import InputRefused
from cabledrive.reduction.lumped_chain import LumpedChain, state_space
from cabledrive.rig.closed_loop.batch_tables import exponentials
from cabledrive.rig.closed_loop.piecewise_kernels import PiecewiseNumbers
from cabledrive.rig.closed_loop.plant_kernels import PlantNumbers

Array = NDArray[np.float64]
SLOPE = 50.0


def plant_numbers(
    chain: LumpedChain, interval: float, *, current_rate: float = 0.0, substeps: int = 1, smooth: bool = False
) -> PlantNumbers:
    """Exact transitions of a lumped chain over one internal step.

    Coulomb friction of the motor is set-valued; that of the load is c tanh(50 w), held over an internal step.

    ``chain``: links between equal angles; ``interval``: sample time [s]; ``current_rate``: bandwidth of the
    torque loop [rad/s]; 0: none; ``substeps``: internal steps per sample; ``smooth``: the motor's friction as
    well is c tanh(50 w).
    Raises `InputRefused` if an inertia between motor and load has Coulomb friction of its own.
    """
    n = chain.size
    inner = [(c, name) for c, name in zip(chain.coulomb[1:-1], chain.names[1:-1], strict=True) if c > 0.0]
    part = "".join(f"{name} pulley" if name == "drive" else name for _, name in inner[:1])
    if inner:
        raise InputRefused(
            f"Coulomb friction {inner[0][0]:.4g} N m of the {part} "
            "beside a flexible joint is not followed here: add it to the motor's, or make the joint rigid"
        )
    rates = _rates(chain, current_rate)
    step = interval / substeps
    load_coulomb = chain.coulomb[-1] if n > 1 else 0.0
    return PlantNumbers(
        rates=rates,
        tables=_tables(rates, step),
        scalars=np.array(
            [
                step,
                chain.inertias[0],
                chain.coulomb[0],
                chain.offsets[0],
                load_coulomb,
                SLOPE,
                current_rate,
                _norm(rates[:, : 2 * n + 1]),
                SLOPE if smooth else 0.0,
            ]
        ),
    )


def piecewise_numbers(
    chain: LumpedChain, step: float, *, current_rate: float = 0.0, play: float = 0.0, slack: float = inf
) -> PiecewiseNumbers:
    """Linear pieces of a chain whose joint has backlash, or whose spans may go slack; empty if neither.

    ``chain``: links between equal angles; ``step``: internal step [s]; ``current_rate``: bandwidth of the
    torque loop [rad/s]; 0: none; ``play``: backlash of the first link, from end to end [rad]; ``slack``:
    twist of the last link beyond which one span of two is slack [rad]; infinite: never.
    """
    m, pieces = 2 * chain.size + 1, []
    if play > 0.0 or slack < inf:
        pieces = [_softened(chain, first, last) for last in (1.0, 0.5) for first in (1.0, 0.0)]
    rates = np.zeros((len(pieces), m, m + 3))
    tables = np.zeros((len(pieces), 2, m, m + 4))
    for i, piece in enumerate(pieces):
        rates[i] = _rates(piece, current_rate)
        tables[i] = _tables(rates[i], step)
    return PiecewiseNumbers(rates=rates, tables=tables, play=0.5 * play, slack=slack)


def _softened(chain: LumpedChain, first: float, last: float) -> LumpedChain:
    """The chain with shares of its first and of its last link."""
    shares = np.ones(chain.size - 1)
    shares[0] *= first
    shares[-1] *= last
    stiffness = tuple(float(v) for v in shares * chain.stiffness)
    damping = tuple(float(v) for v in shares * chain.damping)
    return replace(chain, stiffness=stiffness, damping=damping)


def _tables(rates: Array, step: float) -> Array:
    """States after an internal step, from states and inputs, the motor held and free."""
    m = rates.shape[0]
    block = np.zeros((2, m + 4, m + 4))
    block[:, :m, : m + 3] = rates
    block[0, m // 2] = 0.0
    block[:, m + 1, m + 3] = 1.0 / step  # the motor's torque, rising
    return np.ascontiguousarray(exponentials(block * step)[:, :m])  # kernels are compiled for one layout


def _rates(chain: LumpedChain, current_rate: float) -> Array:
    n = chain.size
    a, b = state_space(chain)
    rates = np.zeros((2 * n + 1, 2 * n + 4))
    rates[: 2 * n, : 2 * n], rates[: 2 * n, 2 * n] = a, b[:, 0]
    rates[2 * n, 2 * n : 2 * n + 2] = -current_rate, current_rate
    rates[: 2 * n, 2 * n + 2], rates[: 2 * n, 2 * n + 3] = b[:, 0], b[:, -1]
    return rates


def _norm(rates: Array) -> float:
    """A rate [1/s] that bounds the growth of the power series' terms."""
    from scipy.linalg import matrix_balance

    return float(np.linalg.norm(matrix_balance(rates, permute=False)[0], 1))
