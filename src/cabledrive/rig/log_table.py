"""A log of the virtual rig as a text file with units in its header, in the form that `identify` reads."""

import numpy as np

from cabledrive.identification.logs.log import Log


def log_csv(log: Log) -> str:
    """The log as comma-separated values.

    Parameters
    ----------
    log : Log

    Returns
    -------
    str
        Header such as ``time [s],torque [N m],angle [rad]``.
    """
    heads = ["time [s]", *(f"{name.replace('_', ' ')} [{log.units[name]}]" for name in log.channels)]
    columns = np.column_stack([log.time, *log.channels.values()])
    lines = [",".join(f"{value:.10g}" for value in row) for row in columns]
    return "\n".join([",".join(heads), *lines]) + "\n"
