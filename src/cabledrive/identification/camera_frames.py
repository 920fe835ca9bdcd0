"""Frames of a camera, and the bright spots of one."""

import os
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array

Frames = Iterator[tuple[int, Array]]

VIDEOS = (".avi", ".mp4", ".mkv", ".mov", ".m4v", ".webm")
PICTURES = (".png", ".tif", ".tiff", ".bmp", ".pgm", ".jpg", ".jpeg")
LARGEST_FRAME = 2**24
"""Pixels of a frame; a larger one is refused before it is unpacked."""
MOST_FRAMES = 500_000
GREY = np.array([0.299, 0.587, 0.114])
"""Weights of red, green and blue in grey, as ITU-R BT.601 has them."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Clip:
    """Frames that can be gone through several times."""

    source: str
    frame_rate: float  # [Hz]
    # yields the number of a frame on an even grid, and the frame in grey, (rows, columns)
    frames: Callable[[], Frames]
    findings: tuple[str, ...] = ()


def open_clip(path: str | Path, frame_rate: float | None = None) -> Clip:
    """Open a video, or a folder of numbered pictures; ``frame_rate`` [Hz]: default: what the file says."""
    path = Path(path)
    if frame_rate is not None and not 0.0 < frame_rate <= 1e7:
        raise InputRefused(f"{path.name}: frame rate {frame_rate:g} Hz must lie above 0 and up to 1e7 Hz")
    if path.is_dir():
        return _pictures(path, frame_rate)
    if not path.is_file():
        raise InputRefused(f"{path}: no such file: give a video or a folder of pictures")
    if path.suffix.lower() not in VIDEOS:
        raise InputRefused(f"{path.name}: videos end in {', '.join(VIDEOS)}: give one, or a folder")
    return _video(path, frame_rate)


def grey(frame: NDArray[Any]) -> Array:
    """A frame in grey (rows, columns); refused if it is no picture."""
    if frame.ndim == 3 and frame.shape[2] in (3, 4):
        return np.asarray(frame[:, :, :3] @ GREY)
    if frame.ndim != 2:
        raise InputRefused(f"a frame of shape {frame.shape}: give rows by columns, in grey or in colour")
    return frame.astype(float)


def _pictures(folder: Path, frame_rate: float | None) -> Clip:
    files = sorted((path for path in folder.iterdir() if path.suffix.lower() in PICTURES), key=_place)
    if len(files) < 3:
        raise InputRefused(f"{folder.name}: holds {len(files)} files ({', '.join(PICTURES)}): give a video")
    if frame_rate is None:
        raise InputRefused(f"{folder.name}: pictures have no time: give the frame rate")
    places = [_place(path)[0] for path in files]
    numbered = len(set(places)) == len(places) and places[0] >= 0
    first = places[0] if numbered else 0

    def read() -> Frames:
        for k, path in enumerate(files):
            yield (places[k] - first if numbered else k), _picture(path)

    return Clip(source=folder.name, frame_rate=frame_rate, frames=read)


def _place(path: Path) -> tuple[int, str]:
    """The last number in a file's name, then the name; files are played in that order."""
    numbers = re.findall(r"\d+", path.stem)
    return (int(numbers[-1]) if numbers else -1), path.name


def _picture(path: Path) -> Array:
    from PIL import Image

    try:
        with Image.open(path) as image:
            _check_size(image.size, path.name)
            plain = image.mode in ("L", "I;16", "F")
            return grey(np.asarray(image if plain else image.convert("RGB")))
    except InputRefused:
        raise
    except Exception as error:
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise InputRefused(f"{path.name}: is no picture that can be read ({reason}): leave it out") from None


def _check_size(size: tuple[int, int], source: str) -> None:
    if size[0] * size[1] > LARGEST_FRAME:
        raise InputRefused(
            f"{source}: frames of {size[0]} x {size[1]} pixels, {LARGEST_FRAME} the most: crop them"
        )


def _opencv() -> Any:
    """OpenCV, silent: its decoder would write to standard error."""
    os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")
    try:
        import cv2
    except ImportError:
        raise InputRefused("videos need OpenCV: pip install 'cabledrive[camera]', or give pictures") from None
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
    return cv2


