"""A carriage that hangs on the cable between two held points."""

from dataclasses import dataclass

from cabledrive.parameters import Drive, InputRefused


@dataclass(frozen=True, slots=True, kw_only=True)
class HangingCarriage:
    """One hanging mass on a stretch of cable that is held across at both ends.

    Attributes
    ----------
    number : int
        Number of the carriage in the file.
    span : {"upper", "lower"}
    mass : float
        Mass m [kg].
    tension : float
        Pretension T0 [N].
    before, after : float
        Lengths L1, L2 under pretension from the carriage to the held points [m].
    cable_mass : float
        Mass of the stretch of cable, rho (L1 + L2) [kg].
    section : (float, float)
        Unstretched positions of the held points [m].
    """

    number: int
    span: str
    mass: float
    tension: float
    before: float
    after: float
    cable_mass: float
    section: tuple[float, float]

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
