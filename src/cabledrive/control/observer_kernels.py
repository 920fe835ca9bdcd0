"""Compiled steps from encoder readings to angles and speeds; the designs are in `kalman` and `difference`."""

from math import isfinite, tanh

from cabledrive.control.observer_numbers import ObserverNumbers
from cabledrive.mechanics.compiled import njit_part
from cabledrive.parameters.arrays import Array


@njit_part
def correct(
    observer: ObserverNumbers, sample: int, estimate: Array, readings: Array, states: Array, scratch: Array
) -> None:
    """Take in the readings of a sample; writes angles and speeds for the law into ``states``.

    A reading that is not a number leaves the law without states: they become NaN. ``estimate`` is kept.
    """
    chosen, output, gains, scalars = observer.chosen, observer.output, observer.gains, observer.scalars
    m = readings.size
    for j in range(m):
        if not isfinite(readings[j]):
            for i in range(states.size):
                states[i] = readings[j]
            return
    if observer.kind == 1:
        for j in range(m):
            if sample > 0:
                slope = (readings[j] - estimate[j]) / scalars[0]
                estimate[m + j] += scalars[1] * (slope - estimate[m + j])
            estimate[j] = readings[j]
    else:
        k = min(sample, gains.shape[0] - 1)
        for j in range(m):
            predicted = 0.0
            for i in range(estimate.size):
                predicted += output[j, i] * estimate[i]
            scratch[j] = readings[j] - predicted
        for i in range(estimate.size):
            for j in range(m):
                estimate[i] += gains[k, i, j] * scratch[j]
    for i in range(states.size):
        states[i] = estimate[chosen[i]]


@njit_part
def predict(
    observer: ObserverNumbers, estimate: Array, held: Array, before: float, after: float, fresh: Array
) -> None:
    """Carry the Kalman filter to the next sample: until the delay has passed ``before`` acts, then ``after``.

    ``held[0]`` is the torque at the motor's shaft as the current loop leaves it; it is carried along.
    """
    model, scalars, n = observer.model, observer.scalars, estimate.size
    torque = held[0]
    load = scalars[7] - scalars[5] * tanh(scalars[6] * estimate[observer.places[0]])
    for i in range(n):
        value = model[i, n] * torque + model[i, n + 1] * before
        value += model[i, n + 2] * after + model[i, n + 3] * load
        for j in range(n):
            value += model[i, j] * estimate[j]
        fresh[i] = value
    for i in range(n):
        estimate[i] = fresh[i]
    held[0] = scalars[2] * torque + scalars[3] * before + scalars[4] * after
