"""Steady states in closed form and by continuation: folds, Hopf points, stability, beats."""

import numpy as np
import pytest

from cabledrive.reduction.averaging import averaged_rates
from cabledrive.reduction.branches import (
    fold,
    growth_of,
    hopf_torque_force,
    jacobian,
    steady_amplitudes,
    steady_state,
)
from cabledrive.reduction.continuation import follow_branch
from resonance_samples import averaged_step, complex_of, one_span, real, settings


def problem(c):
    """Residual and Jacobian of the averaged equations over the force."""

    def residual(x, force):
        return real(averaged_rates(c._replace(force=np.array(force + 0j)), complex_of(x), second=False))

    def slope(x, force):
        return jacobian(c._replace(force=np.array(force + 0j)), complex_of(x))

    return residual, slope


def followed(c, start_force, kind="one", **options):
    at = c._replace(force=np.array(start_force + 0j))
    state = steady_state(at, steady_amplitudes(at, kind)[-1], kind)
    if kind == "one":
        c, state = one_span(c), state[:2]
    scale = np.append(np.tile(np.abs(state), 2), start_force)
    residual, slope = problem(c)
    options = {"limits": (0.0, 5 * start_force), "step": 0.05, "scale": scale} | options
    return follow_branch(residual, slope, real(state), start_force, **options)


def random_settings(rng, cubic=True):
    transverse, pulley = rng.uniform(0.3, 6, 2)
    detunings = rng.uniform(-15, 15, 2)
    threshold = np.hypot(transverse / 2, detunings[1]) * np.hypot(pulley / 2, detunings[0]) / 2.15e4
    return settings(transverse, pulley, *detunings, threshold * 10 ** rng.uniform(-0.5, 1), cubic)


@pytest.mark.parametrize("kind", ["one", "both"])
def test_closed_steady_states_stand_still(kind):
    """Eq. (A.27): the rates of Eq. (A.14) vanish there, in 200 random settings."""
    rng, worst, found = np.random.default_rng(3), 0.0, 0
    for _ in range(200):
        c = random_settings(rng)
        for squared in steady_amplitudes(c, kind):
            state = steady_state(c, squared, kind)
            rates = averaged_rates(c, state, second=False)
            worst, found = max(worst, np.max(np.abs(rates)) / (20 * np.max(np.abs(state)))), found + 1
    assert found > 100
    assert worst < 1e-14, f"{worst:.1e}"


def test_jacobian_is_the_derivative_of_the_rates():
    rng = np.random.default_rng(5)
    for _ in range(10):
        c = random_settings(rng)
        state = 1e-3 * (rng.standard_normal(3) + 1j * rng.standard_normal(3))
        x, exact = real(state), jacobian(c, state)
        residual, _ = problem(c)
        force = float(c.force.real)
        h = 1e-8
        columns = [(residual(x + h * e, force) - residual(x - h * e, force)) / (2 * h) for e in np.eye(6)]
        np.testing.assert_allclose(np.array(columns).T, exact, atol=1e-6 * np.max(np.abs(exact)))


@pytest.mark.parametrize("kind", ["one", "both"])
def test_continuation_finds_the_fold_of_the_closed_form(kind, measured):
    c = settings(2.0, 2.0, 5.0, 6.0, 1e-3)
    force, squared = fold(c, kind)
    branch = followed(c, 1.5 * force, kind, upwards=False)
    folds = [point for point in branch.special if point.kind == "fold"]
    measured(f"fold, {kind}: force within {abs(folds[0].parameter / force - 1.0):.1e} of the closed form")
    assert folds[0].parameter == pytest.approx(force, rel=1e-10)
    assert np.sum(np.abs(complex_of(folds[0].state)[1:]) ** 2) == pytest.approx(squared, rel=1e-6)


def test_fold_lies_well_below_the_threshold():
    """Without cubic terms, c = Gamma = 2, delta = 5, delta_1 = 6: 2.8 times below."""
    c = settings(2.0, 2.0, 5.0, 6.0, 1e-3, cubic=False)
    threshold = np.hypot(1.0, 6.0) * np.hypot(1.0, 5.0) / float(c.pump[0])
    assert threshold / fold(c, "one")[0] == pytest.approx(2.8, abs=0.05)
    assert fold(c, "one")[0] * float(c.pump[0]) == pytest.approx(abs(2 * 6 + 5 * 2) / 2, rel=1e-12)


def test_continuation_finds_the_hopf_point_of_the_closed_form(measured):
    c = settings(0.83, 4.12, 2.83, -4.86, 1e-3, cubic=False)
    force = hopf_torque_force(c)
    branch = followed(c, 1.6 * force, upwards=False)
    hopf = [point for point in branch.special if point.kind == "hopf"]
    measured(f"Hopf point: force within {abs(hopf[0].parameter / force - 1.0):.1e} of the closed form")
    assert hopf[0].parameter == pytest.approx(force, rel=1e-10)


def test_closed_hopf_points_have_an_imaginary_pair():
    """Random settings with opposite detunings: the largest real part vanishes."""
    rng, worst, found = np.random.default_rng(2), 0.0, 0
    while found < 100:
        c = random_settings(rng, cubic=False)
        force = hopf_torque_force(c)
        if force is None:
            continue
        at = c._replace(force=np.array(force + 0j))
        reals = [
            np.min(np.abs(pairs.real))
            for squared in steady_amplitudes(at, "one")
            if (pairs := complex_pairs(at, squared)).size
        ]
        if reals:
            found, worst = found + 1, max(worst, min(reals) / 10)
    assert worst < 1e-8, f"{worst:.1e}"


def complex_pairs(c, squared):
    values = np.linalg.eigvals(jacobian(one_span(c), steady_state(c, squared, "one")[:2]))
    return values[np.abs(values.imag) > 1e-9]


def settled(c, state, duration, h=1e-3):
    for n in range(int(duration / h)):
        state = averaged_step(c, state, n * h, h)
    return state


def test_a_stable_branch_is_where_time_integration_ends(measured):
    """A motion started nearby settles on it to 1e-6."""
    c = settings(2.0, 6.0, 1.0, -2.0, 3e-3)
    kind = "one"
    state = steady_state(c, steady_amplitudes(c, kind)[-1], kind)
    assert growth_of(c, state) < 0
    end = settled(c, state * (1.05 + 0.02j), 18.0)
    moving = np.abs(state) > 1e-9
    apart = np.max(np.abs(np.abs(end[moving]) / np.abs(state[moving]) - 1.0))
    measured(f"amplitudes after 18 s within {apart:.1e} of the branch")
    np.testing.assert_allclose(np.abs(end), np.abs(state), rtol=1e-6, atol=1e-9)


def test_a_continuation_that_cannot_go_on_keeps_what_it_found():
    """A branch that ends in a singular corner: reported, with every point up to there."""

    def residual(x, p):
        return np.array([x[0] - np.sqrt(np.maximum(1.0 - p, 0.0)) if p <= 1.0 else np.nan])

    branch = follow_branch(
        residual, lambda x, p: np.eye(1), np.ones(1), 0.0, limits=(0.0, 2.0), step=0.1, scale=np.ones(2)
    )
    assert not branch.complete
    assert "cannot go on" in branch.ended
    assert branch.parameters.size > 3
    assert branch.parameters[-1] <= 1.0
