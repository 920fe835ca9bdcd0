"""What a route's cable is made of: the common table, and what one route says otherwise."""

import dataclasses
from dataclasses import dataclass, replace
from math import sqrt
from typing import Any

from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.fields import check_fields, choice, quantity, words
from cabledrive.parameters.rigidity import Rigidity, check_one_rigidity
from cabledrive.parameters.route.parts import check_name

_RIGIDITY = ("youngs_modulus", "area", "given_rigidity")


@dataclass(frozen=True, kw_only=True)
class Rope(Rigidity):
    """Keys of ``[cable]`` in a file of kind "route"; a route may say any of them otherwise.

    Attributes
    ----------
    type : str
        Name in the packaged table of belts and ropes, from which absent keys are taken.
    youngs_modulus, area, given_rigidity : float or None
        Modulus [Pa] and cross-section [m^2], or the axial rigidity [N].
    mass_per_length : float or None
        Mass per unstretched metre of one rope [kg/m].
    pretension : float or None
        Tension of one rope [N]; statics starts from it, and needs none where weights give the tension.
    transverse_damping, axial_damping : float
        [1/s], [N s].
    strain_limit : float or None
        Largest strain of the elastic range [-].
    strength : float or None
        Breaking load, or the allowed tension of a belt [N].
    bending_stiffness : float or None
        EI [N m^2].
    least_radius : float or None
        Smallest radius it may be bent to [m].
    tooth_pitch : float or None
        Pitch of a toothed belt [m].
    """

    type: str = words("name in the packaged table of belts and ropes", "")
    youngs_modulus: float | None = quantity("Pa", "positive", "Young's modulus E", None)
    area: float | None = quantity("m^2", "positive", "load-bearing cross-section A", None)
    given_rigidity: float | None = quantity(
        "N", "positive", "axial rigidity EA, instead of modulus and area", None, key="axial_rigidity"
    )
    mass_per_length: float | None = quantity("kg/m", "positive", "mass per unstretched metre", None)
    pretension: float | None = quantity("N", "positive", "tension of one rope", None)
    transverse_damping: float = quantity("1/s", "nonnegative", "transverse damping Gamma", 0.0)
    axial_damping: float = quantity("N s", "nonnegative", "Kelvin-Voigt damping, force per strain rate", 0.0)
    strain_limit: float | None = quantity("1", "positive", "largest strain of the elastic range", None)
    strength: float | None = quantity("N", "positive", "breaking load, or allowed tension of a belt", None)
    bending_stiffness: float | None = quantity("N m^2", "positive", "bending stiffness EI", None)
    least_radius: float | None = quantity("m", "positive", "smallest radius it may be bent to", None)
    tooth_pitch: float | None = quantity("m", "positive", "pitch of a toothed belt", None)

    def __post_init__(self) -> None:
        check_fields(self)
        check_one_rigidity(self)

    @property
    def density(self) -> float:
        """Mass per unstretched length of one rope [kg/m]."""
        assert self.mass_per_length is not None
        return self.mass_per_length

    def wave_speed(self, tension: float) -> float:
        """Transverse wave speed along the rope under a tension.

        Parameters
        ----------
        tension : float
            [N].

        Returns
        -------
        float
            [m/s].
        """
        return sqrt(tension * (1.0 + tension / self.axial_rigidity) / self.density)


@dataclass(frozen=True, kw_only=True)
class Route(Rope):
    """The way of one cable from anchor to pulley to anchor.

    Attributes
    ----------
    name : str
    path : tuple of str
        "+name": anticlockwise round a pulley, its centre to the left of travel; "-name": clockwise; a bare
        name: an anchor. A pulley at an end of an open path is a drum, to which the cable is fixed.
    closed : bool, default False
        Whether the last place leads to the first.
    ropes : int, default 1
        Parallel ropes, all alike.
    speed : float, default 0.0
        Speed at which the cable runs along its path [m/s]; `pretension` is the tension while it runs.
    crossed : bool, default False
        Whether spans of this route may cross each other in the drawing.
    """

    name: str = words("name by which it is called", "")
    path: tuple[str, ...] = ()
    closed: bool = choice((False, True), "whether the last place leads to the first", False)
    ropes: int = quantity("count", "positive", "parallel ropes, all alike", 1)
    speed: float = quantity("m/s", "finite", "speed of the cable along its path", 0.0)
    crossed: bool = choice((False, True), "whether its own spans may cross", False)

    def __post_init__(self) -> None:
        Rope.__post_init__(self)
        check_name(self.name)
        object.__setattr__(self, "path", tuple(self.path))
        if any(not isinstance(place, str) for place in self.path) or len(self.path) < 2:
            raise InputRefused('path must list at least two places: write ["clamp", "+pulley", "-idler"]')


def rope_of(common: Rope | None, route: Route) -> Rope:
    """The rope of a route: its own keys, else those of ``[cable]``; refused without rigidity or mass."""
    names = [field.name for field in dataclasses.fields(Rope)]
    own = {name: getattr(route, name) for name in names if _given(route, name)}
    if any(name in own for name in _RIGIDITY) and common is not None:
        # A rigidity of its own stands instead of modulus and area, and the other way round.
        clash = ("youngs_modulus", "area") if "given_rigidity" in own else ("given_rigidity",)
        absent: dict[str, Any] = dict.fromkeys(clash)
        common = replace(common, **absent)
    rope = replace(common or Rope(), **own)
    pair = (rope.youngs_modulus, rope.area)
    if rope.given_rigidity is None and None in pair:
        raise InputRefused(
            f'route "{route.name}": its axial rigidity is missing: give axial_rigidity [N], or '
            "youngs_modulus "
            "[Pa] and area [m^2], here or in [cable]"
        )
    if rope.mass_per_length is None:
        raise InputRefused(
            f'route "{route.name}": mass_per_length [kg/m] is missing: give it here or in [cable]'
        )
    return rope


def _given(route: Route, name: str) -> bool:
    default = next(field.default for field in dataclasses.fields(Rope) if field.name == name)
    return getattr(route, name) != default
