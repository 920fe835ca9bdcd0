"""Whether the excitation that acts on a machine exceeds the thresholds of its pairs."""

from collections.abc import Sequence
from dataclasses import dataclass

from cabledrive.parameters import InputRefused
from cabledrive.parameters.fields import LARGEST
from cabledrive.parameters.route import RoutedDrive
from cabledrive.studies.excitation_orders import frequency_per_speed
from cabledrive.studies.resonance_detuning import NEAR, NO_EXCITATION, RESONANT, SAFE, STATE_ONE

UNKNOWN = "unknown"
CLOSE_SHARE = 0.5
"""Share of the lowest threshold from which a torque is called close."""


@dataclass(frozen=True, slots=True)
class ActingTorque:
    """A torque that acts on the first motor's pulley without a planned motion.

    Attributes
    ----------
    amplitude : float or None
        [N m]; None: nobody says.
    bands : tuple of (str, float, float), or None
        Name of an order with the frequencies that it reaches [Hz]; None: it may act at any frequency.
    """

    amplitude: float | None
    bands: tuple[tuple[str, float, float], ...] | None = None

    def reaches(self, hertz: float) -> str | None:
        """How it comes to act at a frequency [Hz]: the name of an order, or "" for any; None: it does not."""
        if self.bands is None:
            return ""
        return next((name for name, low, high in self.bands if low <= hertz <= high), None)


def acting_torque(drive: RoutedDrive, torque: float | None) -> ActingTorque | None:
    """The torque of the verdict: as given, else that of the file's [excitation]; None where there is neither.

    ``torque``: amplitude [N m], which may act at any frequency.
    Raises `InputRefused` for one out of range, and for orders that are not tied to the motion.
    """
    if torque is not None:
        if not 0.0 <= torque <= LARGEST:
            raise InputRefused(f"torque = {torque:.9g} N m must lie between 0 and {LARGEST:g} N m")
        return ActingTorque(torque)
    stated = drive.excitation
    if stated is None:
        return None
    ripple, limit = stated.torque_ripple, drive.motor[0].torque_limit if drive.motor else None
    amplitude = None if ripple is None or limit is None else ripple * limit
    if not stated.orders:
        return ActingTorque(amplitude)
    coordinate, low, high = stated.range
    bands = []
    for order in stated.listed:
        rate = frequency_per_speed(drive, order, coordinate)
        if order.pulley is not None:  # a rail's joints push a body, not the motor
            bands.append((order.name, rate * low, rate * high))
    return ActingTorque(amplitude, tuple(bands))


def verdict_of(
    acting: ActingTorque | None, thresholds: Sequence[tuple[float, float | None]]
) -> tuple[str, tuple[str, ...]]:
    """The verdict on an acting torque with its reasons.

    ``thresholds``: longitudinal frequency [Hz] and threshold torque [N m] of every pair.
    """
    excited = [(torque, hertz) for hertz, torque in thresholds if torque is not None]
    if not excited:
        return SAFE, ("no listed pair is excited by the first motor",)
    lowest, at = min(excited)
    from_there = f"from {lowest:.4g} N m of steady torque at {at:.4g} Hz on, transverse modes grow"
    if acting is None:
        return NO_EXCITATION, (f"{STATE_ONE}; {from_there}",)
    reached = [(torque, hertz) for torque, hertz in excited if acting.reaches(hertz) is not None]
    if not reached:
        bands = ", ".join(f"{name} {low:.4g} to {high:.4g} Hz" for name, low, high in acting.bands or ())
        return SAFE, (f"no order reaches the longitudinal frequency of a pair: {bands or 'none turns'}",)
    lowest, at = min(reached)
    by = acting.reaches(at)
    source = f"order {by}" if by else "a torque"
    words = f"{source} at {at:.4g} Hz grows transverse modes from {lowest:.4g} N m on"
    if acting.amplitude is None:
        return UNKNOWN, (f"{words}; its amplitude is not given: add excitation.torque_ripple",)
    words = f"{words}; the amplitude is {acting.amplitude:.4g} N m"
    if acting.amplitude >= lowest:
        return RESONANT, (words,)
    return (NEAR if acting.amplitude >= CLOSE_SHARE * lowest else SAFE), (words,)
