"""The quantities of a drive that a controller depends on, as numbers with bounds."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import inf, pi, radians
from typing import Any

from cabledrive.parameters import Drive, Lumped, Pulley
from cabledrive.reduction.lumped_chain import rim_spring
from cabledrive.studies.study.goals import SPREADS

POSITIVE = 1e-3
"""Smallest share of its best value that a quantity can have."""
SIGNED = ("offset_torque",)
LOG, DATASHEET, GOAL, GUESS = "log", "datasheet", "goal", "guess"
_TABLE = {
    "near_inertia": ("kg m^2", "inertia of motor and drive pulley", "inertia"),
    "motor_share": ("1", "motor's share of it", "inertia"),
    "load_inertia": ("kg m^2", "inertia of the load pulley", "inertia"),
    "viscous_friction": ("N m s/rad", "viscous friction", "friction"),
    "coulomb_friction": ("N m", "Coulomb friction", "friction"),
    "offset_torque": ("N m", "offset torque", "friction"),
    "cable_stiffness": ("N/m", "stiffness of a span", "stiffness"),
    "cable_damping": ("N s/rad", "damping of a span", "damping"),
    "joint_stiffness": ("N m/rad", "stiffness of the motor joint", "stiffness"),
    "joint_damping": ("N m s/rad", "damping of the motor joint", "damping"),
    "load_viscous_friction": ("N m s/rad", "viscous friction of the load pulley", "friction"),
    "load_coulomb_friction": ("N m", "Coulomb friction of the load pulley", "friction"),
    "backlash": ("rad", "backlash of the motor joint", "friction"),
    "delay": ("s", "delay from sampling to torque", ""),
    "ripple_torque": ("N m", "torque ripple and cogging of the motor", ""),
    "ripple_order": ("1/rad", "periods of the ripple per radian", ""),
    "ripple_phase": ("rad", "phase of the ripple", ""),
    "eccentricity": ("rad", "eccentricity of the load encoder", ""),
    "creep": ("1/(N m)", "creep of the rope on its pulley", ""),
    "slip_torque": ("N m", "torque at which the rope slides on its pulley", ""),
    "carriage_mass": ("kg", "mass of the carriage", "inertia"),
    "rail_friction": ("N s/m", "friction of the carriage on its guide", "friction"),
    "hanging_mass": ("kg", "hanging mass", "inertia"),
    "line_length": ("m", "length of its line", "inertia"),
}
"""Of each quantity its SI unit, its name in words, and the spread of `SPREADS` of its data-sheet value."""
UNITS, WORDS, KINDS = ({name: row[k] for name, row in _TABLE.items()} for k in range(3))


FRICTIONS = ("viscous_friction", "coulomb_friction")
LOAD_FRICTIONS = {"load_viscous_friction": "viscous_friction", "load_coulomb_friction": "coulomb_friction"}
"""Friction of the load pulley, at the load, and the friction of the whole drive of which it is a part."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Quantity:
    """One number that is known within bounds."""

    name: str  # one of `UNITS`
    value: float
    # low, high: from a log: the 95 % interval, with what the choice of filter moves. Else: all that is
    # thought possible
    low: float
    high: float
    unit: str
    source: str  # {"log", "datasheet", "goal", "guess"}

    @property
    def half_width(self) -> float:
        """Half of the interval."""
        return 0.5 * (self.high - self.low)

    @property
    def outer(self) -> tuple[float, float]:
        """Twice the 95 % interval, above `POSITIVE` of its value where not to be negative, or all of it."""
        if self.source != LOG:
            return self.low, self.high
        low, high = 2.0 * self.low - self.value, 2.0 * self.high - self.value
        return max(low, self.least), high

    @property
    def least(self) -> float:
        """Smallest value that a drive can have: none for a torque, which may push either way."""
        return -inf if self.name in SIGNED else POSITIVE * abs(self.value)


def known(name: str, value: float, low: float, high: float, source: str = DATASHEET) -> Quantity:
    """A quantity of `UNITS` with its bounds."""
    return Quantity(name=name, value=value, low=low, high=high, unit=UNITS[name], source=source)


