"""Which carriages the scheduled law covers, and the numbers that such a machine depends on."""

from collections.abc import Mapping
from dataclasses import replace
from math import pi

from cabledrive.control.transporter import ENCODERS
from cabledrive.parameters import Drive
from cabledrive.reduction.transporter import (
    SWING_RATIO,
    Transporter,
    compliance,
    frozen_frequencies,
    transporter_of,
)
from cabledrive.rig.setting import DEGREE
from cabledrive.studies.study.goals import Goals
from cabledrive.studies.study.knowledge_stage import Knowledge, with_load
from cabledrive.studies.study.machine import (
    DATASHEET,
    GOAL,
    GUESS,
    KINDS,
    Quantity,
    by_datasheet,
    known,
    values_of,
)

SHARED = (
    *("near_inertia", "load_inertia", "viscous_friction", "coulomb_friction", "offset_torque"),
    *("cable_stiffness", "cable_damping"),
)
UNUSED = "the regression models have no carriage: the logs were not used, all values are from the data sheet"
RAIL = 0.5
"""Default friction of a carriage on its guide [N s/m]: an estimate, sampled from 0 to twice as much."""
STIFF_JOINT = 10.0
"""Stiffness of a motor joint that is taken as rigid, over the cable's between motor and carriage."""
LATE = 0.05
"""Largest delay with the torque loop's lag, over the shortest period of the carriage on its cable."""
MARGIN = 0.02
"""Nearest to a pulley that the carriage may come, over the span's length."""
ORDER = 13
"""Lowest order of the rise: six derivatives enter the feedforward."""
GRAIN, GRAIN_RATIO, GRAVITY = 1e-6, 0.5, 9.81
"""Where nothing hangs: a grain, over the carriage's mass, its damping ratio, and the gravity it needs."""


def missing_for_carriage(drive: Drive) -> tuple[str, ...]:
    """What the scheduled law of one carriage lacks on a drive, each with what would be needed."""
    found, sensors = _other_machine(drive), drive.sensors
    if drive.motor is None:
        found.append("motor is missing, but the carriage has to be moved: add motor.inertia")
    if sensors is None or sensors.sample_rate is None:
        found.append('sensors.sample_rate is missing: give it, such as "5 kHz"')
    if sensors is None or (sensors.motor_encoder is None and sensors.drive_encoder is None):
        found.append("neither sensors.motor_encoder nor sensors.drive_encoder is given: fit one")
    return tuple(found) or _too_soft_or_late(drive)


def _other_machine(drive: Drive) -> list[str]:
    found, first = [], drive.carriage[0]
    if drive.kind != "loop" or any(pulley.fixed for pulley in drive.pulley):
        machine = "an open line" if drive.kind != "loop" else "a loop with a fixed pulley"
        found.append(
            f"carriage control needs a closed loop with two rotating pulleys; this drive is {machine}"
        )
    if len(drive.carriage) > 1:
        found.append(f"carriage control supports one carriage; this drive has {len(drive.carriage)}")
    elif first.span != "upper" or not first.guided:
        found.append(
            'carriage control needs a guided carriage on the upper span: set guided = true and span = "upper"'
        )
    if drive.layout.gravity <= 0.0:
        found.append("layout.gravity = 0, but a hanging mass needs it: give its value")
    if drive.layout.inclination != 0.0:
        found.append(
            f"layout.inclination = {drive.layout.inclination / DEGREE:.4g} deg, but carriage control needs "
            "a level span"
        )
    return found


def _too_soft_or_late(drive: Drive) -> tuple[str, ...]:
    found = []
    assert drive.motor is not None
    assert drive.sensors is not None
    machine = transporter_with(drive, carriage_values(drive, Goals()))
    if drive.motor.joint_stiffness is not None:
        joint = drive.motor.joint_stiffness / machine.radius**2
        cable = 1.0 / float(compliance(machine, machine.start)[0])  # type: ignore[arg-type]
        if joint < STIFF_JOINT * cable:
            found.append(
                f"motor.joint_stiffness is {joint / cable:.3g} times the cable's between motor and "
                f"carriage; carriage control takes the joint as rigid and needs at least {STIFF_JOINT:g} "
                "times"
            )
    loop = drive.motor.current_bandwidth
    lag = drive.sensors.delay + (0.0 if loop is None else 1.0 / (2.0 * pi * loop))
    frequency = cable_frequency(machine, machine.start)
    if lag * frequency > LATE:
        found.append(
            f"delay and torque loop add a lag of {1e3 * lag:.3g} ms, more than a twentieth of a period of "
            f"the carriage on its cable ({frequency:.3g} Hz), and the runs contain no delay: lower "
            "sensors.delay"
        )
    return tuple(found)


