"""Bright spots of one frame: grey, threshold, unwanted pixels removed, centroid, Fig. 4.6."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

Array = NDArray[np.float64]

MOST_SPOTS = 10
SMALLEST = 4
"""Pixels of a spot; smaller ones are unwanted."""
STANDS_OUT = 8.0
"""A marker is this many deviations of the noise above the background."""
HALF = 0.45
"""Threshold between background and marker."""
LEAST_ROOM = 0.35
"""Contrast that must be left over a bright background, as a share of that over the dark one."""
PASSES = 8
EDGE = 2.5
"""How far a window reaches beyond its spot [pixel]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Levels:
    """Grey levels of a clip.

    Attributes
    ----------
    background : float
        Median.
    noise : float
        Standard deviation of the noise of a pixel.
    bright : float
        Brightest place, mean of 3 by 3 pixels.
    """

    background: float
    noise: float
    bright: float

    @property
    def threshold(self) -> float:
        """Between background and marker, and above the noise."""
        return self.background + max(HALF * (self.bright - self.background), 5.0 * self.noise)

    @property
    def marked(self) -> bool:
        """Whether anything stands out."""
        return self.bright - self.background > STANDS_OUT * max(self.noise, 1e-6)


def levels_of(frames: list[Array]) -> Levels:
    """Grey levels from a few frames.

    ``frames``, shape (rows, columns).
    """
    background = float(np.median([np.median(frame) for frame in frames]))
    steps = np.concatenate([np.diff(frame, axis=1).ravel() for frame in frames])
    noise = float(1.4826 * np.median(np.abs(steps)) / np.sqrt(2.0))
    bright = float(np.median([ndimage.uniform_filter(frame, 3).max() for frame in frames]))
    return Levels(background=background, noise=max(noise, 0.3), bright=bright)


def uncovered(frame: Array, still: Array, levels: Levels) -> Array:
    """The frame as it would be with nothing bright behind the marker, which hides what it covers.

    ``frame``, ``still``, shape (rows, columns): with the marker, and without it.
    Returns shape (rows, columns).
    """
    contrast = levels.bright - levels.background
    room = np.maximum(levels.bright - still, LEAST_ROOM * contrast)
    return levels.background + contrast * (frame - still) / room


def spots_of(frame: Array, levels: Levels) -> Array:
    """Bright spots of a frame, the largest first.

    ``frame``, shape (rows, columns).
    Returns shape (spots, 5): row and column of the centroid, from the middle of the first pixel, area, half
    its height and width [pixel].
    """
    labels, count = ndimage.label(frame > levels.threshold)
    if count == 0:
        return np.empty((0, 5))
    areas = np.bincount(labels.ravel())[1:]
    order = [k for k in np.argsort(-areas)[:MOST_SPOTS] if areas[k] >= SMALLEST]
    pieces = ndimage.find_objects(labels)
    found = []
    for k in order:
        rows, columns = pieces[k]
        inside = labels[pieces[k]] == k + 1
        r, c = np.nonzero(inside)
        start = np.array([rows.start + r.mean(), columns.start + c.mean()])
        spread = np.array([max(1.0, r.std()), max(1.0, c.std())])
        found.append(
            [
                *_centroid(frame, levels.background, start, spread),
                float(areas[k]),
                0.5 * np.ptp(r) + 0.5,
                0.5 * np.ptp(c) + 0.5,
            ]
        )
    return np.array(found) if found else np.empty((0, 5))


def _centroid(frame: Array, background: float, start: Array, spread: Array) -> Array:
    """Centroid of the grey above the background in a window with soft edges that moves along with it.

    Inside, the window weighs all pixels alike, since a marker that is smeared unevenly by its motion has its
    mean place in the plain centroid; its edges are soft, so that no pixel enters or leaves at once.
    """
    half = 3.0**0.5 * spread + EDGE
    reach = np.ceil(half + 2.0).astype(int)
    corner = np.maximum(np.rint(start).astype(int) - reach, 0)
    end = np.minimum(np.rint(start).astype(int) + reach + 1, frame.shape)
    part = frame[corner[0] : end[0], corner[1] : end[1]] - background
    rows = np.arange(corner[0], end[0], dtype=np.float64)
    columns = np.arange(corner[1], end[1], dtype=np.float64)
    place = start
    for _ in range(PASSES):
        down = np.exp(-(((rows - place[0]) / half[0]) ** 8))
        along = np.exp(-(((columns - place[1]) / half[1]) ** 8))
        light = down @ part, part @ along
        total = float(light[0] @ along)
        if total <= 0.0:
            return start
        seen = np.array([(light[1] * down) @ rows, (light[0] * along) @ columns]) / total
        moved, place = float(np.abs(seen - place).max()), seen
        if moved > reach.max():
            return start
        if moved < 1e-3:
            break
    return place
