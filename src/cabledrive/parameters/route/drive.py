"""A machine: bodies, pulleys, anchors and the ways of its cables, checked."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property

from cabledrive.parameters.cable import Rope
from cabledrive.parameters.drive import SENSE, Drive
from cabledrive.parameters.drive_parts import Lumped
from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.fields import choice, described, meaning, nearest
from cabledrive.parameters.machine import MachineBase
from cabledrive.parameters.route.geometry import FreeSpan, Place, spans_of_route
from cabledrive.parameters.route.parts import (
    Anchor,
    Body,
    Route,
    RoutedCarriage,
    RoutedMotor,
    RoutedPulley,
    RouteLayout,
    rope_of,
)

_UNDER_GRAVITY = RouteLayout()
ANGLES = ("drive_angle", "load_angle", "motor_angle")


@described
@dataclass(frozen=True, kw_only=True, repr=False)
class Machine(MachineBase):
    """A machine whose cables run over any number of pulleys: what every drive file is read into."""

    kind: str = choice(("route", "loop", "line"), "whether its file lists ways or two pulleys", "route")
    cable: Rope | None = meaning("what the routes have in common", None)
    layout: RouteLayout = meaning("gravity", _UNDER_GRAVITY)
    body: tuple[Body, ...] = meaning("in the order of the file", ())
    pulley: tuple[RoutedPulley, ...] = meaning("in the order of the file", ())
    anchor: tuple[Anchor, ...] = meaning("in the order of the file", ())
    route: tuple[Route, ...] = meaning("in the order of the file")
    carriage: tuple[RoutedCarriage, ...] = meaning("in the order of the file", ())
    motor: tuple[RoutedMotor, ...] = meaning("in the order of the file", ())
    loads: tuple[int, ...] = field(default=(), metadata={"file": False})  # driven pulleys that nothing holds
    stops: tuple[int, ...] = field(default=(), metadata={"file": False})  # held at rest without a motor
    # read from a file of two pulleys: what that calls the free spans, and what it measured
    called: tuple[str, ...] = field(default=(), metadata={"file": False})
    lumped: Lumped | None = field(default=None, metadata={"file": False})

    def __post_init__(self) -> None:
        MachineBase.__post_init__(self)
        if not self.route:
            raise InputRefused("route: none given: list the way of at least one cable under [[route]]")
        # a name calls one pulley or anchor of a path, and one body; `--hold` must know which is meant
        pulleys = [pulley.name for pulley in self.pulley]
        for where, names in (
            ("[[pulley]] and [[anchor]]", [*pulleys, *(anchor.name for anchor in self.anchor)]),
            ("[[body]] and [[pulley]]", [*(body.name for body in self.body), *pulleys]),
            ("[[route]]", [route.name for route in self.route]),
            ("[[carriage]]", [carriage.name for carriage in self.carriage if carriage.name]),
        ):
            twice = next((name for name in names if names.count(name) > 1), None)
            if twice is not None:
                raise InputRefused(f'name = "{twice[:60]}" is given twice among {where}: choose another')
        self.parents  # noqa: B018 (refuses unknown names and rings of bodies)
        self.driven  # noqa: B018
        self.free_spans  # noqa: B018
        self.carriage_places  # noqa: B018

    @property
    def figures(self) -> list[tuple[str, str]]:
        """Key and value of each quantity that its file states."""
        return super().figures if self.listed is self else self.listed.figures

    @property
    def machine(self) -> "Machine":
        """Itself, as `Drive.machine` has it."""
        return self

    @property
    def listed(self) -> "Machine | Drive":
        """What its file lists: two pulleys, or itself."""
        return self.plant or self

    @property
    def plant(self) -> Drive | None:
        """The two pulleys that its file lists, for control as they stand; of routes a chain is found."""
        return self.two_pulleys if self.called else None

    @property
    def sense(self) -> float:
        """Turn of a pulley per turn that its file counts: the file of two pulleys counts as the rope runs."""
        return SENSE if self.called else 1.0

    @property
    def angles(self) -> tuple[tuple[str, str], ...]:
        """What the file of two pulleys calls the angles of drive pulley, load and motor, and their names."""
        if not self.called:
            return ()
        drive, load = (pulley.name for pulley in self.pulley)
        soft = self.motor and self.motor[0].joint_stiffness is not None
        return tuple(zip(ANGLES, (drive, load, f"rotor of {drive}" if soft else drive), strict=True))

    @cached_property
    def two_pulleys(self) -> Drive | None:
        """The one cable between two pulleys that it is, which has closed forms; None where it is more."""
        from cabledrive.parameters.route.two_pulleys import in_machine

        with suppress(InputRefused):
            return in_machine(self)
        return None

    @cached_property
    def plain(self) -> "Machine":
        """Itself as if its file listed the routes: spans and coordinates by their own names and senses."""
        return replace(self, kind="route", called=(), lumped=None) if self.called else self

    @cached_property
    def ropes(self) -> tuple[Rope, ...]:
        """The rope of each route."""
        return tuple(rope_of(self.cable, route) for route in self.route)

    @cached_property
    def parents(self) -> tuple[int | None, ...]:
        """Number of the body that carries each body; None: the frame."""
        found = tuple(body_number(self, part.on, f"body.{i}.on") for i, part in enumerate(self.body))
        for number, body in enumerate(self.body):
            above, steps = found[number], 0
            while above is not None:
                above, steps = found[above], steps + 1
                if steps > len(found):
                    raise InputRefused(f'body "{body.name}" is carried by itself: check the keys `on`')
        return found

    @cached_property
    def driven(self) -> tuple[int, ...]:
        """Number of the pulley that each motor drives."""
        names = [pulley.name for pulley in self.pulley]
        found = []
        for number, motor in enumerate(self.motor):
            if not names:
                raise InputRefused("motor: there is no [[pulley]] to drive: add one")
            if motor.pulley and motor.pulley not in names:
                hint = nearest(motor.pulley[:60], names)
                raise InputRefused(f'motor.{number}.pulley = "{motor.pulley[:60]}" is no pulley{hint}')
            pulley = names.index(motor.pulley) if motor.pulley else 0
            if self.pulley[pulley].fixed:
                raise InputRefused(f'pulley "{names[pulley]}" is fixed, but a motor drives it: leave one out')
            if pulley in found:
                raise InputRefused(f'pulley "{names[pulley]}" has two motors: give each motor its pulley')
            found.append(pulley)
        return tuple(found)

    @property
    def held(self) -> tuple[int, ...]:
        """Number of each pulley that its motor or a stop holds at rest."""
        return (*self.stops, *(number for number in self.driven if number not in self.loads))

    @property
    def turned(self) -> tuple[int, ...]:
        """Number of each pulley that a torque turns: those of the motors, the first where there is none."""
        return self.driven or tuple(range(len(self.pulley)))[:1]

    @cached_property
    def places(self) -> tuple[tuple[Place, ...], ...]:
        """Places of each route, in order of its path."""
        return tuple(
            tuple(_place(self, step, f'route "{route.name}"') for step in route.path) for route in self.route
        )

    @cached_property
    def free_spans(self) -> tuple[FreeSpan, ...]:
        """Free spans of all routes, each in order of travel; names made distinct where two are alike."""
        found: list[FreeSpan] = []
        for number, (route, places) in enumerate(zip(self.route, self.places, strict=True)):
            found += spans_of_route(number, route.name, list(places), route.closed, route.crossed)
        if self.called:
            return tuple(replace(span, name=own) for span, own in zip(found, self.called, strict=True))
        names = [span.name for span in found]
        return tuple(
            span
            if names.count(span.name) == 1
            else replace(
                span, name=f"{self.route[span.route].name}: {span.name} ({names[: i + 1].count(span.name)})"
            )
            for i, span in enumerate(found)
        )

    @property
    def spans(self) -> tuple[str, ...]:
        """Names of the free spans."""
        return tuple(span.name for span in self.free_spans)

    @cached_property
    def carriage_places(self) -> tuple[tuple[int, float], ...]:
        """Span of each carriage and its distance from the span's start [m]."""
        return tuple(_carriage_place(self, number) for number in range(len(self.carriage)))


