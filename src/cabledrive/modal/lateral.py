"""The lateral mode of a carriage that hangs on the cable between two held points."""

from dataclasses import dataclass
from math import pi, sqrt

from cabledrive.modal.mode import Mode
from cabledrive.modal.natural import modes
from cabledrive.parameters import Drive, InputRefused
from cabledrive.parameters.fields import described, meaning


@dataclass(frozen=True, slots=True, kw_only=True)
class HangingCarriage:
    """One hanging mass on a stretch of cable that is held across at both ends."""

    number: int  # number of the carriage in the file
    span: str  # {"upper", "lower"}
    mass: float  # mass m [kg]
    tension: float  # pretension T0 [N]
    # before, after: lengths L1, L2 under pretension from the carriage to the held points [m]
    before: float
    after: float
    cable_mass: float  # mass of the stretch of cable, rho (L1 + L2) [kg]
    section: tuple[float, float]  # unstretched positions of the held points [m]

    @property
    def lateral_stiffness(self) -> float:
        """Force per lateral displacement, T0 (1/L1 + 1/L2) [N/m]."""
        return self.tension * (1.0 / self.before + 1.0 / self.after)


def hanging_carriage(drive: Drive, carriage: int = 0) -> HangingCarriage:
    """The hanging carriage of that number, with its stretch of cable.

    ``carriage``: number of the carriage in the file.
    Raises `InputRefused` if there is no such carriage, if it is guided, or if another hangs on the same
    stretch.
    """
    if not 0 <= carriage < len(drive.carriage):
        raise InputRefused(
            f"carriage {carriage}: the drive has {len(drive.carriage)}, numbered from 0: choose one of them"
        )
    chosen = drive.carriage[carriage]
    if chosen.guided:
        raise InputRefused(
            f"carriage.{carriage}.guided = true: it rides on a rail and has no transverse motion; "
            "write guided = false if it hangs on the cable"
        )
    others = [c for c in drive.carriages_on(chosen.span) if c is not chosen]
    held = [0.0, *(c.position for c in others if c.guided), drive.span_length]
    start = max(position for position in held if position < chosen.position)
    end = min(position for position in held if position > chosen.position)
    if any(start < c.position < end for c in others):
        raise InputRefused(
            f"carriage {carriage} shares its stretch of the {chosen.span} span with another hanging one: "
            "take the transverse modes instead"
        )
    stretch = 1.0 + drive.cable.prestrain
    return HangingCarriage(
        number=carriage,
        span=chosen.span,
        mass=chosen.mass,
        tension=drive.cable.pretension,
        before=(chosen.position - start) * stretch,
        after=(end - chosen.position) * stretch,
        cable_mass=drive.cable.mass_per_length * (end - start),
        section=(start, end),
    )


@described
@dataclass(frozen=True, slots=True, kw_only=True)
class LateralMode:
    """Lateral frequency of one hanging carriage."""

    exact: float = meaning("lowest certified transverse mode of the stretch of cable that carries it [Hz]")
    approximate: float = meaning("as printed, the cable without mass [Hz]")
    corrected: float = meaning("with a third of the mass of that stretch added to the carriage [Hz]")
    mass_ratio: float = meaning("mass of that stretch of cable over the mass of the carriage [-]")

    @property
    def error(self) -> float:
        """Relative error of the approximation [-]; `mass_ratio` / 6 for a light cable."""
        return self.approximate / self.exact - 1.0

    @property
    def corrected_error(self) -> float:
        """Relative error of the corrected approximation [-]; of second order in `mass_ratio`."""
        return self.corrected / self.exact - 1.0


def lateral_mode(drive: Drive, carriage: int = 0) -> LateralMode:
    """Lateral mode of a hanging carriage, with the errors of the simple formulas.

    Parameters
    ----------
    drive : Drive
    carriage : int, default 0
        Number of the carriage in the file.

    Returns
    -------
    LateralMode

    Raises
    ------
    InputRefused
        If the carriage is guided, and so has no lateral mode, or hangs beside another.
    """
    hanging = hanging_carriage(drive, carriage)
    return LateralMode(
        exact=_exact(drive, hanging).frequency,
        approximate=lateral_frequency(hanging),
        corrected=corrected_lateral_frequency(hanging),
        mass_ratio=hanging.cable_mass / hanging.mass,
    )


def lateral_frequency(hanging: HangingCarriage) -> float:
    r"""Lateral frequency of a mass on a cable without mass, Eqs. (3.33)-(3.35).

    .. math:: f = \frac{1}{2\pi}\sqrt{\frac{T_0}{m}\Big(\frac{1}{L_1} + \frac{1}{L_2}\Big)}

    The print calls this omega; it is the frequency in Hz. It does not say that the cable's mass is left out.

    Returns frequency [Hz].
    """
    return sqrt(hanging.lateral_stiffness / hanging.mass) / (2 * pi)


def corrected_lateral_frequency(hanging: HangingCarriage) -> float:
    r"""Lateral frequency to first order in the mass of the cable, Eq. (M.8).

    The exact condition for two pieces of phase :math:`\alpha_i = \omega L_i/c_w` is
    :math:`m\omega = c_w\rho\,(\cot\alpha_1 + \cot\alpha_2)`. With
    :math:`\cot\alpha = 1/\alpha - \alpha/3 - \alpha^3/45 - \dots` its first two terms give

    .. math:: \omega^2\Big(m + \tfrac13\rho(L_1 + L_2)\Big) = T_0\Big(\frac{1}{L_1} + \frac{1}{L_2}\Big):

    a third of the stretch of cable moves with the mass, wherever it hangs.

    Returns frequency [Hz].
    """
    return sqrt(hanging.lateral_stiffness / (hanging.mass + hanging.cable_mass / 3.0)) / (2 * pi)


def _exact(drive: Drive, hanging: HangingCarriage) -> Mode:
    """Lowest transverse mode of the section in which the carriage hangs."""
    count = 2
    while True:
        for mode in modes(drive, count=count).transverse:
            if mode.span == hanging.span and mode.section == hanging.section:
                return mode
        count *= 2
