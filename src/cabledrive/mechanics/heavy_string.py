r"""A string whose tension changes along it: exact waves by power series, piece by piece.

With the transverse force :math:`q = R\,z'`, :math:`1/R = 1/T + 1/EA` per unstretched length, a wave of
frequency :math:`\omega` obeys

.. math:: T\,z' = q\,(1 + T/EA), \qquad q' = -\rho_0\,\omega^2 z.

For a tension that is a polynomial of the place, both are power series with coefficients by recursion. A
vertical rope has :math:`T = T_a + \rho_0 g s`; as :math:`EA \to \infty` its waves are the Bessel functions
:math:`J_0, Y_0` of :math:`2\omega\sqrt{T/\rho_0}/g`. On a sagging span the tension is the parabola through
both ends and the middle of each piece.
"""

from dataclasses import dataclass
from functools import cached_property
from math import ceil

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.rest import RestingStretch

Array = NDArray[np.float64]

LONGEST_PHASE = 1.5
"""Phase of the longest piece [rad]: below half a turn, so that none has a mode of its own when held."""

LARGEST_RISE = 0.2
"""Rise of the tension along a piece over its lowest tension."""

ORDERS, TERMS = 13, 32
"""Of the frequency's square and of the place: what is left out is below 1e-18 on every piece."""

_EXPONENTS = np.arange(ORDERS)
_SMALLEST_SHARE = 2.0**-30
_BLOCK = 256


@dataclass(frozen=True, eq=False, kw_only=True)
class StringPieces:
    """Neighbouring pieces of string; masses sit at their ends.

    Attributes
    ----------
    start, length : ndarray, shape (n,)
        Unstretched [m].
    tension : ndarray, shape (3, n)
        Coefficients of the tension by the share of the piece, constant term first [N].
    mass : ndarray, shape (n,)
        Mass at the end of each piece [kg]; the last one is held.
    stretch : ndarray of int, shape (n,)
        Which stretch of the section each belongs to.
    density : float
        Mass per unstretched length [kg/m].
    axial_rigidity : float
        EA [N].
    top : float
        Highest angular frequency [rad/s].
    """

    start: Array
    length: Array
    tension: Array
    mass: Array
    stretch: NDArray[np.intp]
    density: float
    axial_rigidity: float
    top: float

    def series(self, first: int = 0, last: int | None = None) -> tuple[Array, Array]:
        """Displacement and transverse force of two waves, shape (2, ORDERS, TERMS, n).

        For a unit displacement and a unit force at the start; by the order in (omega / top)^2, by the power
        of the share of the piece.

        ``first``, ``last``: which of the pieces, as of a slice; all if not given.
        """
        t0, t1, t2 = self.tension[:, first:last]
        length = self.length[first:last]
        give = length / t0 * (1.0 + t0 / self.axial_rigidity)
        inertia = -self.density * length * self.top**2
        rise, bend, soft = t1 / t0, t2 / t0, length / self.axial_rigidity
        place = np.arange(TERMS)[:, None]
        # The next z from z and q of this term and of the two before it: shape (TERMS, 6, 1, n).
        next_z = np.zeros((TERMS, 6, 1, t0.size))
        next_z[:, 1, 0] = bend * soft
        next_z[:, 2, 0], next_z[:, 3, 0] = -(place - 1) * bend, rise * soft
        next_z[:, 4, 0], next_z[:, 5, 0] = -place * rise, give
        next_z /= place[:, :, None, None] + 1.0
        next_q = inertia / (place + 1.0)
        terms = np.zeros((TERMS + 2, 2, 2, ORDERS, t0.size))  # two terms of nothing stand before the first
        terms[2, 0, 0, 0] = terms[2, 1, 1, 0] = 1.0
        rows = terms.reshape(TERMS + 2, 2, 2 * ORDERS, -1)
        product = np.empty((6, 2 * ORDERS, t0.size))
        for n in range(TERMS - 1):
            np.multiply(next_z[n], rows[n : n + 3].reshape(product.shape), out=product)
            np.add.reduce(product, axis=0, out=rows[n + 3, 0])
            np.multiply(next_q[n], terms[n + 2, 0, :, :-1], out=terms[n + 3, 1, :, 1:])
        z, q = terms[2:].transpose(1, 2, 3, 0, 4)
        return z, q

    def shape_series(self, first: int) -> Array:
        """Displacements of `series` for one block of pieces, kept.

        ``first``: the first piece of the block.
        Returns shape (2, ORDERS, TERMS, n).
        """
        if first not in self._kept:
            self._keep(first)
        return self._kept[first][0]

    def _keep(self, first: int) -> tuple[Array, Array]:
        """The series of one block of pieces, in place of the block that was kept."""
        self._kept.clear()
        self._kept[first] = self.series(first, first + _BLOCK)
        return self._kept[first]

    @cached_property
    def _kept(self) -> dict[int, tuple[Array, Array]]:
        return {}

    @cached_property
    def at_end(self) -> Array:
        """What a piece adds from start to end, shape (ORDERS, 4, n): rows as in `Transfer`."""
        parts = []
        for first in range(0, self.length.size, _BLOCK):
            z, q = (part[:, :, 1:].sum(axis=2) for part in self._keep(first))
            parts.append(np.stack((z[0], z[1], q[0], q[1]), axis=1))
        return np.concatenate(parts, axis=2)


