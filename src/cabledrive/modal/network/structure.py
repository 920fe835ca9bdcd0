"""A component of a network as the solver sees it: its count, and inverse iteration on its exact stiffness."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.network.motion import Array
from cabledrive.modal.network.component import Component
from cabledrive.modal.network.stiffness import (
    Assembled,
    CutComponent,
    assembled,
    cut_component,
    negative_eigenvalues,
)
from cabledrive.modal.solver import Refined

MULTIPLE = 1e-9
"""Modes closer than this, relative to their frequency, are one mode of higher multiplicity."""

_STEPS = 14
_CONVERGED = 1e-13
_CLUSTER = 1e-6
_SETTLED = 1e-15
_STAY = 1e-12


class ComponentStructure:
    """Counts and refines the modes of one component of a network.

    Parameters
    ----------
    component : Component
    """

    def __init__(self, component: Component) -> None:
        self.component = component
        self.rigid_body_modes = component.rigid_body_modes
        self.longest = component.longest
        self._scale = 1.0 / np.sqrt(_mass_diagonal(component))
        self._counted: dict[float, int] = {}

    def count(self, omega: float) -> int:
        """Number of modes below a frequency [rad/s], rigid-body modes included, Eq. (N.6)."""
        if omega <= 0.0:
            return 0
        if omega not in self._counted:
            cut = cut_component(self.component, omega)
            stiffness = assembled(cut, omega).matrix()
            scale = self._scales(cut)
            self._counted[omega] = cut.inside + negative_eigenvalues(scale[:, None] * stiffness * scale)
        return self._counted[omega]

    def _scales(self, cut: CutComponent) -> Array:
        """Factors that make the coordinates alike in energy; a cut has the mass of its rope."""
        n = self.component.columns.size
        if cut.size == n:
            return self._scale
        links = cut.link[-(cut.size - n) :]
        return np.concatenate(
            (self._scale, 1.0 / np.sqrt(self.component.impedance[links] * self.component.time[links]))
        )

    def refined(self, start: float, modes: int, low: float, high: float) -> Refined | None:
        """Refine the modes between two frequencies by subspace iteration with Rayleigh-Ritz.

        ``start``: where to begin [rad/s]; ``modes``: how many lie between `low` and `high` [rad/s].
        Returns None if the iteration leaves the interval. As Eq. (M.6).
        """
        cut = cut_component(self.component, start)
        if modes > cut.size:
            return None
        scale = self._scales(cut)
        stiffness = assembled(cut, start)
        shapes = _solve(stiffness, scale, _rough_load(cut.size, modes))
        shapes = _solve(stiffness, scale, _rate_load(stiffness, scale, shapes))
        omega, slack = start, _STAY * high
        for _ in range(_STEPS):
            ritz = _rayleigh_ritz(stiffness, scale, shapes)
            if ritz is None:
                return None
            shapes, shifts = ritz
            shift = float(np.mean(shifts))
            if not low - slack <= omega + shifts[0] <= omega + shifts[-1] <= high + slack:
                return None
            if shifts[-1] - shifts[0] <= _CLUSTER * omega and abs(shift) <= _CONVERGED * omega:
                return Refined(omega + shifts, scale[:, None] * shapes, cut)
            omega += shift
            stiffness = assembled(cut, omega)
            if shift**2 > _SETTLED * omega * min(omega - low, high - omega):  # other modes lie beyond
                shapes = _solve(stiffness, scale, _rate_load(stiffness, scale, shapes))
        return None


def _mass_diagonal(component: Component) -> Array:
    """Mass that each coordinate moves, the ropes' shares included, shape (n,)."""
    rope = component.impedance * component.time / 3.0
    own = rope @ (component.start**2 + component.end**2) + component.mass @ component.mass_rows**2
    return np.where(own > 0.0, own, 1.0)


def _rough_load(size: int, modes: int) -> Array:
    """Loads that no mode is orthogonal to, shape (size, modes)."""
    return np.cos(np.outer(np.arange(1, size + 1), 1.0 + np.sqrt(2.0) * np.arange(1, modes + 1)))


def _rate_load(stiffness: Assembled, scale: Array, shapes: NDArray[Any]) -> NDArray[Any]:
    return np.asarray(scale[:, None] * (stiffness.rate_matrix() @ (scale[:, None] * shapes)))


def _solve(stiffness: Assembled, scale: Array, load: NDArray[Any]) -> NDArray[Any]:
    """Scaled unknowns under a load: orthonormal, or one of largest entry 1."""
    from scipy.linalg.lapack import dgesv, zgesv

    matrix = scale[:, None] * stiffness.matrix() * scale
    solver = zgesv if np.iscomplexobj(matrix) else dgesv
    _, _, solution, info = solver(matrix, load)
    if info:  # the frequency is exact to the last bit: step aside by round-off
        aside = 1e-13 * np.abs(matrix).max()
        solution = solver(matrix + aside * np.eye(matrix.shape[0]), load)[2]
    solution = solution / np.max(np.abs(solution), axis=0)
    return np.asarray(np.linalg.qr(solution)[0] if load.shape[1] > 1 else solution)


def _rayleigh_ritz(
    stiffness: Assembled, scale: Array, shapes: NDArray[Any]
) -> tuple[NDArray[Any], Array] | None:
    """Shapes of unit modal mass within their span, and how far each mode is from here [rad/s]."""
    energy, rate = stiffness.energies(scale[:, None] * shapes)
    if shapes.shape[1] == 1:
        return shapes * np.sqrt(2.0 / rate[0, 0].real), (energy[0] / rate[0]).real
    try:
        inverse = np.linalg.inv(np.linalg.cholesky(0.5 * (rate + rate.conj().T)))
    except np.linalg.LinAlgError:
        return None
    reduced = inverse @ energy @ inverse.conj().T
    shifts, vectors = np.linalg.eigh(0.5 * (reduced + reduced.conj().T))
    return np.sqrt(2.0) * shapes @ (inverse.conj().T @ vectors), shifts
