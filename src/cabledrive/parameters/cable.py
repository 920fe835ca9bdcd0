"""The cable, belt or tendon: stiffness, mass, pretension, damping."""

from dataclasses import dataclass
from math import sqrt

from cabledrive.parameters.fields import check_fields, quantity


@dataclass(frozen=True, slots=True, kw_only=True)
class Cable:
    r"""A uniform flexible cable under pretension, stretched elastically.

    Density is per metre of *unstretched* cable, what a user weighs; its mass is conserved when it stretches.

    Attributes
    ----------
    youngs_modulus : float
        Young's modulus :math:`E` [Pa].
    area : float
        Load-bearing cross-section :math:`A` [m^2].
    mass_per_length : float
        Mass per unstretched length :math:`\rho_0` [kg/m].
    pretension : float
        Pretension :math:`T_0` [N]; positive in traction.
    transverse_damping : float, default 0.0
        Transverse damping :math:`\Gamma` [1/s], force per unit momentum, Eq. (2.14).
    axial_damping : float, default 0.0
        Kelvin-Voigt damping :math:`b_{kv}` [N s]: force per strain rate.
    strain_limit : float or None, default None
        Largest strain of the elastic range [-], if known.
    """

    youngs_modulus: float = quantity("Pa", "positive", "Young's modulus E")
    area: float = quantity("m^2", "positive", "load-bearing cross-section A")
    mass_per_length: float = quantity("kg/m", "positive", "mass per metre of unstretched cable rho0")
    pretension: float = quantity("N", "positive", "pretension T0; a slack cable transmits nothing")
    transverse_damping: float = quantity("1/s", "nonnegative", "transverse damping Gamma", 0.0)
    axial_damping: float = quantity("N s", "nonnegative", "Kelvin-Voigt damping, force per strain rate", 0.0)
    strain_limit: float | None = quantity("1", "positive", "largest strain of the elastic range", None)

    def __post_init__(self) -> None:
        check_fields(self)

    @property
    def axial_rigidity(self) -> float:
        """Axial rigidity EA [N]."""
        return self.youngs_modulus * self.area

    @property
    def prestrain(self) -> float:
        """Strain under the pretension, T0 / EA [-], Eq. (2.1)."""
        return self.pretension / self.axial_rigidity

    @property
    def stretched_mass_per_length(self) -> float:
        """Mass per pretensioned metre, rho = rho0 / (1 + eps0) [kg/m]."""
        return self.mass_per_length / (1.0 + self.prestrain)

    @property
    def axial_wave_speed(self) -> float:
        """Longitudinal wave speed c_u along the pretensioned cable [m/s], c_u^2 = EA (1 + eps0) / rho."""
        return sqrt(self.axial_rigidity / self.mass_per_length) * (1.0 + self.prestrain)

    @property
    def transverse_wave_speed(self) -> float:
        """Transverse wave speed c_w along the pretensioned cable [m/s], c_w^2 = T0 / rho."""
        return sqrt(self.pretension / self.stretched_mass_per_length)
