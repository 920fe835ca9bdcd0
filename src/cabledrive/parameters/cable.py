"""The cable, belt or tendon: stiffness, mass, pretension, damping, and packaged types by name."""

import tomllib
from dataclasses import dataclass, replace
from functools import cache
from importlib import resources
from math import sqrt
from typing import Any

from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.fields import check_fields, described, kind_of, nearest, quantity, words


@described
@dataclass(frozen=True, slots=True, kw_only=True)
class Rope:
    """Keys of ``[cable]``: all optional in a file of kind "route", where a route may say any otherwise."""

    youngs_modulus: float | None = quantity("Pa", "positive", "Young's modulus E", None)
    area: float | None = quantity("m^2", "positive", "load-bearing cross-section A", None)
    given_rigidity: float | None = quantity(
        "N", "positive", "axial rigidity EA, instead of modulus and area", None, key="axial_rigidity"
    )
    mass_per_length: float | None = quantity("kg/m", "positive", "mass per metre of unstretched cable", None)
    pretension: float | None = quantity("N", "positive", "tension of one rope", None)
    transverse_damping: float = quantity("1/s", "nonnegative", "transverse damping Gamma", 0.0)
    axial_damping: float = quantity("N s", "nonnegative", "Kelvin-Voigt damping, force per strain rate", 0.0)
    strain_limit: float | None = quantity("1", "positive", "largest strain of the elastic range", None)
    strength: float | None = quantity("N", "positive", "breaking load, or allowed tension of a belt", None)
    bending_stiffness: float | None = quantity("N m^2", "positive", "bending stiffness EI", None)
    least_radius: float | None = quantity("m", "positive", "smallest radius of a pulley", None)
    tooth_pitch: float | None = quantity("m", "positive", "pitch of a toothed belt", None)
    type: str = words("name in the packaged table of belts and ropes", "")

    def __post_init__(self) -> None:
        check_fields(self)
        if self.given_rigidity is not None and (self.youngs_modulus, self.area) != (None, None):
            said = f"axial_rigidity = {self.given_rigidity:.9g} N beside youngs_modulus or area"
            raise InputRefused(f"{said}: give the rigidity, or modulus and area")

    @property
    def axial_rigidity(self) -> float:
        """Axial rigidity EA of one cable [N]."""
        if self.given_rigidity is not None:
            return self.given_rigidity
        assert self.youngs_modulus is not None
        assert self.area is not None
        return self.youngs_modulus * self.area

    @property
    def density(self) -> float:
        """Mass per unstretched length of one rope [kg/m]."""
        assert self.mass_per_length is not None
        return self.mass_per_length

    def wave_speed(self, tension: float) -> float:
        """Transverse wave speed [m/s] along the rope under a tension [N]."""
        return sqrt(tension * (1.0 + tension / self.axial_rigidity) / self.density)


@described
@dataclass(frozen=True, slots=True, kw_only=True)
class Cable(Rope):
    r"""A uniform flexible cable under pretension, stretched elastically.

    Density is per metre of *unstretched* cable, what a user weighs; its mass is conserved when it stretches.
    """

    mass_per_length: float = quantity("kg/m", "positive", "mass per metre of unstretched cable rho0")
    pretension: float = quantity("N", "positive", "pretension T0; a slack cable transmits nothing")

    def __post_init__(self) -> None:
        Rope.__post_init__(self)
        if self.given_rigidity is None and None in (self.youngs_modulus, self.area):
            which = "youngs_modulus" if self.youngs_modulus is None else "area"
            said = f"{which} is missing: give youngs_modulus [Pa] and area [m^2], or axial_rigidity [N]"
            raise InputRefused(f"{said}, their product")

    def with_rigidity(self, rigidity: float) -> "Cable":
        """The same cable of another axial rigidity.

        Parameters
        ----------
        rigidity : float
            EA [N].

        Returns
        -------
        Cable
            Its area kept where it is known.
        """
        if self.area is None:
            return replace(self, given_rigidity=rigidity)
        return replace(self, youngs_modulus=rigidity / self.area)

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


RIGIDITY = ("youngs_modulus", "area")


@cache
def cable_types() -> dict[str, dict[str, Any]]:
    """The table: keys of ``[cable]`` by name of the belt or rope, and ``source``."""
    text = (resources.files("cabledrive.parameters") / "cable_types.toml").read_text(encoding="utf-8")
    return tomllib.loads(text)


def with_type(table: Any, place: str) -> Any:
    """A ``[cable]`` table, what it leaves out from its packaged type; an unknown type is refused."""
    if not isinstance(table, dict) or "type" not in table:
        return table
    name = table["type"]
    if not isinstance(name, str):
        raise InputRefused(f"{place}.type is {kind_of(name)}, not text: write it between quotation marks")
    if name not in cable_types():
        raise InputRefused(
            f'{place}.type = "{name[:60]}" is not in the table{nearest(name[:60], cable_types())}'
        )
    listed = {key: value for key, value in cable_types()[name].items() if key != "source"}
    if any(key in table for key in RIGIDITY):  # a rigidity of the file's own, by modulus and area
        listed.pop("axial_rigidity", None)
    return listed | table
