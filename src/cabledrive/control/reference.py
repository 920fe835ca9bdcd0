"""The reference as a law takes it: flat output and derivatives that lead to the wanted load angle."""

from dataclasses import replace

import numpy as np

from cabledrive.control.flat_output import FlatOutput
from cabledrive.control.reference_numbers import ReferenceNumbers, lag_coefficients, reference_numbers
from cabledrive.parameters.arrays import Array


def lagged(signal: Array, time: float, interval: float) -> Array:
    """A sampled signal through :math:`1/(1 + Ts)`, exact for straight lines between samples.

    It starts at rest on its first value. A derivative of the signal gives the derivative of the result:
    nothing is differenced. ``time``: T [s]; 0 returns the signal.
    """
    if time == 0.0:
        return signal
    from scipy.signal import lfilter

    newest, last, fading = lag_coefficients(time, interval)
    start = (signal[..., :1] * (1.0 - newest)).astype(float)
    return lfilter([newest, last], [1.0, -fading], signal, axis=-1, zi=start)[0]


def flat_reference(flat: FlatOutput, reference: Array, interval: float) -> Array:
    r"""Flat output and its derivatives that lead to a wanted load angle.

    .. math:: z_d = \frac{y_d}{D_1 \cdots D_{n-1}}

    causal, stable and of unit gain; each derivative is filtered by itself. Two more rows follow: speed and
    acceleration of the first inertia that go with it.

    ``reference``, shape (2n + 1, samples): wanted load angle at the first shaft and its derivatives
    [rad/s^k]; ``interval``: sample time [s].
    Returns shape (samples, 2n + 3): z_d to its 2n-th derivative, motor speed [rad/s], motor acceleration
    [rad/s^2].
    """
    z = reference
    for time in flat.time_constants:
        z = lagged(z, float(time), interval)
    speed = flat.angles[0, :-1] @ z[1:]
    return np.ascontiguousarray(np.column_stack((z.T, speed, flat.inertial @ z)))


def flat_generator(flat: FlatOutput, interval: float) -> ReferenceNumbers:
    """The generator of the rows of `flat_reference`."""
    return reference_numbers(flat_map(flat).T, flat.time_constants.tolist(), interval)


def flat_map(flat: FlatOutput) -> Array:
    """The rows of `flat_reference` from each filtered derivative alone, shape (2n + 1, 2n + 3)."""
    unfiltered = replace(flat, time_constants=np.zeros_like(flat.time_constants))
    return flat_reference(unfiltered, np.eye(2 * flat.size + 1), 1.0)


def joint_motion(flat: FlatOutput, flat_rows: Array) -> tuple[Array, Array]:
    """Angles, then speeds, along `flat_reference`, (samples, 2n), and the torque of the first link [N m]."""
    n2 = 2 * flat.size
    return flat_rows[:, :n2] @ flat.states.T, flat_rows[:, : n2 + 1] @ flat.elastic
