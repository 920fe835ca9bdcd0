"""Natural modes in one picture, over figures of a machine, and over speed with their orders."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from io import BytesIO
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from cabledrive.modal import Modes
from cabledrive.modal.mode import BOTH, LONGITUDINAL, TRANSVERSE
from cabledrive.modal.mode_rows import ModeRow, mode_rows
from cabledrive.parameters import Drive
from cabledrive.parameters.route import RoutedDrive
from cabledrive.report.figures.shapes import draw_mode
from cabledrive.report.picture import (
    BLUE,
    GREEN,
    LINE,
    OCHRE,
    ORANGE,
    PAPER,
    PURPLE,
    QUIET,
    RED,
    SMALL,
    TEXT,
    family_colour,
    house_style,
)
from cabledrive.studies.excitation_orders import Branch, Campbell

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


MOST_ROWS, MOST_PANELS = 10, 4
POINTS = 400
_RUNG, _BEND, _WORDS, _SHAPE = 0.07, 0.14, 0.15, 0.54  # across a panel, as shares of its width
_PANEL_WIDTH, _PANEL_HEIGHT, _ROW_HEIGHT, _MARGINS = 6.4, 3.2, 0.55, 1.4  # inch
_STYLES = ("-", "--", ":")
# A file of its own: white paper behind it, and letters as outlines, for wherever it is shown.
_FILE_STYLE: dict[Any, Any] = {
    "figure.facecolor": PAPER,
    "svg.fonttype": "path",
    "svg.hashsalt": "cabledrive",
    "pdf.fonttype": 42,
}


def mode_figure(drive: Drive, found: Modes, *, most: int = MOST_ROWS) -> "Figure":
    """Draw ``most`` frequencies of each kind as a ladder, each with its family and shape along the cable.

    The spans are laid out in a line: the upper one from drive pulley to load pulley, then the lower one back.
    """
    from matplotlib.figure import Figure

    kinds = {LONGITUDINAL: mode_rows(found.longitudinal), TRANSVERSE: mode_rows(found.transverse)}
    panels = {kind: rows for kind, rows in kinds.items() if rows}
    tallest = max(min(len(rows), most) for rows in panels.values())
    with file_style():
        size = (_PANEL_WIDTH * len(panels), _MARGINS + _ROW_HEIGHT * tallest)
        figure = Figure(figsize=size, layout="constrained")
        figure.suptitle(drive.title or drive.name, fontsize=TEXT + 1)
        for number, (kind, rows) in enumerate(panels.items()):
            _draw_panel(figure.add_subplot(1, len(panels), number + 1), drive, kind, rows, most)
    return figure


def route_mode_figure(drive: RoutedDrive, found: Modes, *, most: int = MOST_PANELS) -> "Figure":
    """Draw the lowest modes of a machine with routes on it, each kind in a column, ``most`` of each."""
    from matplotlib.figure import Figure

    kinds = [found.longitudinal[:most], [row.modes[0] for row in mode_rows(found.transverse)][:most]]
    columns = [column for column in kinds if column]
    rows = max(len(column) for column in columns)
    with file_style():
        size = (_PANEL_WIDTH * len(columns), _MARGINS + _PANEL_HEIGHT * rows)
        figure = Figure(figsize=size, layout="constrained")
        figure.suptitle(drive.title or drive.name, fontsize=TEXT + 1)
        for number, column in enumerate(columns):
            for row, mode in enumerate(column):
                draw_mode(
                    figure.add_subplot(rows, len(columns), row * len(columns) + number + 1), drive, mode
                )
    return figure


def mode_picture(drive: Drive | RoutedDrive, found: Modes, form: str, *, most: int | None = None) -> bytes:
    """The picture of a machine's modes as "svg", "png" or "pdf", the same for the same modes."""
    undated: dict[str, Any] = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}
    with file_style(), BytesIO() as file:
        if isinstance(drive, RoutedDrive):
            figure = route_mode_figure(drive, found, most=most or MOST_PANELS)
        else:
            figure = mode_figure(drive, found, most=most or MOST_ROWS)
        figure.savefig(file, format=form, dpi=150, metadata=undated.get(form))
        return file.getvalue()


@contextmanager
def file_style() -> Iterator[None]:
    """The look of the house for a file of its own, drawn inside the block."""
    import matplotlib

    with house_style():
        matplotlib.rcParams.update(_FILE_STYLE)
        yield


