"""What is asked of a transporter, what a run of it leaves, and what it refuses."""

from dataclasses import dataclass
from math import inf, isfinite, pi

import numpy as np
from numpy.typing import NDArray

from cabledrive.parameters import Drive, InputRefused
from cabledrive.reduction.transporter import Transporter

Array = NDArray[np.float64]
MARGIN = 0.05


@dataclass(frozen=True, slots=True, kw_only=True)
class CarriageMove:
    """What is asked of the transporter.

    Attributes
    ----------
    distance : float
        [m].
    duration : float
        [s].
    rest : float
        How long the run goes on at the end [s].
    payload_mass : float
        Of the hanging mass [kg].
    line_length : float
        [m].
    gust : tuple of float
        Force of the wind on the payload [N], its start and end [s].
    """

    distance: float = 1.0
    duration: float = 2.5
    rest: float = 3.0
    payload_mass: float = 0.25
    line_length: float = 0.25
    gust: tuple[float, float, float] = (0.0, 1.0, 1.5)

    def __post_init__(self) -> None:
        for name, unit in (("duration", "s"), ("rest", "s"), ("payload_mass", "kg"), ("line_length", "m")):
            value = getattr(self, name)
            if not isfinite(value) or value <= 0.0:
                raise InputRefused(f"{name} = {value:.4g} {unit} must be finite and above 0: give more")
        if not isfinite(self.distance) or self.distance == 0.0:
            raise InputRefused(f"distance = {self.distance:.4g} m must be finite and not 0: give a way to go")
        if not all(isfinite(value) for value in self.gust) or self.gust[1] > self.gust[2]:
            raise InputRefused(f"gust = {self.gust} must be a force, a start and a later end: mend it")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CarriageRun:
    """A run of the transporter.

    Attributes
    ----------
    law : str
    time : ndarray, shape (samples,)
        [s].
    wanted : ndarray, shape (samples,)
        Displacement asked for [m].
    payload, carriage : ndarray, shape (samples,)
        True displacements [m].
    swing : ndarray, shape (samples,)
        Angle of the line [rad].
    tensions : ndarray, shape (samples, 3)
        Of the strands [N].
    force : ndarray, shape (samples,)
        Of the motor at the rim [N].
    arrival : float
        When the motion is to be over [s].
    incomplete : str or None
        Why the run ended early.
    """

    law: str
    time: Array
    wanted: Array
    payload: Array
    carriage: Array
    swing: Array
    tensions: Array
    force: Array
    arrival: float
    incomplete: str | None

    def residual(self, *, later: float = 0.0) -> float:
        """Largest distance of the payload from where it is to rest, once the motion is over.

        Parameters
        ----------
        later : float, default 0.0
            How long after the arrival to begin [s].

        Returns
        -------
        float
            [m]; infinite where the run ended early.
        """
        after = self.time >= self.arrival + later
        if self.incomplete or not after.any():
            return float("inf")
        return float(np.abs(self.payload[after] - self.wanted[-1]).max())


def check_way(transporter: Transporter, distance: float) -> None:
    """Refuse a way that leaves the span.

    ``distance`` [m].
    """
    end, length = transporter.start + distance, transporter.span_length
    if not MARGIN < min(transporter.start, end) <= max(transporter.start, end) < length - MARGIN:
        raise InputRefused(
            f"the carriage goes from {transporter.start:.4g} m to {end:.4g} m, nearer than {MARGIN:g} m to "
            f"an end of its span of {length:.4g} m: shorten the way, or lengthen layout.span_length"
        )


def one_count(drive: Drive) -> float:
    """One count of the pulleys' encoders at the rim [m].

    Raises `InputRefused` if one is missing, or they differ.
    """
    sensors = drive.sensors
    found = (sensors.drive_encoder, sensors.load_encoder) if sensors else (None, None)
    if found[0] is None or found[0] != found[1]:
        raise InputRefused(
            f"sensors.drive_encoder = {found[0]} and sensors.load_encoder = {found[1]}: give both, alike"
        )
    return 2.0 * pi / found[0] * drive.drive_pulley.radius


def force_limit(drive: Drive) -> float:
    """Largest force of the motor at the rim [N].

    Returns infinite where the drive names no torque limit.
    """
    limit = drive.motor.torque_limit if drive.motor else None
    return inf if limit is None else limit / drive.drive_pulley.radius
