"""Natural modes in one picture, over figures of a machine, and over speed with their orders."""

from typing import TYPE_CHECKING, Any

import numpy as np

from cabledrive.modal import Modes
from cabledrive.modal.mode_rows import mode_rows
from cabledrive.parameters import Machine
from cabledrive.report.figures.shapes import draw_mode
from cabledrive.report.picture import TEXT, Hue, file_figure, file_picture
from cabledrive.report.words import speed_unit
from cabledrive.studies.excitation_orders import Campbell

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


MOST_ROWS = 10
"""Modes of each kind that are drawn."""
_PANEL_WIDTH, _PANEL_HEIGHT, _MARGINS = 6.4, 1.0, 1.4  # inch


def mode_figure(drive: Machine, found: Modes, *, most: int | None = None) -> "Figure":
    """Draw the lowest modes, each kind in a column, ``most`` of each, one panel each with its shape."""
    most = most or MOST_ROWS
    kinds = [mode_rows(found.longitudinal)[:most], mode_rows(found.transverse)[:most]]
    columns = [column for column in kinds if column]
    rows = max(len(column) for column in columns)

    def draw(figure: "Figure") -> None:
        figure.suptitle(drive.title or drive.name, fontsize=TEXT + 1)
        for number, column in enumerate(columns):
            for row, one in enumerate(column):
                axes = figure.add_subplot(rows, len(columns), row * len(columns) + number + 1)
                draw_mode(axes, drive, one.modes[0], last=row == len(column) - 1)

    return file_figure(draw, (_PANEL_WIDTH * len(columns), _MARGINS + _PANEL_HEIGHT * rows))


def mode_picture(drive: Machine, found: Modes, form: str, *, most: int | None = None) -> bytes:
    """The picture of a machine's modes as "svg", "png" or "pdf", the same for the same modes."""
    return file_picture(mode_figure(drive, found, most=most), form)


LINES = (Hue.RED, Hue.GREEN, Hue.PURPLE, Hue.OCHRE)
MOST_NAMES = 8


def campbell_drawing(found: Campbell, form: str) -> bytes:
    """The picture as the content of a file; ``form``, {"svg", "png", "pdf"}."""
    return file_picture(file_figure(lambda figure: draw_campbell(figure, found), (8.4, 5.2)), form)


def draw_campbell(figure: "Figure", found: Campbell) -> None:
    """Put the axes on an empty figure: a mode is the band of its frequencies over all places."""
    axes = figure.add_subplot()
    top, reached = found.covered, found.low
    for low, high in (*found.clear, (found.high, found.high)):
        axes.axvspan(reached, low, color=Hue.ORANGE, alpha=0.15, linewidth=0.0)
        axes.axvspan(low, high, ymax=0.02, color=Hue.GREEN, linewidth=0.0)
        reached = high
    speeds = np.array([found.low, found.high])
    for branch in found.branches:  # a band
        own = branch.hertz[~np.isnan(branch.hertz)]
        low, high = own.min(), min(own.max(), top)
        colour = Hue.BLUE if branch.kind == "longitudinal" else Hue.QUIET
        axes.fill_between(speeds, low, high, color=colour, alpha=0.05, linewidth=0.0)
        for edge in {low, high} - {top}:
            axes.plot(speeds, [edge, edge], color=colour, linewidth=0.7)
    for number, (name, rate) in enumerate(found.orders.items()):
        colour = LINES[number % len(LINES)]
        axes.plot(speeds, rate * speeds, color=colour, linewidth=2.0, label=f"order {name}")
    axes.set(xlim=(found.low, found.high), ylim=(0.0, top))
    unit = speed_unit(found.coordinate)
    axes.set(
        xlabel=f"speed of {found.coordinate} [{unit}]; green: clear of all modes", ylabel="frequency [Hz]"
    )
    axes.legend(frameon=False, loc="upper left")
    # Names of the heaviest modes at the right edge, pushed apart where they would overlap.
    heaviest = sorted(found.branches, key=lambda own: -own.weight)[:MOST_NAMES]
    placed = sorted((float(np.nanmin(branch.hertz)), branch.name) for branch in heaviest)
    gap, last = 0.045 * top, -np.inf
    for hertz, name in placed:
        last = max(hertz, last + gap)
        axes.annotate(
            name,
            (found.high, hertz),
            (1.04, last / top),
            textcoords="axes fraction",
            fontsize=9,
            va="center",
            arrowprops={"arrowstyle": "-", "linewidth": 0.4, "relpos": (0.0, 0.5)},
        )


