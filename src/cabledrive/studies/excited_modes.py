"""Which transverse modes the oscillation of the tensions can excite."""

from dataclasses import dataclass, fields, replace
from math import pi
from typing import Any

import numpy as np

from cabledrive.parameters.arrays import Array
from cabledrive.reduction.autoparametric import AutoparametricModel
from cabledrive.reduction.averaging import averaged_coefficients
from cabledrive.reduction.stretches import StretchModel

ALWAYS = 4
"""First modes of every row that are kept whatever the motion: they carry its slow deflection."""

LEAST_GROWTH = 0.7
"""Logarithm of the growth over the motion below which parametric excitation does not count."""

LEAST_SHARE = 0.3
"""Share of the floor below which direct excitation does not count."""

STRONG = 0.12
"""Relative oscillation of a tension from which the second instability region, at a mode's own frequency,
counts."""

UNSURE = 0.006
"""Relative error of a mode's frequency that the selection allows for: by sag, and by uneven tension."""

WIDE = 0.1
"""Share of a frequency around it whose lines act together."""

HANN = 1.5
"""Sum of the squares of the lines into which the window spreads one."""


def amplitudes(values: Array) -> Array:
    """Amplitudes of the sines in signals, shape (n, signals), without their means, (n // 2 + 1, signals)."""
    window = np.hanning(values.shape[0])[:, None]
    spectrum = np.fft.rfft(window * (values - values.mean(axis=0)), axis=0)
    return np.asarray(2.0 * np.abs(spectrum) / window.sum())


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """Modes across that can couple: frequencies [rad/s], damping [1/s], largest wave speed, slope of sag."""

    omega: Array
    loss: float
    speed: float
    steep: float


def excited_modes(row: Row, lines: tuple[Array, Array, float], floor: float) -> list[int]:
    r"""Places of the transverse modes of a row, the lowest and then the most endangered first.

    ``lines``: spectrum of the tension's oscillation over its value at rest, the largest along the ropes:
    relative amplitude of each line [-] and its frequency [rad/s], shape (n,), and the motion's duration [s];
    ``floor``: amplitude below which nothing counts [m]. A tension that oscillates by :math:`\eta T` at
    :math:`\Omega` makes a mode at :math:`w = \Omega/2`, or two whose frequencies add to it, grow by up to
    :math:`\tfrac18\Omega\eta` per time, within as much in frequency; through a sag of slope :math:`\sigma` it
    shakes a mode at :math:`w = \Omega` to no more than :math:`\eta\sigma/\kappa` times :math:`\min(w/\Gamma,
    \tfrac12 wT)`.
    """
    size, omega, duration = lines
    # Amplitude of all lines near each one together: what a chirp or a band of noise has at one time.
    total = np.concatenate(([0.0], np.cumsum(size**2)))
    place = np.arange(size.size)
    reach = np.maximum((WIDE * place).astype(int), 2)
    high, low = np.minimum(place + reach + 1, place.size), np.maximum(place - reach, 0)
    around = np.sqrt((total[high] - total[low]) / HANN)
    w, blurred = row.omega, 4 * pi / duration
    growth = 0.125 * omega * size * duration
    width = 0.25 * omega * around + blurred
    growth = np.where(around > STRONG, np.maximum(growth, 0.125 * omega * around * duration), growth)
    score = np.zeros(w.size)
    for first in range(3):  # with itself, with the next, with the one after that
        sums = w[: w.size - first] + w[first:]
        for a, both in enumerate(sums):
            near = np.abs(omega - both) < 2.0 * width + UNSURE * both
            best = float(np.max(growth, where=near, initial=0.0)) * (1.0 if first == 0 else 0.3)
            for one in (a, a + first):
                score[one] = max(score[one], best if best > LEAST_GROWTH else 0.0)
    for a, own in enumerate(w):
        near = np.abs(omega - own) < 2.0 * blurred + 2.0 * UNSURE * own
        line = float(np.max(size, where=near, initial=0.0))
        wide = np.abs(omega - own) < 2.0 * blurred + WIDE * own
        strong = float(np.max(around, where=wide, initial=0.0))
        shaken = line * row.steep * row.speed / own * min(own / max(row.loss, 1e-300), 0.5 * own * duration)
        if shaken > LEAST_SHARE * floor:
            score[a] = max(score[a], 1.0 + np.log1p(shaken / floor))
        if strong > STRONG:
            score[a] = max(score[a], 0.125 * own * strong**2 * duration)
    found = [int(a) for a in np.argsort(-score) if score[a] > 0.0 and a >= ALWAYS]
    return [*range(min(ALWAYS, w.size)), *found]


def lines_of(history: Array, still: StretchModel, h: float) -> tuple[Array, Array, float]:
    """Lines of `excited_modes` along the motion, the transverse modes left out."""
    every = max(1, len(history) // 2**16)
    relative = (history @ (still.tension.T / np.maximum(still.rest, 1e-300)))[::every]
    duration = h * len(history)
    size = amplitudes(relative).max(axis=1)
    return size, 2 * pi * np.arange(size.size) / duration, duration


def nearest_two(model: AutoparametricModel) -> AutoparametricModel:
    """The two sections that a torque reaches first."""
    if model.coupling.size <= 2:
        return model
    c = averaged_coefficients(model, torque=1.0, drift=False)
    order = np.argsort(np.abs(c.transverse_detuning) / np.abs(c.pump))[:2]
    rows = {own.name: getattr(model, own.name) for own in fields(model)}
    kept: dict[str, Any] = {
        name: row[order] for name, row in rows.items() if isinstance(row, np.ndarray) and row.ndim == 1
    }
    kept["stiffening"] = model.stiffening[np.ix_(order, order)]
    return replace(model, modes=tuple(model.modes[i] for i in order), **kept)
