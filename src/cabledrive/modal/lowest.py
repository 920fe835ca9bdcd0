"""The lowest frequencies, with the rotor free and held."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from cabledrive.answers.keys import Keys
from cabledrive.mechanics import DerivedQuantities, derived_quantities
from cabledrive.mechanics.holding import CONDITIONS, FREE, HELD, HOLDING, motor_condition
from cabledrive.modal.mode import Modes
from cabledrive.modal.natural import natural_frequencies
from cabledrive.parameters import Machine, NotComputed

NAMES = {motor: f"lowest_frequency_{motor}_hz" for motor in CONDITIONS}
LOWEST = Keys("number: lowest_frequency_free_hz lowest_frequency_held_hz lowest_frequency_holding_hz?")
DERIVED = Keys("map: reasons=text", also=(Keys("**", of=DerivedQuantities), LOWEST))


@dataclass(frozen=True, slots=True, kw_only=True)
class LowestFrequencies:
    """Lowest longitudinal natural frequency of a drive by how its rotor is held."""

    # free, held: [Hz]; None where it could not be computed
    free: float | None
    held: float | None
    holding: float | None  # with the rotor on ``motor.holding_stiffness`` [Hz]; None without that stiffness
    has_motor: bool  # whether the drive has a motor; else "held" holds the drive pulley
    reasons: dict[str, str]  # why a frequency could not be computed, by the name that JSON gives it

    def as_dict(self) -> dict[str, Any]:
        """Frequencies by their names in JSON [Hz]; on the holding stiffness only where there is one."""
        data = {NAMES[FREE]: self.free, NAMES[HELD]: self.held}
        return data if self.holding is None else data | {NAMES[HOLDING]: self.holding}

    @property
    def line(self) -> str:
        """The frequencies in one sentence."""
        part = "motor" if self.has_motor else "drive pulley"
        values = ((self.free, f"with the {part} free"), (self.held, "with it held"))
        parts = [f"{value:.6g} Hz {how}" for value, how in values if value is not None]
        if self.holding is not None:
            parts.append(f"{self.holding:.6g} Hz on its holding stiffness")
        return f"Lowest longitudinal frequency: {', '.join(parts) or 'not computed'}."


def how_held(found: Modes) -> str:
    """With what held a list of modes was made, in one sentence."""
    rotor = {FREE: "free", HELD: "held", HOLDING: "on its holding stiffness"}[found.motor]
    also = f"; also held: {', '.join(found.hold)}" if found.hold else ""
    torque = f"; steady torque {found.at_torque:.6g} N m" if found.at_torque else ""
    return f"Listed with the motor {rotor}{also}{torque}."


def derived_with_lowest(drive: Machine) -> dict[str, Any]:
    """Lowest longitudinal frequencies of a machine, after the derived quantities of two pulleys, for JSON."""
    own, lowest = drive.two_pulleys, lowest_frequencies(drive)
    sheet = {"reasons": {}} if own is None else derived_quantities(own).as_dict()
    return sheet | lowest.as_dict() | {"reasons": sheet["reasons"] | lowest.reasons}


def lowest_frequencies(drive: Machine) -> LowestFrequencies:
    """Lowest longitudinal natural frequency with the rotor free, held, and on its holding stiffness.

    What a user measures on a machine at rest is mostly one of the last two: a stepper, or a servo whose
    position loop is closed, does not turn freely.
    """
    found: dict[str, float | None] = dict.fromkeys(CONDITIONS)
    reasons: dict[str, str] = {}
    for motor in CONDITIONS if motor_condition(drive) == HOLDING else (FREE, HELD):
        try:
            with np.errstate(all="ignore"):  # what cannot be refined is said, not warned of
                listed = natural_frequencies(drive, count=1, motor=motor, taut=False)
            if listed.size:
                found[motor] = float(listed[0])
            else:
                reasons[NAMES[motor]] = "no longitudinal mode among the first of the network"
        except NotComputed as failure:
            reasons[NAMES[motor]] = str(failure)
    return LowestFrequencies(**found, has_motor=bool(drive.motor), reasons=reasons)
