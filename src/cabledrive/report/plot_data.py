"""A plot as the page's script reads it: curves as 32-bit numbers, and the library that draws them."""

import base64
import json
from importlib import resources

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from cabledrive.report.plot import Plot

_UPLOT = resources.files("cabledrive.report") / "vendor" / "uplot"


def plot_json(plot: Plot) -> Markup:
    """Names, units, colours and curves of a plot, fit for a script element."""
    data = {
        "name": plot.name,
        "x": {"name": plot.along, "unit": plot.unit, "values": _packed(plot.points)},
        "panels": [
            {
                "title": panel.title,
                "unit": panel.unit,
                "series": [
                    {"name": s.name, "colour": s.colour, "dashed": s.dashed, "values": _packed(s.values)}
                    for s in panel.series
                ],
            }
            for panel in plot.panels
        ],
    }
    # "<" ends no element from inside a string, whatever a drive file calls its parts
    return Markup(json.dumps(data, ensure_ascii=False).replace("<", "\\u003c"))


def _packed(values: NDArray[np.float64]) -> str:
    return base64.urlsafe_b64encode(np.asarray(values, dtype="<f4").tobytes()).decode("ascii")


def library() -> tuple[str, str]:
    """The script and the style of uPlot, its licence in front of the script."""
    licence = (_UPLOT / "LICENSE").read_text(encoding="utf-8").strip()
    script = (_UPLOT / "uPlot.iife.min.js").read_text(encoding="utf-8")
    return f"/*! uPlot 1.6.32\n{licence}\n*/\n{script}", (_UPLOT / "uPlot.min.css").read_text(
        encoding="utf-8"
    )
