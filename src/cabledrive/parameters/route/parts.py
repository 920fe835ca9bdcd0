"""Parts of a machine whose cable's way is listed: bodies, pulleys, anchors, motors, ropes."""

import dataclasses
from dataclasses import dataclass, field, replace
from typing import Any

from cabledrive.parameters.cable import RIGIDITY, Rope
from cabledrive.parameters.drive_parts import Motor
from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.fields import (
    Checked,
    check_fields,
    choice,
    described,
    meaning,
    pair,
    quantity,
    words,
    written,
)

MOVES = ("x", "y", "turn")


def check_name(name: str) -> None:
    """Refuse a name that no key or path could call."""
    if not name.strip() or name != name.strip() or name[0] in "+-" or "." in name:
        raise InputRefused(
            f"name = {written(name)} cannot be called: write letters and numbers, no dot, + or - not first"
        )


def require_within_travel(body: "Body", value: float) -> None:
    """Refuse a place of a body [m], or a turn from the pose of the file [rad], outside its travel."""
    if body.travel is None:
        return
    low, high = body.travel
    slack = 1e-9 * (high - low)
    if not low - slack <= value <= high + slack:
        unit = "rad" if body.moves == ("turn",) else "m"
        said = f"{body.name}.{body.moves[0]} = {value:.6g} {unit} lies outside its travel, {low:.6g} "
        raise InputRefused(f"{said}: {high:.6g} {unit}: stay inside, or change body.{body.name}.travel")


@described
@dataclass(frozen=True, slots=True, kw_only=True)
class Body:
    """A mass that moves as the file says and carries pulleys, anchors and other bodies."""

    name: str = words("name by which it is called", "")
    at: tuple[float, float] = pair("m", "centre of mass")
    moves: tuple[str, ...] = meaning('how it moves; "turn": about its pivot', ())
    on: str = words("body that carries it; absent: the frame", "")
    pivot: tuple[float, float] | None = pair("m", "axis about which it turns", None)
    mass: float = quantity("kg", "nonnegative", "mass", 0.0)
    inertia: float = quantity("kg m^2", "nonnegative", "moment of inertia about `at`", 0.0)
    stiffness: float = quantity("N/m", "nonnegative", "spring of its own motion; of a turn N m/rad", 0.0)
    damping: float = quantity("N s/m", "nonnegative", "damper of its own motion; of a turn N m s/rad", 0.0)
    coulomb_friction: float = quantity("N", "nonnegative", "friction of its own motion; of a turn N m", 0.0)
    load: tuple[float, float] = pair("N", "constant force at `at`", (0.0, 0.0))
    travel: tuple[float, float] | None = pair("m", "lowest and highest place; of a turn rad", None)

    def __post_init__(self) -> None:
        check_fields(self)
        check_name(self.name)
        given = tuple(self.moves) if isinstance(self.moves, (list, tuple)) else (self.moves,)
        object.__setattr__(self, "moves", given)
        if not given or any(move not in MOVES for move in given) or len(set(given)) < len(given):
            raise InputRefused(f'moves = {written(list(given))} must be "x", "y", "turn", or ["x", "y"]')
        if "turn" in given and len(given) > 1:
            raise InputRefused(
                'moves = "turn" stands alone: put a sliding body under the turning one with `on`'
            )
        if ("turn" in given) != (self.pivot is not None):
            remedy = "add pivot = [x, y]" if self.pivot is None else 'leave it out, or write moves = "turn"'
            raise InputRefused(f'pivot goes together with moves = "turn": {remedy}')
        if self.travel is None:
            return
        low, high = self.travel
        if len(self.moves) > 1:
            raise InputRefused(f'travel belongs to one way, body "{self.name}" has two: leave it out')
        if not low < high:
            raise InputRefused(f"travel = {low:.9g} : {high:.9g} must be two places, the higher last")
        if self.moves != ("turn",):
            require_within_travel(self, self.at["xy".index(self.moves[0])])


@described
@dataclass(frozen=True, slots=True, kw_only=True)
class Anchor:
    """A point of a body or the frame where a cable ends or is clamped."""

    name: str = words("name by which it is called", "")
    at: tuple[float, float] = pair("m", "place")
    on: str = words("body that carries it; absent: the frame", "")

    def __post_init__(self) -> None:
        check_fields(self)
        check_name(self.name)


