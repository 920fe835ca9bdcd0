"""A loop round two pulleys as a machine with routes."""

from dataclasses import fields
from math import hypot
from typing import Any

from cabledrive.parameters.cable import RIGIDITY, Rope
from cabledrive.parameters.drive import SENSE, Drive
from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.route.drive import Machine, RoutedDrive
from cabledrive.parameters.route.parts import Route, RoutedCarriage, RoutedMotor, RoutedPulley, RouteLayout

NAMES = ("drive pulley", "load pulley")


def as_machine(drive: Machine, *, loaded: bool = False, turned: bool = False) -> RoutedDrive:
    """A drive with two pulleys as a machine with routes; its "upper" span leads from drive to load pulley.

    Of the lumped chain of an axis the machine that has it.
    If ``loaded``, a second motor gives the torque on the load pulley; a fixed one is refused. If ``turned``,
    a motor holds the drive pulley against weights at rest, where the file has none.
    """
    if isinstance(drive, RoutedDrive):
        return drive
    if drive.chain_of is not None:
        return as_machine(drive.chain_of.machine)
    if loaded and drive.load_pulley.fixed:
        raise InputRefused("load torque: the load pulley is fixed and takes no torque: leave the column out")
    parts = (drive.drive_pulley, drive.load_pulley)
    held = drive.motor is not None or loaded or (turned and not drive.drive_pulley.fixed)
    driven = (held, loaded)
    apart = hypot(
        drive.pulley_distance, parts[1].radius - parts[0].radius
    )  # as long as they are, spans touch
    pulleys = tuple(
        RoutedPulley(
            name=name,
            at=(i * apart, 0.0),
            **_alike(RoutedPulley, part)
            | ({"inertia": 0.0} if driven[i] and (i == 1 or drive.motor is None) else {}),
        )
        for i, (name, part) in enumerate(zip(NAMES, parts, strict=True))
    )
    motors = []
    for name, part, turns in zip(NAMES, parts, driven, strict=True):
        if turns and name == NAMES[0] and drive.motor is not None:
            sensed = {"offset_torque": SENSE * drive.motor.offset_torque + 0.0}
            motors.append(RoutedMotor(pulley=name, **_alike(RoutedMotor, drive.motor) | sensed))
        elif turns:  # what gives its torque has the pulley's own inertia
            motors.append(RoutedMotor(pulley=name, inertia=part.inertia))
    beyond = {"upper": 0.0, "lower": drive.pulley_distance}
    rigidity = dict.fromkeys(RIGIDITY) | {"given_rigidity": drive.cable.axial_rigidity}
    return RoutedDrive(
        name=drive.name,
        title=drive.title,
        cable=Rope(**_alike(Rope, drive.cable) | rigidity),
        layout=RouteLayout(**_alike(RouteLayout, drive.layout)),
        pulley=pulleys,
        carriage=tuple(
            RoutedCarriage(
                **_alike(RoutedCarriage, own)
                | {"position": own.position * (1.0 + drive.cable.prestrain) + beyond[own.span]}
            )
            for own in drive.carriage
        ),
        motor=tuple(motors),
        loads=(1,) if loaded else (),
        route=(Route(name="cable", path=tuple(f"-{name}" for name in NAMES), closed=drive.kind == "loop"),),
    )


def _alike(table: type[Any], part: Any) -> dict[str, Any]:
    """What a part of a loop says under the keys of a table of a machine with routes."""
    return {own.name: getattr(part, own.name) for own in fields(table) if hasattr(part, own.name)}


def two_pulleys(drive: Machine) -> Drive | None:
    """The machine where one cable between two pulleys is all of it, which has formulas; None of any other."""
    return None if isinstance(drive, RoutedDrive) or drive.chain_of else drive


def require_two_pulleys(drive: Machine, what: str, *, chains: bool = False) -> Drive:
    """The drive; refused if it has not the spans of two pulleys that ``what`` needs, or its shafts alone.

    ``chains``: the lumped chain of an axis, which has two shafts and no spans, will do.
    """
    found, chain = two_pulleys(drive), None if isinstance(drive, RoutedDrive) else drive.chain_of
    if chains and not isinstance(drive, RoutedDrive):
        return drive
    if found is None:
        said = f'kind = "route": {what} takes one cable between two pulleys, kind "loop" or "line" only'
        if chain is not None:
            said += f", the axis of {chain.load} is a lumped chain: give its machine, or take a lumped plant"
        raise InputRefused(said)
    return found
