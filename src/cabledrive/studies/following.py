r"""Modes followed along a parameter by their shapes, and where two curves cross or veer.

Shapes at two values are compared by their mass-weighted overlap: each is a vector of :math:`\sqrt{m}` times
displacement over joints and cable, of length one, so that the squared products of one shape with all shapes
at the other value add up to one. A product squared above one half therefore leaves no doubt; where none is
clearly above it, or two curves change order, the step is halved.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import combinations, pairwise
from typing import TYPE_CHECKING, TypeVar

import numpy as np
from numpy.typing import NDArray

from cabledrive.modal import Mode, natural
from cabledrive.modal.elements import ACROSS, ALONG
from cabledrive.modal.mode import TRANSVERSE
from cabledrive.modal.ranges import ALLOWED
from cabledrive.modal.rows import MASS
from cabledrive.parameters import Drive, InputRefused, Machine, NotComputed, content_hash
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.keys import quantity_of, varied_together

if TYPE_CHECKING:
    import xarray as xr

DECISIVE = 0.6
"""Squared overlap (MAC) from which two shapes are the same mode, of loops and of routes."""

TOUCHING = 1e-9
"""Relative gap of two frequencies below which curves that change order cross."""

_GUARDS = 2
_SMALLEST_STEP = 1e-12
_MOST_STATIONS = 20_000
Modes = TypeVar("Modes")


def followed(
    start: Modes, values: Sequence[float] | Array, step: Callable[[Modes, float, float], tuple[Modes, bool]]
) -> list[tuple[float, Modes]]:
    """Follow modes from the first of ``values`` to the last: every value that is stepped on, and its modes.

    ``step`` takes modes from one value to another, and says whether that may stand; else half of it is tried.
    """
    path = [(float(values[0]), start)]
    for value in values[1:]:
        targets = [float(value)]
        while targets:
            before, here = path[-1]
            there, stands = step(here, before, targets[-1])
            if stands:
                path.append((targets.pop(), there))
            elif len(path) > _MOST_STATIONS:
                raise NotComputed(f"modes are not followed beyond {before:.9g}: more than 20 000 steps")
            else:
                targets.append(0.5 * (before + targets[-1]))
    return path


@dataclass(frozen=True, eq=False)
class Station:
    """Followed modes at one value."""

    value: float
    frequency: Array  # (curves,): frequencies [Hz] in the order of the curves
    shapes: Array  # (n, curves): Mass-weighted shapes of unit length
    family: tuple[str, ...]  # family of each mode
    places: NDArray[np.intp]  # (curves,): place of each mode in the ascending list of all


class Follower:
    """Follows the modes of a drive of one parameter, shapes compared in some ``cells`` per span."""

    def __init__(self, drive_at: Callable[[float], Machine], cells: int) -> None:
        self._drive_at, self._cells = drive_at, cells
        self._known: dict[float, Station] = {}

    def modes_at(self, value: float, count: int) -> Station:
        """Modes in ascending order of frequency."""
        known = self._known.get(value)
        if known is None or known.frequency.size < count:
            drive = self._drive_at(value)
            modes = natural.longitudinal_modes(drive, count=count, taut=bool(drive.called))
            repeats = [mode.multiplicity for mode in modes]
            frequency = np.repeat([mode.frequency for mode in modes], repeats)
            family = tuple(mode.family for mode in modes for _ in range(mode.multiplicity))
            shapes = mass_weighted_shapes(drive, modes, self._cells)
            known = Station(value, frequency, shapes, family, np.arange(frequency.size))
            self._known[value] = known
        return known

    def path(self, values: Array, curves: int) -> list[Station]:
        """Follow the first modes from the first of ``values`` to the last, one station for each substep."""
        first = self.modes_at(float(values[0]), curves)
        smallest = _SMALLEST_STEP * max(abs(float(values[0])), abs(float(values[-1])))

        def step(here: Station, start: float, end: float) -> tuple[Station, bool]:
            there, sure = self.step(here, end)
            return there, sure or abs(end - start) <= smallest

        return [station for _, station in followed(_part(first, np.arange(curves)), values, step)]

    def step(self, here: Station, value: float) -> tuple[Station, bool]:
        """Follow from a station to another value: where it leads, and whether there is no doubt.

        Modes beside those that are followed are matched as well: no curve jumps over one of them unnoticed.
        """
        from scipy.optimize import linear_sum_assignment

        curves = here.frequency.size
        # The modes there that are not followed, up to a few above the highest that is.
        every = np.arange(int(here.places.max()) + 1 + _GUARDS)
        beside = _part(self.modes_at(here.value, every.size), np.setdiff1d(every, here.places))
        shapes = np.hstack((here.shapes, beside.shapes))
        count = shapes.shape[1] + _GUARDS
        while True:  # so many modes that most of each shape is among them
            found = self.modes_at(value, count)
            caught = np.sum((shapes[:, : -_GUARDS or None].T @ found.shapes) ** 2, axis=1)
            if caught.min() >= DECISIVE or count >= 4 * shapes.shape[1] + 16:
                break
            count *= 2
        overlap = here.shapes.T @ found.shapes
        found = _aligned(found, overlap)
        overlap = np.vstack((here.shapes.T @ found.shapes, beside.shapes.T @ found.shapes)) ** 2
        chosen = np.asarray(linear_sum_assignment(-overlap)[1])
        certain = overlap[np.arange(chosen.size), chosen] >= DECISIVE
        before = np.concatenate((here.frequency, beside.frequency))[certain]
        after = found.frequency[chosen][certain]
        gaps = [own[:curves, None] - own for own in (before, after)]
        wide = (np.abs(gaps[0]) > TOUCHING * before) & (np.abs(gaps[1]) > TOUCHING * after)
        sure = bool(certain[:curves].all()) and not np.any((gaps[0] * gaps[1] < 0.0) & wide)
        return _part(found, chosen[:curves]), sure


def mass_weighted_shapes(machine: Machine, modes: tuple[Mode, ...], cells: int) -> Array:
    """Shapes as unit vectors whose products are those of the kinetic energy, shape (n, shapes)."""
    network = modes[0].network
    masses = [own for own in network.fixed if own.kind == MASS]
    spans = []
    for span in machine.free_spans:
        length = max(piece.end for piece in network.pieces if piece.span == span.name)
        mass = machine.ropes[span.route].density * machine.route[span.route].ropes * length
        spans.append((span.name, np.sqrt(mass / cells), (np.arange(cells) + 0.5) * length / cells))
    columns = []
    for mode in modes:
        still = np.zeros(mode.multiplicity)
        at = [mode.coordinates.get(name, still) for name in network.names]
        moved = [np.sqrt(own.factor) * sum(share * at[i] for i, share in own.row) for own in masses]
        ropes = [
            root * mode.displacement(name, way, places).T
            for name, root, places in spans
            for way in (ALONG, ACROSS)
        ]
        columns.append(np.vstack([*moved, *ropes]))
    shapes = np.hstack(columns)
    return shapes / np.linalg.norm(shapes, axis=0)


def _part(station: Station, chosen: NDArray[np.intp]) -> Station:
    family = tuple(station.family[i] for i in chosen)
    places = station.places[chosen]
    return Station(station.value, station.frequency[chosen], station.shapes[:, chosen], family, places)


def _aligned(found: Station, overlap: Array) -> Station:
    """Turn the shapes of a multiple mode, which are any basis, towards those they are compared with."""
    frequency, shapes = found.frequency, found.shapes.copy()
    apart = np.flatnonzero(np.diff(frequency) > TOUCHING * frequency[1:]) + 1
    groups = np.split(np.arange(frequency.size), apart)
    for group in groups:
        if group.size == 1:
            continue
        part = overlap[:, group]
        nearest = np.argsort(-np.sum(part**2, axis=1), kind="stable")[: group.size]
        left, _, right = np.linalg.svd(part[np.sort(nearest)], full_matrices=True)
        rotation = np.vstack((left @ right[: left.shape[0]], right[left.shape[0] :]))
        shapes[:, group] = shapes[:, group] @ rotation.T
    return replace(found, shapes=shapes)


_EXCHANGED = 0.5
_REFINEMENTS = 12


@dataclass(frozen=True, slots=True, kw_only=True)
class Crossing:
    """Two curves that come together."""

    # {"crossing", "veering"}: Crossing: they change order, each keeps its shape. Veering: they keep their
    # order and exchange shapes
    kind: str
    value: float  # value of the parameter, of a veering where the relative gap is least
    frequency: float  # mean of the two frequencies there [Hz]
    gap: float  # their difference there [Hz]; zero at a crossing
    curves: tuple[int, int]  # numbers of the two curves


def crossings(follower: Follower, path: list[Station]) -> list[Crossing]:
    """All crossings and veerings between the curves of a path, in order of the value.

    A veering: the relative gap has a least value, doubles on both sides, and the shapes are exchanged.
    """
    pairs = combinations(range(path[0].frequency.size), 2)
    found = (one for pair in pairs for one in _meetings(follower, path, pair))
    return sorted(found, key=lambda crossing: (crossing.value, crossing.curves))


def _gaps(path: list[Station], pair: tuple[int, int]) -> Array:
    """Relative gap of two curves, signed; zero where they touch."""
    ends = np.array([station.frequency[list(pair)] for station in path])
    gap = 2.0 * (ends[:, 1] - ends[:, 0]) / ends.sum(axis=1)
    return np.where(np.abs(gap) <= TOUCHING, 0.0, gap)


def _meetings(follower: Follower, path: list[Station], pair: tuple[int, int]) -> Iterator[Crossing]:
    """Crossings, then veerings of two curves."""
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
    gap = np.abs(gap)
    for i in range(1, len(path) - 1):
        if 0.0 < gap[i] < gap[i - 1] and gap[i] <= gap[i + 1]:
            closest = _closest(follower, path[i - 1 : i + 2], pair)
            least = abs(_gaps([closest], pair)[0])
            before = np.flatnonzero(gap[:i] >= 2.0 * least)
            after = np.flatnonzero(gap[i + 1 :] >= 2.0 * least)
            if not (least and before.size and after.size):
                continue
            shapes = (path[k].shapes[:, list(pair)] for k in (before[-1], i + 1 + after[0]))
            overlap = next(shapes).T @ next(shapes)
            if min(overlap[0, 1] ** 2, overlap[1, 0] ** 2) >= _EXCHANGED:  # they exchange their shapes
                low, high = sorted(closest.frequency[list(pair)])
                yield Crossing(
                    kind="veering",
                    value=closest.value,
                    frequency=float(0.5 * (low + high)),
                    gap=float(high - low),
                    curves=pair,
                )


def _closest(follower: Follower, bracket: list[Station], pair: tuple[int, int]) -> Station:
    """The station of least gap between three, the middle one lowest: by parabolas through the squared gap."""
    low, middle, high = bracket
    for _ in range(_REFINEMENTS):
        x = np.array([station.value for station in (low, middle, high)]) - middle.value
        y, scale = _gaps([low, middle, high], pair) ** 2, x[2] - x[0]
        bend, slope, _ = np.polyfit(x / scale, y, 2)
        step = -slope / (2.0 * bend) * scale if bend > 0.0 else 0.0
        value = float(middle.value + np.clip(step, 0.9 * x[0], 0.9 * x[2]))
        if abs(value - middle.value) <= 1e-9 * abs(middle.value):
            break
        there, _ = follower.step(middle, value)
        left, right = sorted((middle, there), key=lambda station: station.value)
        if abs(_gaps([left], pair)[0]) <= abs(_gaps([right], pair)[0]):
            middle, high = left, right
        else:
            low, middle = left, right
    return middle


def stamped(data: "xr.Dataset", drive: Machine, title: str) -> "xr.Dataset":
    """Add title, drive, hash, version and method to a result as attributes."""
    from cabledrive.parameters.version import __version__

    return data.assign_attrs(
        title=title,
        drive=drive.name,
        drive_hash=content_hash(drive),
        version=__version__,
        method="exact dynamic stiffness, modes isolated by counting",
    )


MOST_MODES = 200


def frequency_against(
    drive: Machine | Drive, key: str, values: Sequence[float] | Array, *, modes: int = 4
) -> "xr.Dataset":
    """Longitudinal frequencies against one quantity, each curve followed through crossings and veerings.

    A curve is one mode followed by its shape. Where two curves cross, each keeps its shape and they change
    order; where they veer, they keep their order and exchange shapes. Steps between the values are halved
    until there is no doubt which mode is which, down to gaps of 1e-9 of the frequency.

    Parameters
    ----------
    drive : Machine or Drive
    key : str
        Any quantity of the drive file: "cable.pretension", "pulley.0.inertia", "carriage.0.position"; a
        body's place, "head.x".
    values : array_like, shape (p,)
        Values in SI, in any order.
    modes : int, default 4
        Every curve is given that is among the lowest so many at one value or more.

    Returns
    -------
    xarray.Dataset
        Over ``mode`` (the curves, numbered by frequency at the smallest value) and ``value``: ``frequency``
        [Hz], ``family``; over ``value``: ``lowest_transverse`` [Hz]; over ``crossing``: ``crossing_kind``
        ("crossing" or "veering"), ``crossing_value``, ``crossing_frequency`` [Hz], ``crossing_gap`` [Hz],
        ``crossing_first`` and ``crossing_second`` (the two curves). Spans of loops and lines count as
        straight; the attribute ``warning`` says where sag moves a mode, for the least and largest value.

    Raises
    ------
    InputRefused
        If the key names no quantity of this drive, or a value is not allowed.
    NotComputed
        If the modes cannot be followed.
    """
    drive = drive.machine
    if any(route.speed for route in drive.route):
        raise InputRefused("a rope that runs (route.speed) has waves for shapes: set its speed to 0")
    unit, meaning = quantity_of(drive, key)
    array = np.asarray(values, dtype=float)
    if array.ndim != 1 or array.size == 0 or not np.isfinite(array).all():
        raise InputRefused("values: a list of finite numbers is needed: give one or more, in SI")
    if not 0 < modes <= MOST_MODES:
        raise InputRefused(f"modes = {modes} must lie between 1 and {MOST_MODES}: follow fewer at a time")
    ordered, place = np.unique(array, return_inverse=True)
    drive_at = cache(lambda value: varied_together(drive, {key: float(value)}))
    for value in ordered:  # refused before anything is followed
        drive_at(value)
    follower = Follower(drive_at, cells=256 + 16 * modes)
    path = _complete_path(follower, ordered, modes)
    stations = {station.value: station for station in path}
    shown = [stations[float(value)] for value in ordered]
    ranks = [np.sum(s.frequency < s.frequency[:, None] * (1 - 1e-9), axis=1) for s in shown]
    curves = np.flatnonzero(np.min(ranks, axis=0) < modes).tolist()
    spectra = (natural.spectrum_of(drive_at(value))[0] for value in ordered)
    across = (own.first({TRANSVERSE: 1}, distinct=True)[TRANSVERSE][0] for own in spectra)
    transverse = [own[0].frequency if own else np.nan for own in across]  # none where all is slack
    met = [m for m in crossings(follower, path) if set(m.curves) <= set(curves)]
    import xarray as xr

    frequency = np.array([station.frequency[curves] for station in shown]).T[:, place]
    family = np.array([[station.family[curve] for curve in curves] for station in shown], dtype=object).T
    lowest = {"units": "Hz", "long_name": "lowest transverse frequency"}
    data = {
        "frequency": (("mode", "value"), frequency, {"units": "Hz", "long_name": "natural frequency"}),
        "family": (("mode", "value"), family[:, place], {"long_name": "what mainly moves"}),
        "lowest_transverse": ("value", np.array(transverse)[place], lowest),
        "crossing_kind": ("crossing", np.array([m.kind for m in met], dtype=object)),
        "crossing_value": ("crossing", np.array([m.value for m in met]), {"units": unit}),
        "crossing_frequency": ("crossing", np.array([m.frequency for m in met]), {"units": "Hz"}),
        "crossing_gap": ("crossing", np.array([m.gap for m in met]), {"units": "Hz"}),
        "crossing_first": ("crossing", np.array([curves.index(m.curves[0]) for m in met], dtype=int)),
        "crossing_second": ("crossing", np.array([curves.index(m.curves[1]) for m in met], dtype=int)),
    }
    coordinates = {
        "mode": np.arange(len(curves)),
        "value": ("value", ordered[place], {"units": unit, "long_name": meaning, "key": key}),
    }
    found = stamped(xr.Dataset(data, coordinates), drive, f"frequency against {key}")
    return found.assign_attrs(warning=_moved_by_sag(drive_at, (shown[0], shown[-1])))


def _moved_by_sag(drive_at: Callable[[float], Machine], ends: Sequence[Station]) -> str:
    """Why curves of straight ropes are in doubt: how far a mode lies from those of ropes that hang."""
    for end in ends:
        hanging = natural.natural_frequencies(drive_at(end.value), below=1.5 * float(end.frequency.max()))
        moved = np.abs(end.frequency[:, None] / np.append(hanging, np.inf) - 1.0).min(axis=1).max()
        if moved > ALLOWED:
            return f"curves of the straight cable: at {end.value:.6g} sag moves a mode by {moved:.2g} of it"
    return ""


def _complete_path(follower: Follower, values: Array, modes: int) -> list[Station]:
    """Follow so many modes that every one among the lowest, at whatever value, is one of them."""
    curves = modes

    def holds_lowest(station: Station) -> bool:
        lowest = follower.modes_at(station.value, modes).frequency[:modes]
        return np.allclose(np.sort(station.frequency)[:modes], lowest, rtol=1e-9, atol=0.0)

    while curves <= 4 * modes + 16:
        path = follower.path(values, curves)
        if all(map(holds_lowest, path)):
            return path
        curves += 1 + modes // 4
    said = f"a mode among the lowest {modes} starts above the lowest {curves} at the smallest value"
    raise NotComputed(f"{said}: narrow the range")
