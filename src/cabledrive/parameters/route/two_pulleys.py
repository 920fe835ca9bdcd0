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
ANGLES = ("drive_angle", "load_angle", "motor_angle")


def as_machine(drive: Drive, *, loaded: bool = False) -> RoutedDrive:
    """A drive with two pulleys as a machine with routes; its "upper" span leads from drive to load pulley.

    If ``loaded``, a second motor gives the torque on the load pulley; a fixed one is refused.
    """
    if loaded and drive.load_pulley.fixed:
        raise InputRefused("load torque: the load pulley is fixed and takes no torque: leave the column out")
    parts = (drive.drive_pulley, drive.load_pulley)
    motor = drive.motor
    driven = (motor is not None or loaded, loaded)
    apart = hypot(
        drive.pulley_distance, parts[1].radius - parts[0].radius
    )  # as long as they are, spans touch
    pulleys = tuple(
        RoutedPulley(
            name=name,
            at=(i * apart, 0.0),
            **_alike(RoutedPulley, part)
            | ({"inertia": 0.0} if driven[i] and (i == 1 or motor is None) else {}),
        )
        for i, (name, part) in enumerate(zip(NAMES, parts, strict=True))
    )
    motors = []
    for name, part, turns in zip(NAMES, parts, driven, strict=True):
        if turns and name == NAMES[0] and motor is not None:
            sensed = {"offset_torque": SENSE * motor.offset_torque + 0.0}
            motors.append(RoutedMotor(pulley=name, **_alike(RoutedMotor, motor) | sensed))
        elif turns:  # what gives its torque has the pulley's own inertia
            motors.append(RoutedMotor(pulley=name, inertia=part.inertia))
    beyond = {"upper": 0.0, "lower": drive.pulley_distance}
    rigidity = dict.fromkeys(RIGIDITY) | {"given_rigidity": drive.cable.axial_rigidity}
    rotor = NAMES[0] if motor is None or motor.joint_stiffness is None else f"rotor of {NAMES[0]}"
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
        stops=() if driven[0] or drive.drive_pulley.fixed else (0,),
        called=drive.spans,
        angles=tuple(zip(ANGLES, (*NAMES, rotor), strict=True)),
        route=(Route(name="cable", path=tuple(f"-{name}" for name in NAMES), closed=drive.closed),),
    )


def _alike(table: type[Any], part: Any) -> dict[str, Any]:
    """What a part of a loop says under the keys of a table of a machine with routes."""
    return {own.name: getattr(part, own.name) for own in fields(table) if hasattr(part, own.name)}


def require_two_pulleys(drive: Machine, what: str, *, chains: bool = False) -> Drive:
    """The drive; refused if it has not the spans of two pulleys that ``what`` needs, or its shafts alone.

    ``chains``: the lumped chain of an axis, which has two shafts and no spans, will do.
    """
    said = f'kind = "route": {what} takes one cable between two pulleys, kind "loop" or "line" only'
    if isinstance(drive, Drive):
        if chains or drive.two_pulleys:
            return drive
        said += f", the axis of {drive.axis.load} is a lumped chain: give its machine, or take a lumped plant"
    raise InputRefused(said)
