"""Coulomb friction of a network: bearings, bodies, motors, and ropes on their wraps."""

from dataclasses import dataclass

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.network import Network
from cabledrive.mechanics.network.dry_friction import coulomb_of
from cabledrive.simulation.network.wraps import Wrap
from cabledrive.simulation.runs import Integers


@dataclass(frozen=True, kw_only=True, eq=False)
class Rubbing:
    """What rubs, and how much."""

    names: tuple[str, ...]
    rows: Array  # (k, n): speed of what rubs per speed of the coordinates
    bound: Array  # (k,): largest friction [N], [N m]; of a wrap per tension of its slacker side
    wrap: Integers  # (k, 2): pieces before and behind a wrap; -1 elsewhere
    rest: Array
    """(n,): difference of the tensions at rest on both sides of a wrap, which its friction holds [N]."""


def rubbing_of(network: Network, wraps: list[Wrap], tension: Array) -> Rubbing:
    """All Coulomb friction; ``tension``, shape (pieces,): at rest, of one rope [N]."""
    parts, motion = coulomb_of(network), network.motion
    n, rest = len(motion.names), np.zeros(len(motion.names) + len(wraps))
    rows = np.zeros((len(parts) + len(wraps), rest.size))
    for k, (_, row, _) in enumerate(parts):
        rows[k, :n] = row
    for k, wrap in enumerate(wraps):
        rows[len(parts) + k, n + k] = 1.0
        rest[n + k] = wrap.ropes * (tension[wrap.behind] - tension[wrap.before])
    return Rubbing(
        names=(*(name for name, _, _ in parts), *(f"wrap at {wrap.name}" for wrap in wraps)),
        rows=rows,
        bound=np.array([*(bound for _, _, bound in parts), *(wrap.ropes * wrap.factor for wrap in wraps)]),
        wrap=np.array(
            [*((-1, -1) for _ in parts), *((wrap.before, wrap.behind) for wrap in wraps)], dtype=np.int64
        ).reshape(-1, 2),
        rest=rest,
    )
