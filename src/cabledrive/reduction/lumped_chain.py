r"""Inertias in line, joined by springs and dampers: Models 1 to 4 of a cable drive, and longer chains.

Link j joins inertia j to inertia j + 1. Its stretch is :math:`e_j = p_j\theta_j - q_j\theta_{j+1}`; a joint
has :math:`p = q = 1`, a cable between rims has the radii. With :math:`\tau_c` the torque left after Coulomb
friction and offset, the chain obeys Eqs. (4.18), (6.10), (6.11), (6.13) for its length.
"""

from dataclasses import dataclass

import numpy as np

from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array, Complex


@dataclass(frozen=True, slots=True, kw_only=True)
class LumpedChain:
    """A lumped chain of n inertias and n - 1 links; angles in rad, or displacements in m of masses.

    Attributes
    ----------
    names : tuple of str
        What each inertia is: "motor", "drive", "load", ...
    inertias : tuple of float
        Moments of inertia [kg m^2].
    viscous, coulomb, offsets : tuple of float
        Friction b [N m s/rad] and c [N m], and constant torque d [N m] of each inertia, signs as in (4.16).
    stiffness, damping : tuple of float
        Of each link, per stretch: [N m/rad] and [N m s/rad] of a joint; [N/m] and [N s/m] between rims.
    ratios : tuple of (float, float)
        (p, q) of each link: 1 and 1 of a joint; radii [m] of a cable.
    holding : float, default 0.0
        Spring from the first inertia to the ground, the motor's holding stiffness [N m/rad].
    """

    names: tuple[str, ...]
    inertias: tuple[float, ...]
    viscous: tuple[float, ...]
    coulomb: tuple[float, ...]
    offsets: tuple[float, ...]
    stiffness: tuple[float, ...] = ()
    damping: tuple[float, ...] = ()
    ratios: tuple[tuple[float, float], ...] = ()
    holding: float = 0.0

    def __post_init__(self) -> None:
        n = len(self.inertias)
        if n == 0 or any(len(x) != n for x in (self.names, self.viscous, self.coulomb, self.offsets)):
            raise InputRefused(
                f"a lumped chain of {n} inertias needs {n} names, frictions and offsets: give as many"
            )
        if any(len(x) != n - 1 for x in (self.stiffness, self.damping, self.ratios)):
            raise InputRefused(
                f"a lumped chain of {n} inertias needs {n - 1} links: give stiffness, damping and ratios "
                "of each"
            )
        if min(self.inertias) <= 0.0:
            raise InputRefused(
                f"inertia = {min(self.inertias):.4g} must be above 0: merge the inertia with its neighbour"
            )

    @property
    def size(self) -> int:
        """Number of inertias."""
        return len(self.inertias)

    @property
    def link_matrix(self) -> Array:
        """Stretches of the links per angle, shape (n - 1, n)."""
        matrix = np.zeros((self.size - 1, self.size))
        for j, (p, q) in enumerate(self.ratios):
            matrix[j, j], matrix[j, j + 1] = p, -q
        return matrix

    @property
    def stiffness_matrix(self) -> Array:
        """K, shape (n, n) [N m/rad]."""
        g = self.link_matrix
        matrix: Array = g.T @ np.diag(self.stiffness) @ g
        matrix[0, 0] += self.holding
        return matrix

    @property
    def damping_matrix(self) -> Array:
        """C of links and viscous friction, shape (n, n) [N m s/rad]."""
        g = self.link_matrix
        return g.T @ np.diag(self.damping) @ g + np.diag(self.viscous)


def state_space(chain: LumpedChain) -> tuple[Array, Array]:
    r"""Matrices of the chain with angles and speeds as states.

    .. math:: \dot x = A x + B \tau_c, \qquad x = [\theta_1 \dots \theta_n, \dot\theta_1 \dots \dot\theta_n]

    Returns ``a``, shape (2n, 2n); ``b``, shape (2n, n): one column per inertia on which a torque acts.
    """
    n = chain.size
    inverse = np.diag(1.0 / np.array(chain.inertias))
    a = np.zeros((2 * n, 2 * n))
    a[:n, n:] = np.eye(n)
    a[n:, :n] = -inverse @ chain.stiffness_matrix
    a[n:, n:] = -inverse @ chain.damping_matrix
    return a, np.vstack([np.zeros((n, n)), inverse])


