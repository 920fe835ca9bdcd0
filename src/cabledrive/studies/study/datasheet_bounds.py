"""What a data sheet says of a drive as numbers with bounds, and limits of what it leaves out."""

from collections.abc import Mapping
from math import pi, radians

from cabledrive.parameters import Drive
from cabledrive.studies.study.goals import SPREADS
from cabledrive.studies.study.machine import DATASHEET, KINDS, LOAD_FRICTIONS, UNITS, Quantity, values_of

RIPPLE_SHARE, RIPPLE_FRICTION = 0.01, 0.1
"""Largest ripple and cogging, over the torque limit and over the friction, whichever is more."""
ECCENTRIC_COUNTS = 1.0
"""Largest eccentricity of the load encoder, in counts."""
GEAR_BACKLASH, COUPLING_BACKLASH = radians(1.0), radians(0.1)
"""Largest backlash that is drawn where the data sheet says none: small planetary gears have 0.5 to 1 deg at
their output without load, a coupling or a bare shaft next to nothing [rad]."""


def backlash_limit(drive: Drive) -> float:
    """Largest backlash of the motor joint that a data sheet without backlash may hide.

    Returns [rad].
    """
    geared = drive.motor is not None and drive.motor.gear_ratio not in (None, 1.0)
    return GEAR_BACKLASH if geared else COUPLING_BACKLASH


def by_datasheet(
    drive: Drive, spreads: Mapping[str, float], backlash: float | None = None
) -> dict[str, Quantity]:
    """Every quantity with the uncertainty that datasheets are given.

    What a data sheet leaves out counts as unknown and not as none: a delay may be a sample longer than the
    file says, and friction of the load pulley, backlash of the motor joint, torque ripple and eccentricity of
    the load encoder have an upper limit also where the file says zero or nothing.

    ``spreads``: relative half widths by kind, see `cabledrive.studies.study.goals.SPREADS`; ``backlash``:
    largest backlash where the file says none [rad]; default: by the gear, see `backlash_limit`.
    """
    values, spreads = values_of(drive), SPREADS | dict(spreads)
    gear = drive.load_pulley.radius / drive.drive_pulley.radius
    hidden = {name: spreads["load_friction"] * abs(values[whole]) for name, whole in LOAD_FRICTIONS.items()}
    hidden["load_viscous_friction"] *= gear**2
    hidden["load_coulomb_friction"] *= gear
    hidden["backlash"] = backlash_limit(drive) if backlash is None else backlash
    found = {}
    for name, value in values.items():
        half = spreads["friction" if name == "backlash" else KINDS[name]] * abs(value)
        low, high = value - half, value + half
        if name == "offset_torque":
            half = max(half, spreads["friction"] * values["coulomb_friction"])
            low, high = value - half, value + half
        elif name in LOAD_FRICTIONS or (name == "backlash" and value == 0.0):
            high = max(high, value + hidden[name])
        elif name == "motor_share":
            high = min(high, 0.999)
        found[name] = Quantity(name=name, value=value, low=low, high=high, unit=UNITS[name], source=DATASHEET)
    if drive.sensors is not None and drive.sensors.sample_rate is not None:
        late, interval = drive.sensors.delay, 1.0 / drive.sensors.sample_rate
        found["delay"] = Quantity(
            name="delay", value=late, low=late, high=late + interval, unit="s", source=DATASHEET
        )
    for name, most in _unlisted(drive, values).items():
        found[name] = Quantity(name=name, value=0.0, low=0.0, high=most, unit=UNITS[name], source=DATASHEET)
    return found


def _unlisted(drive: Drive, values: Mapping[str, float]) -> dict[str, float]:
    """Largest torque ripple [N m] and eccentricity of the load encoder [rad], which no drive file has."""
    motor, sensors = drive.motor, drive.sensors
    limit = motor.torque_limit if motor is not None and motor.torque_limit else 0.0
    count = 2.0 * pi / sensors.load_encoder if sensors is not None and sensors.load_encoder else 0.0
    return {
        "ripple_torque": max(RIPPLE_SHARE * limit, RIPPLE_FRICTION * values["coulomb_friction"]),
        "eccentricity": ECCENTRIC_COUNTS * count,
    }
