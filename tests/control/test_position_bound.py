"""The bound of a body's place against the loop integrated in time."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from cabledrive.control.position_bound import place_answers, place_bound

POSITION, LAG, OBSERVER = 6.3, 76.0, 11.4


def error_of(time, *, unexpected=None, tension=None, noise=None, measured=None):
    """Error of the place by observer, law and lags as differential equations, from rest."""

    def none(_):
        return 0.0

    a, t, n, g = (given or none for given in (unexpected, tension, noise, measured))

    def rate(now, x):
        e, v, seen, speed, disturbance, first, second = x
        innovation = e + n(now) - seen
        believed = second + disturbance
        feedback = -(POSITION**2) * seen - 2.0 * POSITION * speed - disturbance
        return [
            v,
            second + a(now) + t(now),
            speed + 3.0 * OBSERVER * innovation,
            believed + t(now) + g(now) + 3.0 * OBSERVER**2 * innovation,
            OBSERVER**3 * innovation,
            LAG * (feedback - first),
            LAG * (first - second),
        ]

    return solve_ivp(rate, (0.0, time[-1]), np.zeros(7), t_eval=time, rtol=1e-9, atol=1e-12, max_step=2e-3).y[
        0
    ]


def pulse_answer(kind):
    """Instants and the error under a narrow pulse of unit area."""
    time = np.linspace(0.0, 3.0, 3001)
    width = time[1]
    return time, error_of(time, **{kind: lambda s: 1.0 / width if s < width else 0.0})


@pytest.mark.parametrize(
    ("kind", "name"), [("unexpected", "unexpected"), ("tension", "tension"), ("noise", "place")]
)
def test_the_worst_disturbance_reaches_the_bound_and_none_exceeds_it(kind, name):
    """The signs of the answer, backwards in time."""
    bound = getattr(place_answers(POSITION, LAG, OBSERVER), name)
    time, answer = pulse_answer(kind)
    signs = np.sign(answer)[::-1]
    worst = np.abs(error_of(time, **{kind: lambda s: signs[min(int(s / time[1]), len(signs) - 1)]})).max()
    assert np.trapezoid(np.abs(answer), time) == pytest.approx(bound, rel=0.01)
    assert 0.97 * bound < worst < 1.01 * bound


@pytest.mark.parametrize(("kind", "name"), [("noise", "noisy_place"), ("measured", "noisy_acceleration")])
def test_white_noise_goes_through_the_square_of_the_answer(kind, name):
    time, answer = pulse_answer(kind)
    expected = np.sqrt(np.trapezoid(answer**2, time))
    assert getattr(place_answers(POSITION, LAG, OBSERVER), name) == pytest.approx(expected, rel=0.01)


def test_parts_of_the_bound_add_up():
    answers, zero = place_answers(POSITION, LAG, OBSERVER), np.zeros(1)
    plain = {
        "unexpected": zero,
        "tension": zero,
        "counts": zero,
        "place_noise": zero,
        "acceleration_noise": zero,
    }
    assert place_bound(answers, 1e-3, **plain | {"unexpected": np.ones(1), "counts": np.ones(1)})[
        0
    ] == pytest.approx(answers.unexpected + answers.place)
    noisy = place_bound(answers, 1e-3, **plain | {"place_noise": np.ones(1)})[0]
    assert noisy == pytest.approx(5.0 * np.sqrt(1e-3) * answers.noisy_place)