def speed_state_space(chain: LumpedChain) -> tuple[Array, Array]:
    """Matrices of n - 1 stretches, then n speeds: (2n - 1, 2n - 1) and (2n - 1, n), no rigid rotation.

    Refused with a holding stiffness, whose force is that of an angle.
    """
    if chain.holding > 0.0:
        raise InputRefused(
            f"holding stiffness = {chain.holding:.4g} N m/rad: the response in speeds is that of a motor "
            "that turns freely; take speed_response, or leave out motor.holding_stiffness"
        )
    n, g = chain.size, chain.link_matrix
    inverse = np.diag(1.0 / np.array(chain.inertias))
    a = np.zeros((2 * n - 1, 2 * n - 1))
    a[: n - 1, n - 1 :] = g
    a[n - 1 :, : n - 1] = -inverse @ g.T @ np.diag(chain.stiffness)
    a[n - 1 :, n - 1 :] = -inverse @ chain.damping_matrix
    return a, np.vstack([np.zeros((n - 1, n)), inverse])


def speed_transfer_function(chain: LumpedChain, torque_on: int = 0, speed_of: int = 0) -> tuple[Array, Array]:
    """Polynomials of the transfer function from torque to speed, Eqs. (4.17), (4.19), (6.12), (6.14).

    The second line of (4.19) and the first of (6.14) are misprinted; the equations of motion give this.

    ``chain``: one inertia gives (4.17), motor and drive pulley (4.19), Model 3 (6.12), Model 4 (6.14);
    ``torque_on``, ``speed_of``: numbers of the inertias, from the motor.
    Returns ``numerator``, shape (2n - 1,); ``denominator``, shape (2n,): coefficients of falling powers of s;
    the denominator starts with 1.
    """
    a, b = speed_state_space(chain)
    column = b[:, torque_on]
    row = np.zeros(a.shape[0])
    row[chain.size - 1 + speed_of] = 1.0
    denominator = np.real(np.poly(a))
    # det(s - A + b c) = det(s - A) (1 + c (s - A)^-1 b); b is scaled to the size of A against cancellation.
    scale = np.linalg.norm(a) / np.linalg.norm(column) if np.any(a) else 1.0
    numerator = (np.real(np.poly(a - scale * np.outer(column, row))) - denominator) / scale
    return numerator[1:], denominator


def speed_response(chain: LumpedChain, omega: Array, torque_on: int = 0, speed_of: int = 0) -> Complex:
    r"""Frequency response from torque to speed.

    .. math:: H = i\omega\, e^T (K + i\omega C - \omega^2 M)^{-1} f

    ``omega``, shape (m,): angular frequencies [rad/s], not zero; ``torque_on``, ``speed_of``: numbers of the
    inertias, from the motor.
    Returns shape (m,): speed per torque [rad/(N m s)].
    """
    w = np.asarray(omega, dtype=float)[:, None, None]
    dynamic = chain.stiffness_matrix + 1j * w * chain.damping_matrix - w**2 * np.diag(chain.inertias)
    force = np.zeros((chain.size, 1))
    force[torque_on] = 1.0
    angle = np.linalg.solve(dynamic, np.broadcast_to(force, (w.shape[0], chain.size, 1)))
    return 1j * w[:, 0, 0] * angle[:, speed_of, 0]


def natural_frequencies_of(chain: LumpedChain) -> Array:
    """Undamped natural frequencies [rad/s], ascending, without the rigid rotation if there is one."""
    root = 1.0 / np.sqrt(np.array(chain.inertias))
    squares = np.linalg.eigvalsh(root[:, None] * chain.stiffness_matrix * root)
    return np.sqrt(np.clip(squares[0 if chain.holding > 0.0 else 1 :], 0.0, None))
