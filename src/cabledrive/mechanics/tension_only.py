"""A cable that goes slack instead of pushing, under any law."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.cable_law import Array, CableLaw, Components


@dataclass(frozen=True, slots=True, kw_only=True)
class TensionOnly(CableLaw):
    """Another law, for a cable that goes slack instead of pushing."""

    taut: CableLaw  # the law of the taut cable

    @property
    def tension_only(self) -> bool:
        """True."""
        return True

    @property
    def slack_strain(self) -> float:
        """That of the taut law [-]."""
        return self.taut.slack_strain

    def components(self, u_x: Array, v_x: Array, w_x: Array) -> Components:
        """Components of the tension, zero where the cable is slack; see `CableLaw.components`."""
        x, y, z = self.excess_components(u_x, v_x, w_x)
        return self.pretension + x, y, z

    def excess_components(self, u_x: Array, v_x: Array, w_x: Array) -> Components:
        """Components above the pretension, see `CableLaw.excess_components`."""
        slack = self.is_slack(u_x, v_x, w_x)
        x, y, z = self.taut.excess_components(u_x, v_x, w_x)
        return np.where(slack, -self.pretension, x), np.where(slack, 0.0, y), np.where(slack, 0.0, z)

    def strain(self, u_x: Array, v_x: Array, w_x: Array) -> Array:
        """Apparent strain [-], see `CableLaw.strain`."""
        return self.taut.strain(u_x, v_x, w_x)

    def strain_gradient(self, u_x: Array, v_x: Array, w_x: Array) -> Components:
        """Derivative of the strain, zero where the cable is slack; see `CableLaw.strain_gradient`."""
        slack = self.is_slack(u_x, v_x, w_x)
        x, y, z = (np.where(slack, 0.0, part) for part in self.taut.strain_gradient(u_x, v_x, w_x))
        return x, y, z

    def tension(self, u_x: Array, v_x: Array, w_x: Array) -> Array:
        """Tension, not below zero [N]; see `CableLaw.tension`."""
        return np.maximum(self.taut.tension(u_x, v_x, w_x), 0.0)

    def is_slack(self, u_x: Array, v_x: Array, w_x: Array) -> NDArray[np.bool_]:
        """Where the taut law would push, see `CableLaw.is_slack`."""
        return self.taut.is_slack(u_x, v_x, w_x)

    def energy_density(self, u_x: Array, v_x: Array, w_x: Array) -> Array:
        """Energy density [J/m]; where the cable is slack, minus the work of the pretension."""
        limit, zero = np.array(self.taut.slack_strain), np.array(0.0)
        at_limit = self.taut.energy_density(limit, zero, zero) + self.pretension * limit
        taut = self.taut.energy_density(u_x, v_x, w_x)
        return np.where(self.is_slack(u_x, v_x, w_x), at_limit - self.pretension * u_x, taut)

    def stiffness_matrix(self, u_x: Array, v_x: Array, w_x: Array) -> Array:
        """Derivative of the components, zero where the cable is slack [N]."""
        slack = self.is_slack(u_x, v_x, w_x)
        return np.where(slack[..., None, None], 0.0, self.taut.stiffness_matrix(u_x, v_x, w_x))

    def largest_stiffness(self) -> float:
        """That of the taut law [N]."""
        return self.taut.largest_stiffness()


def taut_law(law: CableLaw) -> CableLaw:
    """The law of the taut cable, whether it may go slack or not."""
    return law.taut if isinstance(law, TensionOnly) else law


def without_pushing(law: CableLaw) -> TensionOnly:
    """The law of a cable that goes slack where the tension would be negative."""
    return TensionOnly(pretension=law.pretension, axial_rigidity=law.axial_rigidity, taut=law)
