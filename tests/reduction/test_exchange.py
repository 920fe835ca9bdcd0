"""Free exchange of energy between the spans, Eqs. (A.30), (A.31)."""

import numpy as np
import pytest

import cabledrive as cd
from cabledrive.reduction.autoparametric import autoparametric_model
from cabledrive.reduction.averaging import averaged_coefficients, averaged_rates
from cabledrive.reduction.exchange import exchange_period, largest_exchange
from resonance_samples import TUNED

MODEL = autoparametric_model(TUNED)


@pytest.mark.parametrize("plucks, period, stroke", [((5, 2), 0.511, 0.2562), ((3, 1), 0.913, 0.1708)])
def test_period_and_stroke_of_unequal_plucks(plucks, period, stroke):
    """Configuration 2: T [s] and the largest pulley displacement [mm]."""
    plucks = 1e-3 * np.array(plucks)
    assert exchange_period(MODEL, *plucks) == pytest.approx(period, rel=6e-3)
    assert largest_exchange(MODEL, *plucks) == pytest.approx(1e-3 * stroke, rel=2e-3)


def test_averaged_equations_swap_in_the_closed_period():
    """Without cubic terms the amplitudes are swapped after T/2 and back after T; AB is kept."""
    c = averaged_coefficients(MODEL)
    c = c._replace(
        cubic=0 * c.cubic, static=0 * c.static, detuning=np.array(0.0), transverse_detuning=np.zeros(2)
    )
    a, b = 3e-3, 1e-3
    steps = 2000
    h, state, most = exchange_period(MODEL, a, b) / steps, np.array([0, a, b], dtype=complex), 0.0
    for n in range(steps):
        one = averaged_rates(c, state, second=False)
        two = averaged_rates(c, state + 0.5 * h * one, second=False)
        three = averaged_rates(c, state + 0.5 * h * two, second=False)
        four = averaged_rates(c, state + h * three, second=False)
        state = state + h / 6 * (one + 2 * two + 2 * three + four)
        most = max(most, abs(state[0]))
        if n + 1 == steps // 2:
            np.testing.assert_allclose(np.abs(state), [0, b, a], atol=1e-9)
    np.testing.assert_allclose(np.abs(state), [0, a, b], atol=1e-9)
    assert most == pytest.approx(largest_exchange(MODEL, a, b), rel=1e-5)


def test_one_span_alone_gives_everything_to_the_pulleys_in_the_end():
    assert exchange_period(MODEL, 1e-3, 0.0) == np.inf


def test_equal_plucks_exchange_nothing():
    with pytest.raises(cd.InputRefused, match="equal"):
        exchange_period(MODEL, 1e-3, -1e-3)