def has_flexible_joint(drive: Drive) -> bool:
    """Whether a spring joins the motor to the drive pulley."""
    return drive.motor is not None and drive.motor.joint_stiffness is not None


def values_of(drive: Drive) -> dict[str, float]:
    """The quantities as a drive file gives them."""
    motor, first, second = drive.motor, drive.drive_pulley, drive.load_pulley
    stiffness, damping = (value / len(drive.spans) for value in rim_spring(drive))
    own = motor.inertia if motor else 0.0
    ratio = first.radius / second.radius
    loads = second.viscous_friction * ratio**2, second.coulomb_friction * ratio
    found = {
        "near_inertia": own + first.inertia,
        "load_inertia": second.inertia,
        "viscous_friction": first.viscous_friction + (motor.viscous_friction if motor else 0.0) + loads[0],
        "coulomb_friction": first.coulomb_friction + (motor.coulomb_friction if motor else 0.0) + loads[1],
        "offset_torque": motor.offset_torque if motor else 0.0,
        "cable_stiffness": stiffness,
        "cable_damping": damping * first.radius,
        "load_viscous_friction": second.viscous_friction,
        "load_coulomb_friction": second.coulomb_friction,
    }
    if motor is not None and motor.joint_stiffness is not None:
        found["motor_share"] = own / found["near_inertia"]
        found["joint_stiffness"] = motor.joint_stiffness
        found["joint_damping"] = motor.joint_damping
        found["backlash"] = motor.backlash
    return found


def drive_with(drive: Drive, values: Mapping[str, float]) -> Drive:
    """A drive with other quantities; pulleys keep their friction where the whole allows it."""
    before = values_of(drive)
    given = before | dict(values)
    motor, first, second = drive.motor, drive.drive_pulley, drive.load_pulley
    lumped = Lumped(cable_stiffness=given["cable_stiffness"], cable_damping=given["cable_damping"])
    rubs: dict[str, Any] = {name: given[f"load_{name}"] for name in FRICTIONS}
    second = replace(second, **rubs)
    rubbing = values_of(replace(drive, pulley=(first, second)))
    moved: dict[str, Any] = {}
    factors = dict.fromkeys(FRICTIONS, 1.0)  # by which the friction of the others is multiplied
    for name in FRICTIONS:
        own, total = getattr(motor or first, name), given[name]
        moved[name] = own + (total - rubbing[name])
        if moved[name] < 0.0 <= total:  # a negative total is the drive's to refuse
            moved[name], factors[name] = 0.0, total / (rubbing[name] - own)

    def scaled(pulley: Pulley, inertia: float) -> Pulley:
        frictions: dict[str, Any] = {name: factor * getattr(pulley, name) for name, factor in factors.items()}
        return replace(pulley, inertia=inertia, **frictions)

    load = scaled(second, given["load_inertia"])
    if motor is None:
        near = replace(first, inertia=given["near_inertia"], **moved)
        return replace(drive, pulley=(near, load), lumped=lumped)
    share = given.get("motor_share", before["near_inertia"] and motor.inertia / before["near_inertia"])
    fresh = replace(
        motor, inertia=share * given["near_inertia"], offset_torque=given["offset_torque"], **moved
    )
    if has_flexible_joint(drive):
        joint = {name: given[name] for name in ("joint_stiffness", "joint_damping", "backlash")}
        fresh = replace(fresh, **joint)
    near = scaled(first, (1.0 - share) * given["near_inertia"])
    return replace(drive, pulley=(near, load), motor=fresh, lumped=lumped)


def mechanical(drive: Drive) -> Drive:
    """A drive without what its mechanics do not depend on: sensors, goals, limits and words."""
    names = ("torque_limit", "speed_limit", "torque_per_volt", "current_bandwidth")
    limits: dict[str, Any] = dict.fromkeys(names)
    motor = drive.motor and replace(drive.motor, **limits)
    return replace(drive, sensors=None, goal=None, motor=motor, name="", title="", source="")


