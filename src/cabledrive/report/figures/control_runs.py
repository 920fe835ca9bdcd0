"""Responses of the models, and the spectrum of a run of the rig."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from cabledrive.parameters import Drive
from cabledrive.reduction.quality import distributed_response, model_response
from cabledrive.report.picture import Picture, picture
from cabledrive.report.style import BLUE, GREEN, INK, ORANGE, QUIET, label, log_axis
from cabledrive.rig import Tracking

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MODEL_COLOURS = {1: QUIET, 2: ORANGE, 3: GREEN, 4: BLUE}
STYLES = ("-", "--", "-.", ":")


def responses_picture(name: str, drive: Drive, models: Sequence[int]) -> Picture:
    """Magnitude from motor torque to load angle: the distributed cable and the models."""
    hertz = np.geomspace(0.5, 500.0, 700)
    omega = 2.0 * np.pi * hertz

    def _draw(figure: "Figure", narrow: bool) -> None:
        axes = figure.subplots()
        axes.plot(hertz, np.abs(distributed_response(drive, omega)), color=INK, linewidth=3.0, alpha=0.35)
        for number in models:
            size = np.abs(model_response(drive, number, omega))
            axes.plot(hertz, size, STYLES[number - 1], color=MODEL_COLOURS[number], linewidth=1.4)
            end = (hertz[-1], size[-1])
            label(axes, str(number), end, (4, -4), color=MODEL_COLOURS[number], annotation_clip=False)
        axes.set_xlim(0.5, 500.0)
        axes.set_ylim(np.abs(distributed_response(drive, omega)).min(), 1e3)
        log_axis(axes, "x", 280.0 if narrow else 600.0)
        log_axis(axes, "y", 200.0)
        axes.set_xlabel("frequency [Hz]")
        axes.set_ylabel("load angle per torque [rad/(N m)]")

    return picture(name, _draw, wide=300.0, narrow=280.0)


def spectrum(run: Tracking, *, lowest: float = 2.0) -> tuple[np.ndarray, np.ndarray]:
    """Frequency [Hz] and amplitude [deg] of the error of the load in the last dwell."""
    interval = run.time[1] - run.time[0]
    still = run.time > run.time[-1] - run.summary["motion"]["dwell"]
    signal = np.degrees(run.error[still])
    window = np.hanning(signal.size)
    amplitude = 2.0 * np.abs(np.fft.rfft((signal - signal.mean()) * window, 8 * signal.size)) / window.sum()
    frequency = np.fft.rfftfreq(8 * signal.size, interval)
    kept = (frequency >= lowest) & (frequency <= 200.0)
    return frequency[kept], amplitude[kept]
