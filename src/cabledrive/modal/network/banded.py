"""A component of a network in a narrow band: order of coordinates, counts and solutions of linear cost."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.network.motion import Array
from cabledrive.modal.network.band_kernels import (
    RATE,
    STIFFNESS,
    SparseRows,
    assemble,
    for_lapack,
    forms,
    negative_pivots,
    placed,
    times,
)
from cabledrive.modal.network.band_segments import BandSegments, tied_by
from cabledrive.modal.network.component import Component
from cabledrive.modal.network.refining_kernels import counted, general_stiffness, rate_times

GROWTH = 1e4
"""Growth of the terms of an unpivoted factorisation up to which its count is taken."""


FEW = 64
"""Coordinates up to which full matrices cost less than sparse ones."""


class Banded:
    """The band of a component; its coordinates scaled so that round-off counts by energy.

    Parameters
    ----------
    component : Component
    scale : ndarray, shape (n,)
        Factors of its coordinates.
    """

    def __init__(self, component: Component, scale: Array) -> None:
        self.component = component
        self.order = _band_order(component)
        self.scale = scale[self.order]
        self.imaginary: Any = 1j if component.moving else 0.0
        self.kind = np.complex128 if component.moving else np.float64
        self.rows = _sparse_rows(component, self.order, self.scale)
        self.segments = [BandSegments(own, self.order, self.scale) for own in component.segments]

    @property
    def natural_scale(self) -> Array:
        """Factors of the coordinates in the order of the component, shape (n,)."""
        out = np.empty_like(self.scale)
        out[self.order] = self.scale
        return out

    @cached_property
    def _reversed(self) -> "Banded":
        """The same with its coordinates eliminated from the other end."""
        other = object.__new__(Banded)
        other.component, other.order = self.component, self.order[::-1].copy()
        other.scale, other.imaginary, other.kind = self.scale[::-1].copy(), self.imaginary, self.kind
        other.rows = _sparse_rows(self.component, other.order, other.scale)
        other.segments = [BandSegments(own, other.order, other.scale) for own in self.component.segments]
        return other

    def at(self, omega: float) -> "BandAt":
        """The band at a frequency [rad/s]."""
        position = np.empty(self.order.size, dtype=np.int64)
        cuts = np.empty(self.rows.time.size, dtype=np.int64)
        size, width, inside = placed(self.rows, omega, position, cuts)
        return BandAt(self, omega, position, cuts, size, width, inside)

    def count(self, omega: float) -> int | None:
        """Modes below a frequency; None where two orders of elimination lose too many digits."""
        below, growth = self._counted(omega)
        if growth > GROWTH:
            below, growth = self._reversed._counted(omega)
        return below if growth <= GROWTH else None

    def _counted(self, omega: float) -> tuple[int, float]:
        """Modes below a frequency by this order of elimination, and how its terms grow."""
        if not self.segments:
            kind = np.empty(0, dtype=self.kind)
            below, growth = counted(self.rows, omega, self.imaginary, self.order.size, kind)
            return int(below), float(growth)
        here = self.at(omega)
        negative, growth = negative_pivots(here.matrix(STIFFNESS))
        return int(negative) + here.inside, float(growth)


@dataclass(frozen=True, eq=False)
class BandAt:
    """A band with its cuts at one frequency.

    Attributes
    ----------
    banded : Banded
    omega : float
        At which the cuts were placed [rad/s].
    position, cuts : ndarray of int
        Places of the coordinates, and of the cuts of links, -1 where none.
    size, width, inside : int
        Coordinates, half bandwidth, modes that cut links hide.
    """

    banded: Banded
    omega: float
    position: NDArray[np.int64]
    cuts: NDArray[np.int64]
    size: int
    width: int
    inside: int

    def matrix(self, what: int, omega: float | None = None) -> NDArray[Any]:
        """Stiffness or rate by rows, shape (size, width + 1)."""
        own = self.banded
        band = np.empty((self.size, self.width + 1), dtype=own.kind)
        assemble(
            own.rows,
            self.omega if omega is None else omega,
            self.omega,
            what,
            own.imaginary,
            self.position,
            self.cuts,
            band,
        )
        for segments in own.segments:
            segments.add(band, self.omega if omega is None else omega, what, self.position)
        return band

    def solve(self, omega: float, load: NDArray[Any]) -> NDArray[Any]:
        """Unknowns under a load: orthonormal, or one of largest entry 1."""
        from scipy.linalg.lapack import dgbsv, zgbsv

        solver = zgbsv if self.banded.component.moving else dgbsv
        matrix = np.empty((3 * self.width + 1, self.size), dtype=self.banded.kind, order="F")
        self._write_stiffness(omega, matrix)
        _, _, solution, info = solver(self.width, self.width, matrix, load)
        if info:  # the frequency is exact to the last bit: step aside by round-off
            matrix[2 * self.width] += 1e-13 * np.abs(matrix).max()
            solution = solver(self.width, self.width, matrix, load)[2]
        solution = solution / np.max(np.abs(solution), axis=0)
        return np.asarray(np.linalg.qr(solution)[0] if load.shape[1] > 1 else solution)

    def rate_load(self, omega: float, shapes: NDArray[Any]) -> NDArray[Any]:
        """Rate times unknowns, shape (size, k)."""
        out, own = np.empty_like(shapes), self.banded
        if own.segments:
            times(self.matrix(RATE, omega), shapes, out)
        else:
            places = self.position, self.cuts, self.width
            rate_times(own.rows, omega, self.omega, own.imaginary, *places, shapes, out)
        return out

    def _write_stiffness(self, omega: float, out: NDArray[Any]) -> None:
        """The stiffness in LAPACK's storage, shape (3 width + 1, size)."""
        own = self.banded
        if own.segments:
            for_lapack(self.matrix(STIFFNESS, omega), out)
        else:
            places = self.position, self.cuts
            general_stiffness(own.rows, omega, self.omega, own.imaginary, *places, out)

    def energies(self, omega: float, shapes: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
        """Quadratic forms of stiffness and rate, shape (k, k) each."""
        own, k = self.banded, shapes.shape[1]
        energy, rate = np.empty((k, k), dtype=own.kind), np.empty((k, k), dtype=own.kind)
        forms(own.rows, omega, self.omega, own.imaginary, self.position, self.cuts, shapes, energy, rate)
        for segments in own.segments:
            more = segments.forms(omega, shapes[self.position])
            energy, rate = energy + more[0], rate + more[1]
        return energy, rate

    def rough_load(self, modes: int) -> NDArray[Any]:
        """Loads that no mode is orthogonal to, shape (size, modes)."""
        waves = np.outer(np.arange(1, self.size + 1), 1.0 + np.sqrt(2.0) * np.arange(1, modes + 1))
        return np.cos(waves).astype(self.banded.kind)

    def displacements(self, shapes: NDArray[Any]) -> NDArray[Any]:
        """Shapes in the order of the component, cuts in the order of their links behind, shape (size, k)."""
        own, n = self.banded, self.position.size
        out = np.empty_like(shapes)
        out[own.order] = own.scale[:, None] * shapes[self.position]
        links = np.flatnonzero(self.cuts >= 0)
        out[n:] = own.rows.cut_scale[links][:, None] * shapes[self.cuts[links]]
        return out


def _band_order(component: Component) -> NDArray[np.intp]:
    """Order of the coordinates that keeps those of one link close together."""
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import reverse_cuthill_mckee

    n = component.size
    if n < 3:
        return np.arange(n)
    rows = np.vstack(
        (np.abs(component.start) + np.abs(component.end), component.mass_rows, component.spring_rows)
    )
    tied = (rows != 0.0).astype(np.float64)
    ties = tied if n <= FEW else csr_array(tied)
    graph = csr_array(ties.T @ ties) + csr_array((component.geometric != 0.0).astype(np.float64))
    for segments in component.segments:
        graph = graph + tied_by(segments)
    return np.asarray(reverse_cuthill_mckee(csr_array(graph), symmetric_mode=True), dtype=np.intp)


def _sparse_rows(component: Component, order: NDArray[np.intp], scale: Array) -> SparseRows:
    start_from, start_at, start_by = _compressed(component.start[:, order] * scale)
    end_from, end_at, end_by = _compressed(component.end[:, order] * scale)
    moved = (component.start[:, order] != 0.0) | (component.end[:, order] != 0.0)
    mass = _fixed(component.mass_rows[:, order] * scale, component.mass)
    spring = _fixed(component.spring_rows[:, order] * scale, component.spring)
    spring = spring + scale[:, None] * component.geometric[np.ix_(order, order)] * scale
    tied = (mass != 0.0) | (spring != 0.0)
    for segments in component.segments:
        tied |= tied_by(segments).toarray()[np.ix_(order, order)] > 0.0
    row, column = np.nonzero(np.tril(tied))
    links = component.impedance * component.time
    return SparseRows(
        time=np.ascontiguousarray(component.time),
        lag=np.ascontiguousarray(component.lag),
        impedance=np.ascontiguousarray(component.impedance),
        cut_scale=1.0 / np.sqrt(links),
        start_from=start_from,
        start_at=start_at,
        start_by=start_by,
        end_from=end_from,
        end_at=end_at,
        end_by=end_by,
        first=np.argmax(moved, axis=1).astype(np.int64) if moved.size else np.zeros(0, dtype=np.int64),
        fixed_row=row.astype(np.int64),
        fixed_column=column.astype(np.int64),
        mass=mass[row, column],
        spring=spring[row, column],
    )


def _compressed(rows: Array) -> tuple[NDArray[np.int64], NDArray[np.int64], Array]:
    """Where each row begins, and coordinates and values of what is not zero."""
    row, column = np.nonzero(rows)
    begins = np.searchsorted(row, np.arange(rows.shape[0] + 1)).astype(np.int64)
    return begins, column.astype(np.int64), np.ascontiguousarray(rows[row, column])


def _fixed(rows: Array, weights: Array) -> Array:
    """Sum of weighted squares of rows, shape (n, n); of many sparse rows without their zeros."""
    if not weights.size:
        return np.zeros(2 * rows.shape[1:])
    if rows.shape[1] <= FEW:
        return np.asarray((rows.T * weights) @ rows)
    from scipy.sparse import csr_array

    own = csr_array(rows)
    return np.asarray((own.T @ (own * weights[:, None])).todense())
