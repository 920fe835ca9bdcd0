"""A log of the virtual rig as a text file with units in its header, in the form that `identify` reads."""

from collections.abc import Sequence

import numpy as np

from cabledrive.identification.logs.log import Log
from cabledrive.rig.closed_loop.loop_numbers import Array


def log_csv(log: Log) -> str:
    """The log as comma-separated values.

    Returns header such as ``time [s],torque [N m],angle [rad]``.
    """
    heads = ["time [s]", *(f"{name.replace('_', ' ')} [{log.units[name]}]" for name in log.channels)]
    return csv_text(heads, [log.time, *log.channels.values()])


def csv_text(heads: Sequence[str], columns: Sequence[Array]) -> str:
    """Columns as comma-separated values of ten digits.

    ``heads``: with units; ``columns``, shape (rows,).
    """
    table = np.column_stack(columns) + 0.0  # no negative zeros
    lines = [",".join(f"{value:.10g}" for value in row) for row in table]
    return "\n".join([",".join(heads), *lines]) + "\n"