def _draw_panel(axes: "Axes", drive: Drive, kind: str, rows: Sequence[ModeRow], most: int) -> None:
    shown = rows[:most]
    top = 1.04 * shown[-1].frequency
    height = top / len(shown)
    hidden = f", the first {most} of {len(rows)} frequencies" if len(rows) > most else ""
    axes.set_title(f"{kind} modes{hidden}", loc="left", fontsize=TEXT)
    axes.set(xlim=(0.0, 1.0), ylim=(0.0, top), ylabel="natural frequency [Hz]", xticks=[])
    axes.spines[["right", "top", "bottom"]].set_visible(False)
    for number, row in enumerate(shown):
        middle = (number + 0.5) * height
        _draw_rung(axes, row, middle)
        _draw_shape(axes, drive, row, middle, 0.36 * height)
    _draw_pulleys(axes, drive, top)


def _draw_rung(axes: "Axes", row: ModeRow, middle: float) -> None:
    """The rung at its frequency, and a line from there to the words about it."""
    colour = family_colour(row.family)
    axes.plot([0.0, _RUNG], [row.frequency] * 2, color=colour, linewidth=2.6, solid_capstyle="butt")
    axes.plot([_RUNG, _BEND], [row.frequency, middle], color=colour, linewidth=0.7)
    axes.annotate(f"{row.frequency:.6g} Hz", (_WORDS, middle), va="bottom", weight="bold", color=colour)
    family = row.family if row.count == 1 else f"{row.family}, {row.count} modes"
    below: dict[str, Any] = {"xytext": (0, -2), "textcoords": "offset points", "va": "top"}
    axes.annotate(family, (_WORDS, middle), **below, fontsize=SMALL - 1.5)


def _draw_shape(axes: "Axes", drive: Drive, row: ModeRow, middle: float, amplitude: float) -> None:
    """The displacement along the unrolled cable, about the line of rest, to its own scale."""
    colour = family_colour(row.family)
    curves = list(_curves(drive, row))
    largest = max(float(np.max(np.abs(u))) for _, u, _ in curves)
    axes.plot([_SHAPE, 1.0], [middle, middle], color=LINE, linewidth=0.8, zorder=1)
    for s, u, style in curves:
        axes.plot(_across(drive, s), middle + amplitude * u / largest, color=colour, linestyle=style)
    for place, swing in _carriages(drive, row):
        axes.plot(
            _across(drive, place), middle + amplitude * swing / largest, "s", color=colour, markersize=3.2
        )


def _curves(drive: Drive, row: ModeRow) -> Iterator[tuple[NDArray[np.float64], NDArray[np.float64], str]]:
    """Unrolled positions [m], displacements, line style: one curve for each span and shape."""
    positions = np.linspace(0.0, drive.span_length, POINTS)
    for number, span in enumerate(drive.spans):
        mode = _on(row, span)
        if mode is not None:
            for u, style in zip(mode.shape(span, positions), _STYLES, strict=False):
                yield positions + number * drive.span_length, u, style


def _carriages(drive: Drive, row: ModeRow) -> Iterator[tuple[float, float]]:
    """Where carriages are on the unrolled cable [m], and how far they move in the first shape."""
    for number, span in enumerate(drive.spans):
        mode = _on(row, span)
        for carriage in drive.carriages_on(span) if mode is not None else ():
            shape = mode.shape(span, np.array([carriage.position]))
            yield carriage.position + number * drive.span_length, float(shape[0, 0])


def _on(row: ModeRow, span: str) -> Any:
    """The mode of a row that lives on a span: a longitudinal one, or one that sag couples, on every span."""
    return next((mode for mode in row.modes if mode.span in (None, BOTH, span)), None)


def _across(drive: Drive, s: Any) -> Any:
    return _SHAPE + (1.0 - _SHAPE) * s / (drive.span_length * len(drive.spans))


def _draw_pulleys(axes: "Axes", drive: Drive, top: float) -> None:
    """Where the pulleys are along the unrolled cable, and the names of the spans between them."""
    below: dict[str, Any] = {"xytext": (0, -4), "textcoords": "offset points", "va": "top", "color": QUIET}
    below["ha"] = "center"
    for number in range(len(drive.spans) + 1):
        x = _across(drive, number * drive.span_length)
        axes.plot([x, x], [0.0, top], color=LINE, linestyle=(0, (2, 2)), linewidth=1.0, zorder=0)
        axes.annotate("load\npulley" if number == 1 else "drive\npulley", (x, 0.0), **below)
    for number, span in enumerate(drive.spans):
        middle = _across(drive, (number + 0.5) * drive.span_length)
        axes.annotate(f"{span}\nspan", (middle, 0.0), **below)


LINES = (RED, GREEN, PURPLE, OCHRE)
MOST_NAMES = 8


def campbell_drawing(found: Campbell, form: str) -> bytes:
    """The picture as the content of a file; ``form``, {"svg", "png", "pdf"}."""
    from matplotlib.figure import Figure

    undated: dict[str, Any] = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}
    with file_style(), BytesIO() as file:
        figure = Figure(figsize=(8.4, 5.2), layout="constrained")
        draw_campbell(figure, found)
        figure.savefig(file, format=form, dpi=150, metadata=undated.get(form))
        return file.getvalue()


