r"""Modes of a machine in one pose, followed from pose to pose.

Between two poses the modes are matched by the modal assurance of their displacements at points of all spans,
along them for longitudinal modes and across for transverse ones,

.. math:: \mathrm{MAC}_{ij} = \frac{(\phi_i\cdot\psi_j)^2}{(\phi_i\cdot\phi_i)\,(\psi_j\cdot\psi_j)}

so that the sum over all pairs is largest. Where a pair falls below a limit, or two exchange their shapes,
half of the step is tried (`cabledrive.studies.following.followed`).
"""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import pairwise
from math import sqrt
from operator import attrgetter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.network.assembly import Network
from cabledrive.mechanics.network.motion import ACROSS, ALONG
from cabledrive.modal import Mode
from cabledrive.modal.mode import LONGITUDINAL, TRANSVERSE
from cabledrive.modal.route_network import network_of_routes
from cabledrive.modal.spectrum import Spectrum
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.waves import WAYS, Waves, waves_of
from cabledrive.studies.following import DECISIVE, followed

_Key = tuple[str, str, int, int]
"""Of a transverse mode: span, plane, first piece if nothing else moves than a section of one span, else -1,
and number among those of these."""

POINTS = np.sort(0.5 * (sqrt(5.0) - 1.0) * np.arange(1, 22) % 1.0)
"""Shares of a span's length at which its displacement is looked at: no wave has its nodes at all of them."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Snapshot:
    """A machine in one pose: q longitudinal modes that move a coordinate and a transverse ones."""

    network: Network
    along: tuple[Mode, ...]
    across: tuple[Mode | None, ...]  # None: not below the highest frequency in this pose
    keys: tuple[_Key, ...]  # of the transverse modes
    pieces: tuple[tuple[int, ...], ...]  # that can move in each of them
    # along_shape, shape: displacement at the points of all spans, along them, (points, q), and from the chord
    # in both planes, (points, a) [kg^-1/2]
    along_shape: Array
    shape: Array
    # along_sign, across_sign: -1 for modes that are turned round, (q,), (a,)
    along_sign: Array
    across_sign: Array

    def with_keys(self, beside: Mapping[_Key, "Snapshot"], count: int) -> "Snapshot":
        """These transverse modes and first longitudinal ones; ``beside``: where the missing ones are."""
        keys = sorted(beside)
        places = [(beside[key], beside[key].keys.index(key)) for key in keys]
        have = [self.keys.index(key) if key in self.keys else None for key in keys]
        shape = [
            one.shape[:, place] if own is None else self.shape[:, own]
            for own, (one, place) in zip(have, places, strict=True)
        ]
        fewer = rearranged(self, "along", np.arange(count), np.ones(count))
        return replace(
            fewer,
            keys=tuple(keys),
            across=tuple(None if own is None else self.across[own] for own in have),
            pieces=tuple(one.pieces[place] for one, place in places),
            shape=np.array(shape).reshape(len(keys), -1).T.copy(),
            across_sign=np.ones(len(keys)),
        )

    def waves(self, across: Sequence[int] = ()) -> Waves:
        """The modes along and some of those across with signs; those of a section start upwards."""
        here = [i for i in across if self.across[i] is not None]
        modes: list[Any] = [self.across[i] for i in here]
        found, signs = waves_of(self.network, list(self.along), modes), self.across_sign[here]
        for n, i in enumerate(here):
            if self.keys[i][2] >= 0:
                signs[n] = 1.0 if found.slopes[1][n, self.pieces[i][0], 0] >= 0.0 else -1.0
        return found.turned(self.along_sign, signs)


def longitudinal_of(network: Network, count: int) -> tuple[Mode, ...]:
    """The first longitudinal modes that move a coordinate."""
    spectrum = Spectrum(network_of_routes(network, hanging=False))
    found = spectrum.first({LONGITUDINAL: count}, distinct=False)[LONGITUDINAL][0]
    return tuple(mode for mode in found if not mode.clamped)[:count]


def snapshot_of(network: Network, along: tuple[Mode, ...], top: float, *, shapes: bool = True) -> Snapshot:
    """Modes along, and across below a frequency [rad/s]; ``shapes``: whether they are to be followed."""
    listed = Spectrum(network_of_routes(network, hanging=False)).below(top)
    across, counted, names = [], Counter[tuple[str, str, int]](), network.drive.spans
    keys, pieces = list[_Key](), list[tuple[int, ...]]()
    for mode in listed:
        if mode.kind != TRANSVERSE:
            continue
        own = {number for number, way in mode.tags if way != ALONG}
        spans = {network.pieces[number].span for number in own}
        section = ALONG not in mode.ways and len(spans) == 1
        plane = "w" if ACROSS in mode.ways and (section or mode.plane == "w") else "v"
        where = names[spans.pop()] if section else mode.span or "", plane, min(own) if section else -1
        counted[where] += 1
        across.append(mode)
        keys.append((*where, counted[where]))
        pieces.append(tuple(sorted(own)))
    return Snapshot(
        network=network,
        along=along,
        across=tuple(across),
        keys=tuple(keys),
        pieces=tuple(pieces),
        along_shape=_along_shapes(network, along) if shapes else np.zeros((0, len(along))),
        shape=_shapes(network, across, keys) if shapes else np.zeros((0, len(across))),
        along_sign=np.ones(len(along)),
        across_sign=np.ones(len(across)),
    )


def _shapes(network: Network, across: Sequence[Mode], keys: Sequence[_Key]) -> Array:
    """Displacement from the chord at points of all spans, in plane, then out; zero of modes of a section."""
    spans, ends = network.drive.free_spans, np.array([0.0, *POINTS, 1.0])
    found = np.zeros((2, len(spans), POINTS.size, len(across)))
    for column, mode in enumerate(across):
        if keys[column][2] >= 0:
            continue
        way = WAYS[mode.plane or "w"]
        for number, span in enumerate(spans):
            values = mode.displacement(span.name, way, ends * span.length)[0].real
            chord = values[0] + (values[-1] - values[0]) * ends
            found[int(mode.plane != "w"), number, :, column] = (values - chord)[1:-1]
    return found.reshape(2 * len(spans) * POINTS.size, len(across))


def _along_shapes(network: Network, along: Sequence[Mode]) -> Array:
    """Displacement along every span at its points and ends, shape (points, modes)."""
    ends, spans = np.array([0.0, *POINTS, 1.0]), network.drive.free_spans
    rows = [
        [mode.displacement(one.name, ALONG, ends * one.length)[0].real for one in spans] for mode in along
    ]
    return np.array(rows).reshape(len(along), len(spans) * ends.size).T


Match = NDArray[np.intp]

SMALLEST = 0.125
"""Share of the way between two poses below which it is not halved any more in search of the modes."""
_SAME_NAME = 1e-3
_SHAPES = {"along": "along_shape", "across": "shape"}


def rearranged(one: Snapshot, kind: str, order: Match, sign: Array) -> Snapshot:
    """A snapshot whose modes of a kind stand in another order, then turned round where ``sign`` is -1."""
    shape = _SHAPES[kind]
    found: dict[str, Any] = {
        kind: tuple(getattr(one, kind)[i] for i in order),
        shape: getattr(one, shape)[:, order] * sign,
        f"{kind}_sign": getattr(one, f"{kind}_sign")[order] * sign,
    }
    return replace(one, **found)


def tracked(
    snapshots: list[Snapshot], between: Callable[[float], Snapshot]
) -> tuple[list[Snapshot], list[str]]:
    """Snapshots whose modes stand in the order of the first, and which of them stay ambiguous."""
    found, doubts, half_way = snapshots, dict[str, None](), cache(between)
    for kind, name in _SHAPES.items():
        path = _path(kind, attrgetter(name), found, half_way)
        for (before, here), (_, there) in pairwise(path):
            for i in matched(getattr(here, name), getattr(there, name))[1]:
                span, plane, _, count = here.keys[i] if kind == "across" else ("", "", -1, i + 1)
                what = f"mode {count} of {span} ({plane})" if span else f"longitudinal mode {count}"
                doubts[f"{what} between poses {int(before) + 1} and {int(before) + 2}"] = None
        found = [one for place, one in path if place % 1.0 == 0.0]
    return found, list(doubts)


def _path(
    kind: str, shape: Callable[[Snapshot], Array], poses: list[Snapshot], between: Callable[[float], Snapshot]
) -> list[tuple[float, Snapshot]]:
    """Poses, and those between that are stepped on, with their modes of a kind in the order of the first."""
    size = shape(poses[0]).shape[1]

    def at(place: float) -> Snapshot:
        return between(place) if place % 1.0 else poses[int(place)]

    def step(here: Snapshot, start: float, end: float) -> tuple[Snapshot, bool]:
        there = at(end)
        order, unsure = matched(shape(here), shape(there))
        facing = np.sum(shape(here) * shape(there)[:, order], axis=0)
        stands = not unsure and bool(np.all(order == np.arange(size)))
        # An exchange may be a crossing, or modes that turn into each other; half-way there may be another.
        stands = stands or end - start <= SMALLEST or shape(at(0.5 * (start + end))).shape[1] != size
        return rearranged(there, kind, order, np.where(facing < 0.0, -1.0, 1.0)), stands

    return followed(poses[0], range(len(poses)), step)


def matched(first: Array, last: Array) -> tuple[Match, list[int]]:
    """Modes, (points, modes), of the second that are those of the first, and the numbers of unsure ones."""
    from scipy.optimize import linear_sum_assignment

    sizes = [np.sum(own**2, axis=0) for own in (first, last)]
    listed = np.outer(sizes[0] > 0.0, sizes[1] > 0.0)
    scale = np.where(listed, np.outer(*sizes), 1.0)
    assurance = np.where(listed, (first.T @ last) ** 2 / scale, 0.0)
    _, match = linear_sum_assignment(-(assurance + _SAME_NAME * np.eye(first.shape[1])))
    rows = np.arange(match.size)
    pair, both = assurance[rows, match], listed[rows, match]
    return match, [int(i) for i in np.flatnonzero(both & (pair < DECISIVE))]