RIPPLE_SHARE, RIPPLE_FRICTION = 0.01, 0.1
"""Largest ripple and cogging, over the torque limit and over the friction, whichever is more."""
ECCENTRIC_COUNTS = 1.0
"""Largest eccentricity of the load encoder, in counts."""
GEAR_BACKLASH, COUPLING_BACKLASH = radians(1.0), radians(0.1)
"""Largest backlash that is drawn where the data sheet says none: small planetary gears have 0.5 to 1 deg at
their output without load, a coupling or a bare shaft next to nothing [rad]."""


def backlash_limit(drive: Drive) -> float:
    """Largest backlash of the motor joint that a data sheet without backlash may hide [rad]."""
    geared = drive.motor is not None and drive.motor.gear_ratio not in (None, 1.0)
    return GEAR_BACKLASH if geared else COUPLING_BACKLASH


def by_datasheet(
    drive: Drive, spreads: Mapping[str, float], backlash: float | None = None
) -> dict[str, Quantity]:
    """Every quantity with the uncertainty of data sheets; ``backlash``: largest where none is said [rad].

    What a data sheet leaves out counts as unknown: delay, friction of the load pulley, backlash, torque
    ripple and eccentricity have an upper limit also where the file says zero or nothing.
    """
    values, spreads = values_of(drive), SPREADS | dict(spreads)
    gear = drive.load_pulley.radius / drive.drive_pulley.radius
    hidden = {name: spreads["load_friction"] * abs(values[whole]) for name, whole in LOAD_FRICTIONS.items()}
    hidden["load_viscous_friction"] *= gear**2
    hidden["load_coulomb_friction"] *= gear
    hidden["backlash"] = backlash_limit(drive) if backlash is None else backlash
    found = {}
    for name, value in values.items():
        half = spreads[KINDS[name]] * abs(value)
        if name == "offset_torque":
            half = max(half, spreads["friction"] * values["coulomb_friction"])
        low, high = value - half, value + half
        if name in LOAD_FRICTIONS or (name == "backlash" and value == 0.0):
            high = max(high, value + hidden[name])
        elif name == "motor_share":
            high = min(high, 0.999)
        found[name] = known(name, value, low, high)
    if drive.sensors is not None and drive.sensors.sample_rate is not None:
        late, interval = drive.sensors.delay, 1.0 / drive.sensors.sample_rate
        found["delay"] = known("delay", late, late, late + interval)
    motor, sensors = drive.motor, drive.sensors  # no drive file has ripple and eccentricity
    limit = motor.torque_limit if motor is not None and motor.torque_limit else 0.0
    count = 2.0 * pi / sensors.load_encoder if sensors is not None and sensors.load_encoder else 0.0
    ripple = max(RIPPLE_SHARE * limit, RIPPLE_FRICTION * values["coulomb_friction"])
    found["ripple_torque"] = known("ripple_torque", 0.0, 0.0, ripple)
    found["eccentricity"] = known("eccentricity", 0.0, 0.0, ECCENTRIC_COUNTS * count)
    return found


@dataclass(frozen=True, slots=True, kw_only=True)
class Demand:
    """One thing that is asked, and what there is."""

    name: str  # {"torque", "speed", "slack_torque"}
    asked: float  # largest along the motion
    limit: float | None  # None: no limit is known
    unit: str

    @property
    def met(self) -> bool:
        """Whether the limit is kept."""
        return self.limit is None or self.asked <= self.limit


@dataclass(frozen=True, slots=True, kw_only=True)
class DemandResult:
    """Everything that the motion asks for."""

    demands: tuple[Demand, ...]
    # shortest duration of this move within the limits, by an upper bound of the demand [s]
    shortest: float | None
    binding: str  # the limit that decides it, or why there is none

    @property
    def exceeded(self) -> tuple[Demand, ...]:
        """What is asked beyond its limit."""
        return tuple(demand for demand in self.demands if not demand.met)
