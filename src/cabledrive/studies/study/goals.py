"""What a study is asked to reach, from a small file, and in what its error is counted."""

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from cabledrive.identification.logs.log import ColumnMap, column_map
from cabledrive.parameters import InputRefused
from cabledrive.parameters.fields import (
    check_fields,
    described,
    meaning,
    nearest,
    quantity,
    require_known,
    written,
)
from cabledrive.parameters.toml_values import quantities_of, quantity_of, read_toml, table_of, whole_of
from cabledrive.parameters.units import to_si
from cabledrive.rig.setting import DEGREE, Motion

COUNTS = ("pulses", "order", "draws", "cable_draws", "carriage_draws", "seed")
TABLES = ("goals", "motion", "carriage", "acceptance")
SPREADS = {"inertia": 0.1, "stiffness": 0.2, "damping": 0.5, "friction": 0.3, "load_friction": 0.15}
"""Relative half widths of data-sheet values, where nothing else is stated; `load_friction` is the largest
share of all friction that the load pulley can have beyond its own data-sheet value, also where that is 0."""
MOST_DRAWS = {"draws": 100_000, "cable_draws": 10_000, "carriage_draws": 100_000}
"""Plants of an acceptance: about a day of one core each."""
LONGEST_MOTION = 3600.0
"""Of all pulses [s]."""
LARGEST_ANGLE = 1e6
"""Of a pulse [rad]."""


@described
@dataclass(frozen=True, slots=True, kw_only=True)
class Goals:
    """Goals of a study and how it is to be tested."""

    error: float | None = quantity(
        "rad", "positive", "largest error of the load angle; None: there is no goal, and no verdict", None
    )
    angle: float | None = quantity(
        "rad", "positive", "of each pulse of the load; None: assumed from the drive's limits", None
    )
    duration: float | None = quantity("s", "positive", "of a move; None: assumed likewise", None)
    dwell: float = quantity("s", "positive", "rest after each move", 0.5)
    pulses: int = meaning("how many", 1)
    order: int = meaning("odd order of the rise", 9)
    torque: float | None = quantity("N m", "positive", "largest torque; None: the motor's limit", None)
    load_inertia: tuple[float, float] | None = meaning(
        "smallest and largest inertia of the load pulley with its load [kg m^2]", None
    )
    travel: float | None = quantity(
        "m",
        "positive",
        "way of a carriage in each pulse; None: what `angle` at the load pulley carries, or assumed",
        None,
    )
    carriage_error: float | None = quantity(
        "m",
        "positive",
        "largest error of a carriage, and of the mass that hangs below it; None: there is no goal",
        None,
    )
    hanging_mass: float | None = quantity("kg", "positive", "below the carriage; None: nothing hangs", None)
    line_length: float | None = quantity("m", "positive", "of the line on which it hangs", None)
    rail_friction: float | None = quantity(
        "N s/m", "positive", "of the carriage on its guide; None: an estimate", None
    )
    draws: int = meaning("lumped plants of the acceptance", 1000)
    cable_draws: int = meaning("plants on the cable", 73)
    carriage_draws: int = meaning("plants with a carriage", 1000)
    seed: int = meaning("of the random numbers", 0)
    every_law: bool = meaning(
        "try every law, not PD, PID, LQG, LQI, the law of the chain and `lqi-learning` alone", False
    )
    spreads: Mapping[str, float] = meaning(
        "relative half widths of datasheet values, by kind, see `SPREADS`", factory=lambda: dict(SPREADS)
    )
    backlash: float | None = quantity(
        "rad",
        "nonnegative",
        "largest backlash of the motor joint where the data sheet says none; None: by the gear, see "
        "`cabledrive.studies.study.machine.backlash_limit`",
        None,
    )
    columns: ColumnMap = meaning("how the logs are to be read", factory=ColumnMap)
    assumed: str = meaning("what of the motion was assumed, in words; empty where all of it was given", "")
    gain: float | None = meaning(
        "way of a sliding load of a machine with routes per angle [m/rad], by which its lengths "
        "were divided; None: the load turns",
        None,
    )

    def __post_init__(self) -> None:
        check_fields(self)
        if min(self.draws, self.carriage_draws) < 1 or self.cable_draws < 0:
            said = f"draws = {self.draws} and carriage_draws = {self.carriage_draws} must be at least 1"
            raise InputRefused(f"{said}, cable_draws = {self.cable_draws} 0")
        for name, most in MOST_DRAWS.items():
            if getattr(self, name) > most:
                raise InputRefused(f"{name} = {getattr(self, name)} is above {most}: ask for fewer")
        if self.seed < 0:
            raise InputRefused(f"seed = {self.seed} must not be negative: give a whole number from 0 on")
        pulse = (self.duration or 0.0) + self.dwell
        if self.pulses * pulse > LONGEST_MOTION:
            said = f"{self.pulses} pulses of {pulse:.4g} s last {self.pulses * pulse:.4g} s"
            raise InputRefused(f"{said}, above {LONGEST_MOTION:g} s: shorten the motion")
        if self.angle is not None and self.angle > LARGEST_ANGLE:
            raise InputRefused(
                f"angle = {self.angle:.4g} rad is above {LARGEST_ANGLE:g} rad: give a pulse of the load"
            )
        if (self.hanging_mass is None) != (self.line_length is None):
            given, other = ("hanging_mass", "line_length")[:: 1 if self.line_length is None else -1]
            raise InputRefused(f"{given} is given without {other}: state both, or none")
        if self.load_inertia is not None and not 0.0 < self.load_inertia[0] <= self.load_inertia[1]:
            low, high = self.load_inertia
            raise InputRefused(f"load_inertia = {low:.4g} to {high:.4g} kg m^2: give 0 < smallest <= largest")
        for name, value in self.spreads.items():
            if not 0.0 <= value < 1.0:
                raise InputRefused(f"uncertainty.{name} = {value:.4g} must be from 0 to below 1, relative")

    @property
    def motion(self) -> Motion:
        """The motion that is planned, once nothing of it is open."""
        assert self.angle is not None
        assert self.duration is not None
        repeated: dict[str, Any] = {"dwell": self.dwell, "pulses": self.pulses, "order": self.order}
        return Motion(angle=self.angle / DEGREE, rise=self.duration, **repeated)


