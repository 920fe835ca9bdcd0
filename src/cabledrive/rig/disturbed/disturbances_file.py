"""What disturbs the plants of a comparison: ranges from a small TOML file, each drawn evenly."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from math import inf
from pathlib import Path
from typing import Any

from cabledrive.parameters import Drive, InputRefused
from cabledrive.parameters.fields import nearest
from cabledrive.parameters.toml_values import quantity_of, read_toml

Range = tuple[float, float]
NONE: Range = (0.0, 0.0)
UNITS: dict[str, tuple[str, float, float]] = {
    "load_coulomb": ("N m", 0.0, inf),
    "load_viscous": ("N m s/rad", 0.0, inf),
    "stribeck_excess": ("1", 0.0, 10.0),
    "stribeck_speed": ("rad/s", 1e-3, inf),
    "backlash": ("rad", 0.0, 0.5),
    "cogging": ("N m", 0.0, inf),
    "cogging_periods": ("1", 1.0, 10_000.0),
    "torque_ripple": ("1", 0.0, 1.0),
    "ripple_periods": ("1", 1.0, 10_000.0),
    "encoder_eccentricity": ("rad", 0.0, 0.5),
    "added_delay": ("s", 0.0, inf),
    "jitter": ("s", 0.0, inf),
    "load_factor": ("1", 0.05, 20.0),
    "load_time": ("s", 0.0, inf),
    "announced_error": ("1", -0.9, 9.0),
    "announced_late": ("s", -inf, inf),
    "softening": ("1/s", 0.0, 1.0),
    "warming": ("1/s", 0.0, 1.0),
    "shock_torque": ("N m", -inf, inf),
    "shock_time": ("s", 0.0, inf),
    "shock_duration": ("s", 0.0, inf),
}
"""SI unit, least and largest value of each key."""
FRICTION_SHARE = 0.5
"""Largest Coulomb friction of the load, over that of the motor, where nothing else is stated."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Disturbances:
    """Ranges from which each plant of a comparison draws, all at the first shaft.

    Attributes
    ----------
    load_coulomb, load_viscous : tuple of float
        Friction of the load beside that of the drive [N m], [N m s/rad].
    stribeck_excess, stribeck_speed : tuple of float
        Friction at standstill over Coulomb friction, as a share of it; speed at which a third is left
        [rad/s].
    backlash : tuple of float
        Of the motor's gearhead, from end to end [rad].
    cogging, cogging_periods : tuple of float
        Torque [N m]; periods per turn of the motor's shaft.
    torque_ripple, ripple_periods : tuple of float
        Share of the torque; periods per turn.
    encoder_eccentricity : tuple of float
        Error of the load's encoder, once per turn [rad].
    added_delay : tuple of float
        On top of the drive's own, unknown to the filter [s].
    jitter : tuple of float
        Standard deviation of the sample times [s].
    load_factor, load_time : tuple of float
        Factor of the load's inertia from a time on; [s].
    announced_error, announced_late : tuple of float
        Of the load that is announced to a law scheduled by it: error as a share of the true one, and by how
        much later than the change it comes, negative: earlier [s].
    softening : tuple of float
        Share of the cable's stiffness that is lost in a second [1/s].
    warming : tuple of float
        Share of all Coulomb friction that is lost in a second [1/s].
    shock_torque, shock_time, shock_duration : tuple of float
        Torque on the load [N m], its start and duration [s].
    """

    load_coulomb: Range = NONE
    load_viscous: Range = NONE
    stribeck_excess: Range = NONE
    stribeck_speed: Range = (0.3, 0.3)
    backlash: Range = NONE
    cogging: Range = NONE
    cogging_periods: Range = (24.0, 24.0)
    torque_ripple: Range = NONE
    ripple_periods: Range = (6.0, 48.0)
    encoder_eccentricity: Range = NONE
    added_delay: Range = NONE
    jitter: Range = NONE
    load_factor: Range = (1.0, 1.0)
    load_time: Range = NONE
    announced_error: Range = NONE
    announced_late: Range = NONE
    softening: Range = NONE
    warming: Range = NONE
    shock_torque: Range = NONE
    shock_time: Range = NONE
    shock_duration: Range = (0.01, 0.01)

    def __post_init__(self) -> None:
        for field in fields(self):
            unit, least, most = UNITS[field.name]
            low, high = getattr(self, field.name)
            words = "" if unit == "1" else f" {unit}"
            if not least <= low <= high <= most:
                raise InputRefused(
                    f"{field.name} = {low:.4g} to {high:.4g}{words}: give smallest and largest, from "
                    f"{least:.4g} to {most:.4g}{words}"
                )

    @property
    def announced(self) -> Range:
        """Least and largest load that is announced, as factors; the drive's own is among them."""
        (low, high), (less, more) = self.load_factor, self.announced_error
        return min(1.0, low * (1.0 + less)), max(1.0, high * (1.0 + more))

    @property
    def changes_load(self) -> bool:
        """Whether the load's inertia may be another than that of the drive."""
        return self.load_factor != (1.0, 1.0)


def standard_disturbances(drive: Drive) -> Disturbances:
    """Coulomb friction of the load up to half that of the motor, where no file says otherwise."""
    own = drive.motor.coulomb_friction if drive.motor else 0.0
    return Disturbances(load_coulomb=(0.0, FRICTION_SHARE * own))


def load_disturbances(path: str | Path) -> Disturbances:
    """Read disturbances; a key that the file leaves out does not disturb.

    Raises `InputRefused` if it cannot be read or is not understood.
    """
    path = Path(path)
    content = read_toml(path, 'write TOML such as load_coulomb = ["0 N m", "0.02 N m"]')
    try:
        return disturbances_of(content)
    except InputRefused as refusal:
        raise refusal.at(path.name) from None


def disturbances_of(content: Mapping[str, Any]) -> Disturbances:
    """Disturbances from a table of TOML: a quantity, or [smallest, largest].

    Raises `InputRefused` if a key is unknown or a value has another unit.
    """
    found: dict[str, Range] = {}
    for key, value in content.items():
        if key not in UNITS:
            raise InputRefused(f"{key}: unknown key{nearest(key, UNITS)}")
        ends = value if isinstance(value, list) else [value, value]
        if len(ends) != 2:
            raise InputRefused(f"{key}: {len(ends)} values are no range: write [smallest, largest]")
        low, high = (quantity_of(key, end, UNITS[key][0]) for end in ends)
        found[key] = (low, high)
    return Disturbances(**found)
