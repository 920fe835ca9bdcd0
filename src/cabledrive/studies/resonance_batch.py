"""Numbers of the internal resonance of many loops of two pulleys at once, as `resonance` gives each."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cabledrive.modal.batch import LoopBatch, many_spectra
from cabledrive.parameters.fields import LARGEST, SMALLEST
from cabledrive.reduction.autoparametric import AutoparametricModel
from cabledrive.reduction.autoparametric_batch import (
    many_models,
    pulley_modes,
    spans_at_rest,
    straight_spans,
)
from cabledrive.reduction.threshold import threshold_torque
from cabledrive.studies.resonance_detuning import verdicts

Array = NDArray[np.float64]

LARGEST_PHASE = 2.0
"""Of the pulley mode along a span [rad]: beyond, another mode may be the lowest in which a pulley turns."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ResonanceBatch:
    """Numbers of each loop; NaN where there is none, every array of shape (n,).

    Attributes
    ----------
    done : ndarray of bool
        Whether the closed form holds; the others are for `resonance`.
    frequency_ratio, tuned_pretension, threshold_torque, threshold_here, pulley_frequency : ndarray
        [-], [N], [N m], [N m], [Hz]; as in `cabledrive.studies.resonance.ResonanceSummary`.
    verdict : ndarray of str
    """

    done: NDArray[np.bool_]
    frequency_ratio: Array
    tuned_pretension: Array
    threshold_torque: Array
    threshold_here: Array
    pulley_frequency: Array
    verdict: NDArray[np.str_]


def many_resonances(loops: LoopBatch, torque: Array) -> ResonanceBatch:
    """Frequency ratio, tuned pretension, thresholds and verdict of each loop; the span lengths are given.

    ``torque``, shape (n,): amplitude of the verdict [N m].
    """
    omegas, found = many_spectra(loops.chains(), 1)
    omega = omegas[:, 0]
    phase = omega * loops.length * np.sqrt(loops.density / loops.rigidity)
    with np.errstate(all="ignore"):
        modes, rest = pulley_modes(loops, omega), spans_at_rest(loops)
        force = straight_spans(loops, loops.pretension).force
        ratio = np.pi * np.sqrt(force / loops.density) / loops.length / omega
        wanted = force / (2.0 * ratio) ** 2
        reached = wanted < loops.rigidity
        tuned = np.where(reached, wanted / (1.0 - wanted / loops.rigidity), np.nan)
        here = many_models(loops, modes, rest)
        at_tuning = many_models(loops, modes, straight_spans(loops, tuned))
        allowed = ~reached | ((tuned >= SMALLEST) & (tuned <= LARGEST))
        return ResonanceBatch(
            done=found & (phase < LARGEST_PHASE) & allowed & (rest.lowest > 0.0),
            frequency_ratio=ratio,
            tuned_pretension=tuned,
            threshold_torque=np.where(reached, _finite(_tuned_threshold(at_tuning)), np.nan),
            threshold_here=_finite(threshold_torque(here)),
            pulley_frequency=omega / (2.0 * np.pi),
            verdict=verdicts(here, torque),
        )


def _tuned_threshold(model: AutoparametricModel) -> Array:
    """Zero where either mode is undamped, whatever round-off leaves of the tuning."""
    undamped = (np.asarray(model.modal_damping) == 0.0) | (np.asarray(model.transverse_damping) == 0.0)
    return np.where(undamped, 0.0, threshold_torque(model))


def _finite(values: Array) -> Array:
    return np.where(np.isfinite(values), values, np.nan)
