r"""Modes followed along a parameter by their shapes, through crossings and veerings.

Shapes at two values are compared by their mass-weighted overlap: each is a vector of :math:`\sqrt{m}` times
displacement over joints and cable, of length one, so that the squared products of one shape with all shapes
at the other value add up to one. A product squared above one half therefore leaves no doubt; where none is
clearly above it, or two curves change order, the step is halved.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.spans import longitudinal_chains
from cabledrive.modal import Mode, longitudinal_modes
from cabledrive.parameters import Drive, NotComputed
from cabledrive.parameters.arrays import Array

DECISIVE = 0.75
"""Squared overlap (MAC) from which two shapes are the same mode."""

TOUCHING = 1e-9
"""Relative gap of two frequencies below which curves that change order cross."""

_GUARDS = 2
_SMALLEST_STEP = 1e-12
_MOST_STATIONS = 20_000


@dataclass(frozen=True, eq=False)
class Station:
    """Followed modes at one value.

    Attributes
    ----------
    value : float
    frequency : ndarray, shape (curves,)
        Frequencies [Hz] in the order of the curves.
    shapes : ndarray, shape (n, curves)
        Mass-weighted shapes of unit length.
    family : tuple of str
        Family of each mode.
    places : ndarray of int, shape (curves,)
        Place of each mode in the ascending list of all.
    """

    value: float
    frequency: Array
    shapes: Array
    family: tuple[str, ...]
    places: NDArray[np.intp]


class Follower:
    """Follows the modes of a drive that depends on one parameter.

    Parameters
    ----------
    drive_at : callable
        Drive at a value of the parameter.
    cells : int
        Cells per span in which shapes are compared: several for each half wave.
    """

    def __init__(self, drive_at: Callable[[float], Drive], cells: int) -> None:
        self._drive_at, self._cells = drive_at, cells
        self._known: dict[float, Station] = {}

    def modes_at(self, value: float, count: int) -> Station:
        """Modes in ascending order of frequency.

        ``count``: at least so many; each as often as its multiplicity.
        """
        known = self._known.get(value)
        if known is None or known.frequency.size < count:
            drive = self._drive_at(value)
            known = self._known[value] = _station(value, drive, count, self._cells)
        return known

    def path(self, values: Array, curves: int) -> list[Station]:
        """Follow the first modes from the first value to the last.

        ``values``, shape (p,): strictly ascending; ``curves``: how many modes, counted from the lowest at the
        first value.
        Returns one for each value, and for each substep that was needed.
        Raises `NotComputed` if the modes cannot be distinguished.
        """
        first = self.modes_at(float(values[0]), curves)
        here = _part(first, np.arange(curves))
        stations = [here]
        smallest = _SMALLEST_STEP * max(abs(float(values[0])), abs(float(values[-1])))
        for value in values[1:]:
            targets = [float(value)]
            while targets:
                there, sure = self.step(here, targets[-1])
                if sure or abs(targets[-1] - here.value) <= smallest:
                    here = there
                    stations.append(here)
                    targets.pop()
                elif len(stations) > _MOST_STATIONS:
                    raise NotComputed(
                        f"modes are not followed beyond {here.value:.9g}: more than 20 000 steps"
                    )
                else:
                    targets.append(0.5 * (here.value + targets[-1]))
        return stations

    def step(self, here: Station, value: float) -> tuple[Station, bool]:
        """Follow from a station to another value, and say whether there is no doubt.

        The modes that are not followed, up to a few above the highest that is, are matched as well: a curve
        must not jump over one of them unnoticed.

        Returns ``there``: in the order of the curves; ``sure``: whether every shape is found again and no two
        curves changed order on the way.
        """
        curves = here.frequency.size
        beside = self._beside(here)
        found = self._partners(np.hstack((here.shapes, beside.shapes)), value)
        overlap = here.shapes.T @ found.shapes
        found = _aligned(found, overlap)
        overlap = np.vstack((here.shapes.T @ found.shapes, beside.shapes.T @ found.shapes)) ** 2
        chosen = _assignment(overlap)
        certain = overlap[np.arange(chosen.size), chosen] >= DECISIVE
        sure = bool(certain[:curves].all()) and not _order_changed(
            np.concatenate((here.frequency, beside.frequency))[certain],
            found.frequency[chosen][certain],
            curves,
        )
        return _part(found, chosen[:curves]), sure

    def _beside(self, here: Station) -> Station:
        """The modes at a station that are not followed, up to a few above the highest that is."""
        count = int(here.places.max()) + 1 + _GUARDS
        known = self.modes_at(here.value, count)
        return _part(known, np.setdiff1d(np.arange(count), here.places))

    def _partners(self, shapes: Array, value: float) -> Station:
        """So many modes at a value that most of each shape is among them."""
        count = shapes.shape[1] + _GUARDS
        while True:
            found = self.modes_at(value, count)
            caught = np.sum((shapes[:, : -_GUARDS or None].T @ found.shapes) ** 2, axis=1)
            if caught.min() >= DECISIVE or count >= 4 * shapes.shape[1] + 16:
                return found
            count *= 2


def _station(value: float, drive: Drive, count: int, cells: int) -> Station:
    modes = longitudinal_modes(drive, count=count)
    repeats = [mode.multiplicity for mode in modes]
    frequency = np.repeat([mode.frequency for mode in modes], repeats)
    family = tuple(mode.family for mode in modes for _ in range(mode.multiplicity))
    places = np.arange(frequency.size)
    return Station(value, frequency, mass_weighted_shapes(drive, modes, cells), family, places)


def mass_weighted_shapes(drive: Drive, modes: tuple[Mode, ...], cells: int) -> Array:
    """Shapes as vectors of unit length whose products are those of the kinetic energy.

    ``modes``: its longitudinal modes; ``cells``: cells per span.
    Returns shape (n, shapes): one column for each mode and multiplicity: the joints, then the cable at the
    midpoints of equal cells.
    """
    masses: dict[str, float] = {}
    for chain in longitudinal_chains(drive):
        masses |= dict(zip(chain.joints, chain.chain.all_masses, strict=True))
    midpoints = (np.arange(cells) + 0.5) * drive.span_length / cells
    cell_mass = drive.cable.mass_per_length * drive.span_length / cells
    columns = []
    for mode in modes:
        still = np.zeros(mode.multiplicity)
        joints = [np.sqrt(mass) * mode.joints.get(name, still) for name, mass in masses.items()]
        cable = [np.sqrt(cell_mass) * mode.shape(span, midpoints).T for span in drive.spans]
        columns.append(np.vstack([*joints, *cable]))
    shapes = np.hstack(columns)
    return shapes / np.linalg.norm(shapes, axis=0)


def _part(station: Station, chosen: NDArray[np.intp]) -> Station:
    family = tuple(station.family[i] for i in chosen)
    places = station.places[chosen]
    return Station(station.value, station.frequency[chosen], station.shapes[:, chosen], family, places)


def _aligned(found: Station, overlap: Array) -> Station:
    """Turn the shapes of a multiple mode, which are any basis, towards those they are compared with."""
    frequency, shapes = found.frequency, found.shapes.copy()
    groups = np.split(
        np.arange(frequency.size), np.flatnonzero(np.diff(frequency) > TOUCHING * frequency[1:]) + 1
    )
    for group in groups:
        if group.size == 1:
            continue
        part = overlap[:, group]
        nearest = np.argsort(-np.sum(part**2, axis=1), kind="stable")[: group.size]
        left, _, right = np.linalg.svd(part[np.sort(nearest)], full_matrices=True)
        rotation = np.vstack((left @ right[: left.shape[0]], right[left.shape[0] :]))
        shapes[:, group] = shapes[:, group] @ rotation.T
    return replace(found, shapes=shapes)


def _assignment(overlap: Array) -> NDArray[np.intp]:
    from scipy.optimize import linear_sum_assignment

    return np.asarray(linear_sum_assignment(-overlap)[1])


def _order_changed(before: Array, after: Array, curves: int) -> bool:
    """Whether a curve and another mode changed order, both gaps wider than round-off; curves come first."""
    gap_before = before[:curves, None] - before
    gap_after = after[:curves, None] - after
    wide = (np.abs(gap_before) > TOUCHING * before) & (np.abs(gap_after) > TOUCHING * after)
    return bool(np.any((gap_before * gap_after < 0.0) & wide))
