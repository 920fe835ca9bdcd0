r"""Damping from a decay: Gamma of a plucked span, or the pulley mode's damping from its own ringing.

.. math:: \ln A(t) = \ln A_0 - \tfrac12\Gamma t \qquad \text{Eq. (A.35)}

with the amplitude A demodulated at the mode's own frequency, while it is well above its own floor.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from cabledrive.answers.figures import figure
from cabledrive.answers.result import Result
from cabledrive.parameters import InputRefused, NotComputed

PERIODS = 6
GUESS = 0.01
"""Share of critical damping to assume where nothing has been measured: an estimate, to be named as one."""


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class DecayEstimate(Result):
    """Damping of one mode."""

    damping: float = figure("1/s", "Gamma or c_q, twice the decay rate of the amplitude", "Decay")
    # of the straight line; it knows nothing of damping that is not viscous
    standard_error: float = figure("1/s", "standard error", "Decay")
    frequency: float = figure("Hz", "frequency of the mode, from the phase", "Decay")
    curvature: float = figure("1/s", "change of the damping from the first half to the second", "Decay")
    """Change of the damping from the first half of the decay to the second [1/s]; of viscous damping zero
    within its error, positive where Coulomb friction ends the decay."""


def damping_from_decay(time: ArrayLike, signal: ArrayLike, frequency: float) -> DecayEstimate:
    """Viscous damping of a mode from its free decay, Eq. (A.35).

    Parameters
    ----------
    time : array_like, shape (n,)
        At equal intervals [s].
    signal : array_like, shape (n,)
        Displacement or angle, in any unit.
    frequency : float
        Of the mode, roughly [Hz].

    Returns
    -------
    DecayEstimate

    Raises
    ------
    InputRefused
        If the times are not equally spaced, or the record holds fewer than 30 periods.
    NotComputed
        If the mode is not there.
    """
    t, x = np.asarray(time, dtype=float), np.asarray(signal, dtype=float)
    steps = np.diff(t)
    even = t.ndim == 1 and t.shape == x.shape and t.size >= 8 and np.ptp(steps) <= 1e-6 * steps.mean()
    if not even or steps.mean() <= 0.0:
        raise InputRefused("decay: time and signal must be equally long, at equal ascending intervals")
    periods = (t[-1] - t[0]) * frequency
    if periods < 30:
        raise InputRefused(f"decay: {periods:.3g} periods of {frequency:.4g} Hz recorded, 30 are needed")
    omega, x = 2 * np.pi * frequency, x - np.mean(x)
    interval = t[1] - t[0]
    length = round(PERIODS * 2 * np.pi / omega / interval)
    weight = np.hanning(length + 1)[:-1]
    starts = np.arange(0, t.size - length, max(1, length // 2))
    rows = starts[:, None] + np.arange(length)
    turned = 2.0 * (x[rows] * np.exp(-1j * omega * t[rows]) * weight).sum(axis=1) / weight.sum()
    centre = t[starts] + 0.5 * length * interval
    size = np.abs(turned)
    kept = size > max(3.0 * float(np.min(size)), 1e-12) if np.min(size) < 0.05 * size[0] else size > 0.0
    last = int(np.argmin(kept)) if not kept.all() else kept.size
    if last < 6 or not size[0] > 0.0:
        raise NotComputed(f"decay: no mode near {frequency:.4g} Hz stays above the noise floor long enough")
    centre, turned = centre[:last], turned[:last]
    line, covariance = np.polyfit(centre, np.log(np.abs(turned)), 1, cov=True)
    halves = slice(last // 2), slice(last // 2, None)
    first, second = (np.polyfit(centre[part], np.log(np.abs(turned[part])), 1)[0] for part in halves)
    drift = np.polyfit(centre, np.unwrap(np.angle(turned)), 1)[0]
    return DecayEstimate(
        damping=float(-2 * line[0]),
        standard_error=float(2 * np.sqrt(covariance[0, 0])),
        frequency=frequency + float(drift) / (2 * np.pi),
        curvature=float(-2 * (second - first)),
    )


def guessed_damping(frequency: float) -> float:
    """Damping to assume where none is known: one per cent of critical at a frequency [Hz], in 1/s."""
    return 2.0 * GUESS * 2 * np.pi * frequency
