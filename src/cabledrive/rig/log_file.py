"""A run of the rig as a log with units in its header, such as a laboratory would keep."""

from collections.abc import Sequence

import numpy as np

from cabledrive.identification.logs.log import Log
from cabledrive.parameters import Drive
from cabledrive.rig.closed_loop.loop_numbers import Array
from cabledrive.rig.tracking import Tracking


def log_csv(log: Log) -> str:
    """The log as comma-separated values, header such as ``time [s],torque [N m],angle [rad]``."""
    heads = ["time [s]", *(f"{name.replace('_', ' ')} [{log.units[name]}]" for name in log.channels)]
    return csv_text(heads, [log.time, *log.channels.values()])


def csv_text(heads: Sequence[str], columns: Sequence[Array]) -> str:
    """Columns as comma-separated values of ten digits; ``heads``: with units; ``columns``, shape (rows,)."""
    table = np.column_stack(columns) + 0.0  # no negative zeros
    lines = [",".join(f"{value:.10g}" for value in row) for row in table]
    return "\n".join([",".join(heads), *lines]) + "\n"


LOAD_CELL_SEED = 1
HEADS = {"motor": "angle", "drive": "drive angle", "load": "load angle"}
"""As `cabledrive experiment` calls them, and `identify` reads them."""


def log_text(tracking: Tracking, drive: Drive | None = None) -> str:
    """The log as comma-separated values: time, torque, encoder angles, reference, load cell."""
    shafts = [HEADS[shaft] for shaft in tracking.summary["encoders"]]
    head = ["time [s]", "torque [N m]", *(f"{shaft} [rad]" for shaft in shafts), "reference [rad]"]
    columns = [tracking.time, tracking.torque, *tracking.encoder_angles.T, tracking.reference]
    cell = None if drive is None else load_cell(tracking, drive)
    if cell is not None:
        head.append("load cell force [N]")
        columns.append(cell)
    return csv_text(head, columns)


def load_cell(tracking: Tracking, drive: Drive) -> Array | None:
    r"""What a load cell says that holds the load pulley against both spans, with its noise.

    .. math:: F = T_1 + T_2 - 2\rho v^2

    ``drive``: the drive as it is.
    Returns shape (samples,) [N]; None where there is no load cell, or no tension is known.
    """
    noise = drive.sensors.load_cell_noise if drive.sensors else None
    if noise is None or tracking.tensions is None:
        return None
    generator = np.random.default_rng((tracking.summary["seed"], LOAD_CELL_SEED))
    rim = drive.drive_pulley.radius * tracking.speeds[:, -1]
    carried = drive.cable.stretched_mass_per_length * rim**2
    return tracking.tensions.sum(axis=1) - 2.0 * carried + noise * generator.normal(size=len(rim))
