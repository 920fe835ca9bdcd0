"""The determinant of the modal matrix, Figs. 3.1 and 3.2, with every mode of the drive on its zero line."""

from typing import TYPE_CHECKING

import numpy as np

from cabledrive.parameters import Drive
from cabledrive.report.numbers import number
from cabledrive.report.picture import Picture, picture
from cabledrive.report.style import BLUE, LINE, family_colour, label, short_family
from cabledrive.studies import modal_determinant

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WINDOWS = ((0.0, 3000.0), (0.0, 200.0), (735.0, 785.0))
"""Ranges of frequency [Hz]: two as in the print, and one round the second and third mode."""

_POINTS = 601


def determinant_windows(drive: Drive) -> tuple["xr.Dataset", ...]:
    """The determinant over each of the `WINDOWS`.

    ``drive``: a loop without carriages.
    Returns as from `cabledrive.studies.modal_determinant`.
    """
    return tuple(modal_determinant(drive, np.linspace(*window, _POINTS)) for window in WINDOWS)


def determinant_picture(name: str, windows: tuple["xr.Dataset", ...]) -> Picture:
    """Draw the determinant over several ranges of frequency.

    ``name``: unique on the page; ``windows``: from `determinant_windows`.
    """

    def _draw(figure: "Figure", narrow: bool) -> None:
        rows, columns = (len(windows), 1) if narrow else (1, len(windows))
        for axes, data in zip(figure.subplots(rows, columns, squeeze=False).flat, windows, strict=True):
            _draw_window(axes, data)
        figure.supylabel("determinant", fontsize=11)
        figure.supxlabel("frequency [Hz]", fontsize=11)

    return picture(name, _draw, wide=230.0, narrow=470.0)


def _draw_window(axes: "Axes", data: "xr.Dataset") -> None:
    frequency, determinant = data["frequency"].to_numpy(), data["determinant"].to_numpy()
    axes.axhline(0.0, color=LINE, linewidth=1.0)
    axes.plot(frequency, determinant, color=BLUE, linewidth=1.4)
    low, high = frequency[[0, -1]]
    axes.set_xlim(low, high)
    size = float(np.abs(determinant).max())
    axes.set_ylim(determinant.min() - 0.08 * size, determinant.max() + 0.3 * size)
    axes.yaxis.set_major_formatter(lambda value, _: number(value, 3))
    shown = [
        (f, family)
        for f, family in zip(data["natural_frequency"].to_numpy(), data["family"].to_numpy(), strict=True)
        if low <= f <= high
    ]
    for mode, (f, family) in enumerate(shown):
        axes.plot(f, 0.0, "o", color=family_colour(family), markersize=5, zorder=3)
        if high - low < 1000.0:
            words = f"{number(f, 4)}\n{short_family(family)}"
            side = "right" if len(shown) > 1 and mode == 0 else "left"
            look = {"ha": side, "va": "bottom", "color": family_colour(family), "linespacing": 1.3}
            label(axes, words, (f, 0.0), (-3 if side == "right" else 3, 5), **look)
