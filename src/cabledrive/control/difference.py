"""Speeds from encoder readings by a filtered difference."""

from collections.abc import Sequence
from math import exp, pi

import numpy as np

from cabledrive.control.observer_numbers import DIFFERENCE, IDEAL, ObserverNumbers
from cabledrive.parameters import InputRefused


def filtered_difference(
    encoders: Sequence[int], interval: float, *, chosen: Sequence[int], cut_off: float = 200.0
) -> ObserverNumbers:
    r"""Speeds by differences of successive readings through a first-order filter.

    .. math::
        \hat\omega_k = \hat\omega_{k-1} + (1 - e^{-2\pi f h})\,\big((y_k - y_{k-1})/h - \hat\omega_{k-1}\big)

    The second-order filter of (4.1) lags more and was worse in closed loop at every cut-off tried.

    ``encoders``: inertia that each reads; ``chosen``: inertias of which the law takes angle and speed,
    refused without an encoder; ``cut_off``: f [Hz].
    """
    places = list(encoders)
    missing = [inertia for inertia in chosen if inertia not in places]
    if missing:
        raise InputRefused(f"inertia {missing[0] + 1} of the chain has no encoder: take the Kalman filter")
    numbers = [places.index(inertia) for inertia in chosen]
    m = len(places)
    share = 1.0 - exp(-2.0 * pi * cut_off * interval)
    return _plain(DIFFERENCE, interval, [*numbers, *(m + i for i in numbers)], share)


def ideal_states(n: int, interval: float, *, chosen: Sequence[int]) -> ObserverNumbers:
    """No observer: the law sees the true angles and speeds of ``chosen`` ones of n inertias."""
    return _plain(IDEAL, interval, [*chosen, *(n + i for i in chosen)])


def _plain(kind: int, interval: float, chosen: Sequence[int], share: float = 1.0) -> ObserverNumbers:
    square = np.zeros((0, 0))
    return ObserverNumbers(
        kind=kind,
        chosen=np.array(chosen, dtype=np.int64),
        places=np.zeros(2, dtype=np.int64),
        model=square,
        output=square,
        gains=np.zeros((0, 0, 0)),
        scalars=np.array([interval, share, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0]),
    )
