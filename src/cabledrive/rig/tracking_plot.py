"""The quick picture of a tracking run: reference and load angle, error, torque."""

from typing import TYPE_CHECKING

import numpy as np

from cabledrive.rig.tracking import Tracking

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def tracking_figure(run: Tracking) -> "Figure":
    """Reference and load angle, error with its bound, and torque over time."""
    from matplotlib import pyplot

    figure, (above, middle, below) = pyplot.subplots(3, 1, sharex=True, layout="constrained")
    above.plot(run.time, np.degrees(run.reference), "--", label="reference")
    above.plot(run.time, np.degrees(run.load_angle), label="load")
    above.set_ylabel("angle [deg]")
    above.legend()
    above.set_title(f"{run.summary['controller']} on {run.summary['plant']}")
    middle.plot(run.time, np.degrees(run.error))
    if run.bound is not None and run.summary["within_bound"] is not None:
        for sign in (-1.0, 1.0):
            middle.plot(run.time, sign * np.degrees(run.bound), ":", color="gray")
    middle.set_ylabel("error [deg]")
    below.plot(run.time, run.torque)
    below.set_ylabel("torque [N m]")
    below.set_xlabel("time [s]")
    return figure
