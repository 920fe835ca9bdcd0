r"""Modes of a machine with routes in one pose, followed from pose to pose.

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
from math import pi, sqrt
from operator import attrgetter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.holding import FREE
from cabledrive.mechanics.network import network_of
from cabledrive.mechanics.network.assembly import Network
from cabledrive.mechanics.network.motion import ALONG
from cabledrive.modal import Mode
from cabledrive.modal.natural import straight_modes
from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.route import RoutedDrive
from cabledrive.studies.following import DECISIVE, followed
from cabledrive.studies.pair_thresholds import HIGHEST, NEAR, WAYS, turns_of, waves_of

_Key = tuple[str, str, int]
"""Of a transverse mode: span, plane, number among those of that span and plane."""

POINTS = np.sort(0.5 * (sqrt(5.0) - 1.0) * np.arange(1, 22) % 1.0)
"""Shares of a span's length at which its displacement is looked at: no wave has its nodes at all of them."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Snapshot:
    """A machine in one pose: q longitudinal modes that a motor drives and a transverse ones."""

    # along, along_loss: (q,): [rad/s], [1/s]
    along: Array
    along_loss: Array
    along_turn: Array  # (q, motors): turn of the motors in a mode of unit modal mass [rad/sqrt(kg)]
    along_shape: Array  # (points, q): displacement along the spans at the points of all of them [kg^-1/2]
    strain: Array  # (pieces, q): rise of the tension of each piece by a mode [N/(m sqrt(kg))]
    tension: Array  # (pieces,): lowest at rest [N]
    keys: tuple[_Key, ...]  # of the transverse modes
    # across, across_loss: (a,): [rad/s], [1/s]
    across: Array
    across_loss: Array
    across_turn: Array  # (a, motors)
    coupling: Array  # (q, a, a): of Eq. (N.11)
    # (points, a): displacement from the chord of the span at the points of all spans, both planes [kg^-1/2]
    shape: Array
    certified: bool
    top: float  # frequency up to which longitudinal modes are listed [Hz]

    @property
    def reach(self) -> float:
        """Transverse modes above it are not listed: no longitudinal mode excites them [rad/s]."""
        return pi * (1.0 + NEAR) * self.top

    def with_keys(self, beside: Mapping[_Key, "Snapshot"], count: int) -> "Snapshot":
        """These transverse modes and first longitudinal ones; ``beside``: those of missing ones."""
        keys = sorted(beside)
        have = [n for n, key in enumerate(keys) if key in self.keys]
        own = [self.keys.index(keys[n]) for n in have]
        places = [(beside[key], beside[key].keys.index(key)) for key in keys]
        fewer, size = rearranged(self, "along", np.arange(count), np.ones(count)), len(keys)
        shape = np.array([one.shape[:, place] for one, place in places])
        moved: dict[str, Any] = {
            "across": np.full(size, self.reach),
            "across_loss": np.array([one.across_loss[place] for one, place in places]),
            "across_turn": np.zeros((size, self.across_turn.shape[1])),
            "coupling": np.zeros((count, size, size)),
            "shape": shape.reshape(size, len(self.shape)).T.copy(),
        }
        for name in ("across", "across_loss", "across_turn"):
            moved[name][have] = getattr(self, name)[own]
        kept = self.coupling[np.ix_(range(count), own, own)]
        moved["coupling"][np.ix_(range(count), have, have)] = kept
        moved["shape"][:, have] = self.shape[:, own]
        return replace(fewer, keys=tuple(keys), **moved)


