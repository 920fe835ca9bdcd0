r"""Modes of a machine followed from pose to pose by their shapes.

Between two poses the modes are matched by the modal assurance of their displacements at points of all spans,
along them for longitudinal modes and across for transverse ones,

.. math:: \mathrm{MAC}_{ij} = \frac{(\phi_i\cdot\psi_j)^2}{(\phi_i\cdot\phi_i)\,(\psi_j\cdot\psi_j)}

so that the sum over all pairs is largest. Where a pair falls below a limit, or two exchange their shapes,
poses half-way are looked at.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache

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


@dataclass(frozen=True, slots=True)
class _Kind:
    """Modes of one kind in a snapshot: their shapes, their name, and how to order and to turn them round."""

    shape: Callable[[Snapshot], Array]
    name: Callable[[Snapshot, int], str]
    ordered: Callable[[Snapshot, Match], Snapshot]
    signed: Callable[[Snapshot, Array], Snapshot]


def tracked(
    snapshots: list[Snapshot], between: Callable[[float], Snapshot]
) -> tuple[list[Snapshot], list[str]]:
    """Snapshots whose modes stand in the order of the first, and which of them stay ambiguous.

    ``between``: the snapshot at a place along the poses, such as 0.5 half-way from the first to the second,
    with as many modes of each kind, the transverse ones with the same names in the same order.
    """
    found, doubts, half_way = list(snapshots), list[str](), cache(between)
    for kind in (_ALONG, _ACROSS):
        order = np.arange(kind.shape(snapshots[0]).shape[1])
        for number, one in enumerate(snapshots[1:], 1):
            before = snapshots[number - 1]
            ends = float(number - 1), float(number)
            match, unsure = _followed(kind.shape, before, one, *ends, half_way, HALVINGS)
            doubts += [f"{kind.name(before, i)} between poses {number} and {number + 1}" for i in unsure]
            order = match[order]
            own = kind.ordered(found[number], order)
            facing = np.sum(kind.shape(own) * kind.shape(found[number - 1]), axis=0)
            found[number] = kind.signed(own, np.where(facing < 0.0, -1.0, 1.0))
    return found, doubts


def _followed(
    shape: Callable[[Snapshot], Array],
    first: Snapshot,
    last: Snapshot,
    start: float,
    end: float,
    between: Callable[[float], Snapshot],
    halvings: int,
) -> tuple[Match, list[int]]:
    """Where each mode of a pose is in the next one, and which are not sure; halved where that helps."""
    match, unsure = matched(shape(first), shape(last))
    stay = not unsure and bool(np.all(match == np.arange(match.size)))
    if stay or halvings == 0:  # an exchange may be a crossing, or modes that turn into each other
        return match, unsure
    middle = 0.5 * (start + end)
    half = between(middle)
    if shape(half).shape[1] != match.size:  # another mode lies between them there
        return match, unsure
    here, before = _followed(shape, first, half, start, middle, between, halvings - 1)
    there, behind = _followed(shape, half, last, middle, end, between, halvings - 1)
    back = np.argsort(here)
    return there[here], sorted({*before, *(int(back[i]) for i in behind)})


def matched(first: Array, last: Array) -> tuple[Match, list[int]]:
    """Modes of the second that are those of the first, and the numbers of those that are not sure.

    ``first``, ``last``, shape (points, modes): displacements. A mode that one of the two does not list,
    because it lies above all resonances, keeps its number.
    """
    from scipy.optimize import linear_sum_assignment

    sizes = [np.sum(own**2, axis=0) for own in (first, last)]
    listed = np.outer(sizes[0] > 0.0, sizes[1] > 0.0)
    scale = np.where(listed, np.outer(*sizes), 1.0)
    assurance = np.where(listed, (first.T @ last) ** 2 / scale, 0.0)
    _, match = linear_sum_assignment(-(assurance + _SAME_NAME * np.eye(first.shape[1])))
    rows = np.arange(match.size)
    pair, both = assurance[rows, match], listed[rows, match]
    return match, [int(i) for i in np.flatnonzero(both & (pair < SURE))]


def _across_name(one: Snapshot, number: int) -> str:
    span, plane, count = one.keys[number]
    return f"mode {count} of {span} ({plane})"


def _across_ordered(one: Snapshot, order: Match) -> Snapshot:
    return replace(
        one,
        across=one.across[order],
        across_loss=one.across_loss[order],
        across_turn=one.across_turn[order],
        coupling=one.coupling[:, order][:, :, order],
        shape=one.shape[:, order],
    )


def _across_signed(one: Snapshot, sign: Array) -> Snapshot:
    return replace(
        one,
        across_turn=one.across_turn * sign[:, None],
        coupling=one.coupling * np.outer(sign, sign),
        shape=one.shape * sign,
    )


def _along_ordered(one: Snapshot, order: Match) -> Snapshot:
    return replace(
        one,
        along=one.along[order],
        along_loss=one.along_loss[order],
        along_turn=one.along_turn[order],
        along_shape=one.along_shape[:, order],
        strain=one.strain[:, order],
        coupling=one.coupling[order],
    )


def _along_signed(one: Snapshot, sign: Array) -> Snapshot:
    return replace(
        one,
        along_turn=one.along_turn * sign[:, None],
        along_shape=one.along_shape * sign,
        strain=one.strain * sign,
        coupling=one.coupling * sign[:, None, None],
    )


_ACROSS = _Kind(lambda one: one.shape, _across_name, _across_ordered, _across_signed)
_ALONG = _Kind(
    lambda one: one.along_shape,
    lambda one, number: f"longitudinal mode {number + 1}",
    _along_ordered,
    _along_signed,
)
