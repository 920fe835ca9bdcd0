"""Figures 3.3 to 3.5: fundamental shapes, and which modes turn the pulleys."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from cabledrive.parameters import load_drive
from reproduction.item import DIFFERS, Item, Outcome, outcome, place
from reproduction.judge import claimed
from reproduction.panel import Panel, curve
from reproduction.shapes import mode_shapes

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

SHAPE_DIFFERS = (DIFFERS, "not explained")


def shapes(quick: bool) -> Outcome:
    """Figs. 3.3 to 3.5: fundamental shapes are spring-like, and which of the modes turn the pulleys.

    ``quick``: changes nothing here.
    """
    items: list[Item] = []
    panels: list[Panel] = []
    for number, figure in ((1, "3.3"), (2, "3.4")):
        data = mode_shapes(load_drive(f"dissertation-{number}"), modes=2)
        items.append(_spring_like(number, figure, data))
        panels.append(shape_panel(f"Fig. {figure}", data, 0))
        if number == 1:
            items += _phases(data)
            panels += [shape_panel("Fig. 3.5", data, mode) for mode in (0, 1)]
    return outcome(items, panels)


def spans_of(data: "xr.Dataset", mode: int) -> dict[str, Array]:
    """Shape of each span.

    ``data``: of `reproduction.shapes.mode_shapes`.
    """
    shape = data["displacement"].isel(mode=mode)
    return {str(span): shape.sel(span=span).to_numpy() for span in data["span"].to_numpy()}


def _spring_like(number: int, figure: str, data: "xr.Dataset") -> Item:
    bend = 0.0
    for shape in spans_of(data, 0).values():
        x = np.linspace(0.0, 1.0, shape.size)
        line = shape[0] + (shape[-1] - shape[0]) * x
        bend = max(bend, float(np.max(np.abs(shape - line)) / np.ptp(shape)))
    return claimed(
        f"figure-{figure.replace('.', '-')}",
        f"Fig. {figure}: fundamental shapes of configuration {number}",
        "consistent with a spring-like behaviour of the two spans",
        f"largest distance from a straight line {100 * bend:.2g} % of the stroke",
        bend < 0.05,
        otherwise=SHAPE_DIFFERS,
    )


def _phases(data: "xr.Dataset") -> list[Item]:
    items = []
    for mode, letter, words in ((0, "a", "require rotation of the pulleys"), (1, "b", "do not require it")):
        upper = spans_of(data, mode)["upper"]
        rim = float(max(abs(upper[0]), abs(upper[-1])) / np.max(np.abs(upper)))
        turns = rim > 1e-6
        items.append(
            claimed(
                f"figure-3-5-{letter}",
                f"Fig. 3.5({letter}): {'out-of-phase' if mode == 0 else 'in-phase'} mode",
                words,
                f"rims move {rim:.2g} of the largest displacement, at {float(data['frequency'][mode]):.2f} "
                "Hz",
                turns == (mode == 0),
                otherwise=SHAPE_DIFFERS,
                note=""
                if mode == 0
                else f"it is the second mode, not in Table 3.2. {place('erratum-table-3-2-in-phase')}",
            )
        )
    return items


def shape_panel(figure: str, data: "xr.Dataset", mode: int) -> Panel:
    """Shape of both spans as a panel.

    ``data``: of `reproduction.shapes.mode_shapes`.
    """
    found = spans_of(data, mode)
    return Panel(
        figure=figure,
        title=f"Normalised shape at {float(data['frequency'][mode]):.2f} Hz",
        x="position over span length",
        y="displacement",
        curves=tuple(curve(name, np.linspace(0, 1, shape.size), shape) for name, shape in found.items()),
    )