def body_number(machine: Machine, name: str, key: str) -> int | None:
    """Number of a body by its name, None for the frame, which has none; ``key``: where it is written.

    Raises `InputRefused` if no body has that name.
    """
    if not name:
        return None
    names = [body.name for body in machine.body]
    if name not in names:
        raise InputRefused(f'{key} = "{name[:60]}" is no body{nearest(name[:60], names)}')
    return names.index(name)


def carried_by(machine: Machine, number: int | None) -> tuple[int, ...]:
    """A body and all that carry it, the body itself first; nothing carries the frame, None."""
    found: list[int] = []
    while number is not None:
        found.append(number)
        number = machine.parents[number]
    return tuple(found)


def _place(drive: Machine, step: str, where: str) -> Place:
    """What one step of a path calls."""
    sense = {"+": 1, "-": -1}.get(step[:1], 0)
    name = step[1:].strip() if sense else step
    parts: Sequence[RoutedPulley | Anchor] = drive.pulley if sense else drive.anchor
    names = [part.name for part in parts]
    if name not in names:
        other = [part.name for part in (drive.anchor if sense else drive.pulley)]
        if name in other:
            remedy = "write it without a sign" if sense else f'write "+{name}" (anticlockwise) or "-{name}"'
            raise InputRefused(f'{where}: path step "{step[:60]}" names the wrong kind of part: {remedy}')
        kind = "pulley" if sense else "anchor"
        raise InputRefused(
            f'{where}: path step "{step[:60]}" is no {kind}{nearest(name[:60], names + other)}'
        )
    number = names.index(name)
    if not sense:
        return Place(name=name, pulley=None, anchor=number, sense=0, centre=parts[number].at, radius=0.0)
    part = drive.pulley[number]
    return Place(
        name=name,
        pulley=number,
        anchor=None,
        sense=sense,
        centre=part.at,
        radius=part.radius,
        turns=part.turns,
        wrap=part.wrap_angle,
    )


def _carriage_place(drive: Machine, number: int) -> tuple[int, float]:
    carriage = drive.carriage[number]
    names = [route.name for route in drive.route]
    if carriage.route and carriage.route not in names:
        hint = nearest(carriage.route[:60], names)
        raise InputRefused(f'carriage.{number}.route = "{carriage.route[:60]}" is no route{hint}')
    route = names.index(carriage.route) if carriage.route else 0
    if drive.route[route].ropes > 1:
        said = f'carriage.{number}: route "{names[route]}" has {drive.route[route].ropes} ropes'
        raise InputRefused(f"{said}, a carriage is clamped to one: make it a body with anchors")
    left = carriage.position
    total = 0.0
    for index, span in enumerate(drive.free_spans):
        if span.route == route:
            if left < span.length:
                if left <= 1e-9 * span.length:
                    raise InputRefused(
                        f"carriage.{number}.position = {carriage.position:.9g} m is where {span.start.name} "
                        "is: move it into a span"
                    )
                return index, left
            left -= span.length
            total += span.length
    raise InputRefused(
        f"carriage.{number}.position = {carriage.position:.9g} m lies outside its route of {total:.9g} m of "
        "free spans: move it inside"
    )
