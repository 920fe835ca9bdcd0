r"""Exact dynamic stiffness of a network's component, divided by the frequency, and the count it gives.

With the rows :math:`B_a, B_b` of a link's ends, :math:`\alpha = \omega\tau` and :math:`\varphi =
\omega\delta`,

.. math::
    \hat K = \sum \frac{Z}{\sin\alpha}\,\bigl|e^{i\varphi} B_a - B_b\bigr|^2
             - Z \tan\frac{\alpha}{2}\,\bigl(|B_a|^2 + |B_b|^2\bigr) + \frac{K_q}{\omega} - \omega M_q,
    \qquad \text{Eq. (N.5)}

where :math:`|B|^2` stands for :math:`B^H B`. Then :math:`-\hat K' > 0`, also where ropes run, so each
eigenvalue falls and crosses zero once; by Sylvester's law and the modes between held ends

.. math:: J(\omega) = s\{\hat K(\omega)\} + \sum \lfloor \omega\tau/\pi \rfloor, \qquad \text{Eq. (N.6)}

counts all modes below :math:`\omega`, rigid-body modes included. A link longer than 2 rad is cut as in
`cabledrive.mechanics.chain.split_at_antinodes`, with one more coordinate, so that no part is near a pole.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.network.motion import Array
from cabledrive.modal.network.component import Component

_LONG = 2.0


@dataclass(frozen=True, eq=False)
class CutComponent:
    """A component whose long links are cut in two, for frequencies near one.

    Attributes
    ----------
    component : Component
    link : ndarray of int, shape (p,)
        Link of the component to which each part belongs.
    share : ndarray, shape (p,)
        Part of the link's travel time and lag.
    start, end : ndarray, shape (p, n + cuts)
        Rows of both ends of each part; the last columns are the cuts.
    inside : int
        Modes that the parts have between held ends.
    """

    component: Component
    link: NDArray[np.intp]
    share: Array
    start: Array
    end: Array
    inside: int

    @property
    def size(self) -> int:
        """Number of coordinates, cuts included."""
        return self.start.shape[1]

    @property
    def time(self) -> Array:
        """Travel time of each part [s]."""
        return self.share * self.component.time[self.link]

    @property
    def lag(self) -> Array:
        """Lag of each part [s]."""
        return self.share * self.component.lag[self.link]

    @property
    def impedance(self) -> Array:
        """Impedance of each part [kg/s]."""
        return self.component.impedance[self.link]

    def padded(self, rows: Array) -> Array:
        """Rows in the component's own coordinates, with zeros for the cuts."""
        return np.hstack((rows, np.zeros((rows.shape[0], self.size - rows.shape[1]))))


def cut_component(component: Component, omega: float) -> CutComponent:
    """Cut the links longer than 2 rad at a frequency; ``omega`` [rad/s]."""
    phase = omega * component.time
    long = np.flatnonzero(phase > _LONG)
    m = component.start.shape[0]
    if not long.size:
        return CutComponent(component, np.arange(m), np.ones(m), component.start, component.end, 0)
    half_turns = np.rint(phase[long] / np.pi)
    first = ((half_turns - 1) // 2 + 0.5) * np.pi + (phase[long] - half_turns * np.pi) / 2
    share = np.concatenate((np.ones(m), 1.0 - first / phase[long]))
    share[long] = first / phase[long]
    key = long.tobytes()
    if key not in component.known_cuts:
        component.known_cuts[key] = _cut_rows(component, long)
    start, end = component.known_cuts[key]
    link = np.concatenate((np.arange(m), long))
    inside = int(np.sum(half_turns - 1))
    return CutComponent(component, link, share, start, end, inside)


def _cut_rows(component: Component, long: NDArray[np.intp]) -> tuple[Array, Array]:
    """Rows of both ends of each part where some links are cut, shape (p, n + cuts); not to be written."""
    m, n = component.start.shape
    start = np.zeros((m + long.size, n + long.size))
    end = np.zeros_like(start)
    start[:m, :n], end[:m, :n] = component.start, component.end
    cuts, seconds = n + np.arange(long.size), m + np.arange(long.size)
    end[long] = 0.0
    end[long, cuts] = 1.0
    start[seconds, cuts] = 1.0
    end[seconds, :n] = component.end[long]
    start.flags.writeable = end.flags.writeable = False
    return start, end


@dataclass(frozen=True, eq=False)
class Assembled:
    """The dynamic stiffness at one frequency, as terms that are squares of rows.

    Attributes
    ----------
    omega : float
        [rad/s].
    stretch : ndarray, shape (p, n)
        Rows that strain each link; complex where a rope runs.
    turned : ndarray, shape (p, n)
        Rows of the links' starts with their phase.
    link, link_rate, edge, edge_rate, lag : ndarray, shape (p,)
        Coefficients of links and of their ends, with minus their derivatives [kg/s], [kg].
    """

    cut: CutComponent
    omega: float
    stretch: NDArray[Any]
    turned: NDArray[Any]
    link: Array
    link_rate: Array
    edge: Array
    edge_rate: Array

    def matrix(self) -> NDArray[Any]:
        """The matrix itself, shape (n, n)."""
        own, omega = self.cut.component, self.omega
        total = _squares(self.stretch, self.link) + _squares(self.cut.start, self.edge)
        total = total + _squares(self.cut.end, self.edge)
        n = own.size
        total[:n, :n] += _squares(own.mass_rows, -omega * own.mass)
        total[:n, :n] += _squares(own.spring_rows, own.spring / omega) + own.geometric / omega
        for segments in own.segments:
            total[:n, :n] += segments.matrix(omega)
        return total


def assembled(cut: CutComponent, omega: float) -> Assembled:
    """The stiffness of a component at one frequency, Eq. (N.5); ``omega`` [rad/s]."""
    time, z = cut.time, cut.impedance
    t = np.tan(0.5 * omega * time)  # sin = 2 t / (1 + t^2), cos = (1 - t^2) / (1 + t^2)
    link = z * (t + 1.0 / t) / 2
    link_rate = link * time * (1.0 / t - t) / 2
    turned: NDArray[Any] = cut.start
    if cut.component.moving:
        turned = np.exp(1j * omega * cut.lag)[:, None] * cut.start
    edge, edge_rate = -z * t, z * time * (1.0 + t**2) / 2
    return Assembled(cut, omega, turned - cut.end, turned, link, link_rate, edge, edge_rate)


def _squares(rows: NDArray[Any], weights: Array) -> NDArray[Any]:
    """Sum of weighted squares of rows, B^H diag(w) B."""
    return (rows.conj().T * weights) @ rows


def negative_eigenvalues(matrix: NDArray[Any]) -> int:
    """Number of negative eigenvalues, by the pivots of LDL^H (Sylvester, Bunch and Kaufman)."""
    from scipy.linalg.lapack import dsytrf, zhetrf

    if matrix.shape[0] == 1:
        return int(matrix[0, 0].real < 0.0)
    factor = zhetrf if np.iscomplexobj(matrix) else dsytrf
    factors, pivots, _ = factor(matrix, lower=1)
    single = pivots > 0
    negative = np.count_nonzero(np.diag(factors).real[single] < 0.0)
    return int(
        negative + (pivots.size - np.count_nonzero(single)) // 2
    )  # a block of two has one of each sign
