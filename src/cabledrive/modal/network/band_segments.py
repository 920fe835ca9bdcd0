"""Segments of heavy strings and beams in the band of a component."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.network.motion import Array
from cabledrive.modal.network.segments import Segments


class BandSegments:
    """Segments in the order and the scale of a band.

    Parameters
    ----------
    segments : Segments
    order : ndarray of int, shape (n,)
        Coordinates of the component in the order of the band.
    scale : ndarray, shape (n,)
        Factors of the coordinates in that order.
    """

    def __init__(self, segments: Segments, order: NDArray[np.intp], scale: Array) -> None:
        self.segments = segments
        self.local = (segments.local[:, order] * scale).tocsr()
        own, width = self.local.tocoo(), 2 * segments.links[0].unknowns
        self._width = width
        by_row: dict[int, list[tuple[int, float]]] = {}
        for row, column, value in zip(own.row.tolist(), own.col.tolist(), own.data.tolist(), strict=True):
            by_row.setdefault(row, []).append((column, value))
        entries = [
            (i, j, (row * width) + second % width, near * far)
            for row in by_row
            for second in range(row - row % width, row - row % width + width)
            for i, near in by_row[row]
            for j, far in by_row.get(second, ())
            if i >= j
        ]
        numbers = np.array([entry[:3] for entry in entries], dtype=np.intp).reshape(-1, 3)
        self._row, self._column, self._source = numbers.T
        self._weight = np.array([entry[3] for entry in entries])

    def add(self, band: NDArray[Any], omega: float, what: int, position: NDArray[np.int64]) -> None:
        """Add stiffness (``what`` 0) or rate (1) to a band; ``position``: places of the coordinates in it."""
        values = self.segments.both(omega)[what].ravel()[self._source] * self._weight
        row = position[self._row]
        np.add.at(band, (row, row - position[self._column]), values)

    def forms(self, omega: float, x: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
        """Quadratic forms of stiffness and rate for columns of x in the order of the band, shape (k, k)."""
        moved = (self.local @ x).reshape(-1, self._width, x.shape[1])
        energy, rate = self.segments.forms(omega, moved)
        return energy.sum(axis=0), rate.sum(axis=0)


def tied_by(segments: Segments) -> Any:
    """Which coordinates segments tie to each other: a sparse array of positive numbers, shape (n, n)."""
    from scipy.sparse import bsr_array

    width = 2 * segments.links[0].unknowns
    count = int(segments.first[-1])
    rows = abs(segments.local)
    ones = bsr_array((np.ones((count, width, width)), np.arange(count), np.arange(count + 1)))
    return rows.T @ ones @ rows
