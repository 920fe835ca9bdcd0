"""Least squares by segments: one QR's estimate, errors that survive colour, unidentifiable directions."""

import numpy as np
import pytest
from scipy import signal

from cabledrive.identification.identifiability import (
    unidentifiable_parameters,
    unidentifiable_words,
)
from cabledrive.identification.regression import (
    bootstrap,
    factor,
    joined,
    merged,
    solve,
    suited_segments,
)

NAMES = ("inertia", "viscous_friction", "coulomb_friction")
TRUE = np.array([2.0, -1.0, 0.5])


def coloured(rng, rows=6000, pole=0.9):
    regressors = signal.lfilter([1.0], [1.0, -0.8], rng.normal(size=(rows, 3)), axis=0)
    noise = signal.lfilter([1.0], [1.0, -pole], rng.normal(size=rows))
    return regressors, regressors @ TRUE + noise


def test_segments_give_the_estimate_of_all_rows():
    phi, y = coloured(np.random.default_rng(1))
    direct = np.linalg.lstsq(phi, y, rcond=None)[0]
    parts = joined([factor(phi[:2500], y[:2500], NAMES, 7), factor(phi[2500:], y[2500:], NAMES, 11)])
    for factors in (parts, merged(parts, 4)):
        fit = solve(factors)
        np.testing.assert_allclose(fit.values, direct, rtol=1e-11)
        assert fit.residual == pytest.approx(np.sqrt(np.mean((y - phi @ direct) ** 2)), rel=1e-10)
        assert fit.condition == pytest.approx(np.linalg.cond(phi), rel=1e-9)


def test_intervals_of_coloured_residuals_cover_as_they_say():
    """Residuals with memory, where plain errors would be too small by about 3; 300 runs of 3 parameters."""
    rng = np.random.default_rng(4)
    inside = []
    for _ in range(300):
        phi, y = coloured(rng, rows=3000)
        fit = solve(suited_segments(factor(phi, y, NAMES, 240)))
        inside.append(np.abs(fit.values - TRUE) < fit.half_width())
    share = np.mean(inside)
    assert 0.925 < share < 0.975, f"observed {share:.3f}"


def test_the_bootstrap_spreads_as_the_standard_errors_say():
    rng = np.random.default_rng(5)
    phi, y = coloured(rng)
    factors = suited_segments(factor(phi, y, NAMES, 240))
    fit = solve(factors)
    spread = bootstrap(factors, 1000, rng).std(axis=0)
    np.testing.assert_allclose(spread, np.sqrt(np.diag(fit.covariance)), rtol=0.2)


def test_two_regressors_that_are_one_are_named_and_get_no_number():
    phi, y = coloured(np.random.default_rng(6))
    phi[:, 2] = 3 * phi[:, 1]
    fit = solve(factor(phi, y, NAMES, 9))
    assert unidentifiable_parameters(fit) == {"viscous_friction", "coulomb_friction"}
    (words,) = unidentifiable_words(fit)
    assert words.startswith("viscous friction, coulomb friction ")
    assert "(- viscous friction + coulomb friction)" in words
    assert fit.condition == float("inf")
    assert fit.values[0] == pytest.approx(TRUE[0], rel=0.05)
