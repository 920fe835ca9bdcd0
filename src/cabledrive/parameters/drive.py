"""The whole drive: cable, two pulleys, carriages, motor, sensors, put together and checked."""

import re
from dataclasses import dataclass, field
from functools import cached_property
from math import copysign
from typing import TYPE_CHECKING, Any

from cabledrive.parameters.cable import Cable
from cabledrive.parameters.drive_parts import Carriage, Layout, Lumped, Motor, Pulley
from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.fields import choice, described, meaning, nearest
from cabledrive.parameters.machine import MachineBase

if TYPE_CHECKING:
    from cabledrive.parameters.route.drive import Machine

PART_NAMES = ("drive pulley", "load pulley", "motor", "cable")
SENSE = -1.0
"""Turn of a pulley of a machine with routes per turn of that of a loop, which is counted as the rope runs."""


@dataclass(frozen=True, kw_only=True)
class Axis:
    """What a motor moves, and the machine with the spans that does it."""

    machine: "Machine"
    load: str = "load pulley"  # coordinate that is the load
    gain: float = 1.0  # its motion per motor angle [m/rad], [rad/rad]
    slides: bool = False  # whether the load slides: its "load angle" is then its place over the gain
    words: dict[str, Any] = field(compare=False)  # how a chain of routes was found, for results

    @property
    def per_angle(self) -> float:
        """Motion of the load per load angle [m/rad]; of one that turns the sense of the gain [-]."""
        return self.gain if self.slides else copysign(1.0, self.gain)


@described
@dataclass(frozen=True, kw_only=True, repr=False)
class Drive(MachineBase):
    """A machine driven by one cable between two pulleys, with the names of its file."""

    kind: str = choice(("loop", "line"), "cable loop round two pulleys, or one span with its ends on them")
    cable: Cable = meaning("rigidity, mass and pretension")
    layout: Layout = meaning("distance of the pulleys, gravity")
    pulley: tuple[Pulley, ...] = meaning("drive pulley, without the motor, and load pulley")
    carriage: tuple[Carriage, ...] = meaning("any number of carried masses", ())
    motor: Motor | None = meaning("on the drive pulley", None)
    lumped: Lumped | None = meaning("measured stiffness and damping", None)
    route = ()  # listed by other files
    # where it is the lumped chain of a machine with routes, for control: without spans of its own, its cable
    # has the chain's stiffness, no mass, and the pretension of a loop slack at the same torque
    chain_of: Axis | None = field(default=None, metadata={"file": False})
    # where it was found in a machine with routes: what that calls the spans
    called: tuple[str, ...] = field(default=(), compare=False, metadata={"file": False})

    def __post_init__(self) -> None:
        MachineBase.__post_init__(self)
        if len(self.pulley) != 2:
            raise InputRefused(
                f"pulley: {len(self.pulley)} given, but a drive has 2: the drive pulley, then the load pulley"
            )
        if self.motor is not None and self.drive_pulley.fixed:
            raise InputRefused(
                "pulley.0.fixed = true, but [motor] drives that pulley: leave one of the two out"
            )
        seen: dict[Any, int] = {}
        for number, carriage in enumerate(self.carriage):
            _check_carriage(self, number, carriage, seen)
        for number, carriage in enumerate(self.carriage):
            _check_coupling(self, number, carriage)
        if self.excitation is not None and self.excitation.orders:
            raise InputRefused(
                'excitation.orders are for kind = "route": leave them out, and name them with `map --order`'
            )

    @property
    def plant(self) -> "Drive":
        """Itself, which control takes as it stands."""
        return self

    listed = plant  # by a file

    @property
    def axis(self) -> Axis:
        """The axis that its motor moves: of a machine with routes, or its own load pulley."""
        return self.chain_of or Axis(
            machine=self.machine, gain=SENSE, words={"motors": {"drive pulley": SENSE}}
        )

    @cached_property
    def machine(self) -> "Machine":
        """It as a machine with routes; where it is a lumped chain, the machine that has it."""
        from cabledrive.parameters.route.two_pulleys import as_machine

        return self.chain_of.machine if self.chain_of else as_machine(self)

    @property
    def closed(self) -> bool:
        """Whether the cable leads back from the load pulley, as a loop of two spans."""
        return self.kind == "loop"

    @cached_property
    def span_length(self) -> float:
        """Unstretched length L of one span [m]."""
        if self.layout.span_length is not None:
            return self.layout.span_length
        assert self.layout.pulley_distance is not None
        return self.layout.pulley_distance / (1.0 + self.cable.prestrain)

    @cached_property
    def pulley_distance(self) -> float:
        """Length Le = L (1 + eps0) of one span under pretension [m]."""
        if self.layout.pulley_distance is not None:
            return self.layout.pulley_distance
        return self.span_length * (1.0 + self.cable.prestrain)

    @property
    def drive_pulley(self) -> Pulley:
        """The pulley on the motor's side."""
        return self.pulley[0]

    @property
    def load_pulley(self) -> Pulley:
        """The pulley at the load."""
        return self.pulley[1]

    @property
    def spans(self) -> tuple[str, ...]:
        """Names of the spans: upper and lower of a loop, upper of a line."""
        return ("upper", "lower") if self.closed else ("upper",)

    def carriages_on(self, span: str) -> tuple[Carriage, ...]:
        """Carriages of one span, in order from the pulley where it starts.

        Parameters
        ----------
        span : {"upper", "lower"}
            The span; the upper one starts at the drive pulley, the lower one at the load pulley.

        Returns
        -------
        tuple of Carriage
            Ordered by position.
        """
        return tuple(sorted((c for c in self.carriage if c.span == span), key=lambda c: c.position))


