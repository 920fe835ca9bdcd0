"""The quantities of a drive that a controller depends on, as numbers with bounds."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import inf, pi, radians
from typing import Any

from cabledrive.parameters import Drive, Lumped, Motor, Pulley
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
        """Bounds for a projection: twice the 95 % interval, about four standard deviations, or all of it.

        What cannot be negative stays above `POSITIVE` of its value: no plant is drawn below that either, so
        that every plant within twice its interval is within the bounds.
        """
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
    """A drive with other quantities; its `values_of` are these.

    The load pulley has the friction that is given for it, the drive pulley keeps its own, and the motor has
    the rest; where less is given than those take, all of it is theirs in the proportions that they have.
    """
    before = values_of(drive)
    given = before | dict(values)
    motor, first, second = drive.motor, drive.drive_pulley, drive.load_pulley
    lumped = Lumped(cable_stiffness=given["cable_stiffness"], cable_damping=given["cable_damping"])
    rubs: dict[str, Any] = {name: given[f"load_{name}"] for name in FRICTIONS}
    second = replace(second, **rubs)
    rubbing = values_of(replace(drive, pulley=(first, second)))
    shared = {name: _shared(motor or first, name, rubbing[name], given[name]) for name in FRICTIONS}
    moved: dict[str, Any] = {name: own for name, (own, _) in shared.items()}
    load = replace(second, inertia=given["load_inertia"], **_scaled(second, shared))
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
    near = replace(first, inertia=(1.0 - share) * given["near_inertia"], **_scaled(first, shared))
    return replace(drive, pulley=(near, load), motor=fresh, lumped=lumped)


def _shared(part: Motor | Pulley, name: str, before: float, total: float) -> tuple[float, float]:
    """Friction of the part that has the rest, and by what the friction of the others is multiplied."""
    own: float = getattr(part, name)
    rest = own + (total - before)
    if rest >= 0.0 or total < 0.0:  # a negative total is the drive's to refuse
        return rest, 1.0
    return 0.0, total / (before - own)


def _scaled(pulley: Pulley, shared: Mapping[str, tuple[float, float]]) -> dict[str, Any]:
    return {name: factor * getattr(pulley, name) for name, (_, factor) in shared.items()}


def mechanical(drive: Drive) -> Drive:
    """A drive without what its mechanics do not depend on: sensors, goals, limits and words."""
    motor = drive.motor
    if motor is not None:
        motor = replace(
            motor, torque_limit=None, speed_limit=None, torque_per_volt=None, current_bandwidth=None
        )
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
    """Every quantity with the uncertainty that datasheets are given.

    ``backlash``: largest backlash where the file says none [rad]; default: by the gear, see `backlash_limit`.
    What a data sheet leaves out counts as unknown and not as none: a delay may be a sample longer than the
    file says, and friction of the load pulley, backlash of the motor joint, torque ripple and eccentricity of
    the load encoder have an upper limit also where the file says zero or nothing.
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
