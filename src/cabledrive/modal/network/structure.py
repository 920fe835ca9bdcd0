"""A component of a network as the solver sees it: its count, and inverse iteration on its exact stiffness."""

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.network.motion import Array
from cabledrive.modal.network.component import Component
from cabledrive.modal.network.stiffness import assembled, cut_component, negative_eigenvalues
from cabledrive.modal.solver import Refined

if TYPE_CHECKING:
    from cabledrive.modal.network.banded import BandAt, Banded

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
        self._counted: dict[float, int] = {}
        self._cut: dict[tuple[int, ...], Banded] = {}

    def _banded(self, omega: float) -> "Banded":
        """The component as it is cut for frequencies up to one [rad/s]."""
        from cabledrive.modal.network.banded import Banded  # its kernels load the compiler

        octaves = self.component.octaves(omega) if self.component.elastic else ()
        if octaves not in self._cut:
            own = self.component.segmented(octaves) if octaves else self.component
            self._cut[octaves] = Banded(own, 1.0 / np.sqrt(_mass_diagonal(own, omega)))
        return self._cut[octaves]

    def count(self, omega: float) -> int:
        """Number of modes below a frequency [rad/s], rigid-body modes included, Eq. (N.6)."""
        if omega <= 0.0:
            return 0
        if omega not in self._counted:
            own = self._banded(omega).count(omega)
            self._counted[omega] = self.pivoted_count(omega) if own is None else own
        return self._counted[omega]

    def pivoted_count(self, omega: float) -> int:
        """The count by a full matrix and pivots, which loses no digits."""
        banded = self._banded(omega)
        cut = cut_component(banded.component, omega)
        links = cut.link[banded.component.links.size :]
        cuts = 1.0 / np.sqrt(self.component.impedance[links] * self.component.time[links])
        scale = np.concatenate((banded.natural_scale, cuts))
        return cut.inside + negative_eigenvalues(scale[:, None] * assembled(cut, omega).matrix() * scale)

    def refined(self, start: float, modes: int, low: float, high: float) -> Refined | None:
        """Refine the modes between two frequencies by subspace iteration with Rayleigh-Ritz.

        ``start``: where to begin [rad/s]; ``modes``: how many lie between `low` and `high` [rad/s].
        Returns None if the iteration leaves the interval. As Eq. (M.6).
        """
        banded = self._banded(high)
        if modes == 1 and not banded.segments:
            return self._refined_one(banded, start, low, high)
        band = banded.at(start)
        if modes > band.size:
            return None
        shapes = band.solve(start, band.rough_load(modes))
        shapes = band.solve(start, band.rate_load(start, shapes))
        omega, slack = start, _STAY * high
        for _ in range(_STEPS):
            ritz = _rayleigh_ritz(band, omega, shapes)
            if ritz is None:
                return None
            shapes, shifts = ritz
            shift = float(np.mean(shifts))
            if not low - slack <= omega + shifts[0] <= omega + shifts[-1] <= high + slack:
                return None
            if shifts[-1] - shifts[0] <= _CLUSTER * omega and abs(shift) <= _CONVERGED * omega:
                frame = cut_component(banded.component, start)
                return Refined(omega + shifts, band.displacements(shapes), frame)
            omega += shift
            if shift**2 > _SETTLED * omega * min(omega - low, high - omega):  # other modes lie beyond
                shapes = band.solve(omega, band.rate_load(omega, shapes))
        return None

    @staticmethod
    def _refined_one(banded: "Banded", start: float, low: float, high: float) -> Refined | None:
        """The same for a single mode of strings, in one compiled call."""
        from cabledrive.modal.network.banded import BandAt
        from cabledrive.modal.network.refining_kernels import refined_one

        position = np.empty(banded.order.size, dtype=np.int64)
        cuts = np.empty(banded.rows.time.size, dtype=np.int64)
        found, omega, shape, *size = refined_one(
            banded.rows, start, low, high, banded.imaginary, position, cuts, np.empty(0, dtype=banded.kind)
        )
        if not found:
            return None
        band = BandAt(banded, start, position, cuts, *size)
        frame = cut_component(banded.component, start)
        return Refined(np.array([omega]), band.displacements(shape), frame)


def _mass_diagonal(component: Component, omega: float) -> Array:
    """Mass that each coordinate moves, the ropes' shares included, shape (n,); ``omega`` [rad/s]."""
    rope = component.impedance * component.time / 3.0
    own = rope @ (component.start**2 + component.end**2) + component.mass @ component.mass_rows**2
    for segments in component.segments:
        rates = np.einsum("pii->pi", segments.both(omega)[1]).ravel()
        own = own + rates @ segments.local.power(2)
    return np.where(own > 0.0, own, 1.0)


def _rayleigh_ritz(band: "BandAt", omega: float, shapes: NDArray[Any]) -> tuple[NDArray[Any], Array] | None:
    """Shapes of unit modal mass within their span, and how far each mode is from here [rad/s]."""
    energy, rate = band.energies(omega, shapes)
    if shapes.shape[1] == 1:
        return shapes * np.sqrt(2.0 / rate[0, 0].real), (energy[0] / rate[0]).real
    try:
        inverse = np.linalg.inv(np.linalg.cholesky(0.5 * (rate + rate.conj().T)))
    except np.linalg.LinAlgError:
        return None
    reduced = inverse @ energy @ inverse.conj().T
    shifts, vectors = np.linalg.eigh(0.5 * (reduced + reduced.conj().T))
    return np.sqrt(2.0) * shapes @ (inverse.conj().T @ vectors), shifts
