"""Ensembles of the resonance model in readable steps, for any number of transverse modes."""

import numpy as np

from cabledrive.reduction.averaging import averaged_rates
from cabledrive.reduction.oscillators import AVERAGED_STEP, Largest, integrate_oscillators_reference


def averaged_ensemble_reference(c, start, duration):
    """Largest amplitudes by the averaged equations, Runge-Kutta steps of order 4."""
    steps = int(np.ceil(duration / AVERAGED_STEP - 1e-9))
    h, state, largest = duration / steps, np.array(start), np.abs(start)
    for n in range(steps):
        t = n * h
        one = averaged_rates(c, state, t, second=False)
        two = averaged_rates(c, state + 0.5 * h * one, t + 0.5 * h, second=False)
        three = averaged_rates(c, state + 0.5 * h * two, t + 0.5 * h, second=False)
        four = averaged_rates(c, state + h * three, t + h, second=False)
        state = state + h / 6 * (one + 2 * two + 2 * three + four)
        largest = np.maximum(largest, np.abs(state))
    return Largest(largest[0], largest[1:], state)


def oscillator_ensemble_reference(c, plucks, steps):
    """Largest displacements by the oscillators themselves."""
    records = integrate_oscillators_reference(c, np.asarray(plucks, dtype=float), steps, 1)
    return Largest(
        np.abs(records[:, 0]).max(axis=0), np.abs(records[:, 2:]).max(axis=0), np.delete(records[-1], 1, 0)
    )
