"""Does a feedback loop make the torque? What was not predicted in the angle then shows in the torque."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from cabledrive.identification.innovations import Prediction, Track, autoregression
from cabledrive.identification.torque_lines import spectral_lines

Array = NDArray[np.float64]

REACH = 20
"""Samples after an innovation in which the torque is looked at."""
BEYOND = 6.0
"""Standard errors of a correlation that are beyond chance."""


def feedback_significance(torque: Array, run: Prediction, late: int) -> float:
    """Largest correlation of the torque with innovations before it, in standard errors.

    ``torque``, shape (samples,): as logged; ``run``: of an observer along the same samples; ``late``: samples
    by which the torque channel is logged late: their correlations are no feedback.
    """
    lines = spectral_lines(torque)
    noise = torque if lines is torque else torque - lines
    cause = np.convolve(run.innovation, autoregression(run.innovation), "valid")
    effect = np.convolve(noise, autoregression(noise), "valid")
    size = effect.size
    norm = float(np.linalg.norm(cause) * np.linalg.norm(effect))
    if norm == 0.0:
        return 0.0
    lags = range(1 + late, REACH + late)
    return float(np.sqrt(size) / norm * max(abs(float(cause[: size - k] @ effect[k:])) for k in lags))


def inside_a_loop(
    torques: Sequence[Array], tracks: Sequence[Track], runs: Sequence[Prediction], shift: float
) -> bool:
    """Whether the torque of any log answers to the angle.

    ``torques``: as logged; ``shift``: time by which the torque acts later than it is logged [s].
    """
    late = [max(0, int(np.ceil(-shift / track.interval + 0.5))) for track in tracks]
    cases = zip(torques, runs, late, strict=True)
    return any(feedback_significance(*one) > BEYOND for one in cases)
