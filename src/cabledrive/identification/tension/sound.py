"""Recordings of a ping: a sound file, or any log."""

import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np

from cabledrive.identification.logs.column_map import ColumnMap
from cabledrive.identification.logs.log import Log, log_of
from cabledrive.identification.logs.reading import read_log
from cabledrive.parameters import InputRefused
from cabledrive.parameters.files import require_regular

LARGEST_SOUND = 512 * 2**20
"""Bytes of a sound file that are read; a minute in stereo at 192 kHz has 92 MB."""


def read_ping(path: str | Path, columns: ColumnMap | None = None) -> Log:
    """Read a recording of a ping: a WAV file, or a log of any format that `identify` reads.

    Parameters
    ----------
    path : path-like
    columns : ColumnMap, optional
        For logs.

    Returns
    -------
    Log
    """
    path = Path(path)
    return read_wav(path) if path.suffix.lower() == ".wav" else read_log(path, columns)


def read_wav(path: str | Path) -> Log:
    """Read a WAV file as a log with the channel "sound" (and "sound_2", ...), full scale being 1.

    Parameters
    ----------
    path : path-like

    Returns
    -------
    Log

    Raises
    ------
    InputRefused
        If it is no WAV file of plain samples, is empty, or is longer than `LARGEST_SOUND`.
    """
    from scipy.io import wavfile

    path = Path(path)
    require_regular(path, "give the path of a recording")
    size = path.stat().st_size
    if size > LARGEST_SOUND:
        raise InputRefused(
            f"{path.name}: has {size / 2**20:.0f} MB, at most 512 MB are read: cut out the ping"
        )
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", wavfile.WavFileWarning)
            rate, values = wavfile.read(path)
    except Exception as error:
        raise InputRefused(
            f"{path.name}: is no sound file of plain samples ({error}): export it as WAV, PCM"
        ) from None
    if values.shape[0] < 3 or rate <= 0:
        raise InputRefused(f"{path.name}: holds {values.shape[0]} samples: record again")
    rows = values.reshape(values.shape[0], -1).astype(float)
    if values.dtype.kind in "iu":
        full = float(np.iinfo(values.dtype).max) + 1.0
        rows = rows / full if values.dtype.kind == "i" else 2.0 * rows / full - 1.0
    channels = {("sound" if k == 0 else f"sound_{k + 1}"): rows[:, k] for k in range(rows.shape[1])}
    time = np.arange(rows.shape[0], dtype=np.float64) / rate
    log = log_of(time, channels, dict.fromkeys(channels, "full scale"), source=path.name)
    clipped = [name for name, row in channels.items() if np.mean(np.abs(row) >= 0.999) > 1e-3]
    findings = tuple(f"{name} is clipped: record it less loud" for name in clipped)
    return replace(log, report=replace(log.report, findings=findings))