def cable_frequency(transporter: Transporter, position: float) -> float:
    """Frequency of the carriage on the cable, without what hangs below it [Hz]; ``position`` [m]."""
    bare = replace(transporter, payload_mass=GRAIN * transporter.carriage_mass, line_length=1e6)
    return float(frozen_frequencies(bare, position)[1]) / (2.0 * pi)


def carriage_values(drive: Drive, goals: Goals) -> dict[str, float]:
    """The numbers of a machine with a carriage, as file and goals give them."""
    known = values_of(drive)
    values = {name: known[name] for name in SHARED} | {"carriage_mass": drive.carriage[0].mass}
    values["rail_friction"] = RAIL if goals.rail_friction is None else goals.rail_friction
    if goals.hanging_mass is not None and goals.line_length is not None:
        values |= {"hanging_mass": goals.hanging_mass, "line_length": goals.line_length}
    return values


def carriage_quantities(drive: Drive, goals: Goals) -> dict[str, Quantity]:
    """The same with their bounds; an estimate may be nothing, or twice as much."""
    sheet, found = by_datasheet(drive, goals.spreads), {}
    for name, value in carriage_values(drive, goals).items():
        if name in sheet:
            found[name] = sheet[name]
            continue
        guessed = name == "rail_friction" and goals.rail_friction is None
        half = value if guessed else goals.spreads[KINDS[name]] * value
        source = GUESS if guessed else DATASHEET if name == "carriage_mass" else GOAL
        found[name] = known(name, value, value - half, value + half, source)
    return found


def know_carriage(drive: Drive, goals: Goals, spreads: Mapping[str, float], *, logged: bool) -> Knowledge:
    """What is known of a drive with a carriage: the data sheet, the goals and estimates."""
    known = carriage_quantities(drive, replace(goals, spreads=spreads))
    found = Knowledge(quantities=known, undetermined=(UNUSED,) if logged else ())
    return found if goals.load_inertia is None else with_load(found, goals.load_inertia)


def transporter_with(drive: Drive, values: Mapping[str, float]) -> Transporter:
    """The transporter of a drive with these numbers; where nothing hangs, a grain stands in for it."""
    assert drive.sensors is not None
    assert drive.sensors.sample_rate is not None
    hanging = "hanging_mass" in values
    r, gravity = drive.drive_pulley.radius, drive.layout.gravity if hanging else GRAVITY
    base = transporter_of(
        drive,
        payload_mass=values["hanging_mass"] if hanging else GRAIN * drive.carriage[0].mass,
        line_length=values["line_length"] if hanging else gravity / drive.sensors.sample_rate**2,
        rail_friction=values["rail_friction"],
    )
    damping = 2.0 * (SWING_RATIO if hanging else GRAIN_RATIO) * (base.line_length / gravity) ** 0.5
    return replace(
        base,
        axial_rigidity=values["cable_stiffness"] * drive.span_length,
        damping_time=values["cable_damping"] / r / values["cable_stiffness"],
        drive_mass=values["near_inertia"] / r**2,
        load_mass=values["load_inertia"] / drive.load_pulley.radius**2,
        carriage_mass=values["carriage_mass"],
        gravity=gravity,
        swing_damping=damping,
        viscous=values["viscous_friction"] / r**2,
        coulomb=values["coulomb_friction"] / r,
        offset=values["offset_torque"] / r,
    )


def encoders_read(drive: Drive) -> tuple[float, tuple[int, ...]]:
    """One count at the rim [m], and the pulleys whose encoders, both of one count, the law listens to."""
    sensors, (first, second) = drive.sensors, drive.pulley
    assert sensors is not None
    own = sensors.drive_encoder or sensors.motor_encoder
    assert own is not None
    count = 2.0 * pi * first.radius / own
    other = 2.0 * pi * second.radius / sensors.load_encoder if sensors.load_encoder else None
    alike = other is not None and abs(other / count - 1.0) < 1e-9
    return count, ENCODERS if alike else ENCODERS[:1]
