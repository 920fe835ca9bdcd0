"""Pictures of the rig: errors of several laws over time, spectra, and the responses of the models."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from cabledrive.parameters import Drive
from cabledrive.reduction.lumped_chain import speed_response
from cabledrive.reduction.models import highest_model, lumped_model
from cabledrive.reduction.quality import distributed_response, model_response
from cabledrive.report.picture import Picture, picture
from cabledrive.report.style import BLUE, GREEN, INK, ORANGE, PURPLE, QUIET, RED, label, log_axis
from cabledrive.rig import Tracking

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MODEL_COLOURS = {1: QUIET, 2: ORANGE, 3: GREEN, 4: BLUE}
STYLES = ("-", "--", "-.", ":")
_COLOURS = (BLUE, ORANGE, GREEN, PURPLE, RED, INK)


def responses_picture(name: str, drive: Drive, models: Sequence[int]) -> Picture:
    """Magnitude from motor torque to load angle: the distributed cable and the models.

    ``name``: unique on the page.
    """
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


def models_with_cable(drive: Drive) -> tuple[int, ...]:
    """Which of Models 1 to 4 have a flexible cable and can be made of a drive."""
    return (3, 4) if highest_model(drive) == 4 else (3,)


def motor_speed_picture(name: str, drive: Drive, printed: Sequence[float]) -> Picture:
    """Magnitude from motor torque to motor speed, Models 3 and 4 beside the distributed cable.

    ``name``: unique on the page; ``printed``: frequencies that the print reads off its curve [Hz]; may be
    empty.
    """
    hertz = np.geomspace(1.0, 500.0, 700)
    omega = 2.0 * np.pi * hertz
    exact = omega * np.abs(distributed_response(drive, omega, angle_of="motor"))

    def _draw(figure: "Figure", narrow: bool) -> None:
        axes = figure.subplots()
        for place in printed:
            axes.axvline(place, color=RED, linewidth=1.0, linestyle=":")
            label(axes, f"{place:g} Hz", (place, exact.max()), (3, 0), color=RED)
        axes.plot(hertz, exact, color=INK, linewidth=3.0, alpha=0.35)
        lowest = exact.min()
        for number in models_with_cable(drive):
            size = np.abs(speed_response(lumped_model(drive, number), omega))
            colour = MODEL_COLOURS[number]
            axes.plot(hertz, size, STYLES[number - 1], color=colour, linewidth=1.4)
            lowest = min(lowest, size.min())
            label(axes, str(number), (hertz[-1], size[-1]), (4, -4), color=colour, annotation_clip=False)
        axes.set_xlim(1.0, 500.0)
        axes.set_ylim(0.7 * lowest, 1.4 * exact.max())
        log_axis(axes, "x", 280.0 if narrow else 600.0)
        log_axis(axes, "y", 200.0)
        axes.set_xlabel("frequency [Hz]")
        axes.set_ylabel("motor speed per torque [rad/(N m s)]")

    return picture(name, _draw, wide=290.0, narrow=280.0)


def spectrum(run: Tracking, inertia: int, *, lowest: float = 2.0) -> tuple[np.ndarray, np.ndarray]:
    """Amplitude spectrum of an angle's deviation from the reference in the last dwell.

    ``inertia``: number of the inertia, from the motor; ``lowest`` [Hz].
    Returns ``frequency``, shape (p,) [Hz]; ``amplitude``, shape (p,) [deg].
    """
    interval = run.time[1] - run.time[0]
    still = run.time > run.time[-1] - run.summary["motion"]["dwell"]
    signal = np.degrees(run.angles[still, inertia] - run.reference[still])
    window = np.hanning(signal.size)
    amplitude = 2.0 * np.abs(np.fft.rfft((signal - signal.mean()) * window, 8 * signal.size)) / window.sum()
    frequency = np.fft.rfftfreq(8 * signal.size, interval)
    kept = (frequency >= lowest) & (frequency <= 200.0)
    return frequency[kept], amplitude[kept]


def spectra_picture(name: str, runs: Sequence[tuple[str, Tracking]]) -> Picture:
    """Spectra of the drive pulley and the load in the dwell after a pulse.

    ``name``: unique on the page; ``runs``: what to call each run, and the run.
    """

    def _draw(figure: "Figure", narrow: bool) -> None:
        panels = figure.subplots(len(runs), 1, sharex=True, squeeze=False)[:, 0]
        for axes, (words, run) in zip(panels, runs, strict=True):
            for inertia, colour, style in ((-2, ORANGE, "-"), (-1, BLUE, "--")):
                axes.plot(*spectrum(run, inertia), style, color=colour, linewidth=1.3)
            axes.set_title(words)
            axes.set_xlim(2.0, 200.0)
            axes.set_ylim(1e-4, 3.0)
            log_axis(axes, "x", 280.0 if narrow else 600.0)
            log_axis(axes, "y", 80.0)
            axes.set_ylabel("deg")
        panels[-1].set_xlabel("frequency [Hz]; solid: drive pulley, dashed: load")

    height = 105.0 * len(runs) + 45.0
    return picture(name, _draw, wide=height, narrow=height)
