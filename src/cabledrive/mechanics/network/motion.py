r"""Coordinates of a machine with routes, how its points move, and where a tension is passed on.

The coordinates q are the moves of each body, the angle of each pulley that turns, place along and across of
each carriage, and the rotor behind a flexible joint. An end of a span on a pulley of centre c, sense s and
radius r moves by

.. math:: u = t \cdot J_c\,q + s\,r\,\theta, \qquad w = n \cdot J_c\,q, \qquad \text{Eq. (N.2)}

along and across the span; :math:`J_c` is the motion of the body that carries it.
"""

from collections.abc import Sequence, Set
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cabledrive.mechanics.holding import FREE, HELD
from cabledrive.parameters import Machine
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.fields import nearest
from cabledrive.parameters.route.drive import body_number, carried_by
from cabledrive.parameters.route.geometry import Place, Point

ALONG, ACROSS, OUT_OF_PLANE = "along", "across", "out of plane"
AT_REST = 1e-9
"""Part of a row, relative to its largest entry, that is round-off."""


class Row(dict[int, float]):
    """A motion, a strain: numbers of the coordinates that take part, each with its factor."""

    __array_ufunc__ = None  # a number of numpy is a factor as well

    def __add__(self, other: "Row") -> "Row":
        """Both together."""
        total = Row(self)
        for number, factor in other.items():
            total[number] = total.get(number, 0.0) + factor
        return total

    def __sub__(self, other: "Row") -> "Row":
        """One against the other."""
        return self + -1.0 * other

    def __rmul__(self, factor: float) -> "Row":
        """So many times."""
        return Row({number: factor * own for number, own in self.items()})


def dense(rows: Sequence[Row], n: int) -> Array:
    """Rows of n coordinates as an array, shape (rows, n)."""
    total = np.zeros((len(rows), n))
    for own, row in zip(total, rows, strict=True):
        own[list(row)] = list(row.values())
    return total


