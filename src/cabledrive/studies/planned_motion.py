"""A planned motion, and the drive along it: pretension and carriages at each instant."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from cabledrive.parameters import Drive, InputRefused

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PlannedMotion:
    """A motion, sampled.

    Attributes
    ----------
    time : ndarray, shape (n,)
        From 0, ascending [s].
    torque : ndarray, shape (n,)
        [N m].
    pretension : ndarray, shape (n,), or None
        [N]; the drive's own unless given.
    carriage : ndarray, shape (n,), or None
        Position of the first carriage [m]; carriages coupled to it move as far.
    load_torque : ndarray, shape (n,), or None
        Slowly changing torque on the load pulley [N m]; it splits the span tensions.
    places : mapping of str to ndarray, each of shape (n,)
        Of bodies of a machine with routes, by "head.x", "arm.turn" [m], [rad].
    torques : mapping of str to ndarray, each of shape (n,)
        Of its motors but the first, by the name of their pulley [N m].
    """

    time: Array
    torque: Array
    pretension: Array | None = None
    carriage: Array | None = None
    load_torque: Array | None = None
    places: Mapping[str, Array] = field(default_factory=dict)
    torques: Mapping[str, Array] = field(default_factory=dict)

    def __post_init__(self) -> None:
        n = np.asarray(self.time).size
        if n < 2 or not np.all(np.diff(self.time) > 0.0) or self.time[0] != 0.0:
            raise InputRefused("motion: time must start at 0 and ascend: give two instants or more")
        named = {name: getattr(self, name) for name in ("torque", "pretension", "carriage", "load_torque")}
        for name, values in {**named, **self.places, **self.torques}.items():
            if values is not None and (np.shape(values) != (n,) or not np.all(np.isfinite(values))):
                raise InputRefused(f"motion: {name} must be {n} finite numbers, one for each time")

    @property
    def changes(self) -> bool:
        """Whether pretension, carriages or load torque change along it."""
        columns = (self.pretension, self.carriage, self.load_torque)
        return any(values is not None and np.ptp(values) > 0.0 for values in columns)

    def of_two_pulleys(self) -> "PlannedMotion":
        """The motion of a loop or line written as a machine with routes; its torques by pulley.

        Raises `InputRefused` if pretension or carriages change along it.
        """
        for name in ("pretension", "carriage"):
            if getattr(self, name) is not None:
                raise InputRefused(
                    f"motion: {name} is not for margins, which take the tension and places of the drive "
                    "file: leave the column out"
                )
        loads = {} if self.load_torque is None else {"load pulley": self.load_torque}
        return PlannedMotion(time=self.time, torque=self.torque, torques=loads)


def drive_along(drive: Drive, motion: PlannedMotion, t: float) -> Drive:
    """The drive with the pretension and the carriage places that a motion has at an instant.

    ``t`` [s].
    Raises `InputRefused` if the motion moves a carriage that the drive has not.
    """
    if motion.pretension is not None:
        tension = float(np.interp(t, motion.time, motion.pretension))
        drive = replace(drive, cable=replace(drive.cable, pretension=tension))
    if motion.carriage is not None:
        if not drive.carriage:
            raise InputRefused("motion: carriage positions are given, but the drive has none: leave them out")
        place = float(np.interp(t, motion.time, motion.carriage))
        drive = with_carriage_at(drive, place)
    return drive


def with_carriage_at(drive: Drive, place: float) -> Drive:
    """The drive with its first carriage at a place, and those that move together with it moved as far.

    ``place``: position of the first carriage [m].
    """
    moved = place - drive.carriage[0].position
    carriages = list(drive.carriage)
    for number, direction in drive.moving_with(0).items():
        own = carriages[number]
        position = place if number == 0 else own.position + direction * moved
        carriages[number] = replace(own, position=position)
    return replace(drive, carriage=tuple(carriages))
