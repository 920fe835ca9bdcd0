"""Picture of an identification: a response."""

from typing import TYPE_CHECKING

import numpy as np

from cabledrive.identification.frequency_response import FrequencyResponse
from cabledrive.report.picture import Picture, picture
from cabledrive.report.style import BLUE, INK, log_axis

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def measured_picture(
    name: str,
    measured: FrequencyResponse,
    model: tuple[np.ndarray, np.ndarray] | None,
    unit: str,
) -> Picture:
    """A measured response with its 95 % band, and a model's, at frequencies [Hz], where there is one."""
    low = np.maximum(measured.magnitude - 2 * measured.deviation, 0.3 * measured.magnitude)
    high = measured.magnitude + 2 * measured.deviation

    def _draw(figure: "Figure", narrow: bool) -> None:
        above, below = figure.subplots(2, 1, sharex=True, gridspec_kw={"height_ratios": [1.6, 1]})
        above.fill_between(measured.frequency, low, high, color=BLUE, alpha=0.18, linewidth=0)
        above.plot(measured.frequency, measured.magnitude, color=BLUE, linewidth=1.0)
        below.plot(measured.frequency, measured.phase, color=BLUE, linewidth=1.0)
        if model is not None:
            above.plot(model[0], np.abs(model[1]), "--", color=INK, linewidth=1.2)
            below.plot(model[0], np.degrees(np.angle(model[1])), "--", color=INK, linewidth=1.2)
        below.set_xlim(float(measured.frequency[0]), float(measured.frequency[-1]))
        log_axis(below, "x", 250.0 if narrow else 600.0)
        above.set_ylim(low.min(), high.max())
        log_axis(above, "y", 170.0)
        above.set_ylabel(unit)
        above.set_title("blue: measured, 95 % band; dashed: model")
        below.set_ylim(-190.0, 190.0)
        below.set_yticks((-180, -90, 0, 90, 180))
        below.set_ylabel("phase [deg]")
        below.set_xlabel("frequency [Hz]")

    return picture(name, _draw, wide=330.0, narrow=330.0)
