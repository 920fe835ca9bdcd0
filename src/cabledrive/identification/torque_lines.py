"""Spectral lines of a torque: what moves an axis without noise, where there is nothing else."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from cabledrive.identification.logs.log import Log
from cabledrive.identification.rigid_axis import AxisOptions, channels_of

Array = NDArray[np.float64]

SPARSE = 0.3
HALF = 0.5
BETWEEN = 2.5
"""Power density between lines over that above them: nearly 1 where the rest is noise; 4 and more where the
torque of a feedback loop happens to have peaks."""


def spectral_lines(values: Array) -> Array:
    """A signal without what lies near its noise floor; the signal itself where it is no sum of lines.

    ``values``, shape (samples,).
    Returns shape (samples,).
    """
    spectrum = np.fft.rfft(values)
    kept = _lines_of(spectrum)
    if kept.mean() > SPARSE:
        return values
    return np.fft.irfft(np.where(kept, spectrum, 0.0), values.size)


def driven_by_lines(logs: Sequence[Log], options: AxisOptions) -> bool:
    """Whether the torque of every log is a sum of lines, so that a motion free of noise is known.

    Returns false where what stands above the noise fills more than half of its band, as steps, chirps and
    torques of feedback loops do; and where the torque channel saturates, for it cannot drive a model then.
    """
    torque, _ = channels_of(logs[0], options)
    for log in logs:
        if torque in log.saturated and log.saturated[torque].any():
            return False
        kept = _lines_of(np.fft.rfft(log.channel(torque)))
        band = np.flatnonzero(kept)
        if band.size == 0 or band.size > HALF * (band[-1] - band[0] + 1) or kept.mean() > SPARSE:
            return False
    return True


def noise_between_lines(logs: Sequence[Log], options: AxisOptions) -> bool:
    """Whether nothing but noise lies between the torque's lines, so that they are all that moves the axis.

    ``logs``: driven by lines, see `driven_by_lines`.
    """
    torque, _ = channels_of(logs[0], options)
    spectra = [np.fft.rfft(log.channel(torque)) for log in logs]
    return all(_between_and_above(np.abs(s) ** 2, _lines_of(s)) <= BETWEEN for s in spectra)


def _between_and_above(power: Array, kept: NDArray[np.bool_]) -> float:
    """Mean power between the lines over that above them; 1 where there is no such place."""
    first, last = np.flatnonzero(kept)[[0, -1]]
    between = power[first:last][~kept[first:last]]
    above = power[last + 1 :]
    return float(between.mean() / above.mean()) if between.size and above.size and above.any() else 1.0


def _lines_of(spectrum: NDArray[np.complex128]) -> NDArray[np.bool_]:
    size = np.abs(spectrum)
    above = size > 12.0 * np.median(size)
    return np.asarray(np.convolve(above, np.ones(3), "same") > 0)
