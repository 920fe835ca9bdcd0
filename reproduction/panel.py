"""Data of a figure: curves with their axes, few enough points for a page."""

import itertools
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

MOST_POINTS = 400
DIGITS = 6


@dataclass(frozen=True, slots=True, kw_only=True)
class Curve:
    """One curve.

    Attributes
    ----------
    name : str
    x, y : tuple of float
        NaN where the curve is broken.
    """

    name: str
    x: tuple[float, ...]
    y: tuple[float, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Panel:
    """One pair of axes.

    Attributes
    ----------
    figure : str
        Such as "Fig. 3.1".
    title : str
        What is shown, and what was chosen where the print is silent.
    x, y : str
        Axes with units.
    curves : tuple of Curve
    log_x, log_y : bool
    """

    figure: str
    title: str
    x: str
    y: str
    curves: tuple[Curve, ...]
    log_x: bool = False
    log_y: bool = False

    def plain(self) -> dict[str, Any]:
        """The panel as JSON gives it, null where a curve is broken."""
        data = asdict(self)
        for curve in data["curves"]:
            for axis in ("x", "y"):
                curve[axis] = [value if np.isfinite(value) else None for value in curve[axis]]
        return data


def curve(name: str, x: ArrayLike, y: ArrayLike) -> Curve:
    """A curve with at most `MOST_POINTS` points; of more, smallest and largest of each stretch.

    ``x``, ``y``, shape (n,).
    """
    across, up = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
    if across.size > MOST_POINTS:
        edges = np.linspace(0, across.size, MOST_POINTS // 2 + 1).astype(int)
        kept: list[int] = []
        for first, last in itertools.pairwise(edges):
            part = up[first:last]
            if not np.all(np.isfinite(part)):
                kept.append(first)
                continue
            kept += sorted({first + int(np.argmin(part)), first + int(np.argmax(part))})
        across, up = across[kept], up[kept]
    return Curve(name=name, x=_rounded(across), y=_rounded(up))


def _rounded(values: np.ndarray) -> tuple[float, ...]:
    return tuple(float(f"{value:.{DIGITS}g}") for value in values)


def panel_of(data: dict[str, Any]) -> Panel:
    """A panel from its plain data.

    ``data``: of `Panel.plain`.
    """

    def _values(found: list[float | None]) -> tuple[float, ...]:
        return tuple(float("nan") if value is None else value for value in found)

    curves = tuple(
        Curve(name=one["name"], x=_values(one["x"]), y=_values(one["y"])) for one in data["curves"]
    )
    return Panel(**{**data, "curves": curves})
