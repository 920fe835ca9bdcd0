"""The marker among the bright spots of a clip, and its track as a log in metres."""

from dataclasses import dataclass, replace
from math import hypot

import numpy as np

from cabledrive.identification.camera_frames import STANDS_OUT, Clip, Levels, levels_of, spots_of, uncovered
from cabledrive.identification.logs.log import Log, log_of
from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array, Integers

SAMPLED = 32
LASTING = 0.5
"""Share of the frames in which a spot must be seen to be a marker."""
MOVING = 0.15
"""Motion of a spot [pixel] above which it is a marker."""
SHARE = 0.25
"""The same, as a share of the largest motion."""
FURTHEST = 40.0
"""Jump between neighbouring frames [pixel] at which a spot is another one."""
CLEARS = 0.6
"""Deviation of a marker's place, over half its size, above which what is behind it is seen at times."""
MOST_PIXELS = 2**24
"""Of frames that are held together."""
MARGIN = 3.5
"""Beyond a marker's edge, where its blurred light still falls [pixel]."""
LEAST_SEEN = 3
UNLIKE = 1.4
"""Logarithm of the ratio of areas from which spots are not the same."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MarkerTrack:
    """Where the markers are in each frame."""

    source: str
    frame_rate: float  # [Hz]
    place: Integers  # (frames,): number of each frame on an even grid; one that is left out was dropped
    # rows, columns: (frames, markers), down and right of the first pixel's middle [pixel]; NaN where lost
    rows: Array
    columns: Array
    findings: tuple[str, ...] = ()


def track_marker(
    clip: Clip, *, markers: int = 1, region: tuple[int, int, int, int] | None = None
) -> MarkerTrack:
    """Follow a white marker on a dark background, or several; refused if none is found, or more move.

    Where it moves enough to show what is behind it, that is taken off and the clip gone through once more.
    ``region``: first and last row, first and last column to look at [pixel].
    """
    if region is not None:
        a, b, c, d = region
        if not (0 <= a < b and 0 <= c < d):
            raise InputRefused(f"region {region}: give first and last row, first and last column")
        whole = clip.frames
        clip = replace(clip, frames=lambda: ((k, frame[a:b, c:d]) for k, frame in whole()))
    levels = levels_of([frame for _, frame in _sampled(clip)])
    if not levels.bright - levels.background > STANDS_OUT * max(levels.noise, 1e-6):
        raise InputRefused(
            f"{clip.source}: no marker: nothing is {STANDS_OUT:g} deviations of the noise above the "
            "background: light it, or paint it white"
        )
    place, spots, repeated = _go_through(clip, levels, None)
    chosen, moving = _movers(clip.source, spots, markers)
    # those that move by enough of their own size, height and width, show what is behind them
    sizes = [CLEARS * np.nanmedian(track[:, 3:], axis=0) for track in chosen]
    if any(np.any(np.nanstd(t[:, :2], axis=0) > size) for t, size in zip(chosen, sizes, strict=True)):
        place, spots, repeated = _go_through(clip, levels, _still(clip, levels, place, chosen))
        chosen, moving = _movers(clip.source, spots, markers)
    if moving > markers:
        raise InputRefused(f"{clip.source}: {moving} markers move, {markers} wanted: give a region")
    found = np.stack(chosen, axis=1)
    found = found[:, np.argsort(np.nanmedian(found[:, :, 0], axis=0))]
    top, left = (region[0], region[2]) if region else (0, 0)
    return MarkerTrack(
        source=clip.source,
        frame_rate=clip.frame_rate,
        place=place,
        rows=found[:, :, 0] + top,
        columns=found[:, :, 1] + left,
        findings=(*clip.findings, *_findings(place, found[:, :, 0], repeated)),
    )


def _sampled(clip: Clip, count: int = SAMPLED) -> list[tuple[int, Array]]:
    """Frames from all over the clip with their numbers, few enough for memory."""
    kept: list[tuple[int, Array]] = []
    every = 1
    for number, (place, frame) in enumerate(clip.frames()):
        count = min(count, max(4, MOST_PIXELS // max(1, frame.size)))
        if number % every == 0:
            kept.append((place, frame))
            if len(kept) == 2 * count:
                kept, every = kept[::2], 2 * every
    if len(kept) < 3 or min(kept[0][1].shape) < 8:
        raise InputRefused(f"{clip.source}: holds {len(kept)} frames: at least 3 of 8 by 8 pixels are needed")
    return kept


def _still(clip: Clip, levels: Levels, place: Integers, markers: list[Array]) -> Array:
    """What stands in the picture: the median of each pixel while no marker is near it."""
    frames = []
    for number, frame in _sampled(clip, 4 * SAMPLED):
        at = int(np.searchsorted(place, number))
        if at == place.size or place[at] != number or not all(np.isfinite(m[at, 0]) for m in markers):
            continue
        kept = np.array(frame)
        for marker in markers:
            row, column, _, high, wide = marker[at]
            top, left = max(0, int(row - high - MARGIN)), max(0, int(column - wide - MARGIN))
            kept[top : int(row + high + MARGIN) + 1, left : int(column + wide + MARGIN) + 1] = np.nan
        frames.append(kept)
    seen = np.array(frames) if frames else np.full((1, 1, 1), np.nan)
    often = np.isfinite(seen).sum(axis=0) >= min(LEAST_SEEN, len(frames))
    filled = np.where(often, seen, levels.background)
    return np.asarray(np.nanmedian(filled, axis=0))


def _go_through(clip: Clip, levels: Levels, still: Array | None) -> tuple[Integers, list[Array], int]:
    """Spots of every frame; a frame that repeats the one before it is a dropped one."""
    place, spots, repeated = [], [], 0
    before: Array | None = None
    for number, frame in clip.frames():
        if before is not None and frame.shape == before.shape and np.array_equal(frame, before):
            repeated += 1
            continue
        before = frame
        place.append(number)
        spots.append(spots_of(frame if still is None else uncovered(frame, still, levels), levels))
    return np.array(place, dtype=np.int64), spots, repeated


def _linked(spots: list[Array]) -> list[Array]:
    """Spots joined to tracks, each to the nearest end of one of about its size; NaN where there is none."""
    tracks: list[Array] = []
    last = np.empty((0, 3))
    for number, seen in enumerate(spots):
        free = list(range(len(seen)))
        if len(last) and free:
            distance = np.linalg.norm(last[:, None, :2] - seen[None, :, :2], axis=2)
            distance[np.abs(np.log(seen[None, :, 2] / last[:, None, 2])) > UNLIKE] = np.inf
            for flat in np.argsort(distance, axis=None):
                track, spot = divmod(int(flat), len(seen))
                open_ = spot in free and not np.isfinite(tracks[track][number, 0])
                if open_ and distance[track, spot] <= FURTHEST:
                    tracks[track][number], last[track] = seen[spot], seen[spot, :3]
                    free.remove(spot)
        for spot in free:
            if len(tracks) < 400:
                track_rows = np.full((len(spots), 5), np.nan)
                track_rows[number] = seen[spot]
                tracks.append(track_rows)
                last = np.vstack([last, seen[spot, :3]])
    return tracks


def _movers(source: str, spots: list[Array], markers: int) -> tuple[list[Array], int]:
    """The tracks that move most, of those that last, and how many of these move."""
    lasting = [track for track in _linked(spots) if np.isfinite(track[:, 0]).mean() > LASTING]
    if len(lasting) < markers:
        raise InputRefused(
            f"{source}: no marker: {len(lasting)} bright spots last through half of {len(spots)} frames, "
            f"{markers} wanted: light it, or slow its motion below {FURTHEST:g} pixels per frame"
        )
    motions = np.array([np.hypot(*np.nanstd(track[:, :2], axis=0)) for track in lasting])
    moving = int(np.sum(motions > max(MOVING, SHARE * motions.max())))
    return [lasting[k] for k in np.argsort(-motions, kind="stable")[:markers]], moving


def _findings(place: Integers, rows: Array, repeated: int) -> list[str]:
    found = []
    dropped = int(place[-1] - place[0] + 1 - place.size)
    if dropped:
        found.append(f"{dropped} frames dropped, {repeated} of them repeat the one before")
    lost = int(np.isnan(rows).any(axis=1).sum())
    if lost:
        found.append(f"marker lost in {lost} of {place.size} frames")
    if np.nanstd(rows) < 0.05:
        found.append("the marker stands still")
    return found


def scale_from(length: float, first: tuple[float, float], second: tuple[float, float]) -> float:
    """Length of a pixel [m/pixel] from a known length [m] and rows and columns of its ends [pixel]."""
    pixels = hypot(second[0] - first[0], second[1] - first[1])
    if pixels < 1.0 or not length > 0.0:
        raise InputRefused(f"a length of {length:g} m over {pixels:.3g} pixels is no scale: measure another")
    return length / pixels


def marker_log(track: MarkerTrack, scale: float) -> Log:
    """A track as a log, ``scale`` [m/pixel]: up and to the right positive, NaN where frames dropped."""
    if not (np.isfinite(scale) and scale > 0.0):
        raise InputRefused(f"scale = {scale:g} m/pixel must be positive and finite: measure a known length")
    count = track.rows.shape[1]
    if count > 2:
        raise InputRefused(f"{count} markers: a log holds one, or an upper and a lower one")
    place = track.place - track.place[0]
    time = np.arange(place[-1] + 1, dtype=np.float64) / track.frame_rate
    channels = {}
    for k, name in enumerate(("",) if count == 1 else ("upper_", "lower_")):
        for axis, values in (
            (f"{name}position", -track.rows[:, k]),
            (f"{name}along_position", track.columns[:, k]),
        ):
            whole = np.full(time.size, np.nan)
            whole[place] = scale * (values - np.nanmean(values))
            channels[axis] = whole
    log = log_of(time, channels, dict.fromkeys(channels, "m"), source=track.source)
    return replace(log, report=replace(log.report, findings=track.findings))
