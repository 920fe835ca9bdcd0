"""Whether a torque on the first motor's pulley exceeds the lowest threshold of a machine's pairs."""

from collections.abc import Iterable

from cabledrive.parameters import InputRefused
from cabledrive.parameters.fields import LARGEST
from cabledrive.parameters.route import RoutedDrive
from cabledrive.studies.resonance_detuning import NEAR, RESONANT, SAFE

UNKNOWN = "unknown"
CLOSE_SHARE = 0.5
"""Share of the lowest threshold from which a torque is called close."""


def judged_torque(drive: RoutedDrive, torque: float | None) -> float | None:
    """Amplitude of the verdict [N m]: as given, else the first motor's limit; None where there is neither."""
    if torque is None:
        return drive.motor[0].torque_limit if drive.motor else None
    if not 0.0 <= torque <= LARGEST:
        raise InputRefused(f"torque = {torque:.9g} N m must lie between 0 and {LARGEST:g} N m")
    return torque


def lowest_threshold(thresholds: Iterable[float | None]) -> float | None:
    """The lowest of the thresholds that exist [N m]."""
    return min((one for one in thresholds if one is not None), default=None)


def verdict_of(torque: float | None, lowest: float | None) -> tuple[str, tuple[str, ...]]:
    """The verdict on a torque [N m] with its reasons."""
    if lowest is None:
        return SAFE, ("no listed pair is excited by the first motor",)
    if torque is None:
        return UNKNOWN, ("no torque is given: state one, or motor.torque_limit in the file",)
    words = (
        f"the lowest threshold is {lowest:.4g} N m of steady torque at a longitudinal frequency, "
        f"the torque {torque:.4g} N m"
    )
    if torque >= lowest:
        return RESONANT, (words,)
    return (NEAR if torque >= CLOSE_SHARE * lowest else SAFE), (words,)
