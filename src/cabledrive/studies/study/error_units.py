"""In what the error of a study is counted: degrees of a load that turns, millimetres of what slides."""

from dataclasses import dataclass

from cabledrive.rig.setting import DEGREE
from cabledrive.studies.study.goals import Goals


@dataclass(frozen=True, slots=True, kw_only=True)
class ErrorUnit:
    """A unit of an error.

    Attributes
    ----------
    name : str
        As it is printed, and the ending of its keys.
    si : str
    size : float
        In SI.
    """

    name: str
    si: str
    size: float

    def of(self, error: float) -> float:
        """An error in this unit."""
        return error / self.size

    def words(self, error: float) -> str:
        """An error with three digits and the unit."""
        return f"{error / self.size:.3g} {self.name}"


DEGREES = ErrorUnit(name="deg", si="rad", size=DEGREE)
MILLIMETRES = ErrorUnit(name="mm", si="m", size=1e-3)


def error_unit(goals: Goals) -> ErrorUnit:
    """Millimetres where a carriage travels or a load slides, else degrees.

    ``goals``: as `cabledrive.studies.study.assumed_motion.goals_for` leaves them.
    """
    if goals.gain is not None:  # of an angle: its way is the angle times the gain
        return ErrorUnit(name="mm", si="rad", size=1e-3 / goals.gain)
    return DEGREES if goals.travel is None else MILLIMETRES


def goal_of(goals: Goals) -> float | None:
    """Largest error allowed.

    Returns [rad] of the load, [m] of a carriage.
    """
    return goals.error if goals.travel is None else goals.carriage_error
