r"""Transverse modes of a machine followed from pose to pose by their shapes.

Between two poses the modes are matched by the modal assurance of their displacements at points of all spans,

.. math:: \mathrm{MAC}_{ij} = \frac{(\phi_i\cdot\psi_j)^2}{(\phi_i\cdot\phi_i)\,(\psi_j\cdot\psi_j)}

so that the sum over all pairs is largest. Where a pair falls below a limit, or two exchange their shapes,
poses half-way are looked at.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cabledrive.studies.route_snapshot import Snapshot

Array = NDArray[np.float64]
Match = NDArray[np.intp]

SURE = 0.6
"""Modal assurance from which a pair is the same mode."""
HALVINGS = 3
"""How often the way between two poses is halved in search of the modes."""
_SAME_NAME = 1e-3


def tracked(
    snapshots: list[Snapshot], between: Callable[[float], Snapshot]
) -> tuple[list[Snapshot], list[str]]:
    """Snapshots whose transverse modes stand in the order of the first, and which of them stay ambiguous.

    ``between``: the snapshot at a place along the poses, such as 0.5 half-way from the first to the second,
    with the same names of modes in the same order.
    """
    found, doubts = [snapshots[0]], []
    order = np.arange(len(snapshots[0].keys))
    for number, one in enumerate(snapshots[1:]):
        match, unsure = _followed(snapshots[number], one, float(number), float(number + 1), between, HALVINGS)
        for i in unsure:
            span, plane, count = snapshots[number].keys[i]
            doubts.append(f"mode {count} of {span} ({plane}) between poses {number + 1} and {number + 2}")
        order = match[order]
        found.append(_signed(_ordered(one, order), found[-1]))
    return found, doubts


def _followed(
    first: Snapshot,
    last: Snapshot,
    start: float,
    end: float,
    between: Callable[[float], Snapshot],
    halvings: int,
) -> tuple[Match, list[int]]:
    """Where each mode of a pose is in the next one, and which are not sure; halved where that helps."""
    match, unsure = matched(first, last)
    stay = not unsure and bool(np.all(match == np.arange(match.size)))
    if stay or halvings == 0:  # an exchange may be a crossing, or modes that turn into each other
        return match, unsure
    middle = 0.5 * (start + end)
    half = between(middle)
    here, before = _followed(first, half, start, middle, between, halvings - 1)
    there, behind = _followed(half, last, middle, end, between, halvings - 1)
    back = np.argsort(here)
    return there[here], sorted({*before, *(int(back[i]) for i in behind)})


def matched(first: Snapshot, last: Snapshot) -> tuple[Match, list[int]]:
    """Modes of the second that are those of the first, and the numbers of those that are not sure.

    A mode that one of the two does not list, because it lies above all resonances, keeps its name.
    """
    from scipy.optimize import linear_sum_assignment

    sizes = [np.sum(own.shape**2, axis=0) for own in (first, last)]
    listed = np.outer(sizes[0] > 0.0, sizes[1] > 0.0)
    scale = np.where(listed, np.outer(*sizes), 1.0)
    assurance = np.where(listed, (first.shape.T @ last.shape) ** 2 / scale, 0.0)
    _, match = linear_sum_assignment(-(assurance + _SAME_NAME * np.eye(len(first.keys))))
    rows = np.arange(match.size)
    pair, both = assurance[rows, match], listed[rows, match]
    return match, [int(i) for i in np.flatnonzero(both & (pair < SURE))]


def _ordered(one: Snapshot, order: Match) -> Snapshot:
    """A snapshot with its transverse modes in another order."""
    return replace(
        one,
        across=one.across[order],
        across_loss=one.across_loss[order],
        across_turn=one.across_turn[order],
        coupling=one.coupling[:, order][:, :, order],
        shape=one.shape[:, order],
    )


def _signed(one: Snapshot, before: Snapshot) -> Snapshot:
    """A snapshot whose transverse modes move as those of the pose before, not against them."""
    sign = np.where(np.sum(one.shape * before.shape, axis=0) < 0.0, -1.0, 1.0)
    return replace(
        one,
        across_turn=one.across_turn * sign[:, None],
        coupling=one.coupling * np.outer(sign, sign),
        shape=one.shape * sign,
    )
