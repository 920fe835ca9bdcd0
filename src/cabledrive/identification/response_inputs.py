"""From a log to the input and output of a response: friction and offset taken off, speed from an angle."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cabledrive.identification.filters import difference, zero_phase
from cabledrive.identification.logs.column_map import Column, ColumnMap
from cabledrive.identification.logs.log import Log
from cabledrive.identification.logs.quantities import recognise
from cabledrive.identification.logs.reading import open_log, read_log
from cabledrive.parameters import InputRefused

Array = NDArray[np.float64]


def compensated_torque(
    torque: Array, speed: Array, coulomb: float, offset: float, slope: float = 0.0
) -> Array:
    r"""Torque without Coulomb friction and offset, the input of the transfer functions.

    .. math:: \tau_c = \tau - c_1 S(\dot\theta) + d_1

    ``torque``, ``speed``, shape (samples,) [N m], [rad/s]; ``coulomb``, ``offset`` [N m]; ``slope``: K of a
    smooth friction tanh(K w) [s/rad]; 0: its sign.
    Returns shape (samples,).
    """
    level = np.tanh(slope * speed) if slope > 0.0 else np.sign(speed)
    return torque - coulomb * level + offset


def speed_of(log: Log, channel: str, bandwidth: float | None = None) -> Array:
    """Speed from a channel: as it is, or from the difference of an angle or position.

    ``bandwidth``: of a filter without phase [Hz]; default: none.
    Returns shape (samples,).
    Raises `InputRefused` if the channel is neither a speed nor an angle or position.
    """
    values, quantity = log.channel(channel), channel.rpartition("_")[2]
    if quantity not in ("angle", "position", "velocity"):
        raise InputRefused(
            f'{log.source}: "{channel}" is no angle, position or velocity: choose another channel'
        )
    if bandwidth is not None:
        values = zero_phase(values, log.interval, bandwidth)
    return values if quantity == "velocity" else difference(values, log.interval)


def read_pair(path: str | Path, columns: ColumnMap, input_: str, output: str) -> tuple[Log, str, str]:
    """Read a log for a response; input and output may be channels or plain columns of the file.

    ``input_``, ``output``: channel ("torque"), head ("torque [N m]"), or any column; the last is taken in the
    unit of the file.
    Returns ``input_, output``: channels of the log.
    Raises `InputRefused` if input and output are one column.
    """
    wanted = {"input_": input_, "output": output}
    chosen: dict[str, Column] = dict(columns.columns)
    names: dict[str, str] = {}
    table = open_log(path, columns if columns.columns else _time_only(columns, input_, output)).table
    for role, name in wanted.items():
        seen = recognise(name)
        heads = [
            head
            for head in table.names
            if (known := recognise(head)) and seen and known.channel == seen.channel
        ]
        if name in chosen:
            names[role] = name
        elif seen is not None and len(heads) == 1:
            names[role] = seen.channel
            chosen[seen.channel] = Column(column=heads[0])
        else:
            names[role] = f"{role.strip('_')}_voltage"  # any column: its numbers as they are
            chosen[names[role]] = Column(column=table.require(name), unit="V")
    source, target = (chosen[names[role]].column for role in wanted)
    if source == target:
        raise InputRefused(
            f'{table.source}: input and output are both the column "{source}": a response is from one column '
            f"to another: choose two of {', '.join(table.names)[:90]}"
        )
    return read_log(path, replace(columns, columns=chosen)), names["input_"], names["output"]


def _time_only(columns: ColumnMap, input_: str, output: str) -> ColumnMap:
    """A map that lets the file be opened whatever its columns are called."""
    plain: Mapping[str, Column] = {"input_voltage": Column(column=input_, unit="V")}
    recognised = recognise(input_) is not None and recognise(output) is not None
    return columns if recognised else replace(columns, columns=plain)
