"""From a marker's track to a log with lengths in metres."""

from dataclasses import replace
from math import hypot

import numpy as np

from cabledrive.identification.camera.marker import MarkerTrack
from cabledrive.identification.logs.log import Log, log_of
from cabledrive.parameters import InputRefused


def scale_from(length: float, first: tuple[float, float], second: tuple[float, float]) -> float:
    """Length of a pixel from a known length in the picture.

    Parameters
    ----------
    length : float
        [m].
    first, second : (float, float)
        Row and column of its ends [pixel].

    Returns
    -------
    float
        [m/pixel].

    Raises
    ------
    InputRefused
        If the ends coincide or the length is not positive.
    """
    pixels = hypot(second[0] - first[0], second[1] - first[1])
    if pixels < 1.0 or not length > 0.0:
        raise InputRefused(
            f"a length of {length:g} m over {pixels:.3g} pixels gives no scale: measure another"
        )
    return length / pixels


def marker_log(track: MarkerTrack, scale: float) -> Log:
    """A marker's track as a log: upwards is positive, dropped frames are filled with NaN.

    Parameters
    ----------
    track : MarkerTrack
    scale : float
        [m/pixel].

    Returns
    -------
    Log
        "position" across the picture upwards and "along_position" to the right, from their means; with two
        markers "upper_position" and "lower_position".

    Raises
    ------
    InputRefused
        If the scale is not positive, or there are more than two markers.
    """
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
