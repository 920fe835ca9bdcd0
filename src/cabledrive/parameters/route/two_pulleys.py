"""A loop round two pulleys as a machine with routes, and an axis of a route as such a loop."""

from dataclasses import dataclass, field
from typing import Any

from cabledrive.parameters.cable import Rope
from cabledrive.parameters.drive import Drive
from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.route.drive import Machine, RoutedDrive
from cabledrive.parameters.route.parts import (
    Route,
    RoutedCarriage,
    RoutedMotor,
    RoutedPulley,
    RouteLayout,
)

NAMES = ("drive pulley", "load pulley")
_ROPE = ("mass_per_length", "pretension", "transverse_damping", "axial_damping", "strength", "tooth_pitch")
_PULLEY = ("radius", "inertia", "viscous_friction", "coulomb_friction", "fixed", "capstan_friction")
_MOTOR = (
    "inertia",
    "joint_stiffness",
    "joint_damping",
    "viscous_friction",
    "coulomb_friction",
    "torque_limit",
    "speed_limit",
    "holding_stiffness",
)


def as_machine(drive: Machine, *, loaded: bool = False) -> RoutedDrive:
    """A drive with two pulleys as a machine with routes; its "upper" span leads from drive to load pulley.

    If ``loaded``, a second motor gives the torque on the load pulley; a fixed one is refused.
    """
    if isinstance(drive, RoutedDrive):
        return drive
    if loaded and drive.load_pulley.fixed:
        raise InputRefused("load torque: the load pulley is fixed and takes no torque: leave the column out")
    parts = (drive.drive_pulley, drive.load_pulley)
    turned = (drive.motor is not None or loaded, loaded)
    pulleys = tuple(
        RoutedPulley(
            name=name,
            at=(i * drive.pulley_distance, 0.0),
            **{key: getattr(part, key) for key in _PULLEY}
            | ({"inertia": 0.0} if turned[i] and (i == 1 or drive.motor is None) else {}),
        )
        for i, (name, part) in enumerate(zip(NAMES, parts, strict=True))
    )
    motors = []
    for name, part, turns in zip(NAMES, parts, turned, strict=True):
        if turns and name == NAMES[0] and drive.motor is not None:
            own = {key: getattr(drive.motor, key) for key in _MOTOR}
            motors.append(RoutedMotor(pulley=name, **own))
        elif turns:  # what gives its torque has the pulley's own inertia
            motors.append(RoutedMotor(pulley=name, inertia=part.inertia))
    rope = {key: getattr(drive.cable, key) for key in _ROPE}
    return RoutedDrive(
        name=drive.name,
        title=drive.title,
        cable=Rope(given_rigidity=drive.cable.axial_rigidity, **rope),
        layout=RouteLayout(gravity=drive.layout.gravity, inclination=drive.layout.inclination),
        pulley=pulleys,
        carriage=tuple(
            RoutedCarriage(
                name=own.name,
                mass=own.mass,
                guided=own.guided,
                position=own.position * (1.0 + drive.cable.prestrain)
                + (drive.pulley_distance if own.span == "lower" else 0.0),
            )
            for own in drive.carriage
        ),
        motor=tuple(motors),
        route=(Route(name="cable", path=tuple(f"-{name}" for name in NAMES), closed=drive.kind == "loop"),),
    )


@dataclass(frozen=True, kw_only=True)
class AxisDrive(Drive):
    """The chain that a motor of a machine with routes drives, for control: it has no spans of its own.

    Its cable has the chain's stiffness, no mass, and the pretension of a loop slack at the same torque.
    """

    machine: RoutedDrive  # where it comes from
    load: str  # coordinate that is the load
    gain: float  # its motion per motor angle [m/rad], [rad/rad]
    slides: bool  # whether the load slides: its "load angle" is then its place over the gain
    words: dict[str, Any] = field(compare=False)  # how the chain was found, for results


def require_own_spans(drive: object, what: str) -> None:
    """Refuse an axis of a machine with routes where the spans themselves are needed; ``what``: by whom."""
    if isinstance(drive, AxisDrive):
        said = f'kind = "route": {what} needs the spans, and the axis of {drive.load} is a lumped chain'
        raise InputRefused(f"{said}: take a lumped plant")
