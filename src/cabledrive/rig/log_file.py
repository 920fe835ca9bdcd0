"""A run of the rig as a log with units in its header, such as a laboratory would keep."""

import numpy as np

from cabledrive.rig.tracking import Tracking


def log_text(tracking: Tracking) -> str:
    """The log as comma-separated values: time, torque, encoder angles, reference.

    Parameters
    ----------
    tracking : Tracking

    Returns
    -------
    str
    """
    shafts = tracking.summary["encoders"]
    head = ["time [s]", "torque [N m]", *(f"{shaft} angle [rad]" for shaft in shafts), "reference [rad]"]
    columns = np.column_stack((tracking.time, tracking.torque, tracking.encoder_angles, tracking.reference))
    lines = [",".join(f"{value:.10g}" for value in row) for row in columns]
    return "\n".join([",".join(head), *lines]) + "\n"
