"""Where two followed curves of frequency cross, and where they veer away from each other."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations, pairwise

import numpy as np

from cabledrive.parameters.arrays import Array
from cabledrive.studies.following import TOUCHING, Follower, Station

_EXCHANGED = 0.5
_REFINEMENTS = 12


@dataclass(frozen=True, slots=True, kw_only=True)
class Crossing:
    """Two curves that come together.

    Attributes
    ----------
    kind : {"crossing", "veering"}
        Crossing: they change order, each keeps its shape. Veering: they keep their order and exchange shapes.
    value : float
        Value of the parameter, of a veering where the relative gap is least.
    frequency : float
        Mean of the two frequencies there [Hz].
    gap : float
        Their difference there [Hz]; zero at a crossing.
    curves : (int, int)
        Numbers of the two curves.
    """

    kind: str
    value: float
    frequency: float
    gap: float
    curves: tuple[int, int]


def crossings(follower: Follower, path: list[Station]) -> list[Crossing]:
    """All crossings and veerings between the curves of a path.

    A veering is counted where the relative gap has a least value, doubles on both sides within the path, and
    each shape on the one side is more like the other curve's shape on the other side (squared overlap above
    one half).

    ``follower``: what made the path; it refines the places.
    Returns in order of the value.
    """
    found = []
    for pair in combinations(range(path[0].frequency.size), 2):
        found += [*_crossings(path, pair), *_veerings(follower, path, pair)]
    return sorted(found, key=lambda crossing: (crossing.value, crossing.curves))


def _gaps(path: list[Station], pair: tuple[int, int]) -> Array:
    """Relative gap of two curves, signed; zero where they touch."""
    ends = np.array([station.frequency[list(pair)] for station in path])
    gap = 2.0 * (ends[:, 1] - ends[:, 0]) / ends.sum(axis=1)
    return np.where(np.abs(gap) <= TOUCHING, 0.0, gap)


def _crossings(path: list[Station], pair: tuple[int, int]) -> Iterator[Crossing]:
    gap = _gaps(path, pair)
    apart = np.flatnonzero(gap)
    for a, b in pairwise(apart):
        if gap[a] * gap[b] > 0.0:
            continue
        share = gap[a] / (gap[a] - gap[b])
        value = path[a].value + share * (path[b].value - path[a].value)
        if b - a > 1:
            value = float(np.mean([station.value for station in path[a + 1 : b]]))
        nearest = min(path[a : b + 1], key=lambda station: abs(station.value - value))
        frequency = float(np.mean(nearest.frequency[list(pair)]))
        yield Crossing(kind="crossing", value=float(value), frequency=frequency, gap=0.0, curves=pair)


def _veerings(follower: Follower, path: list[Station], pair: tuple[int, int]) -> Iterator[Crossing]:
    gap = np.abs(_gaps(path, pair))
    for i in range(1, len(path) - 1):
        if 0.0 < gap[i] < gap[i - 1] and gap[i] <= gap[i + 1]:
            closest = _closest(follower, path[i - 1 : i + 2], pair)
            least = abs(_gaps([closest], pair)[0])
            before = np.flatnonzero(gap[:i] >= 2.0 * least)
            after = np.flatnonzero(gap[i + 1 :] >= 2.0 * least)
            if (
                least
                and before.size
                and after.size
                and _exchange(path[before[-1]], path[i + 1 + after[0]], pair)
            ):
                low, high = sorted(closest.frequency[list(pair)])
                yield Crossing(
                    kind="veering",
                    value=closest.value,
                    frequency=float(0.5 * (low + high)),
                    gap=float(high - low),
                    curves=pair,
                )


def _exchange(before: Station, after: Station, pair: tuple[int, int]) -> bool:
    overlap = before.shapes[:, list(pair)].T @ after.shapes[:, list(pair)]
    return bool(overlap[0, 1] ** 2 >= _EXCHANGED and overlap[1, 0] ** 2 >= _EXCHANGED)


def _closest(follower: Follower, bracket: list[Station], pair: tuple[int, int]) -> Station:
    """The station of least gap between three, the middle one lowest: by parabolas through the squared gap."""
    low, middle, high = bracket
    for _ in range(_REFINEMENTS):
        value = _lowest_point(low, middle, high, pair)
        if abs(value - middle.value) <= 1e-9 * abs(middle.value):
            break
        there, _ = follower.step(middle, value)
        left, right = sorted((middle, there), key=lambda station: station.value)
        if abs(_gaps([left], pair)[0]) <= abs(_gaps([right], pair)[0]):
            middle, high = left, right
        else:
            low, middle = left, right
    return middle


def _lowest_point(low: Station, middle: Station, high: Station, pair: tuple[int, int]) -> float:
    x = np.array([station.value for station in (low, middle, high)]) - middle.value
    y = _gaps([low, middle, high], pair) ** 2
    scale = x[2] - x[0]
    bend, slope, _ = np.polyfit(x / scale, y, 2)
    step = -slope / (2.0 * bend) * scale if bend > 0.0 else 0.0
    return float(middle.value + np.clip(step, 0.9 * x[0], 0.9 * x[2]))
