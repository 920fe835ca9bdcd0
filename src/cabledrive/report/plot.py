"""A block of curves that answer to the pointer."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Series:
    """A curve of a plot.

    Attributes
    ----------
    name : str
    values : ndarray, shape (p,)
        At the points of the plot; a gap where not finite.
    colour : str, default "blue"
        Name of a colour of the page.
    dashed : bool, default False
    """

    name: str
    values: NDArray[np.float64]
    colour: str = "blue"
    dashed: bool = False


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Panel:
    """Curves over one axis.

    Attributes
    ----------
    title : str
    unit : str
        Of all curves.
    series : tuple of Series
    """

    title: str
    unit: str
    series: tuple[Series, ...]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Plot:
    """Curves that answer to the pointer: values, zoom, the data as a file.

    Attributes
    ----------
    name : str
        Anchor, unique on the page.
    alt : str
        What is seen, for whoever does not see it.
    caption : str or Markup
    points : ndarray, shape (p,)
        Ascending, common to all panels.
    along, unit : str
        What the points are, and their unit.
    panels : tuple of Panel
        One above the other.
    """

    kind: ClassVar[str] = "plot"
    name: str
    alt: str
    caption: str | Markup
    points: NDArray[np.float64]
    along: str
    unit: str
    panels: tuple[Panel, ...]

    def __post_init__(self) -> None:
        for panel in self.panels:
            for series in panel.series:
                if series.values.shape != self.points.shape:
                    raise ValueError(
                        f"{self.name}: {series.name} has shape {series.values.shape}, "
                        f"the points {self.points.shape}"
                    )
