"""The track of a marker is right to a twentieth of a pixel, and what is wrong with a clip is said."""

import numpy as np
import pytest

from cabledrive.app.results import log_csv
from cabledrive.identification.camera_frames import Clip, open_clip
from cabledrive.identification.camera_marker import marker_log, track_marker
from cabledrive.identification.logs.reading import read_log
from cabledrive.identification.tension.tones import Tones, fit_tones
from command import refused
from painted_marker import VirtualCamera, filmed

RATE = 480.0
TONES = (34.2, 71.7, 143.1)


def clip_of(frames, rate):
    """Frames in memory."""
    return Clip(
        source="frames", frame_rate=rate, frames=lambda: enumerate(np.asarray(f, float) for f in frames)
    )


def film(seed, amplitudes, *, duration=2.0, **options):
    """Rows of a marker that swings at three frequencies about 80.3 pixels, and it filmed.

    A row is the mean of nine instants of an exposure of half a frame.
    """
    rng = np.random.default_rng(seed)
    phases = rng.uniform(0.0, 6.0, len(TONES))
    frames = np.arange(round(duration * RATE))[:, None] / RATE
    time = frames + 0.5 / RATE * np.linspace(-0.5, 0.5, 9)
    waves = [
        a * np.exp(-time) * np.sin(2 * np.pi * f * time + p)
        for a, f, p in zip(amplitudes, TONES, phases, strict=True)
    ]
    rows = 80.3 + np.sum(waves, axis=0)
    return rows.mean(axis=1), list(filmed(VirtualCamera(**options), rows, rng))


@pytest.fixture(scope="module")
def clip():
    """Two seconds of 224 x 160 pixels at 480 frames per second, large motion, six spots of clutter."""
    return film(7, (18.0, 6.0, 2.5))


SIZES = [(18.0, 6.0, 2.5), (8.0, 3.0, 1.0), (1.5, 0.6, 0.2)]
"""Amplitudes of the films [pixel]."""


@pytest.mark.parametrize(
    "seed, amplitudes, duration",
    [
        *((0, size, 1.0) for size in SIZES),
        *(pytest.param(n, size, 2.0, marks=pytest.mark.verify) for size in SIZES for n in range(10)),
    ],
)
def test_tracks_of_ten_films_each(seed, amplitudes, duration, measured):
    """Clutter that touches a marker which moves less than its own size is not kept apart: none here."""
    clutter = 6 if amplitudes[0] > 3.0 else 0
    exact, frames = film(seed, amplitudes, duration=duration, clutter=clutter)
    rows = track_marker(clip_of(frames, RATE)).rows[:, 0]
    error = rows - exact
    rms = np.sqrt(np.nanmean(error**2))
    # the tones found near those that were filmed, gaps of the track bridged
    number, tones, seen = np.arange(rows.size), np.arange(len(TONES)), np.isfinite(rows)
    whole = np.interp(number, number[seen], rows[seen])
    sizes = {"scale": np.ones(tones.size), "decay": np.ones(tones.size), "rise": np.zeros(tones.size)}
    start = Tones(family=tones, tooth=np.array(TONES), number=tones + 1, **sizes)
    off = fit_tones(whole, 1 / RATE, start, 2).tones.frequency - TONES
    measured(f"{rms:.3f} pixel rms; frequencies off by {', '.join(f'{one:+.3f}' for one in off)} Hz")
    assert rms <= 0.05, rms
    assert np.isnan(error).sum() <= 5
    assert np.abs(off).max() <= 0.1, off


def test_dropped_and_repeated_frames_are_missing_rows_that_identify_fills(clip, tmp_path):
    exact, frames = clip
    kept = [frames[k - 1] if k in (50, 51) else frame for k, frame in enumerate(frames[:80])]
    track = track_marker(clip_of(kept, RATE))
    assert "2 frames dropped" not in track.findings[0]  # frame 51 repeats frame 50, not the one before
    log = marker_log(track, 4e-4)
    assert np.isnan(log.channel("position")).sum() == 1
    (tmp_path / "track.csv").write_text(log_csv(log))
    read = read_log(tmp_path / "track.csv")
    assert "missing values of position filled" in read.report.repaired[0]
    centred = -4e-4 * (exact[:80] - exact[:80].mean())
    error = read.channel("position") - centred
    assert np.sqrt(np.mean(np.delete(error - error.mean(), [49, 50, 51]) ** 2)) < 4e-4 * 0.08


def test_a_lost_marker_is_missing_and_said(clip):
    _, frames = clip
    dark = [frame.copy() for frame in frames[:100]]
    rng = np.random.default_rng(1)
    for k in (60, 61, 62):
        dark[k] = (28 + 8 * rng.normal(size=dark[k].shape)).clip(0, 255).astype(np.uint8)
    track = track_marker(clip_of(dark, RATE))
    assert np.isnan(track.rows[60:63, 0]).all()
    assert np.isfinite(np.delete(track.rows[:, 0], [60, 61, 62])).all()
    assert "marker lost in 3 of 100 frames" in track.findings


def test_a_clip_without_a_marker_is_refused_in_one_line():
    rng = np.random.default_rng(2)
    frames = [25 + 8 * rng.normal(size=(60, 80)) for _ in range(20)]
    refused(lambda: track_marker(clip_of(frames, RATE)), "no marker")
    refused(lambda: track_marker(clip_of(frames, RATE), region=(500, 600, 0, 9)), "8 by 8 pixels")


def test_a_video_file_and_a_folder_of_pictures_are_the_same_clip(clip, tmp_path):
    cv2 = pytest.importorskip("cv2", reason="needs the extra camera")
    from PIL import Image

    exact, frames = clip
    video = cv2.VideoWriter(str(tmp_path / "a.avi"), cv2.VideoWriter_fourcc(*"MJPG"), 30.0, (224, 160))
    (tmp_path / "frames").mkdir()
    for k, frame in enumerate(frames[:60]):
        video.write(np.repeat(frame[:, :, None], 3, axis=2))
        if k != 40:  # a picture that was lost
            Image.fromarray(frame).save(tmp_path / "frames" / f"frame_{k + 7:04d}.png")
    video.release()
    for source in ("a.avi", "frames"):
        track = track_marker(open_clip(tmp_path / source, RATE))
        assert (track.frame_rate, track.place[0]) == (RATE, 0)
        error = track.rows[:, 0] - exact[:60][track.place - track.place[0]]
        assert np.sqrt(np.mean(error**2)) <= 0.05, (source, np.sqrt(np.mean(error**2)))
    assert "1 frames dropped" in track.findings[0]