def carriage_number(drive: Drive, name: str) -> int | None:
    """Number of a carriage in the file by its name, or by "carriage 0"; None if there is none."""
    known = {f"carriage {number}": number for number in range(len(drive.carriage))}
    known |= {carriage.name: number for number, carriage in enumerate(drive.carriage) if carriage.name}
    return known.get(name)


def moving_with(drive: Drive, number: int) -> dict[int, int]:
    """Carriages that move with one, itself included: by number 1 where both positions grow, else -1."""
    links = [
        (own, carriage_number(drive, carriage.coupled), carriage.direction)
        for own, carriage in enumerate(drive.carriage)
        if carriage.coupled
    ]
    found, grown = {number: 1}, True
    while grown:
        grown = False
        for own, other, direction in links:
            for here, there in ((own, other), (other, own)):
                if here in found and there is not None and there not in found:
                    found[there], grown = direction * found[here], True
    return found


def _check_carriage(drive: Drive, number: int, carriage: Carriage, seen: dict[Any, int]) -> None:
    """Its place lies inside a span; place and name are its own, which ``seen`` keeps."""
    place = f"carriage.{number}.position = {carriage.position:.9g} m"
    if carriage.span not in drive.spans:
        raise InputRefused(f'carriage.{number}.span = "lower", but a "line" has no lower span: write "upper"')
    if not 0.0 < carriage.position < drive.span_length:
        raise InputRefused(
            f"{place} lies outside its span of {drive.span_length:.9g} m (unstretched): move it inside"
        )
    other = seen.setdefault((carriage.span, carriage.position), number)
    if other != number:
        raise InputRefused(
            f"{place} is taken by carriage.{other} on the same span: add the masses or move one"
        )
    name = f'carriage.{number}.name = "{carriage.name[:60]}"'
    if carriage.name in PART_NAMES or re.fullmatch(r"carriage \d+", carriage.name):
        raise InputRefused(f"{name} is the name of another part: choose another")
    other = seen.setdefault(carriage.name, number) if carriage.name else number
    if other != number:
        raise InputRefused(f"{name} is taken by carriage.{other}: choose another")


def _check_coupling(drive: Drive, number: int, carriage: Carriage) -> None:
    """It is coupled to one that is there, and round a ring of couplings the directions agree."""
    if not carriage.coupled:
        if carriage.direction != 1:
            said = f"carriage.{number}.direction = {carriage.direction} needs carriage.{number}.coupled"
            raise InputRefused(f"{said}, the carriage that it moves with: add it, or leave direction out")
        return
    place = f'carriage.{number}.coupled = "{carriage.coupled[:60]}"'
    other = carriage_number(drive, carriage.coupled)
    if other is None:
        names = [own.name or f"carriage {n}" for n, own in enumerate(drive.carriage) if n != number]
        raise InputRefused(f"{place} is no carriage of this drive{nearest(carriage.coupled[:60], names)}")
    if other == number:
        raise InputRefused(f"{place} is the carriage itself: name the one that it moves with")
    if moving_with(drive, number)[other] != carriage.direction:
        raise InputRefused(f"{place} contradicts another coupling: check the directions")
