"""Pictures of frequencies: modes followed along a quantity, of several machines, a measured response."""

from collections.abc import Sequence
from math import log10
from typing import TYPE_CHECKING, Any

import numpy as np
from markupsafe import Markup

from cabledrive.answers.figures import number
from cabledrive.identification.signals import FrequencyResponse
from cabledrive.modal import Modes
from cabledrive.parameters.arrays import Array
from cabledrive.report.picture import Hue, family_colour, label, log_axis, picture, short_family

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
    across: bool = True,
) -> Markup:
    """Draw the curves of `cabledrive.studies.frequency_against`, named where they end, crossings marked.

    The horizontal axis is ``quantity`` in ``unit``, ``scale`` SI units in one; ``here``: value of the drive
    itself [SI], marked; ``across``: whether the lowest transverse mode is drawn as well.
    """
    values = data["value"].to_numpy() / scale

    def _draw(figure: "Figure") -> None:
        axes = figure.add_subplot()
        axes.set_yscale("log")
        ends = [_draw_curve(axes, values, data, curve) for curve in range(data.sizes["mode"])]
        if across:
            ends.append(_draw_across(axes, values, data, unit))
        _draw_crossings(axes, data, scale, unit)
        axes.set_xlim(values[0], values[-1])
        log_axis(axes, "x", 560.0)
        log_axis(axes, "y", HEIGHT - 60.0)
        axes.set(xlabel=f"{quantity} [{unit}]" if unit else quantity, ylabel="frequency [Hz]")
        if here is not None:
            axes.axvline(here / scale, color=Hue.QUIET, linewidth=1.0, dashes=(2, 3), zorder=0)
            foot = ("data", "axes fraction")
            label(axes, "this drive", (here / scale, 0.0), (4, 5), xycoords=foot, color=Hue.QUIET)
        _name_ends(axes, ends)

    return picture(name, _draw, height=HEIGHT)


def _draw_across(axes: "Axes", x: Array, data: "xr.Dataset", unit: str) -> tuple[float, str, str]:
    """The lowest mode across the cable, and where it is half the lowest along it."""
    across, along = data["lowest_transverse"].to_numpy(), data["frequency"].to_numpy().min(axis=0)
    axes.plot(x, across, color=Hue.INK, dashes=(5, 3))
    ratio = np.log(across / along)
    if np.all(np.diff(ratio) > 0.0) and ratio[0] < -np.log(2.0) < ratio[-1]:
        place, height = (np.exp(np.interp(-np.log(2.0), ratio, np.log(y))) for y in (x, across))
        axes.plot(place, height, "o", markersize=11, markerfacecolor="none", markeredgecolor=Hue.INK)
        words = f"half the lowest longitudinal: {number(place, 3)} {unit}"
        label(axes, words, (place, height), (-10, 6), ha="right")
    return float(across[-1]), "lowest transverse", Hue.INK


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
        ring: dict[str, Any] = {"markerfacecolor": "none", "markeredgecolor": Hue.INK, "markeredgewidth": 1}
        axes.plot(value, frequency, "o", markersize=13, **ring)
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


_ROW, _FOOT = 27.0, 72.0  # heights [px]


def overview_picture(name: str, machines: Sequence[str], all_modes: Sequence[Modes]) -> Markup:
    """Draw the lowest frequency of each kind for every machine, machines in order of the first."""
    rows = [(machine, lowest(modes)) for machine, modes in zip(machines, all_modes, strict=True)]
    rows.sort(key=lambda row: row[1])

    def _draw(figure: "Figure") -> None:
        axes = figure.add_subplot()
        widest = max(rows, key=lambda row: max(row[1]) / min(row[1]))
        for place, row in enumerate(rows):
            _draw_row(axes, place, row[1], named=row is widest)
        values = [value for _, pair in rows for value in pair]
        room = (max(values) / min(values)) ** 0.25  # for what stands beside the outermost marks
        axes.set_xlim(min(values) / max(room, 3.4), max(values) * max(room**0.56, 2.6))
        log_axis(axes, "x", 560.0)
        axes.set(xlabel="frequency [Hz]", ylim=(len(rows) - 0.4, -0.9))
        axes.spines["left"].set_visible(False)
        axes.set_yticks(range(len(rows)), [machine for machine, _ in rows])
        axes.tick_params(axis="y", length=0)

    return picture(name, _draw, height=_ROW * len(rows) + _FOOT)


def lowest(modes: Modes) -> tuple[float, float]:
    """Lowest frequency along the cable and across it. Returns ``along, across`` [Hz]."""
    return modes.longitudinal[0].frequency, modes.transverse[0].frequency


def _draw_row(axes: "Axes", place: float, pair: tuple[float, float], *, named: bool) -> None:
    """One machine; in the row where there is most room the two marks are named."""
    along, across = pair
    axes.hlines(place, min(along, across), max(along, across), color=Hue.LINE, linewidth=1.2)
    axes.plot(along, place, "o", color=Hue.BLUE, markersize=7)
    axes.plot(across, place, "D", color=Hue.ORANGE, markersize=6)
    for value, colour, word in ((along, Hue.BLUE, "along"), (across, Hue.ORANGE, "across")):
        words = [number(value, 3), word] if named else [number(value, 3)]
        side = 1 if value == max(pair) else -1
        looks = {"ha": "left" if side > 0 else "right", "va": "center", "color": colour}
        label(axes, "  ".join(words[::side]), (value, place), (8 * side, 0), **looks)


def measured_picture(
    name: str, measured: FrequencyResponse, model: tuple[np.ndarray, np.ndarray] | None, unit: str
) -> Markup:
    """A measured response with its 95 % band, and a model's, at frequencies [Hz], where there is one."""
    low = np.maximum(measured.magnitude - 2 * measured.deviation, 0.3 * measured.magnitude)
    high = measured.magnitude + 2 * measured.deviation

    def _draw(figure: "Figure") -> None:
        above, below = figure.subplots(2, 1, sharex=True, gridspec_kw={"height_ratios": [1.6, 1]})
        above.fill_between(measured.frequency, low, high, color=Hue.BLUE, alpha=0.18, linewidth=0)
        above.plot(measured.frequency, measured.magnitude, color=Hue.BLUE, linewidth=1.0)
        below.plot(measured.frequency, measured.phase, color=Hue.BLUE, linewidth=1.0)
        if model is not None:
            above.plot(model[0], np.abs(model[1]), "--", color=Hue.INK, linewidth=1.2)
            below.plot(model[0], np.degrees(np.angle(model[1])), "--", color=Hue.INK, linewidth=1.2)
        below.set_xlim(float(measured.frequency[0]), float(measured.frequency[-1]))
        log_axis(below, "x", 600.0)
        above.set_ylim(low.min(), high.max())
        log_axis(above, "y", 170.0)
        above.set(ylabel=unit, title="blue: measured, 95 % band; dashed: model")
        below.set(
            ylim=(-190.0, 190.0),
            yticks=(-180, -90, 0, 90, 180),
            ylabel="phase [deg]",
            xlabel="frequency [Hz]",
        )

    return picture(name, _draw, height=330.0)
