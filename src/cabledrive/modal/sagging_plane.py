"""The modes of the plane of gravity: counted by the signs of its matrix, found together."""

from dataclasses import dataclass
from math import sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.heavy_string import transfer
from cabledrive.modal.plane_mode import PlaneMode, localised
from cabledrive.modal.sagging_matrix import SaggingMatrix
from cabledrive.modal.section_string import SectionMotion
from cabledrive.modal.solver import ENCLOSURE

Array = NDArray[np.float64]

GRID = 12
"""Parts of a window at whose ends all eigenvalues are looked at."""

OCTAVES = 8
"""Below the first of them, in the window that begins at rest."""

LARGEST_BLOCK = 2_000_000
"""Numbers in the matrices that are solved together."""

MOST_STEPS = 12
BESIDE = 1e-7
"""Relative distance of the frequency at which a slope is taken."""


@dataclass(frozen=True, slots=True)
class Group:
    """Modes of one natural frequency: number of the first, from 1, how many, the frequency [rad/s]."""

    number: int
    count: int
    omega: float
    proven: bool


class SaggingPlane:
    """The plane of gravity up to one frequency.

    Parameters
    ----------
    matrix : SaggingMatrix
        Of the machine.
    """

    def __init__(self, matrix: SaggingMatrix) -> None:
        self._matrix = matrix
        self._before = len(matrix.pulls) + matrix.rigid_body_modes  # negative eigenvalues that are no modes
        self._counts: dict[float, int] = {}

    def count(self, omega: float) -> int:
        """Modes of the plane below a frequency, along and across, without the rigid-body mode.

        ``omega`` [rad/s].
        """
        return self._counted(np.array([omega]))[0]

    def _counted(self, omega: Array) -> list[int]:
        """Modes below several frequencies, shape (k,) [rad/s]."""
        from scipy.linalg.lapack import dsytrf

        new = np.array([w for w in omega.tolist() if w > 0.0 and w not in self._counts])
        for some in self._blocks(new):
            for w, matrix in zip(some.tolist(), self._matrix.scaled(some)[0], strict=True):
                factors, pivots, _ = dsytrf(matrix, lower=1)
                self._counts[w] = max(_negative_blocks(np.diag(factors), pivots) - self._before, 0)
        return [self._counts[w] if w > 0.0 else 0 for w in omega.tolist()]

    def _blocks(self, values: NDArray[Any]) -> list[NDArray[Any]]:
        """Values, shape (k,), in parts whose matrices fit into `LARGEST_BLOCK`."""
        most = max(1, LARGEST_BLOCK // self._matrix.size**2)
        return [values[start : start + most] for start in range(0, values.size, most)]

    def frequencies(self, first: int, last: int, low: float, high: float) -> list[tuple[float, bool]]:
        """Natural frequencies, by the eigenvalues that pass zero there, confirmed by counts.

        ``first``, ``last``: numbers from 1, the rigid-body mode left out; ``low``, ``high``: frequencies
        between which the count passes all of them [rad/s].
        Returns for each ``omega`` [rad/s]; ``proven``: whether counts on both sides of the enclosure prove
        it.
        """
        numbers = np.arange(first, last + 1)
        if numbers.size == 0:
            return []
        below, above = self._brackets(numbers, low, high)
        near = np.concatenate(
            [
                self._by_eigenvalues(numbers[some], below[some], above[some])
                for some in self._blocks(np.arange(numbers.size))
            ]
        )
        room = 0.9 * ENCLOSURE
        sides = self._counted(np.concatenate((near * (1.0 - room), near * (1.0 + room))))
        found = []
        for i, number in enumerate(numbers.tolist()):
            if sides[i] < number <= sides[numbers.size + i]:
                found.append((float(near[i]), True))
            else:
                found.append(self._by_counts(number, float(near[i]), low, high))
        return found

    def _brackets(self, numbers: NDArray[np.intp], low: float, high: float) -> tuple[Array, Array]:
        """Neighbours on a grid between which each of these eigenvalues passes zero [rad/s]."""
        grid = low + (high - low) * np.arange(GRID + 1) / GRID
        if low <= 0.0:
            grid = np.concatenate((grid[1] / 2.0 ** np.arange(OCTAVES, 0, -1), grid[1:]))
        values = np.concatenate(
            [np.linalg.eigvalsh(self._matrix.scaled(some)[0]) for some in self._blocks(grid)]
        )[:, numbers - 1 + self._before]
        passed = np.clip(np.sum(values > 0.0, axis=0), 1, grid.size - 1)
        return grid[passed - 1], grid[passed]

    def _by_eigenvalues(self, numbers: NDArray[np.intp], low: Array, high: Array) -> Array:
        """Where the eigenvalues of these numbers pass zero: Newton's steps on the quotient of Rayleigh.

        Each eigenvector is kept for its slope, so that the steps converge with the third order. What has not
        converged is left to the counts.
        ``low``, ``high``, shape (n,): brackets [rad/s]. Returns shape (n,) [rad/s].
        """
        places = (numbers - 1 + self._before)[:, None, None]
        near = (low + high) / 2.0
        for _ in range(MOST_STEPS):
            beside = near * (1.0 + BESIDE)
            matrices, scales = self._matrix.scaled(np.concatenate((near, beside)))
            (here, there), (scale, other) = np.split(matrices, 2), np.split(scales, 2)
            values, vectors = np.linalg.eigh(here)
            value = np.take_along_axis(values, places[:, 0], axis=1)[:, 0]
            vector = np.take_along_axis(vectors, places, axis=2)
            moved = vector * (scale / other)[:, :, None]
            slope = ((np.swapaxes(moved, 1, 2) @ there @ moved)[:, 0, 0] - value) / BESIDE
            step = -value / np.where(slope < 0.0, slope, -np.inf)
            low, high = np.where(value > 0.0, near, low), np.where(value > 0.0, high, near)
            last, near = near, near * (1.0 + step)
            near = np.where((near >= low) & (near <= high), near, (low + high) / 2.0)
            if np.all(np.abs(near - last) <= 1e-9 * near):  # the next step would be below round-off
                break
        return near

    def _by_counts(self, number: int, near: float, low: float, high: float) -> tuple[float, bool]:
        """One natural frequency by counts alone, where its eigenvalue is rough.

        ``near``: where the eigenvalue says that it is; else as `frequencies`.
        """
        low = max((omega for omega, count in self._counts.items() if count < number), default=low)
        high = min((omega for omega, count in self._counts.items() if count >= number), default=high)
        for room in (20.0 * ENCLOSURE, 1e-9):
            inner, outer = near * (1.0 - room), near * (1.0 + room)
            if self.count(inner) < number <= self.count(outer):
                low, high = inner, outer
                break
        while high - low > 2.0 * ENCLOSURE * high:
            middle = (low + high) / 2.0
            if not low < middle < high:
                break
            low, high = (low, middle) if self.count(middle) >= number else (middle, high)
        return (low + high) / 2.0, high - low <= 2.0 * ENCLOSURE * high

    def motions(self, groups: list[Group]) -> list[PlaneMode]:
        """The modes of natural frequencies: the eigenvectors that belong to their numbers."""
        found: list[PlaneMode] = []
        for some in self._blocks(np.arange(len(groups))):
            matrices, scales = self._matrix.scaled(np.array([groups[i].omega for i in some]))
            for i, vectors, scale in zip(some, np.linalg.eigh(matrices)[1], scales, strict=True):
                place = groups[i].number - 1 + self._before
                own = vectors[:, place : place + groups[i].count].T
                found += localised([self._motion(scale * x, groups[i].omega, groups[i].proven) for x in own])
        return found

    def _motion(self, x: Array, omega: float, proven: bool) -> PlaneMode:
        """The motion of unit modal mass that has these unknowns."""
        parts, node = [], self._matrix.first_across
        for part in self._matrix.parts:
            ends = np.concatenate(([0.0], x[node : node + part.nodes], [0.0]))
            node += part.nodes
            waves = transfer(part.pieces, omega)
            shift = part.fall * x[self._matrix.first_pull + part.tension] / omega
            start, end = ends[:-1] - shift, ends[1:] - shift
            force = (end - start - waves.near * start) / waves.give
            parts.append(SectionMotion(part.pieces, omega, np.stack((start, force)), shift))
        along = sum(self._along_mass(i, x) for i in range(len(self._matrix.chains)))
        across = np.array([part.mass for part in parts])
        total = along + across.sum()
        unit = tuple(part.scaled(1.0 / sqrt(total)) for part in parts)
        return PlaneMode(omega, proven, along / total, across / total, unit)

    def _along_mass(self, number: int, x: Array) -> float:
        chain, _ = self._matrix.chains[number]
        joints = np.zeros(chain.masses.size + len(chain.pendants))
        joints[self._matrix.along[number]] = x[
            self._matrix.offsets[number] : self._matrix.offsets[number + 1]
        ]
        near, far = (
            joints[: chain.lengths.size],
            np.roll(joints[: chain.masses.size], -1)[: chain.lengths.size],
        )
        cable = chain.density * chain.lengths / 3.0
        return float(chain.all_masses @ joints**2 + cable @ (near**2 + near * far + far**2))


def _negative_blocks(diagonal: Array, pivots: NDArray[np.intp]) -> int:
    """Negative eigenvalues from the factors of Bunch and Kaufman: a block of two has one of each sign."""
    single = pivots > 0
    return int(np.sum(diagonal[single] < 0.0)) + int(np.sum(~single)) // 2
