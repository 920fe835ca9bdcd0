"""Compiled bookkeeping of the energy-conserving scheme: its stored energy and what rounding takes away.

A rim turns far while the forces on it are large, so that the rounding of its displacement would be work that
nobody does; like the stored energy it is summed with compensation.
"""

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.compiled import for_kernels, njit_in_place, njit_strict


@njit_in_place
@for_kernels
def raised_shift(shift: float, lowest: float) -> float:
    """Shift C, doubled until the energy stays half of it away from zero."""
    while lowest + shift < 0.5 * shift:
        shift *= 2.0
    return shift


@njit_strict
@for_kernels
def sum_with_loss(extra: Array, number: int, value: float, amount: float) -> float:
    """Value plus amount, and what rounding took away last time; keeps what it takes away now."""
    amount -= extra[number]
    total = value + amount
    extra[number] = (total - value) - amount
    return total
