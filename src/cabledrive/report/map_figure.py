"""Natural frequencies over figures of a machine, drawn: curves over one figure, fields over two."""

from io import BytesIO
from typing import TYPE_CHECKING, Any

import numpy as np

from cabledrive.report.mode_figure import file_style
from cabledrive.report.style import BLUE, GREEN, OCHRE, ORANGE, PURPLE, QUIET, RED

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

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