@described
@dataclass(frozen=True, slots=True, kw_only=True)
class RoutedPulley(Anchor):
    """A pulley, idler or drum that stands somewhere, on the frame or on a body."""

    at: tuple[float, float] = pair("m", "centre")
    radius: float = quantity("m", "positive", "radius at the cable's centre line")
    inertia: float = quantity("kg m^2", "nonnegative", "moment of inertia about the axis", 0.0)
    mass: float = quantity("kg", "nonnegative", "mass, carried by its body", 0.0)
    viscous_friction: float = quantity("N m s/rad", "nonnegative", "viscous friction b", 0.0)
    coulomb_friction: float = quantity("N m", "nonnegative", "Coulomb friction c", 0.0)
    fixed: bool = choice((False, True), "a sliding guide that does not turn", False)
    capstan_friction: float | None = quantity(
        "1", "positive", "friction coefficient of cable on pulley", None
    )
    turns: int = quantity("count", "nonnegative", "full turns of the cable beyond the angle of wrap", 0)
    # as the file of two pulleys states it, else that of the drawing [rad]
    wrap_angle: float | None = field(default=None, metadata={"file": False})


@described
@dataclass(frozen=True, slots=True, kw_only=True)
class RoutedMotor(Motor):
    """A motor on the shaft of a named pulley."""

    pulley: str = words("pulley it drives; absent: the first", "")


@described
@dataclass(frozen=True, slots=True, kw_only=True)
class RoutedCarriage(Checked):
    """A point mass clamped to the cable of a route."""

    mass: float = quantity("kg", "positive", "mass clamped to the cable")
    position: float = quantity("m", "positive", "free span lengths from the route's first contact")
    route: str = words("route that carries it; absent: the first", "")
    guided: bool = choice(
        (False, True), "rides on a rail (no transverse motion); false: hangs on the cable", True
    )
    name: str = words("name by which it can be called", "")
    # of a file of two pulleys: the carriage that it moves with, and whether as that does or against it
    coupled: str = field(default="", metadata={"file": False})
    direction: int = field(default=1, metadata={"file": False})


@dataclass(frozen=True, slots=True, kw_only=True)
class RouteLayout(Checked):
    """Gravity in the plane of the machine."""

    gravity: float = quantity("m/s^2", "nonnegative", "gravitational acceleration, along -y", 9.81)
    inclination: float = quantity("rad", "steepness", "angle of the x axis above the horizontal", 0.0)


@described
@dataclass(frozen=True, kw_only=True)
class Route(Rope):
    """The way of one cable from anchor to pulley to anchor."""

    name: str = words("name by which it is called", "")
    path: tuple[str, ...] = meaning(
        '"+name": anticlockwise round a pulley, its centre to the left of travel; "-name": '
        "clockwise; a bare name: an anchor. A pulley at an end of an open path is a drum, to which "
        "the cable is fixed",
        (),
    )
    closed: bool = choice((False, True), "whether the last place leads to the first", False)
    ropes: int = quantity("count", "positive", "parallel ropes, all alike", 1)
    speed: float = quantity("m/s", "finite", "speed of the cable along its path", 0.0)
    crossed: bool = choice((False, True), "whether its own spans may cross", False)
    # 0 is a value of its own beside that of [cable]
    transverse_damping: float | None = quantity("1/s", "nonnegative", "transverse damping Gamma", None)  # type: ignore[assignment]
    axial_damping: float | None = quantity("N s", "nonnegative", "Kelvin-Voigt damping", None)  # type: ignore[assignment]

    def __post_init__(self) -> None:
        Rope.__post_init__(self)
        check_name(self.name)
        path = tuple(self.path) if isinstance(self.path, (list, tuple)) else ()
        object.__setattr__(self, "path", path)
        if any(not isinstance(place, str) for place in path) or len(path) < 2:
            raise InputRefused('path must list at least two places: write ["clamp", "+pulley", "-idler"]')


def rope_of(common: Rope | None, route: Route) -> Rope:
    """The rope of a route: its own keys, else those of ``[cable]``; refused without rigidity or mass."""
    stated = {one.name: getattr(route, one.name) for one in dataclasses.fields(Rope)}
    own = {name: value for name, value in stated.items() if value not in (None, "")}
    if any(name in own for name in (*RIGIDITY, "given_rigidity")) and common is not None:
        # A rigidity of its own stands instead of modulus and area, and the other way round.
        clash = ("youngs_modulus", "area") if "given_rigidity" in own else ("given_rigidity",)
        absent: dict[str, Any] = dict.fromkeys(clash)
        common = replace(common, **absent)
    rope = replace(common or Rope(), **own)
    pair = (rope.youngs_modulus, rope.area)
    if rope.given_rigidity is None and None in pair:
        said = f'route "{route.name}": its axial rigidity is missing: give axial_rigidity [N]'
        raise InputRefused(f"{said}, or youngs_modulus [Pa] and area [m^2], here or in [cable]")
    if rope.mass_per_length is None:
        raise InputRefused(
            f'route "{route.name}": mass_per_length [kg/m] is missing: give it here or in [cable]'
        )
    return rope