def _video(path: Path, frame_rate: float | None) -> Clip:
    cv2 = _opencv()
    capture = cv2.VideoCapture(str(path), cv2.CAP_FFMPEG)
    try:
        size = (int(capture.get(cv2.CAP_PROP_FRAME_WIDTH)), int(capture.get(cv2.CAP_PROP_FRAME_HEIGHT)))
        played, count = float(capture.get(cv2.CAP_PROP_FPS)), int(capture.get(cv2.CAP_PROP_FRAME_COUNT))
        if not capture.isOpened() or min(size) < 1:
            raise InputRefused(f"{path.name}: is no video that can be read: record it again or convert it")
        _check_size(size, path.name)
        if not capture.grab():
            raise InputRefused(f"{path.name}: holds no frame that can be read: record it again or convert it")
    finally:
        capture.release()
    if frame_rate is None and not 0.0 < played < 1e7:
        raise InputRefused(f"{path.name}: states no frame rate: give it")
    findings = () if frame_rate is not None else (f"frame rate {played:g} Hz as the file says",)
    return Clip(
        source=path.name,
        frame_rate=frame_rate or played,
        frames=lambda: _video_frames(path, played, count),
        findings=findings,
    )


def _video_frames(path: Path, played: float, count: int) -> Frames:
    """Each frame at its place by its time stamp, where the file has any; else one after another."""
    cv2 = _opencv()
    capture = cv2.VideoCapture(str(path), cv2.CAP_FFMPEG)
    try:
        place, first, read = -1, 0.0, 0
        while read < MOST_FRAMES:
            ready, frame = capture.read()
            if not ready:
                break
            stamp = float(capture.get(cv2.CAP_PROP_POS_MSEC)) * 1e-3 * played
            first = stamp if read == 0 else first
            place = max(place + 1, round(stamp - first)) if np.isfinite(stamp) else place + 1
            yield place, grey(frame[:, :, ::-1] if frame.ndim == 3 else frame)
            read += 1
    finally:
        capture.release()


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
    """Grey levels of a clip."""

    background: float  # median
    noise: float  # standard deviation of the noise of a pixel
    bright: float  # brightest place, mean of 3 by 3 pixels

    @property
    def threshold(self) -> float:
        """Between background and marker, and above the noise."""
        return self.background + max(HALF * (self.bright - self.background), 5.0 * self.noise)


def levels_of(frames: list[Array]) -> Levels:
    """Grey levels from a few frames (rows, columns)."""
    background = float(np.median([np.median(frame) for frame in frames]))
    steps = np.concatenate([np.diff(frame, axis=1).ravel() for frame in frames])
    noise = float(1.4826 * np.median(np.abs(steps)) / np.sqrt(2.0))
    bright = float(np.median([ndimage.uniform_filter(frame, 3).max() for frame in frames]))
    return Levels(background=background, noise=max(noise, 0.3), bright=bright)


def uncovered(frame: Array, still: Array, levels: Levels) -> Array:
    """The frame without what is bright behind the marker, from what stands there, both (rows, columns)."""
    contrast = levels.bright - levels.background
    room = np.maximum(levels.bright - still, LEAST_ROOM * contrast)
    return levels.background + contrast * (frame - still) / room


def spots_of(frame: Array, levels: Levels) -> Array:
    """The largest bright spots first, (spots, 5): row, column, area, half its height and width [pixel]."""
    labels, _ = ndimage.label(frame > levels.threshold)
    areas = np.bincount(labels.ravel())[1:]
    pieces, found = ndimage.find_objects(labels), []
    for k in (k for k in np.argsort(-areas)[:MOST_SPOTS] if areas[k] >= SMALLEST):
        rows, columns = pieces[k]
        r, c = np.nonzero(labels[pieces[k]] == k + 1)
        start = np.array([rows.start + r.mean(), columns.start + c.mean()])
        spread = np.array([max(1.0, r.std()), max(1.0, c.std())])
        place = _centroid(frame, levels.background, start, spread)
        found.append([*place, float(areas[k]), 0.5 * np.ptp(r) + 0.5, 0.5 * np.ptp(c) + 0.5])
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