@dataclass(frozen=True, eq=False)
class Motion:
    """Coordinates of a machine, some of them held."""

    drive: Machine
    motor: str = FREE  # of the rotors: "free", "held" or "holding"
    hold: tuple[str, ...] = ()  # names of bodies, pulleys and carriages that are held as well

    def __post_init__(self) -> None:
        known = [body.name for body in self.drive.body] + [pulley.name for pulley in self.drive.pulley]
        known += [self.carriage_name(number) for number in range(len(self.drive.carriage))]
        for name in self.hold:
            if name not in known:
                hint = (
                    ': the rotors are held by motor = "held"'
                    if name == "motor"
                    else nearest(name[:60], known)
                )
                raise InputRefused(f'hold = "{name[:60]}" is no part of this drive that can be held{hint}')

    def carriage_name(self, number: int) -> str:
        """Name of a carriage, "carriage 0" where the file gives none."""
        return self.drive.carriage[number].name or f"carriage {number}"

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of the coordinates: "head.x", "motor a", "carriage 0 along", "rotor of motor a"."""
        drive = self.drive
        found = [
            f"{body.name}.{move}" for body in drive.body if body.name not in self.hold for move in body.moves
        ]
        found += [pulley.name for number, pulley in enumerate(drive.pulley) if self.turns(number)]
        for number, carriage in enumerate(drive.carriage):
            name = self.carriage_name(number)
            if name not in self.hold:
                found.append(f"{name} {ALONG}")
                found += [] if carriage.guided else [f"{name} {ACROSS}", f"{name} {OUT_OF_PLANE}"]
        if self.motor != HELD:
            found += [
                f"rotor of {drive.pulley[pulley].name}"
                for motor, pulley in zip(drive.motor, drive.driven, strict=True)
                if motor.joint_stiffness is not None
            ]
        return tuple(found)

    def turns(self, number: int) -> bool:
        """Whether a pulley turns: it is no guide, and neither held nor the rigid shaft of a held rotor."""
        pulley = self.drive.pulley[number]
        if pulley.fixed or pulley.name in self.hold:
            return False
        if self.motor != HELD:
            return True
        if not self.drive.motor:
            return number != 0
        rigid = (
            own
            for own, motor in zip(self.drive.driven, self.drive.motor, strict=True)
            if motor.joint_stiffness is None
        )
        return number not in rigid

    def unit(self, name: str) -> Row:
        """Row that picks one coordinate, empty where it is held."""
        return Row({self._index[name]: 1.0} if name in self._index else {})

    @cached_property
    def _index(self) -> dict[str, int]:
        return {name: number for number, name in enumerate(self.names)}

    def dense(self, *rows: Row | str) -> Array:
        """Rows, or those that pick coordinates by their names, as an array, shape (rows, n)."""
        return dense([self.unit(row) if isinstance(row, str) else row for row in rows], len(self.names))

    def point(self, at: Point, body: int | None) -> tuple[Row, Row]:
        """Motion of a point of a body along x and y [m]."""
        x, y = Row(), Row()
        for number in carried_by(self.drive, body):
            part = self.drive.body[number]
            for move in part.moves:
                step = self.unit(f"{part.name}.{move}")
                if part.pivot is not None:
                    x -= (at[1] - part.pivot[1]) * step
                    y += (at[0] - part.pivot[0]) * step
                elif move == "x":
                    x += step
                else:
                    y += step
        return x, y

    def rotation(self, body: int | None) -> Row:
        """Turn of a body [rad]."""
        row = Row()
        for number in carried_by(self.drive, body):
            part = self.drive.body[number]
            if "turn" in part.moves:
                row += self.unit(f"{part.name}.turn")
        return row

    def angle(self, pulley: int) -> Row:
        """Turn of a pulley [rad]; a guide and a held pulley turn with their body."""
        return self.unit(self.drive.pulley[pulley].name) if self.turns(pulley) else self.mount(pulley)

    def mount(self, pulley: int) -> Row:
        """Turn of what carries a pulley [rad]."""
        part = self.drive.pulley[pulley]
        return self.rotation(body_number(self.drive, part.on, part.name))

    def rotor(self, pulley: int) -> Row:
        """Turn of the rotor behind a flexible joint; of a held one that of the body it is mounted on."""
        name = f"rotor of {self.drive.pulley[pulley].name}"
        return self.unit(name) if name in self._index else self.mount(pulley)

    def body_of(self, place: Place) -> int | None:
        """Body that carries a place of a path."""
        if place.anchor is not None:
            part = self.drive.anchor[place.anchor]
            return body_number(self.drive, part.on, part.name)
        assert place.pulley is not None
        pulley = self.drive.pulley[place.pulley]
        return body_number(self.drive, pulley.on, pulley.name)

    def end_rows(self, place: Place, along: Point, across: Point) -> tuple[Row, Row]:
        """Rows u and w of a span's end, Eq. (N.2)."""
        x, y = self.point(place.centre, self.body_of(place))
        u, w = along[0] * x + along[1] * y, across[0] * x + across[1] * y
        return _clean(u + self.rim(place)), _clean(w)

    def rim(self, place: Place) -> Row:
        """Motion of the rope along itself by the rim of a pulley; none at an anchor."""
        return Row() if place.pulley is None else place.rim * self.angle(place.pulley)


def _clean(row: Row) -> Row:
    """A row without what round-off left of directions at right angles, whatever the unit of a column."""
    least = AT_REST * max([1.0, *map(abs, row.values())])
    return Row({number: own for number, own in row.items() if abs(own) > least})


def gravity(drive: Machine) -> Array:
    """Gravity in the plane of the machine, shape (2,) [m/s^2]."""
    slope = drive.layout.inclination
    return -drive.layout.gravity * np.array([np.sin(slope), np.cos(slope)])


def sections_of(drive: Machine, passing: Set[int]) -> list[list[int]]:
    """Numbers of the free spans of each section, in order; ``passing``: pulleys that pass a tension on."""
    found: list[list[int]] = []
    for route, data in enumerate(drive.route):
        own = [number for number, span in enumerate(drive.free_spans) if span.route == route]
        breaks = [i for i, number in enumerate(own) if drive.free_spans[number].start.pulley not in passing]
        if data.closed:
            first = breaks[0] if breaks else 0
            own, breaks = own[first:] + own[:first], [i - first for i in breaks] or [0]
        elif 0 not in breaks:
            breaks.insert(0, 0)
        found += [own[i:j] for i, j in zip(breaks, [*breaks[1:], len(own)], strict=True)]
    return found
