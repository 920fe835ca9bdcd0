r"""Bound of the place of a body between two motors, by the answers of its linear loop.

Let a be the acceleration of the body that the law's model does not expect and :math:`a_e` that of the
tensions' error :math:`T - T_f`. The observer with three equal poles :math:`\omega_o` leaves

.. math:: (s+\omega_o)^3\,\tilde q = s\,a,\qquad (s+\omega_o)^3\,\tilde v = s(s+3\omega_o)\,a,\qquad
    (s+\omega_o)^3\,\hat d = \omega_o^3\,a ,

and the error e of the place obeys, with the lags :math:`F = \omega_f^2/(s+\omega_f)^2` of the tension,
:math:`P = 2\omega_p s + \omega_p^2` and :math:`B\,a = \omega_p^2\tilde q + 2\omega_p\tilde v - \hat d`,

.. math:: (s^2 + FP)\,e = (1 + FB)\,a + a_e + FB\,a_g - FN\,n ,

:math:`a_g` and n the noise of the observer's acceleration and of its place. What is bounded goes through the
integral of the answer's magnitude, white noise through that of its square.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import polynomial as poly
from numpy.typing import NDArray

from cabledrive.parameters.arrays import Array

Coefficients = NDArray[np.floating[Any]]
DEVIATIONS = 5.0
"""Within which noise is taken to lie."""
_STEPS, _DECAYS = 4000, 16.0


class PlaceAnswers(NamedTuple):
    """Integrals of the answers of the place to an acceleration and to noise.

    ``unexpected``, ``tension``: of the magnitude of e per a, per a_e [s^2]; ``place``: per n [-];
    ``noisy_place``, ``noisy_acceleration``: root of the integral of the square, per n [s^-1/2] and per a_g
    [s^3/2].
    """

    unexpected: float
    tension: float
    place: float
    noisy_place: float
    noisy_acceleration: float


def place_answers(position: float, lag: float, observer: float) -> PlaceAnswers:
    """Integrals of the answers; bandwidths of position, lags and observer [rad/s]."""
    wp, wf, wo = position, lag, observer
    lags, seen = poly.polypow([wf, 1.0], 2), poly.polypow([wo, 1.0], 3)
    loop = poly.polyadd(poly.polymul([0.0, 0.0, 1.0], lags), wf**2 * np.array([wp**2, 2.0 * wp]))
    believed = np.array([-(wo**3), wp**2 + 6.0 * wp * wo, 2.0 * wp])
    # What noise n of the place makes of place, speed and disturbance, with the weights of the feedback.
    noisy = (
        wp**2 * np.array([wo**3, 3.0 * wo**2, 3.0 * wo])
        + 2.0 * wp * np.array([0.0, wo**3, 3.0 * wo**2])
        + np.array([0.0, 0.0, wo**3])
    )
    whole = poly.polymul(loop, seen)
    slowest = float(np.abs(poly.polyroots(whole).real).min())
    time = np.linspace(0.0, _DECAYS / slowest, _STEPS)

    def magnitude(above: Coefficients, below: Coefficients) -> float:
        return float(np.trapezoid(np.abs(_impulse(above, below, time)), time))

    def energy(above: Coefficients, below: Coefficients) -> float:
        return float(np.sqrt(np.trapezoid(_impulse(above, below, time) ** 2, time)))

    return PlaceAnswers(
        unexpected=magnitude(poly.polyadd(poly.polymul(lags, seen), wf**2 * believed), whole),
        tension=magnitude(lags, loop),
        place=magnitude(wf**2 * noisy, whole),
        noisy_place=energy(wf**2 * noisy, whole),
        noisy_acceleration=energy(wf**2 * believed, whole),
    )


def _impulse(above: Coefficients, below: Coefficients, time: Array) -> Array:
    """Answer to an impulse of a transfer function, coefficients of rising powers, at equal instants."""
    from scipy.linalg import expm

    order, lead = len(below) - 1, below[-1]
    matrix = np.diag(np.ones(order - 1), 1)
    matrix[-1] = -below[:-1] / lead
    row = np.zeros(order)
    row[: len(above)] = above / lead
    step, state, found = expm(matrix * time[1]), np.eye(order)[-1], np.zeros(len(time))
    for k in range(len(time)):
        found[k] = row @ state
        state = step @ state
    return found


def place_bound(
    answers: PlaceAnswers,
    interval: float,
    *,
    unexpected: Array,
    tension: Array,
    counts: Array,
    place_noise: Array,
    acceleration_noise: Array,
) -> Array:
    """Bound of each coordinate [m], shape (m,).

    ``interval``: sample time [s]; ``unexpected``, ``tension``: largest a and a_e [m/s^2]; ``counts``: largest
    error of the place by rounding [m]; ``place_noise``, ``acceleration_noise``: standard deviations of n [m]
    and a_g [m/s^2] of a sample; each of shape (m,).
    """
    bounded = answers.unexpected * unexpected + answers.tension * tension + answers.place * counts
    noisy = np.hypot(answers.noisy_place * place_noise, answers.noisy_acceleration * acceleration_noise)
    return np.asarray(bounded + DEVIATIONS * np.sqrt(interval) * noisy)