QUANTITIES = {
    one.name: one.metadata["unit"] for one in fields(Goals) if one.metadata.get("bound") == "positive"
}
"""SI unit of each quantity of the goals."""


def load_goals(path: str | Path) -> Goals:
    """Read the goals of a study.

    TOML with tables ``[goals]``, ``[motion]``, ``[carriage]``, ``[acceptance]``, ``[uncertainty]`` and
    ``[log]``; the keys of the first four may stand without a table as well.
    Raises `InputRefused` if it cannot be read or is not understood.
    """
    return read_toml(path, "write TOML with a table [goals]", goals_of)


def goals_of(content: Mapping[str, Any]) -> Goals:
    """Goals from a table of TOML."""
    plain_tables = {name: dict(table_of(name, content.get(name, {}))) for name in ("uncertainty", "log")}
    flat = {key: value for key, value in content.items() if not isinstance(value, Mapping)}
    for table in TABLES:
        flat |= table_of(table, content.get(table, {}))
    known = (*QUANTITIES, *COUNTS, "load_inertia")
    found: dict[str, Any] = {}
    for key, value in flat.items():
        require_known(key, known, f"{key}: unknown key")
        if key in QUANTITIES:
            unit, name = QUANTITIES[key], key
            if key == "error" and isinstance(value, str):  # of a carriage it is a length, such as "0.5 mm"
                with suppress(InputRefused):
                    to_si(value, "m")
                    unit, name = "m", "carriage_error"
            found[name] = quantity_of(key, value, unit)
        elif key == "load_inertia":
            if not isinstance(value, list) or len(value) != 2:
                raise InputRefused(f"load_inertia = {written(value)} is no range: write [smallest, largest]")
            found[key] = tuple(quantities_of(key, value, "kg m^2"))
        else:
            found[key] = whole_of(key, value, least=0 if key in ("seed", "cable_draws") else 1)
    for key, value in content.items():
        if isinstance(value, Mapping):
            require_known(key, (*TABLES, *plain_tables), f"{key}: unknown table")
    open_values = dict(plain_tables["uncertainty"])
    if "backlash" in open_values:
        found["backlash"] = quantity_of("uncertainty.backlash", open_values.pop("backlash"), "rad")
    for key in open_values:
        if key not in SPREADS:
            raise InputRefused(f"uncertainty.{key}: unknown key{nearest(key, (*SPREADS, 'backlash'))}")
    spreads = {key: quantity_of(f"uncertainty.{key}", value, "1") for key, value in open_values.items()}
    return Goals(spreads=SPREADS | spreads, columns=column_map(plain_tables["log"]), **found)


@dataclass(frozen=True, slots=True, kw_only=True)
class ErrorUnit:
    """A unit of an error."""

    name: str  # as it is printed, and the ending of its keys
    si: str
    size: float  # in SI

    def of(self, error: float) -> float:
        """An error in this unit."""
        return error / self.size

    def words(self, error: float) -> str:
        """An error with three digits and the unit."""
        return f"{error / self.size:.3g} {self.name}"


DEGREES = ErrorUnit(name="deg", si="rad", size=DEGREE)
MILLIMETRES = ErrorUnit(name="mm", si="m", size=1e-3)


def error_unit(goals: Goals) -> ErrorUnit:
    """Millimetres where a carriage travels or a load slides, else degrees."""
    if goals.gain is not None:  # of an angle: its way is the angle times the gain
        return ErrorUnit(name="mm", si="rad", size=1e-3 / goals.gain)
    return DEGREES if goals.travel is None else MILLIMETRES


def goal_of(goals: Goals) -> float | None:
    """Largest error allowed [rad] of the load, [m] of a carriage."""
    return goals.error if goals.travel is None else goals.carriage_error
