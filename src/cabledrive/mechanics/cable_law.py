r"""What a cable law is: tension and its components from the displacement gradients at a point.

A material point that sits at :math:`x` of the straight, pretensioned cable moves to :math:`(x + u, v, w)`.
Everything here is a function of the gradients :math:`(u', v', w')` at that point; the equation of motion is

.. math:: \rho\,(\ddot u, \ddot v, \ddot w) = \frac{\partial}{\partial x}(T_x, T_y, T_z)

with :math:`\rho` per pretensioned metre. The laws differ in what they keep of the geometry.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar, TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float64]
Components: TypeAlias = tuple[Array, Array, Array]


@dataclass(frozen=True, slots=True, kw_only=True)
class CableLaw(ABC):
    r"""What every cable law answers, from the gradients (u', v', w') at any number of points.

    Attributes
    ----------
    pretension : float
        Pretension :math:`T_0` [N].
    axial_rigidity : float
        Axial rigidity :math:`EA` [N].
    tension_only : bool, default False
        The cable goes slack: where the tension would be negative it is zero.
    """

    name: ClassVar[str]
    has_potential: ClassVar[bool] = True

    pretension: float
    axial_rigidity: float
    tension_only: bool = False

    @property
    def stiffness(self) -> float:
        r"""Tension per apparent strain, :math:`K = EA\,(1 + \epsilon_0) = EA + T_0` [N]."""
        return self.axial_rigidity + self.pretension

    @property
    def slack_strain(self) -> float:
        r"""Apparent strain at which the tension vanishes, :math:`-T_0/K` [-]."""
        return -self.pretension / self.stiffness

    def transverse_stretch(self, u_x: Array, v_x: Array, w_x: Array) -> Array:
        """Part of the stretch that comes from the slopes.

        ``u_x``, ``v_x``, ``w_x``: displacement gradients [-].
        Returns what the slopes add to u' in the apparent strain of the energy [-].
        """
        return self._transverse_stretch(u_x, v_x, w_x)

    def strain(self, u_x: Array, v_x: Array, w_x: Array) -> Array:
        """Apparent strain, measured from the pretensioned cable.

        ``u_x``, ``v_x``, ``w_x``: displacement gradients [-].
        Returns apparent strain lambda [-]; the tension is T0 + K lambda.
        """
        return self._strain(u_x, v_x, w_x)

    def strain_gradient(self, u_x: Array, v_x: Array, w_x: Array) -> Components:
        """Derivative of the apparent strain with respect to (u', v', w').

        ``u_x``, ``v_x``, ``w_x``: displacement gradients [-].
        Returns its three components [-]; also the direction in which axial damping acts.
        """
        return self._strain_gradient(u_x, v_x, w_x)

    def tension(self, u_x: Array, v_x: Array, w_x: Array) -> Array:
        """Tension T = T0 + K lambda.

        ``u_x``, ``v_x``, ``w_x``: displacement gradients [-].
        Returns tension [N]; negative where the cable would have to push, zero there if `tension_only`.
        """
        tension = self.pretension + self.stiffness * self.strain(u_x, v_x, w_x)
        return np.maximum(tension, 0.0) if self.tension_only else tension

    def excess_components(self, u_x: Array, v_x: Array, w_x: Array) -> Components:
        """Components of the tension above the pretension, free of cancellation at small displacements.

        The pretension pulls equally on both sides of everything; what a chain sums is the rest.

        ``u_x``, ``v_x``, ``w_x``: displacement gradients [-].
        Returns tx - T0, Ty, Tz [N].
        """
        excess = self._taut_excess(u_x, v_x, w_x)
        if not self.tension_only:
            return excess
        slack = self.strain(u_x, v_x, w_x) < self.slack_strain
        x, y, z = excess
        return np.where(slack, -self.pretension, x), np.where(slack, 0.0, y), np.where(slack, 0.0, z)

    def components(self, u_x: Array, v_x: Array, w_x: Array) -> Components:
        """Components of the tension.

        ``u_x``, ``v_x``, ``w_x``: displacement gradients [-].
        Returns tx, Ty, Tz [N].
        """
        x, y, z = self.excess_components(u_x, v_x, w_x)
        return self.pretension + x, y, z

    def energy_density(self, u_x: Array, v_x: Array, w_x: Array) -> Array:
        r"""Elastic energy per pretensioned metre, above the straight pretensioned cable.

        .. math:: e = T_0\,(\lambda - u') + \tfrac12 K \lambda^2

        It is zero, and least, for the straight cable; its derivative is `excess_components`. The work of
        the pretension on the ends, :math:`T_0 u'`, is left out: it cancels round a loop. A law without a
        potential answers with that of the truncation nearest to it.

        ``u_x``, ``v_x``, ``w_x``: displacement gradients [-].
        Returns energy density [J/m].
        """
        strain = self.strain(u_x, v_x, w_x)
        slopes = self.transverse_stretch(u_x, v_x, w_x)
        taut = self.pretension * slopes + 0.5 * self.stiffness * strain**2
        if not self.tension_only:
            return taut
        slack = -self.pretension * (0.5 * self.pretension / self.stiffness + u_x)
        return np.where(strain < self.slack_strain, slack, taut)

    def stiffness_matrix(self, u_x: Array, v_x: Array, w_x: Array) -> Array:
        """Derivative of the components with respect to (u', v', w').

        ``u_x``, ``v_x``, ``w_x``: displacement gradients [-].
        Returns shape (..., 3, 3): row: component of the tension, column: gradient [N]. Symmetric if the law
        has a potential.
        """
        matrix = self._stiffness_matrix(u_x, v_x, w_x)
        if not self.tension_only:
            return matrix
        slack = self.strain(u_x, v_x, w_x) < self.slack_strain
        return np.where(slack[..., None, None], 0.0, matrix)

    def _strain(self, u_x: Array, v_x: Array, w_x: Array) -> Array:
        return u_x + self._transverse_stretch(u_x, v_x, w_x)

    @abstractmethod
    def _transverse_stretch(self, u_x: Array, v_x: Array, w_x: Array) -> Array: ...

    @abstractmethod
    def _strain_gradient(self, u_x: Array, v_x: Array, w_x: Array) -> Components: ...

    @abstractmethod
    def _taut_excess(self, u_x: Array, v_x: Array, w_x: Array) -> Components: ...

    @abstractmethod
    def _stiffness_matrix(self, u_x: Array, v_x: Array, w_x: Array) -> Array: ...
