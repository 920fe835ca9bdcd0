"""Pictures of an identification: responses, the amplifier."""

from typing import TYPE_CHECKING

import numpy as np

from cabledrive.identification.amplifier import AmplifierFit, amplifier_response
from cabledrive.identification.frequency_response import FrequencyResponse
from cabledrive.reduction.lumped_chain import speed_response
from cabledrive.report.picture import Picture, picture
from cabledrive.report.style import BLUE, INK, log_axis
from cabledrive.studies.chapter_4 import ResponseExperiment

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

HIGHEST = 300.0
"""Of the responses that are shown [Hz]."""


def response_picture(name: str, found: ResponseExperiment) -> Picture:
    """Magnitude and phase of a response, with its 95 % band, above the model that made it.

    ``name``: unique on the page.
    """
    fine = np.geomspace(1.0, HIGHEST, 500)
    exact = speed_response(found.chain, 2 * np.pi * fine)
    return measured_picture(name, found.measured.between(1.0, HIGHEST), (fine, exact), "rad/(N m s)")


def amplifier_picture(name: str, measured: FrequencyResponse, fit: AmplifierFit, interval: float) -> Picture:
    """Response from command to torque: Fig. 4.21.

    ``name``: unique on the page; ``interval``: for which a command stands, and over which a torque is the
    mean [s].
    """
    fine = np.geomspace(1.0, HIGHEST, 200)
    bandwidth = fit.bandwidth.value if np.isfinite(fit.bandwidth.value) else np.inf
    seen = amplifier_response(
        fine, fit.gain.value, bandwidth, fit.delay.value, held=interval, averaged=interval
    )
    return measured_picture(name, measured.between(1.0, HIGHEST), (fine, seen), "N m/V", decibels=True)


def measured_picture(
    name: str,
    measured: FrequencyResponse,
    model: tuple[np.ndarray, np.ndarray] | None,
    unit: str,
    *,
    decibels: bool = False,
) -> Picture:
    """A measured response with its 95 % band, and a model's where there is one.

    ``name``: unique on the page; ``model``: frequencies [Hz] and response; ``unit``: of the response;
    ``decibels``: whether the magnitude is shown in dB.
    """
    low = np.maximum(measured.magnitude - 2 * measured.deviation, 0.3 * measured.magnitude)
    high = measured.magnitude + 2 * measured.deviation

    def size(values: np.ndarray) -> np.ndarray:
        return 20 * np.log10(values) if decibels else values

    def _draw(figure: "Figure", narrow: bool) -> None:
        above, below = figure.subplots(2, 1, sharex=True, gridspec_kw={"height_ratios": [1.6, 1]})
        above.fill_between(measured.frequency, size(low), size(high), color=BLUE, alpha=0.18, linewidth=0)
        above.plot(measured.frequency, size(measured.magnitude), color=BLUE, linewidth=1.0)
        below.plot(measured.frequency, measured.phase, color=BLUE, linewidth=1.0)
        if model is not None:
            above.plot(model[0], size(np.abs(model[1])), "--", color=INK, linewidth=1.2)
            below.plot(model[0], np.degrees(np.angle(model[1])), "--", color=INK, linewidth=1.2)
        band = (float(measured.frequency[0]), float(measured.frequency[-1]))
        _scale(above, below, band, size(np.array([low.min(), high.max()])), decibels, narrow)
        above.set_ylabel("dB" if decibels else unit)
        above.set_title("blue: measured, 95 % band; dashed: model")
        below.set_ylabel("phase [deg]")
        below.set_xlabel("frequency [Hz]")

    return picture(name, _draw, wide=330.0, narrow=330.0)


def _scale(
    above: "Axes",
    below: "Axes",
    band: tuple[float, float],
    limits: np.ndarray,
    decibels: bool,
    narrow: bool,
) -> None:
    """Logarithmic axes, or in dB a range in which a constant looks constant."""
    below.set_xlim(*band)
    log_axis(below, "x", 250.0 if narrow else 600.0)
    if decibels:
        middle = float(np.mean(limits))
        above.set_ylim(middle - 6.0, middle + 6.0)
    else:
        above.set_ylim(*limits)
        log_axis(above, "y", 170.0)
    below.set_ylim(-190.0, 190.0)
    below.set_yticks((-180, -90, 0, 90, 180))
