"""Permanent beats, where no steady motion is stable: their envelope and period."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cabledrive.parameters import NotComputed
from cabledrive.reduction.averaging import AveragedCoefficients
from cabledrive.studies.resonance_validation import averaged_history

Complex = NDArray[np.complex128]

BEAT_STEP = 4e-3
"""Step along beats [s]: rates stay below some 30 rad/s."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Beats:
    """Permanent beats.

    Attributes
    ----------
    period : float
        [s].
    least, most : float
        Smallest and largest amplitude of the span that moves most [m].
    """

    period: float
    least: float
    most: float


def beats(
    c: AveragedCoefficients, start: Complex, *, settle: float, watch: float, second: bool = True
) -> Beats:
    """Envelope and period of permanent beats, by integration of the averaged equations.

    Parameters
    ----------
    c : AveragedCoefficients
        Without drift.
    start : ndarray of complex, shape (1 + J,)
        Slow amplitudes [m].
    settle, watch : float
        Time that is let pass, and time that is judged [s].
    second : bool, default True
        To second order.

    Returns
    -------
    Beats

    Raises
    ------
    NotComputed
        If the motion has become steady, or less than three beats were seen.
    """
    _, before = averaged_history(c, start, settle, second=second, step=BEAT_STEP)
    time, states = averaged_history(c, before[:, -1], watch, second=second, step=BEAT_STEP)
    sizes = np.abs(states[1:])
    size = sizes[int(np.argmax(sizes.max(axis=1)))]
    if size.max() - size.min() < 1e-3 * size.max():
        raise NotComputed(f"no beats: the motion is steady at {size.max():.4g} m from {settle:.4g} s on")
    level = size - 0.5 * (size.max() + size.min())
    rising = np.flatnonzero((level[:-1] < 0.0) & (level[1:] >= 0.0))
    if rising.size < 4:
        raise NotComputed(f"{rising.size} beats in {watch:.4g} s are too few for a period: watch longer")
    share = level[rising] / (level[rising] - level[rising + 1])
    crossing = time[rising] + share * (time[1] - time[0])
    return Beats(
        period=float((crossing[-1] - crossing[0]) / (crossing.size - 1)),
        least=float(size[rising[0] : rising[-1]].min()),
        most=float(size[rising[0] : rising[-1]].max()),
    )
