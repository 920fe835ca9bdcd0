"""Parameters that are not identifiable from a log, in words."""

import numpy as np
from numpy.typing import NDArray

from cabledrive.identification.regression import Fit

Array = NDArray[np.float64]

NOTICED = 0.05
SIDES = {"near_inertia": "motor-side inertia"}
"""Words for parameters whose key is older than the words."""

WEAK_SHARE = 0.1
"""Share of the measured torque that a parameter's uncertainty may make before it counts as undetermined."""


def unidentifiable_words(fit: Fit) -> tuple[str, ...]:
    """Name each direction about which the log has no information."""
    return tuple(_direction_words(fit.names, direction) for direction in fit.unidentifiable)


def unidentifiable_parameters(fit: Fit) -> set[str]:
    """Parameters that no number is given for, because an unidentifiable direction moves them."""
    return {fit.names[k] for direction in fit.unidentifiable for k in _members(direction)}


def weak_parameters(fit: Fit, sizes: Array, level: float = 0.95) -> tuple[str, ...]:
    """Parameters whose interval is wider than their value, and whose uncertainty matters for the torque.

    ``sizes``, shape (p,): root mean square of each regressor.
    Returns a small parameter that the log bounds well (friction that is not there) is not among them.
    """
    half = fit.half_width(level)
    weak = (half > np.abs(fit.values)) & (half * sizes > WEAK_SHARE * fit.scale)
    return tuple(name for name, is_weak in zip(fit.names, weak, strict=True) if is_weak)


def weak_words(name: str) -> str:
    """Say that a parameter is not determined."""
    return f"{readable(name)} is not determined: its interval is wider than its value"


def readable(name: str) -> str:
    """A parameter's name as running text."""
    for side in ("positive", "negative"):
        if name.endswith(f"_{side}"):
            return f"{name.removesuffix(f'_{side}').replace('_', ' ')} ({side} speed)"
    return SIDES.get(name, name.replace("_", " "))


def _members(direction: Array) -> list[int]:
    share = np.abs(direction) / np.abs(direction).max()
    return [int(k) for k in np.argsort(-share) if share[k] > NOTICED]


def _direction_words(names: tuple[str, ...], direction: Array) -> str:
    members = sorted(_members(direction))
    if len(members) == 1:
        return f"{readable(names[members[0]])} is not identifiable: the log does not excite it"
    lead = direction[members[-1]]
    moves = [f"{'+' if direction[k] / lead > 0 else '-'} {readable(names[k])}" for k in members]
    listed = ", ".join(readable(names[k]) for k in members)
    return (
        f"{listed} are not identifiable separately: a joint change ({' '.join(moves)}) has no effect on "
        "the log"
    )
