"""Inverse iteration on the exact dynamic stiffness: frequency and shapes to the last digits."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.chain import Array, Chain
from cabledrive.mechanics.stiffness_matrix import DynamicStiffness, dynamic_stiffness, free_joints, links
from cabledrive.modal.polish import polished

_STEPS = 12
_CONVERGED = 1e-13
_CLUSTER = 1e-6
_SETTLED = 1e-15
_STAY = 1e-12


def inverse_iteration(
    split: Chain, start: float, modes: int, low: float, high: float
) -> tuple[Array, Array] | None:
    r"""Refine the modes nearest to a frequency.

    Subspace iteration :math:`\hat K(\omega_k)\,Y = -\hat K'(\omega_k)\,X` with Rayleigh-Ritz,
    :math:`\omega_{k+1} = \omega_k + \text{eig}(Y^T\hat K Y,\,-Y^T\hat K' Y)`, Eq. (M.6): cubic at simple and
    at multiple modes alike.

    ``split``: no segment near a pole between `low` and `high`; ``start``: where to begin [rad/s]; ``modes``:
    how many modes lie between `low` and `high`; ``low``, ``high``: interval the modes must lie in [rad/s].
    Returns ``omegas``, shape (modes,): natural frequencies [rad/s], ascending; ``shapes``, shape (joints,
    modes): displacements of the joints (the pendants' last), of unit modal mass. Or None, if the iteration
    leaves the interval.
    """
    if modes == 1 and split.uniform:
        found = polished(split, start, low, high)
        if found is not None:
            return found
    stiffness = dynamic_stiffness(split, start)
    band = FoldedBand(split, stiffness.ground_rate)
    if modes > band.free.size:
        return None
    solve = band.solver(stiffness)
    shapes = _stepped(solve, band.rate_load(stiffness, solve(band.rough_load(modes))))
    omega, slack = start, _STAY * high
    for _ in range(_STEPS):
        if shapes is None:
            return None
        shapes, shifts = _rayleigh_ritz(stiffness, band, shapes)
        shift = float(np.mean(shifts))
        if not low - slack <= omega + shifts[0] <= omega + shifts[-1] <= high + slack:
            return None
        if shifts[-1] - shifts[0] <= _CLUSTER * omega and abs(shift) <= _CONVERGED * omega:
            return omega + shifts, band.spread(shapes)
        omega += shift
        stiffness = dynamic_stiffness(split, omega)
        if shift**2 > _SETTLED * omega * min(omega - low, high - omega):  # other modes lie beyond
            shapes = _stepped(band.solver(stiffness), band.rate_load(stiffness, shapes))
    return None


def _stepped(solve: Callable[[Array], Array], load: Array) -> Array | None:
    """One inverse iteration; None where cables are so stiff that their inertia drowns in round-off."""
    return solve(load) if load.any(axis=0).all() else None


def _rayleigh_ritz(stiffness: DynamicStiffness, band: "FoldedBand", shapes: Array) -> tuple[Array, Array]:
    """Shapes of unit modal mass within their span, and how far each mode is from here [rad/s]."""
    energy, rate = stiffness.energies(band.spread(shapes))
    if shapes.shape[1] == 1:
        return shapes * np.sqrt(2.0 / rate[0, 0]), energy[0] / rate[0]
    inverse = np.linalg.inv(np.linalg.cholesky(rate))
    shifts, vectors = np.linalg.eigh(inverse @ energy @ inverse.T)
    return np.sqrt(2.0) * shapes @ (inverse.T @ vectors), shifts


class FoldedBand:
    r"""Order of the unknowns that keeps a ring's matrix in a narrow band: both sides of the ring in turn.

    The unknowns are :math:`y = \sqrt{m}\,u`: round-off then counts by its energy, however unlike the masses.

    Parameters
    ----------
    split : Chain
    masses : ndarray, shape (joints,)
        Masses m that weigh the unknowns, cable included [kg].
    """

    def __init__(self, split: Chain, masses: Array) -> None:
        self.free = free_joints(split)
        self._total = split.masses.size + len(split.pendants)
        self._place = _places(split, self.free)
        self._order = self.free[np.argsort(self._place[self.free])]
        self._width = 1 + split.closed + len(split.pendants)
        self._left, self._right = (self._place[joints] for joints in links(split))
        self._both = (self._left >= 0) & (self._right >= 0)
        near, far = self._left[self._both], self._right[self._both]
        rows, middle = 3 * self._width + 1, 2 * self._width
        diagonal = (self._place[self.free], self._left[self._left >= 0], self._right[self._right >= 0])
        places = [rows * place + middle for place in diagonal]
        places += [rows * column + middle + row - column for row, column in ((near, far), (far, near))]
        self._index = np.concatenate(places)
        scale = 1.0 / np.sqrt(masses[self._order])
        self._scale = scale[:, None]
        weights = [scale[place] ** 2 for place in diagonal] + 2 * [scale[near] * scale[far]]
        self._weights = np.concatenate(weights)

    def spread(self, shapes: Array) -> Array:
        """Displacements of all joints, held ones at rest, from the unknowns.

        ``shapes``, shape (free joints, k): unknowns, in band order.
        Returns shape (joints, k).
        """
        out = np.zeros((self._total, shapes.shape[1]))
        out[self.free] = (self._scale * shapes)[self._place[self.free]]
        return out

    def rough_load(self, modes: int) -> Array:
        """Loads that no mode is orthogonal to.

        ``modes``: number of columns k.
        Returns shape (free joints, k): in band order.
        """
        waves = np.outer(np.arange(1, self.free.size + 1), 1.0 + np.sqrt(2.0) * np.arange(1, modes + 1))
        return np.cos(waves)

    def rate_load(self, stiffness: DynamicStiffness, shapes: Array) -> Array:
        """Minus the derivative of the stiffness times the unknowns.

        ``shapes``, shape (free joints, k): in band order.
        Returns shape (free joints, k): in band order.
        """
        return _band_product(self._assemble(stiffness.link_rate, stiffness.ground_rate), shapes, self._width)

    def solver(self, stiffness: DynamicStiffness) -> Callable[[Array], Array]:
        """Factorise once, solve often.

        Returns takes loads, shape (free joints, k), to unknowns: orthonormal, or one of largest entry 1.
        """
        from scipy.linalg.lapack import dgbtrf, dgbtrs

        width = self._width
        factors, pivots, info = dgbtrf(self._assemble(stiffness.link, stiffness.ground), width, width)
        if info:  # the frequency is exact to the last bit: step aside by round-off
            band = self._assemble(stiffness.link, stiffness.ground)
            parts = self._assemble(np.abs(stiffness.link), np.abs(stiffness.ground))
            band[2 * width] += 1e-13 * parts[2 * width]
            factors, pivots, info = dgbtrf(band, width, width)

        def solve(load: Array) -> Array:
            """Unknowns under a load."""
            solution = dgbtrs(factors, width, width, load, pivots)[0]
            solution /= np.max(np.abs(solution), axis=0)
            return np.linalg.qr(solution)[0] if load.shape[1] > 1 else solution

        return solve

    def _assemble(self, link: Array, ground: Array) -> Array:
        """Band matrix in LAPACK's storage for factorisation: a[i, j] in row ``2 width + i - j``."""
        both = -link[self._both]
        values = (ground[self.free], link[self._left >= 0], link[self._right >= 0], both, both)
        rows = 3 * self._width + 1
        weighted = self._weights * np.concatenate(values)
        entries = np.bincount(self._index, weighted, rows * self.free.size)
        return np.asarray(entries, dtype=np.float64).reshape(-1, rows).T


def _places(split: Chain, free: NDArray[np.intp]) -> NDArray[np.intp]:
    """Row of each joint in the band matrix; -1 for a held one."""
    n = split.masses.size
    order = np.arange(n)
    if split.closed:
        order[0::2], order[1::2] = np.arange((n + 1) // 2), np.arange(n - 1, (n - 1) // 2, -1)
    for number, pendant in enumerate(split.pendants):
        order = np.insert(order, np.flatnonzero(order == pendant.joint), n + number)
    place = np.full(n + len(split.pendants), -1)
    place[free] = 0
    order = order[place[order] == 0]
    place[order] = np.arange(order.size)
    return place


def _band_product(band: Array, x: Array, width: int) -> Array:
    """Product of a band matrix in LAPACK's storage with x."""
    size, middle = band.shape[1], 2 * width
    out = band[middle][:, None] * x
    for offset in range(1, min(width, size - 1) + 1):
        out[:-offset] += band[middle - offset, offset:][:, None] * x[offset:]
        out[offset:] += band[middle + offset, :-offset][:, None] * x[:-offset]
    return out
