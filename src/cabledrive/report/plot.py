"""A block of curves that answer to the pointer."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Series:
    """A curve of a plot."""

    name: str
    values: NDArray[np.float64]  # (p,): at the points of the plot; a gap where not finite
    colour: str = "blue"  # name of a colour of the page
    dashed: bool = False


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Panel:
    """Curves over one axis."""

    title: str
    unit: str  # of all curves
    series: tuple[Series, ...]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Plot:
    """Curves that answer to the pointer: values, zoom, the data as a file."""

    kind: ClassVar[str] = "plot"
    name: str  # anchor, unique on the page
    alt: str  # what is seen, for whoever does not see it
    caption: str | Markup
    points: NDArray[np.float64]  # (p,): ascending, common to all panels
    along: str  # what the points are
    unit: str  # of the points
    panels: tuple[Panel, ...]  # one above the other

    def __post_init__(self) -> None:
        for panel in self.panels:
            for series in panel.series:
                if series.values.shape != self.points.shape:
                    raise ValueError(
                        f"{self.name}: {series.name} has shape {series.values.shape}, "
                        f"the points {self.points.shape}"
                    )
