"""Frequencies against one quantity of the drive, each curve a mode followed by its shape."""

from math import log10
from typing import TYPE_CHECKING

import numpy as np

from cabledrive.parameters.arrays import Array
from cabledrive.report.numbers import number
from cabledrive.report.picture import Picture, picture
from cabledrive.report.style import INK, QUIET, family_colour, label, log_axis, short_family

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


HEIGHT = 330.0  # px


def followed_picture(
    name: str,
    data: "xr.Dataset",
    quantity: str,
    *,
    unit: str = "",
    scale: float = 1.0,
    here: float | None = None,
    logarithmic: bool = True,
    across: bool = True,
) -> Picture:
    """Draw the curves of `cabledrive.studies.frequency_against`, named where they end, crossings marked.

    The horizontal axis is ``quantity`` in ``unit``, ``scale`` SI units in one; ``here``: value of the drive
    itself [SI], marked; ``across``: whether the lowest transverse mode is drawn as well.
    """
    values = data["value"].to_numpy() / scale

    def _draw(figure: "Figure", narrow: bool) -> None:
        axes = figure.add_subplot()
        axes.set_yscale("log")
        ends = [_draw_curve(axes, values, data, curve) for curve in range(data.sizes["mode"])]
        if across:
            ends.append(_draw_across(axes, values, data, unit, narrow))
        _draw_crossings(axes, data, scale, "" if narrow else unit)
        axes.set_xlim(values[0], values[-1])
        if logarithmic:
            log_axis(axes, "x", 230.0 if narrow else 560.0)
        log_axis(axes, "y", HEIGHT - 60.0)
        axes.set_xlabel(f"{quantity} [{unit}]" if unit else quantity)
        axes.set_ylabel("frequency [Hz]")
        if here is not None:
            axes.axvline(here / scale, color=QUIET, linewidth=1.0, dashes=(2, 3), zorder=0)
            foot = ("data", "axes fraction")
            label(axes, "this drive", (here / scale, 0.0), (4, 5), xycoords=foot, color=QUIET)
        _name_ends(axes, ends)

    return picture(name, _draw, wide=HEIGHT, narrow=HEIGHT)


def _draw_across(
    axes: "Axes", x: Array, data: "xr.Dataset", unit: str, narrow: bool
) -> tuple[float, str, str]:
    """The lowest mode across the cable, and where it is half the lowest along it."""
    across, along = data["lowest_transverse"].to_numpy(), data["frequency"].to_numpy().min(axis=0)
    axes.plot(x, across, color=INK, dashes=(5, 3))
    ratio = np.log(across / along)
    if np.all(np.diff(ratio) > 0.0) and ratio[0] < -np.log(2.0) < ratio[-1]:
        place, height = (np.exp(np.interp(-np.log(2.0), ratio, np.log(y))) for y in (x, across))
        axes.plot(place, height, "o", markersize=11, markerfacecolor="none", markeredgecolor=INK)
        words = (
            f"1:2 at {number(place, 3)} {unit}"
            if narrow
            else f"half the lowest longitudinal: {number(place, 3)} {unit}"
        )
        label(axes, words, (place, height), (-10, 6), ha="right")
    return float(across[-1]), "across" if narrow else "lowest transverse", INK


def _draw_curve(axes: "Axes", x: Array, data: "xr.Dataset", curve: int) -> tuple[float, str, str]:
    """A curve in the colours of its families, which may change on the way; its end and name there."""
    frequency = data["frequency"].to_numpy()[curve]
    families = data["family"].to_numpy()[curve]
    starts = np.flatnonzero(np.concatenate(([True], families[1:] != families[:-1])))
    for start, stop in zip(starts, [*starts[1:], families.size - 1], strict=True):
        axes.plot(x[start : stop + 1], frequency[start : stop + 1], color=family_colour(families[start]))
    return frequency[-1], short_family(families[-1]), family_colour(families[-1])


def _draw_crossings(axes: "Axes", data: "xr.Dataset", scale: float, unit: str) -> None:
    """A ring where two curves come together; its place in words where there is room for them."""
    for kind, value, frequency in zip(
        data["crossing_kind"].to_numpy(),
        data["crossing_value"].to_numpy() / scale,
        data["crossing_frequency"].to_numpy(),
        strict=True,
    ):
        axes.plot(
            value,
            frequency,
            "o",
            markersize=13,
            markerfacecolor="none",
            markeredgecolor=INK,
            markeredgewidth=1,
        )
        words = f"{kind} at {number(value, 3)} {unit}" if unit else kind
        label(axes, words, (value, frequency), (0, 10), ha="center")


def _name_ends(axes: "Axes", ends: list[tuple[float, str, str]]) -> None:
    """Names beside the right ends of the curves, moved apart where they would lie on one another."""
    low, high = (log10(limit) for limit in axes.get_ylim())
    step = 14.0 / (HEIGHT - 60.0) * (high - low)
    floor = -np.inf
    for frequency, words, colour in sorted(ends):
        place = max(log10(frequency), floor + step)
        floor = place
        beside = ("axes fraction", "data")
        look = {"va": "center", "color": colour, "annotation_clip": False}
        label(axes, words, (1.0, 10**place), (6, 0), xycoords=beside, **look)
