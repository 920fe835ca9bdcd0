"""One cable between two pulleys as a machine with routes, and found in one."""

from dataclasses import fields, replace
from math import atan2, hypot, pi, remainder
from typing import Any

from cabledrive.parameters.cable import RIGIDITY, Cable, Rope
from cabledrive.parameters.drive import SENSE, Drive
from cabledrive.parameters.drive_parts import Carriage, Layout, Motor, Pulley
from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.route.drive import Machine
from cabledrive.parameters.route.parts import Route, RoutedCarriage, RoutedMotor, RoutedPulley, RouteLayout

NAMES = ("drive pulley", "load pulley")
_UPRIGHT = 1e-9  # beyond the vertical, of what round-off makes lean [rad]
SAID = ("name", "title", "source", "sensors", "goal")  # alike in both files


def as_machine(drive: Drive, *, loaded: bool = False) -> Machine:
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
    machine = Machine(
        **{name: getattr(drive, name) for name in (*SAID, "kind", "excitation")},
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
        route=(Route(name="cable", path=tuple(f"-{name}" for name in NAMES), closed=drive.closed),),
        lumped=drive.lumped,
    )
    if not loaded:
        vars(machine)["two_pulleys"] = drive  # with the length that its file gives
    return machine


def two_pulleys_of(drive: Machine | Drive, what: str, *, chains: bool = False) -> Drive:
    """The cable between two pulleys of a machine; refused, with the reason, where ``what`` finds none.

    ``chains``: the lumped chain of an axis, which has two shafts and no spans, will do.
    """
    try:
        if isinstance(drive, Machine):
            return drive.two_pulleys or in_machine(drive)
        if chains or not drive.chain_of:
            return drive
        raise InputRefused(f"{drive.axis.load} is of a lumped chain: give its machine, or a lumped plant")
    except InputRefused as refusal:
        raise InputRefused(f"{what} takes one cable between two pulleys: {refusal}") from None


def in_machine(machine: Machine) -> Drive:
    """The drive with two pulleys that a machine with routes is, its angles counted as the rope runs.

    Its drive pulley is that of the motor or the stop. A machine that leads to the left is seen in a mirror,
    and a path whose cable would leave the drive pulley below on its way to the load is followed backwards.
    Refused, with the reason, if there is another part.
    """
    route, rope, layout, spans = machine.route[0], machine.ropes[0], machine.layout, machine.free_spans
    first = (*machine.held, *machine.turned, 0)[0]
    if (len(machine.route), len(route.path), len(machine.pulley)) != (1, 2, 2) or machine.body:
        rows = {"route": machine.route, "pulley": machine.pulley, "body": machine.body}
        counts = ", ".join(f"{len(own)} [[{name}]]" for name, own in rows.items())
        raise InputRefused(f"this machine has {counts}, its first path {len(route.path)} places")
    drive, load = parts = tuple(machine.pulley[number] for number in (first, 1 - first))
    rise = atan2(load.at[1] - drive.at[1], load.at[0] - drive.at[0])
    slope, senses = remainder(layout.inclination + rise, 2.0 * pi), {own.sense for own in machine.places[0]}
    mirrored = abs(slope) > pi / 2 + _UPRIGHT
    slope = remainder(pi - slope, 2.0 * pi) if mirrored else slope
    backwards = (1 in senses) != mirrored
    starts = [(span.end if backwards else span.start).pulley for span in spans]
    balanced = not layout.gravity or (route.closed and not machine.carriage)
    for unlike, said in (
        (len(senses) > 1 or 0 in senses, "its cable crosses over, or ends at an anchor"),
        (route.ropes > 1 or route.speed, "its cable runs, or is one of several"),
        (len(machine.motor) > 1, "it has two motors"),
        (rope.pretension is None, "its cable has no pretension"),
        (not (machine.held or drive.fixed or balanced), "nothing holds its pulleys at rest"),
        (layout.gravity and first not in starts, "its span leaves the drive pulley on the other side"),
    ):
        if unlike:
            raise InputRefused(said)
    motor, inertias = machine.motor[0] if machine.motor else None, [part.inertia for part in parts]
    if motor is not None and motor.joint_stiffness is None and not drive.inertia:  # one shaft, half to each
        motor = replace(motor, inertia=0.5 * motor.inertia)
        inertias[0] = motor.inertia
    sense = 1.0 if mirrored else SENSE
    wraps = {span.end.pulley: span.wrap for span in spans}
    cable = Cable(**_alike(Cable, rope))
    carriages = []
    for own, (number, along) in zip(machine.carriage, machine.carriage_places, strict=True):
        after = spans[number].length - along if backwards != (first not in starts) else along
        place = {"position": after / (1.0 + cable.prestrain), "span": "upper"}
        if route.closed and starts[number] != first:
            place["span"] = "lower"
        carriages.append(Carriage(**_alike(Carriage, own) | place))
    return Drive(
        kind="loop" if route.closed else "line",
        **{name: getattr(machine, name) for name in SAID},
        excitation=None if machine.excitation and machine.excitation.orders else machine.excitation,
        cable=cable,
        layout=Layout(
            pulley_distance=spans[0].length,
            gravity=layout.gravity,
            inclination=max(-pi / 2, min(pi / 2, slope)),
        ),
        pulley=tuple(
            Pulley(
                **_alike(Pulley, part)
                | {"inertia": inertia, "wrap_angle": part.wrap_angle if machine.called else wraps.get(number)}
            )
            for part, inertia, number in zip(parts, inertias, (first, 1 - first), strict=True)
        ),
        motor=motor and Motor(**_alike(Motor, motor) | {"offset_torque": sense * motor.offset_torque + 0.0}),
        carriage=tuple(carriages),
        called=() if machine.called else machine.spans if starts[0] == first else machine.spans[::-1],
        lumped=machine.lumped,
    )


def _alike(table: type[Any], part: Any) -> dict[str, Any]:
    """What a part says under the keys of the table of another form of file."""
    return {own.name: getattr(part, own.name) for own in fields(table) if hasattr(part, own.name)}
