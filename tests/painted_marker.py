"""Films of a painted marker on a cable, as the camera of section 4.1 sees it."""

from dataclasses import dataclass

import numpy as np
from scipy import special
from scipy.ndimage import gaussian_filter


@dataclass(frozen=True, kw_only=True)
class VirtualCamera:
    """A camera as in section 4.1."""

    rows: int = 160
    columns: int = 224
    frame_rate: float = 480.0  # [Hz]
    exposure: float = 0.5  # share of the time between frames with an open shutter: motion blurs the marker
    blur: float = 1.0  # deviation of the lens's blur [pixel]
    noise: float = 8.0  # deviation of a pixel's noise, of 255 levels
    clutter: int = 6  # bright spots that stand still, nine tenths of the marker at most, beside hot pixels
    marker: tuple[float, float] = (6.0, 12.0)  # height and width of the painted segment [pixel]
    contrast: float = 170.0  # grey level of the marker above the dark background


def filmed(camera, position, rng, *, column=112.3):
    """Frames of a marker, shape (rows, columns), whose middle has rows ``position``, (frames, instants)."""
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


def _box(pixels, middle, size, blur):
    """Light of a blurred bar on each pixel, integrated over the pixel, mean over the instants."""
    edges = np.concatenate([pixels - 0.5, [pixels[-1] + 0.5]])

    def ramp(x):  # integral of the blurred edge
        return np.asarray(
            0.5 * x * (1.0 + special.erf(x / (blur * 2**0.5)))
            + blur / (2 * np.pi) ** 0.5 * np.exp(-0.5 * (x / blur) ** 2)
        )

    low, high = middle[:, None] - size / 2, middle[:, None] + size / 2
    return np.diff(ramp(edges - low) - ramp(edges - high), axis=1).mean(axis=0)


def _backdrop(camera, rng):
    """Dark cable and rig: a level that changes slowly, spots that stand still, hot pixels."""
    shape = (camera.rows, camera.columns)
    light = 25.0 + 6.0 * np.linspace(0.0, 1.0, camera.columns) * np.ones(shape)
    spots = np.zeros(shape)
    for _ in range(camera.clutter):
        spots[rng.integers(4, camera.rows - 4), rng.integers(4, camera.columns - 4)] = rng.uniform(
            500.0, 2400.0
        )
    hot = (rng.random(shape) < 5e-4) * rng.uniform(100.0, 230.0, shape)
    return np.asarray(light + gaussian_filter(spots, 1.6) + hot)