_COLOURS = (Hue.BLUE, Hue.ORANGE, Hue.GREEN, Hue.PURPLE, Hue.OCHRE, Hue.RED)
_PANEL = 4.6  # inch
MOST_FIELDS = 4


def map_drawing(found: "xr.Dataset", form: str) -> bytes:
    """The drawing as the content of a file; ``form``, {"svg", "png", "pdf"}."""
    fields = 1 if len(plane_of(found)) == 1 else len(fields_of(found))
    columns = min(fields, 2)
    size = (_PANEL * columns + 1.6, _PANEL * -(-fields // columns))
    return file_picture(file_figure(lambda figure: draw_map(figure, found, columns), size), form)


def plane_of(found: "xr.Dataset") -> list[str]:
    """The dimensions that are drawn: the first one or two with more than one value."""
    dims = [str(dim) for dim in found["certified"].dims]
    return [dim for dim in dims if found.sizes[dim] > 1][:2] or dims[:1]


def fields_of(found: "xr.Dataset") -> list[tuple[str, "xr.DataArray"]]:
    """What is drawn over two figures: bodies' moves where the machine has them, else longitudinal modes."""
    dims = [str(dim) for dim in found["certified"].dims]
    rest = {dim: 0 for dim in dims if dim not in plane_of(found)}
    if "coordinate_hz" in found:
        own = [(str(c), found["coordinate_hz"].sel(coordinate=c)) for c in found["coordinate"].values]
    else:
        own = [(f"longitudinal mode {m}", found["longitudinal_hz"].sel(mode=m)) for m in found["mode"].values]
    kept = [(name, data.isel(rest)) for name, data in own if np.isfinite(data.isel(rest).values).any()]
    return kept[:MOST_FIELDS]


def draw_map(figure: "Figure", found: "xr.Dataset", columns: int) -> None:
    """Put the axes of a map on an empty figure."""
    plane = plane_of(found)
    if len(plane) == 1:
        _draw_curves(figure.add_subplot(), found, plane[0])
        return
    fields = fields_of(found)
    for number, (name, data) in enumerate(fields):
        axes = figure.add_subplot(-(-len(fields) // columns), columns, number + 1)
        _draw_field(figure, axes, name, data, plane)


def _draw_curves(axes: "Axes", found: "xr.Dataset", dim: str) -> None:
    rest = {str(d): 0 for d in found["certified"].dims if d != dim}
    x = found[dim].values
    for mode in found["mode"].values:
        own = found.sel(mode=mode).isel(rest)
        for kind, colour, width in (("transverse", Hue.QUIET, 0.8), ("longitudinal", Hue.BLUE, 1.6)):
            words = kind if mode == found["mode"].values[0] else None
            axes.plot(x, own[f"{kind}_hz"], color=colour, linewidth=width, label=words)
    for number, (name, data) in enumerate(fields_of(found) if "coordinate_hz" in found else []):
        colour = _COLOURS[(number + 1) % len(_COLOURS)]
        axes.plot(x, data.values, ":", color=colour, linewidth=2.4, label=name)
    axes.set(xlabel=_label(found, dim), ylabel="frequency [Hz]")
    axes.set_ylim(bottom=0.0)
    axes.legend(facecolor=Hue.PAPER, edgecolor="none")


def _draw_field(figure: "Figure", axes: "Axes", name: str, data: "xr.DataArray", plane: list[str]) -> None:
    values = data.transpose(plane[1], plane[0]).values
    x, y = data[plane[0]].values, data[plane[1]].values
    mesh = axes.pcolormesh(x, y, values, shading="nearest", cmap="viridis")
    if min(values.shape) > 1 and np.isfinite(values).all() and np.ptp(values) > 0.0:
        lines = axes.contour(x, y, values, 8, colors="white", linewidths=0.7)
        for text in axes.clabel(lines, fmt="%.4g", fontsize=9, colors=Hue.INK):
            text.set_bbox({"facecolor": Hue.PAPER, "edgecolor": "none", "pad": 1.0})
    bar = figure.colorbar(mesh, ax=axes)
    bar.set_label("Hz")
    axes.set(title=name, xlabel=_label(data, plane[0]), ylabel=_label(data, plane[1]))


def _label(found: Any, dim: str) -> str:
    return f"{dim} [{found[dim].attrs['units']}]"