def snapshot_of(drive: RoutedDrive, wanted: float | None = None) -> Snapshot:
    """Modes of a machine with free rotors, to ``wanted`` [Hz] or thrice the lowest that a motor drives."""
    network = network_of(drive, motor=FREE)
    top = wanted
    if top is None:
        listed = straight_modes(drive, count=10, motor=FREE).longitudinal
        turning = (mode for mode in listed if not mode.clamped and np.any(turns_of(network, mode)))
        lowest = next(turning, None)
        if lowest is None:
            raise InputRefused(
                "motion: no motor turns in the first longitudinal modes: it changes no tension"
            )
        top = HIGHEST * lowest.frequency
    found = straight_modes(drive, below=top * 1.0001, motor=FREE)
    modes = (mode for mode in found.longitudinal if not mode.clamped and np.any(turns_of(network, mode)))
    across = [mode for mode in found.transverse if mode.frequency <= 0.5 * (1.0 + NEAR) * top]
    waves = waves_of(network, list(modes), across)
    turns = np.array([turns_of(network, mode) for mode in waves.along])
    signs = np.array([np.sign(own[np.flatnonzero(own)[0]]) for own in turns])
    # A mode leaves the start of the piece that it moves most upwards, the same in every pose.
    most = np.abs(waves.slopes[1]).max(axis=2).argmax(axis=1)
    facing = np.where(waves.slopes[1][np.arange(len(across)), most, 0] >= 0.0, 1.0, -1.0)
    crossed = np.array([turns_of(network, mode) for mode in across]).reshape(len(across), turns.shape[1])
    losses = waves.losses
    counted, keys = Counter[tuple[str, str]](), list[_Key]()
    for mode in across:
        where = mode.span or "", mode.plane or "w"
        counted[where] += 1
        keys.append((*where, counted[where]))
    return Snapshot(
        along=np.array([2.0 * pi * mode.frequency for mode in waves.along]),
        along_loss=losses[0],
        along_turn=signs[:, None] * turns,
        along_shape=_along_shapes(network, waves.along) * signs,
        strain=waves.rigidity[:, None] * (waves.slopes[0] @ waves.weights).T * signs,
        across=np.array([2.0 * pi * mode.frequency for mode in across]),
        across_loss=losses[1],
        across_turn=facing[:, None] * crossed,
        shape=_shapes(network, across) * facing,
        tension=np.array([min(piece.start_tension, piece.end_tension) for piece in network.pieces]),
        keys=tuple(keys),
        coupling=signs[:, None, None] * waves.couplings * np.outer(facing, facing),
        certified=found.certified,
        top=top,
    )


def peaks_of(shape: Array) -> Array:
    """Largest displacement in each mode, (a,), by the `Snapshot.shape`; of waves by their mean square."""
    spans = shape.reshape(-1, POINTS.size, shape.shape[1])
    squares = np.maximum((spans**2).max(axis=1, initial=0.0), 2.0 * np.mean(spans**2, axis=1))
    return np.sqrt(squares.max(axis=0, initial=0.0))


def _shapes(network: Network, across: Sequence[Mode]) -> Array:
    """Displacement from the chord at the points of all spans, in plane and then out of plane."""
    spans, ends = network.drive.free_spans, np.array([0.0, *POINTS, 1.0])
    found = np.zeros((2, len(spans), POINTS.size, len(across)))
    for column, mode in enumerate(across):
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


_AXES: dict[str, dict[str, tuple[int, ...]]] = {
    "along": {
        **dict.fromkeys(("along", "along_loss", "along_turn", "coupling"), (0,)),
        **dict.fromkeys(("along_shape", "strain"), (1,)),
    },
    "across": {"across": (0,), "across_loss": (0,), "across_turn": (0,), "shape": (1,), "coupling": (1, 2)},
}
"""Of each kind of mode the figures of a snapshot that it has, and their axes over its modes."""
_SHAPES = {"along": "along_shape", "across": "shape"}


def rearranged(one: Snapshot, kind: str, order: Match, sign: Array) -> Snapshot:
    """A snapshot whose modes of a kind stand in another order, then turned round where ``sign`` is -1."""
    found: dict[str, Any] = {}
    for name, axes in _AXES[kind].items():
        found[name] = getattr(one, name)
        for axis in axes:
            found[name] = np.take(found[name], order, axis)
            if name not in (kind, f"{kind}_loss"):
                found[name] = found[name] * np.expand_dims(
                    sign, [k for k in range(found[name].ndim) if k != axis]
                )
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
                span, plane, count = here.keys[i] if kind == "across" else ("", "", i + 1)
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
