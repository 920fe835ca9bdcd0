r"""Exact dynamic stiffness of a chain, and its rate of change with frequency.

Everything here is divided by the frequency: :math:`\hat K(\omega) = K(\omega)/\omega`. Singular together, and
:math:`-\hat K'` is positive definite with :math:`x^T(-\hat K')x` = twice the modal mass at a mode, Eq. (M.4).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.chain import Array, Chain


@dataclass(frozen=True, slots=True, eq=False)
class DynamicStiffness:
    r"""Stiffness of a chain at one frequency as links between joints and to the ground.

    A segment of phase :math:`\alpha` and impedance Z holds its two ends together by a link
    :math:`Z/\sin\alpha` and each to the ground by :math:`-Z\tan(\alpha/2)`, Eq. (M.1). In this form low modes
    of long chains lose no digits: nothing large cancels.

    Attributes
    ----------
    omega : float or ndarray, shape (k, 1)
        Angular frequency [rad/s]; of several, links and grounds have a row for each.
    left, right : ndarray of int, shape (m,)
        Joints at the ends of each link.
    link, link_rate : ndarray, shape (m,) or (k, m)
        Link stiffness over omega [kg/s] and minus its derivative [kg].
    ground, ground_rate : ndarray, shape (n,) or (k, n)
        Stiffness to ground over omega [kg/s] and minus its derivative [kg].
    """

    omega: float | Array
    left: NDArray[np.intp]
    right: NDArray[np.intp]
    link: Array
    link_rate: Array
    ground: Array
    ground_rate: Array

    def energies(self, x: Array) -> tuple[Array, Array]:
        """Quadratic forms of the columns of x, without cancellation.

        Parameters
        ----------
        x : ndarray, shape (n, k)
            Displacements of the joints.

        Returns
        -------
        stiffness, rate : ndarray, shape (k, k)
            ``x.T @ K @ x`` and ``-x.T @ dK/domega @ x``.
        """
        stretch = x[self.left] - x[self.right]
        stiffness = stretch.T @ (self.link[:, None] * stretch) + x.T @ (self.ground[:, None] * x)
        rate = stretch.T @ (self.link_rate[:, None] * stretch) + x.T @ (self.ground_rate[:, None] * x)
        return stiffness, rate

    def matrix(self) -> Array:
        """The assembled matrix.

        Returns
        -------
        ndarray, shape (n, n)
            Dense and symmetric.
        """
        dense = np.diag(self.ground)
        np.add.at(dense, (self.left, self.left), self.link)
        np.add.at(dense, (self.right, self.right), self.link)
        np.subtract.at(dense, (self.left, self.right), self.link)
        np.subtract.at(dense, (self.right, self.left), self.link)
        return dense


def dynamic_stiffness(chain: Chain, omega: float | Array) -> DynamicStiffness:
    r"""Exact dynamic stiffness of a chain, Eqs. (M.1), (M.3).

    .. math::
        \hat K:\quad \frac{Z}{\sin\alpha}\ \text{(link)},\quad -Z\tan\frac{\alpha}{2}\ \text{(ground)},\quad
        -\omega m\ \text{(mass)},\quad \frac{k}{\omega}\ \text{(spring of a pendant, or to the ground)}

    Held joints stay in the list; leave them out with `free_joints`. The pendants' masses are the
    last joints.

    Parameters
    ----------
    chain : Chain
        No segment may be near a pole: `split_at_antinodes` first.
    omega : float or ndarray, shape (k, 1)
        Angular frequency [rad/s], or several.

    Returns
    -------
    DynamicStiffness
    """
    n, segments = chain.masses.size, chain.lengths.size
    left, right = links(chain)
    time, z = chain.travel_times, chain.impedances
    t = np.tan(omega * time / 2)  # sin = 2 t / (1 + t^2), cos = (1 - t^2) / (1 + t^2)
    link = z * (t + 1.0 / t) / 2
    link_rate = link * time * (1.0 / t - t) / 2
    edge, edge_rate = -z * t, z * time * (1.0 + t**2) / 2
    springs = chain.ground_springs
    ground = springs / omega - omega * chain.masses
    ground_rate = springs / omega**2 + chain.masses
    for total, part in ((ground, edge), (ground_rate, edge_rate)):
        total[..., :segments] += part
        total[..., 1:] += part[..., : n - 1]
        if chain.closed:
            total[..., 0] += part[..., -1]
    for pendant in chain.pendants:
        spring, mass, held = pendant.stiffness, pendant.mass, pendant.ground
        link, link_rate = _with(link, spring / omega), _with(link_rate, spring / omega**2)
        ground = _with(ground, held / omega - omega * mass)
        ground_rate = _with(ground_rate, held / omega**2 + mass)
    return DynamicStiffness(omega, left, right, link, link_rate, ground, ground_rate)


def _with(values: Array, last: float | Array) -> Array:
    """Values, shape (..., n), with one more, shape (..., 1)."""
    return np.concatenate((values, np.reshape(last, (*values.shape[:-1], 1))), axis=-1)


def links(chain: Chain) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Joints at the two ends of each link: the segments in order, then the pendants' springs.

    Returns ``left, right``: indices of joints; the pendants' masses are the last ones.
    """
    n, segments = chain.masses.size, chain.lengths.size
    left = np.arange(segments)
    right = np.arange(1, segments + 1)
    if chain.closed:
        right[-1] = 0
    for number, pendant in enumerate(chain.pendants):
        left, right = np.append(left, n + number), np.append(right, pendant.joint)
    return left, right


def free_joints(chain: Chain) -> NDArray[np.intp]:
    """Joints that can move: all but the held ends, the pendants' masses included.

    Returns indices into the joints of `dynamic_stiffness`.
    """
    n = chain.masses.size
    free = np.ones(n + len(chain.pendants), dtype=bool)
    free[0], free[n - 1] = not chain.fixed[0], not chain.fixed[1]
    return np.flatnonzero(free)
