"""A virtual high-speed camera: a white marker on a black cable, blurred, noisy, amid clutter."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import special

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class VirtualCamera:
    """A camera as in section 4.1.

    Attributes
    ----------
    rows, columns : int
        Of a frame.
    frame_rate : float
        [Hz].
    exposure : float
        Share of the time between frames during which the shutter is open: motion blurs the marker.
    blur : float
        Deviation of the lens's blur [pixel].
    noise : float
        Deviation of a pixel's noise, of 255 levels.
    clutter : int
        Bright spots that stand still, at most nine tenths as bright as the marker, beside hot pixels.
    marker : (float, float)
        Height and width of the painted segment [pixel].
    contrast : float
        Grey level of the marker above the dark background; it hides what is behind it.
    """

    rows: int = 160
    columns: int = 224
    frame_rate: float = 480.0
    exposure: float = 0.5
    blur: float = 1.0
    noise: float = 8.0
    clutter: int = 6
    marker: tuple[float, float] = (6.0, 12.0)
    contrast: float = 170.0


def filmed(
    camera: VirtualCamera, position: Array, rng: np.random.Generator, *, column: float = 112.3
) -> Iterator[NDArray[np.uint8]]:
    """Frames of a marker that moves up and down.

    Parameters
    ----------
    camera : VirtualCamera
    position : ndarray, shape (frames, instants)
        Row of the marker's middle at instants spread evenly over the exposure of each frame [pixel].
    rng : Generator
        Draws the clutter and every frame's noise.
    column : float, default 112.3
        Column of the marker's middle [pixel].

    Yields
    ------
    ndarray of uint8, shape (rows, columns)
        One frame after another.
    """
    backdrop = _backdrop(camera, rng)
    across = _box(
        np.arange(camera.columns, dtype=np.float64), np.array([column]), camera.marker[1], camera.blur
    )
    rows = np.arange(camera.rows, dtype=np.float64)
    for instants in np.atleast_2d(position):
        down = _box(rows, instants, camera.marker[0], camera.blur)
        cover = np.outer(down, across)
        frame = backdrop * (1.0 - cover) + (25.0 + camera.contrast) * cover
        frame = frame + camera.noise * rng.normal(size=frame.shape)
        yield np.clip(np.rint(frame), 0, 255).astype(np.uint8)


def _box(pixels: Array, middle: Array, size: float, blur: float) -> Array:
    """Light of a blurred bar on each pixel, integrated over the pixel, mean over the instants."""
    edges = np.concatenate([pixels - 0.5, [pixels[-1] + 0.5]])

    def ramp(x: Array) -> Array:  # integral of the blurred edge
        return np.asarray(
            0.5 * x * (1.0 + special.erf(x / (blur * 2**0.5)))
            + blur / (2 * np.pi) ** 0.5 * np.exp(-0.5 * (x / blur) ** 2)
        )

    low, high = middle[:, None] - size / 2, middle[:, None] + size / 2
    return np.diff(ramp(edges - low) - ramp(edges - high), axis=1).mean(axis=0)


def _backdrop(camera: VirtualCamera, rng: np.random.Generator) -> Array:
    """Dark cable and rig: a level that changes slowly, spots that stand still, hot pixels."""
    from scipy.ndimage import gaussian_filter

    shape = (camera.rows, camera.columns)
    light = 25.0 + 6.0 * np.linspace(0.0, 1.0, camera.columns) * np.ones(shape)
    spots = np.zeros(shape)
    for _ in range(camera.clutter):
        spots[rng.integers(4, camera.rows - 4), rng.integers(4, camera.columns - 4)] = rng.uniform(
            500.0, 2400.0
        )
    hot = (rng.random(shape) < 5e-4) * rng.uniform(100.0, 230.0, shape)
    return np.asarray(light + gaussian_filter(spots, 1.6) + hot)
