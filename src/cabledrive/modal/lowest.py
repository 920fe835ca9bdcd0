"""The lowest frequencies: with the rotor free and held, and beside what simple formulas say of them."""

from dataclasses import dataclass, replace
from math import pi
from typing import Any

import numpy as np

from cabledrive.answers.keys import Keys
from cabledrive.mechanics import DerivedQuantities, derived_quantities
from cabledrive.mechanics.holding import CONDITIONS, FREE, HELD, HOLDING, motor_condition
from cabledrive.mechanics.spans import lumped_cable_mode
from cabledrive.modal.mode import Modes
from cabledrive.modal.natural import modes, natural_frequencies
from cabledrive.modal.tuning import pulley_mode
from cabledrive.parameters import Drive, InputRefused, NotComputed
from cabledrive.parameters.fields import described, meaning
from cabledrive.parameters.route import Machine
from cabledrive.parameters.route.two_pulleys import two_pulleys

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
        """Frequencies by the names that JSON gives them.

        Returns in Hz; the one on the holding stiffness only where there is one.
        """
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
    own, lowest = two_pulleys(drive), lowest_frequencies(drive)
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


@described
@dataclass(frozen=True, slots=True, kw_only=True)
class Comparison:
    """A frequency from a simple formula beside the certified one."""

    simple: float = meaning("frequency from the formula [Hz]")
    exact: float = meaning("certified frequency [Hz]")

    @property
    def deviation(self) -> float:
        """Relative deviation of the simple formula, simple / exact - 1 [-]."""
        return self.simple / self.exact - 1.0


def against_rigid_supports(drive: Drive) -> tuple[Comparison, Comparison]:
    r"""How far rigid supports in place of pulleys and carriages lead astray.

    Eqs. (3.14a), (3.14b) with Le for L:

    .. math:: f_u = \frac{c_u}{2 L_e} = \frac{1}{2 L}\sqrt{EA/\rho_0}, \qquad f_w = \frac{c_w}{2 L_e}

    Along and across: the bare span between rigid supports against the lowest certified mode of each kind.
    """
    found, cable, twice = modes(drive, count=1), drive.cable, 2.0 * drive.pulley_distance
    return (
        Comparison(simple=cable.axial_wave_speed / twice, exact=found.longitudinal[0].frequency),
        Comparison(simple=cable.transverse_wave_speed / twice, exact=found.transverse[0].frequency),
    )


def against_lumped_springs(drive: Drive) -> Comparison:
    r"""How far a cable of springs without mass leads astray.

    The simple frequency is that of `lumped_cable_mode` with :math:`k = EA/L`,
    :math:`\omega = \sqrt{2k\,(r_1^2/J_1 + r_2^2/J_2)}` for a loop; carriages are left out, the motor joint is
    taken as rigid. On a bare drive it is too high, to first order in the mass :math:`m_c` of the cable by

    .. math:: \frac{m_c}{6\mu}\Big(1 - \frac{3\mu}{m_1 + m_2}\Big), \qquad
              \mu = \frac{m_1 m_2}{m_1 + m_2}, \quad m_i = J_i/r_i^2 \qquad \text{Eq. (M.7)}

    Against the certified `pulley_mode`; raises `InputRefused` if both pulleys are fixed.
    """
    simple = lumped_cable_mode(replace(drive, lumped=None))
    if simple is None:
        raise InputRefused("both pulleys are fixed, so that no mode turns one: leave out pulley.0.fixed or 1")
    return Comparison(simple=simple / (2 * pi), exact=pulley_mode(drive).omega / (2 * pi))