def draw_campbell(figure: "Figure", found: Campbell) -> None:
    """Put the axes on an empty figure: a mode is the band of its frequencies over all places."""
    axes = figure.add_subplot()
    top, reached = found.covered, found.low
    for low, high in (*found.clear, (found.high, found.high)):
        axes.axvspan(reached, low, color=ORANGE, alpha=0.15, linewidth=0.0)
        axes.axvspan(low, high, ymax=0.02, color=GREEN, linewidth=0.0)
        reached = high
    for branch in found.branches:
        _band(axes, branch, top, found)
    speeds = np.array([found.low, found.high])
    for number, (name, rate) in enumerate(found.orders.items()):
        colour = LINES[number % len(LINES)]
        axes.plot(speeds, rate * speeds, color=colour, linewidth=2.0, label=f"order {name}")
    axes.set_xlim(found.low, found.high)
    axes.set_ylim(0.0, top)
    unit = "m/s" if found.coordinate.endswith((".x", ".y")) else "rad/s"
    axes.set_xlabel(f"speed of {found.coordinate} [{unit}]; green: clear of all modes")
    axes.set_ylabel("frequency [Hz]")
    axes.legend(frameon=False, loc="upper left")
    _names(axes, found, top)


def _band(axes: "Axes", branch: Branch, top: float, found: Campbell) -> None:
    own = branch.hertz[~np.isnan(branch.hertz)]
    low, high = own.min(), min(own.max(), top)
    colour = BLUE if branch.kind == "longitudinal" else QUIET
    axes.fill_between([found.low, found.high], low, high, color=colour, alpha=0.05, linewidth=0.0)
    for edge in {low, high} - {top}:
        axes.plot([found.low, found.high], [edge, edge], color=colour, linewidth=0.7)


def _names(axes: "Axes", found: Campbell, top: float) -> None:
    """Names of the heaviest modes at the right edge, pushed apart where they would overlap."""
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
            fontsize=7,
            va="center",
            arrowprops={"arrowstyle": "-", "linewidth": 0.4, "relpos": (0.0, 0.5)},
        )


_COLOURS = (BLUE, ORANGE, GREEN, PURPLE, OCHRE, RED)
_PANEL = 4.6  # inch
MOST_FIELDS = 4


def map_drawing(found: "xr.Dataset", form: str) -> bytes:
    """The drawing as the content of a file; ``form``, {"svg", "png", "pdf"}."""
    from matplotlib.figure import Figure

    undated: dict[str, Any] = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}
    with file_style(), BytesIO() as file:
        columns = 1 if len(plane_of(found)) == 1 else min(len(fields_of(found)), 2)
        rows = 1 if columns == 1 and len(plane_of(found)) == 1 else -(-len(fields_of(found)) // columns)
        figure = Figure(figsize=(_PANEL * columns + 1.6, _PANEL * rows), layout="constrained")
        draw_map(figure, found, columns)
        figure.savefig(file, format=form, dpi=150, metadata=undated.get(form))
        return file.getvalue()


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
        first = mode == found["mode"].values[0]
        axes.plot(x, own["transverse_hz"], color=QUIET, linewidth=0.8, label="transverse" if first else None)
        axes.plot(
            x, own["longitudinal_hz"], color=BLUE, linewidth=1.6, label="longitudinal" if first else None
        )
    for number, (name, data) in enumerate(fields_of(found) if "coordinate_hz" in found else []):
        colour = _COLOURS[(number + 1) % len(_COLOURS)]
        axes.plot(x, data.values, ":", color=colour, linewidth=2.4, label=name)
    axes.set_xlabel(_label(found, dim))
    axes.set_ylabel("frequency [Hz]")
    axes.set_ylim(bottom=0.0)
    axes.legend(frameon=False)


def _draw_field(figure: "Figure", axes: "Axes", name: str, data: "xr.DataArray", plane: list[str]) -> None:
    values = data.transpose(plane[1], plane[0]).values
    x, y = data[plane[0]].values, data[plane[1]].values
    mesh = axes.pcolormesh(x, y, values, shading="nearest", cmap="viridis")
    if min(values.shape) > 1 and np.isfinite(values).all() and np.ptp(values) > 0.0:
        lines = axes.contour(x, y, values, 8, colors="white", linewidths=0.7)
        axes.clabel(lines, fmt="%.4g", fontsize=7)
    bar = figure.colorbar(mesh, ax=axes)
    bar.set_label("Hz")
    axes.set_title(name)
    axes.set_xlabel(_label(data, plane[0]))
    axes.set_ylabel(_label(data, plane[1]))


def _label(found: Any, dim: str) -> str:
    return f"{dim} [{found[dim].attrs['units']}]"
