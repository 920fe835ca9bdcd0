"""Words on horizontal lines, where no curve of the panel passes through them."""

from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from cabledrive.report.style import label

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.text import Annotation

Array = NDArray[np.float64]
CLEAR, STEP = 3.0, 4.0
"""Free room round the words, and how far they are moved at a time [px]."""


def label_lines(axes: "Axes", named: Sequence[tuple[str, float]], *, color: str) -> None:
    """Name horizontal lines, as far to the right as the curves leave room, above or else below.

    ``axes``: with its curves, limits and scales, in a figure whose layout is made; ``named``: words, and the
    height of their line.
    """
    curves = [line for line in axes.lines if line.get_transform() == axes.transData]
    taken = [drawn_points(np.column_stack(line.get_data()), axes) for line in curves]
    for words, value in named:
        heights = [height for _, height in named if height != value]
        others = [*taken, *(_along(axes, height) for height in heights)]
        taken.append(_corners(_placed(axes, words, value, color, np.vstack(others))))


def drawn_points(points: Array, axes: "Axes") -> Array:
    """A curve as dense points of the picture.

    ``points``, shape (n, 2): in the units of the axes.
    Returns shape (m, 2) [px]; what is not finite is left out.
    """
    place = axes.transData.transform(np.asarray(points, dtype=np.float64))
    share = np.linspace(0.0, 1.0, 100)[:, None]
    dense = np.vstack([a + share * (b - a) for a, b in pairwise(place)])
    return np.asarray(dense[np.isfinite(dense).all(axis=1)], dtype=np.float64)


def _along(axes: "Axes", height: float) -> Array:
    return drawn_points(np.array([[x, height] for x in axes.get_xlim()]), axes)


def _corners(text: "Annotation") -> Array:
    """The outline of words that are placed, dense enough that others keep away."""
    box = text.get_window_extent()
    grid = np.meshgrid(np.linspace(box.x0, box.x1, 30), np.linspace(box.y0, box.y1, 5))
    return np.stack(grid, axis=-1).reshape(-1, 2)


def _placed(axes: "Axes", words: str, value: float, color: str, others: Array) -> "Annotation":
    """The words where the fewest points of others lie in their box: none, if there is such a place."""
    frame, right = axes.get_window_extent(), axes.get_xlim()[1]
    best, fewest = (0.0, 0.0), None
    for lift in (2.0, -12.0):
        text = label(axes, words, (right, value), (-2.0, lift), ha="right", color=color)
        box = text.get_window_extent()
        text.remove()
        for shift in np.arange(0.0, frame.width - box.width - 2.0, STEP):
            low = np.array([box.x0 - shift - CLEAR, box.y0 - min(CLEAR, 1.0)])
            high = np.array([box.x1 - shift + CLEAR, box.y1 + CLEAR])
            inside = int(np.count_nonzero(((others > low) & (others < high)).all(axis=1)))
            if fewest is None or inside < fewest:
                best, fewest = (-2.0 - float(shift), lift), inside
    return label(axes, words, (right, value), best, ha="right", color=color)
