"""Which channels of a log show two inertias, and their speeds."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cabledrive.identification.chain_model import Record
from cabledrive.identification.filters import difference
from cabledrive.identification.logs.log import Log
from cabledrive.identification.regression import readable
from cabledrive.parameters import InputRefused

INPUTS = {"torque": "N m", "force": "N", "current": "A", "voltage": "V"}
MOTIONS = ("velocity", "angle", "position")
LOAD = ("load", "pulley", "output", "second")


@dataclass(frozen=True, slots=True, kw_only=True)
class TwoInertiaChannels:
    """Which channels of a log are used."""

    input: str
    # motor, load: Speed, angle or position of each side; one of them at least
    motor: str | None
    load: str | None
    rectified: bool

    @property
    def outputs(self) -> tuple[str, ...]:
        """Those that are measured, the motor's first."""
        return tuple(name for name in (self.motor, self.load) if name is not None)

    @property
    def notes(self) -> tuple[str, ...]:
        """What was assumed of them."""
        found = ["the speed is never negative: assumed to be its absolute value"] if self.rectified else []
        if self.input.rpartition("_")[2] in ("voltage", "current"):
            found.append(f"parameters are in the unit of the {readable(self.input)}: the gain is not known")
        if self.motor is None:
            found.append("only the load is measured: motor and load may be exchanged")
        return tuple(found)


def channels_of(logs: Sequence[Log]) -> TwoInertiaChannels:
    """Choose the channels, the same in every log.

    Raises `InputRefused` if input or motion is missing or constant.
    """
    names = [name for name in logs[0].channels if all(name in log.channels for log in logs)]
    input_ = next((n for kind in INPUTS for n in names if n.rpartition("_")[2] == kind), None)
    if input_ is None:
        raise InputRefused(f"{logs[0].source}: no torque, force, voltage or current: map one with --column")
    moving = [n for kind in MOTIONS for n in names if n.rpartition("_")[2] == kind]
    load = next((n for n in moving if set(n.split("_")) & set(LOAD)), None)
    motor = next((n for n in moving if not set(n.split("_")) & set(LOAD)), None)
    if load is None and motor is None:
        raise InputRefused(
            f"{logs[0].source}: no velocity, angle or position: map one, as --column "
            '"load_velocity=COLUMN:rad/s"'
        )
    for log in logs:
        for name in filter(None, (input_, motor, load)):
            if np.ptp(log.channel(name)) == 0.0:
                raise InputRefused(f"{log.source}: {name} is constant: a log must move the machine")
    speeds = [n for n in (motor, load) if n is not None and n.rpartition("_")[2] == "velocity"]
    both = any(log.channel(input_).min() < 0.0 < log.channel(input_).max() for log in logs)
    rectified = bool(speeds) and both and all(log.channel(n).min() >= 0.0 for log in logs for n in speeds)
    return TwoInertiaChannels(input=input_, motor=motor, load=load, rectified=rectified)


def record_of(log: Log, channels: TwoInertiaChannels) -> Record:
    """Input and measured speeds of a log; angles and positions are differentiated."""
    speeds = [
        log.channel(name) if name.endswith("velocity") else difference(log.channel(name), log.interval)
        for name in channels.outputs
    ]
    return Record(input=log.channel(channels.input), output=np.column_stack(speeds), interval=log.interval)


def unit_of(name: str, channels: TwoInertiaChannels, log: Log) -> str:
    """Unit of a parameter: of N m and rad, or of the input and the motion."""
    force = INPUTS[channels.input.rpartition("_")[2]]
    way = log.units[channels.outputs[0]].split("/")[0]
    if name == "sensor_lag":
        return "s"
    if name.startswith("inertia"):
        plain = {("N m", "rad"): "kg m^2", ("N", "m"): "kg"}
        return plain.get((force, way), f"{force} s^2/{way}")
    if name.startswith(("viscous", "damping")):
        return f"{force} s/{way}"
    return f"{force}/{way}" if name == "stiffness" else force
