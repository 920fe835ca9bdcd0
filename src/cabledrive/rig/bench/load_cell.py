"""The virtual load cell that carries the load pulley, section 4.1: it reads both spans together."""

from dataclasses import replace

import numpy as np

from cabledrive.identification.filters import difference, zero_phase
from cabledrive.identification.logs.log import Log
from cabledrive.parameters import Drive

CHANNEL = "load_cell_force"
SPEED_BANDWIDTH = 40.0
"""Of the rim speed, whose square takes off some of the pull [Hz]."""


def with_load_cell(log: Log, drive: Drive, rng: np.random.Generator) -> Log:
    r"""A log with what the load cell reads, where the drive has one.

    .. math:: F = 2 T_0 - 2\rho v^2

    since what the load pulley adds to one span it takes from the other; v is the speed of the rim.

    ``log``: with the angle of the load pulley; without it the cable is taken to rest; ``rng``: noise of the
    cell.
    Returns with the channel "load_cell_force"; the log itself where the drive has no load cell.
    """
    noise = drive.sensors.load_cell_noise if drive.sensors else None
    if noise is None or drive.kind != "loop":
        return log
    pull = np.full(len(log), 2.0 * drive.cable.pretension)
    if "load_angle" in log.channels:
        bandwidth = min(SPEED_BANDWIDTH, 0.2 * log.sample_rate)
        speed = difference(zero_phase(log.channel("load_angle"), log.interval, bandwidth), log.interval)
        pull -= 2.0 * drive.cable.stretched_mass_per_length * (drive.load_pulley.radius * speed) ** 2
    read = pull + noise * rng.normal(size=len(log))
    return replace(log, channels={**log.channels, CHANNEL: read}, units={**log.units, CHANNEL: "N"})
