"""The modes of the plane of gravity: counted by the signs of its matrix, one found after another."""

from math import sqrt

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.heavy_string import transfer
from cabledrive.modal.plane_mode import PlaneMode, localised
from cabledrive.modal.sagging_matrix import SaggingMatrix
from cabledrive.modal.section_string import SectionMotion
from cabledrive.modal.solver import ENCLOSURE

Array = NDArray[np.float64]


class SaggingPlane:
    """The plane of gravity up to one frequency.

    Parameters
    ----------
    matrix : SaggingMatrix
        Of the machine.
    """

    def __init__(self, matrix: SaggingMatrix) -> None:
        self._matrix = matrix
        self._counts: dict[float, int] = {}

    def count(self, omega: float) -> int:
        """Modes of the plane below a frequency, along and across, without the rigid-body mode.

        ``omega`` [rad/s].
        """
        if omega <= 0.0:
            return 0
        if omega not in self._counts:
            from scipy.linalg.lapack import dsytrf

            factors, pivots, _ = dsytrf(self._matrix.scaled(omega)[0], lower=1)
            negative = _negative_blocks(np.diag(factors), pivots)
            self._counts[omega] = max(negative - len(self._matrix.pulls) - self._matrix.rigid_body_modes, 0)
        return self._counts[omega]

    def frequency(self, number: int, low: float, high: float) -> tuple[float, bool]:
        """One natural frequency, by the eigenvalue that passes zero there and by counts where that is rough.

        ``number``: from 1, the rigid-body mode left out; ``low``, ``high``: frequencies between which the
        count reaches that number [rad/s].
        Returns ``omega`` [rad/s]; ``proven``: whether counts on both sides of the enclosure prove it.
        """
        low = max((omega for omega, count in self._counts.items() if count < number), default=low)
        high = min((omega for omega, count in self._counts.items() if count >= number), default=high)
        while high - low > 0.05 * high:
            middle = (low + high) / 2.0
            low, high = (low, middle) if self.count(middle) >= number else (middle, high)
        low, high = self._by_eigenvalue(number, low, high)
        while high - low > 2.0 * ENCLOSURE * high:
            middle = (low + high) / 2.0
            if not low < middle < high:
                break
            low, high = (low, middle) if self.count(middle) >= number else (middle, high)
        return (low + high) / 2.0, high - low <= 2.0 * ENCLOSURE * high

    def _by_eigenvalue(self, number: int, low: float, high: float) -> tuple[float, float]:
        """A narrow interval around a root of one eigenvalue, where counts confirm it; else the given one."""
        from scipy.optimize import brentq

        place = number - 1 + len(self._matrix.pulls) + self._matrix.rigid_body_modes

        def eigenvalue(omega: float) -> float:
            return float(np.linalg.eigvalsh(self._matrix.scaled(omega)[0])[place])

        if not eigenvalue(low) > 0.0 >= eigenvalue(high):
            return low, high
        root = brentq(eigenvalue, low, high, xtol=1e-300, rtol=4e-15)
        for room in (0.9 * ENCLOSURE, 20.0 * ENCLOSURE, 1e-9):
            inner, outer = root * (1.0 - room), root * (1.0 + room)
            if self.count(inner) < number <= self.count(outer):
                return inner, outer
        return low, high

    def motions(self, number: int, count: int, omega: float, proven: bool) -> list[PlaneMode]:
        """The modes of one natural frequency: the eigenvectors that belong to their numbers.

        ``number``: of the first, from 1; ``count``: how many share the frequency; ``omega`` [rad/s];
        ``proven``: passed on.
        """
        matrix, scale = self._matrix.scaled(omega)
        first = number - 1 + len(self._matrix.pulls) + self._matrix.rigid_body_modes
        vectors = np.linalg.eigh(matrix)[1][:, first : first + count]
        return localised([self._motion(scale * vector, omega, proven) for vector in vectors.T])

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