@dataclass(frozen=True, slots=True, eq=False)
class Transfer:
    """From displacement and transverse force at the start of each piece to those at its end.

    The matrix is ``[[1 + near, give], [inertia, 1 + far]]`` with determinant 1; what differs from 1 is kept
    apart so that nothing cancels at low frequencies.

    Attributes
    ----------
    near, give, inertia, far : ndarray, shape (n,) or (k, n)
    """

    near: Array
    give: Array
    inertia: Array
    far: Array


def transfer(pieces: StringPieces, omega: complex | Array) -> Transfer:
    """Exact waves on every piece, Eq. (M.11).

    ``omega``, one or shape (k,): angular frequency, up to the highest of the pieces [rad/s]; complex ones
    give derivatives.
    """
    orders = np.square(np.asarray(omega) / pieces.top)[..., None] ** _EXPONENTS
    total = (orders @ pieces.at_end.reshape(ORDERS, -1)).reshape(*orders.shape[:-1], 4, pieces.length.size)
    return Transfer(total[..., 0, :], total[..., 1, :], total[..., 2, :], total[..., 3, :])


def displacement_series(pieces: StringPieces, omega: float, motion: Array) -> Array:
    """Displacement inside the pieces, as power series of the share of the piece.

    ``omega``: angular frequency [rad/s]; ``motion``, shape (2, n): displacement and transverse force at the
    start of each piece.
    Returns shape (TERMS, n): constant term first.
    """
    orders = (omega / pieces.top) ** (2 * np.arange(ORDERS))
    total = np.zeros((TERMS, pieces.length.size))
    for first in range(0, pieces.length.size, _BLOCK):
        here = slice(first, first + _BLOCK)
        total[:, here] = np.einsum("bn,botn,o->tn", motion[:, here], pieces.shape_series(first), orders)
    return total


def string_pieces(
    stretches: tuple[RestingStretch, ...], masses: Array, density: float, omega: float
) -> StringPieces:
    """Cut the stretches of a section so that the series converge fast up to a frequency.

    ``stretches``: in order, all of them taut; ``masses``, shape (stretches,): mass at the end of each [kg];
    ``density``: mass per unstretched length [kg/m]; ``omega``: highest angular frequency [rad/s].
    """
    cuts = [_cuts(stretch, density, omega) for stretch in stretches]
    start = np.concatenate([cut[:-1] for cut in cuts])
    length = np.concatenate([np.diff(cut) for cut in cuts])
    number = np.repeat(np.arange(len(cuts)), [cut.size - 1 for cut in cuts])
    tension = np.concatenate(
        [_parabola(stretch, cut) for stretch, cut in zip(stretches, cuts, strict=True)], 1
    )
    mass = np.zeros(length.size)
    mass[np.cumsum([cut.size - 1 for cut in cuts]) - 1] = masses
    return StringPieces(
        start=start,
        length=length,
        tension=tension,
        mass=mass,
        stretch=number,
        density=density,
        axial_rigidity=stretches[0].axial_rigidity,
        top=omega,
    )


def _cuts(stretch: RestingStretch, density: float, omega: float) -> Array:
    """Ends of the pieces of one stretch: by the rise of the tension, then by the phase."""
    steep = [stretch.start]
    stack = [(stretch.start, stretch.end)]
    while stack:
        a, b = stack.pop()
        tension = stretch.tension_at(np.array([a, (a + b) / 2.0, b]))
        short = b - a <= _SMALLEST_SHARE * stretch.length
        if short or np.ptp(tension) <= LARGEST_RISE * tension.min():
            slowest = np.sqrt(density * (1.0 / tension.min() + 1.0 / stretch.axial_rigidity))
            count = max(1, ceil(omega * (b - a) * slowest / LONGEST_PHASE))
            steep += [*(a + (b - a) * np.arange(1, count) / count), b]
        else:
            stack += [((a + b) / 2.0, b), (a, (a + b) / 2.0)]
    return np.array(steep)


def _parabola(stretch: RestingStretch, cuts: Array) -> Array:
    """Tension on each piece as a parabola through both ends and the middle, shape (3, pieces)."""
    ends = stretch.tension_at(cuts)
    middle = stretch.tension_at((cuts[1:] + cuts[:-1]) / 2.0)
    first, last = ends[:-1], ends[1:]
    bend = 2.0 * (first + last - 2.0 * middle)
    bend[np.abs(bend) <= 1e-13 * middle] = 0.0
    return np.stack((first, last - first - bend, bend))
