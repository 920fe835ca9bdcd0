"""Steady states in closed form and by continuation: folds, Hopf points, stability, beats."""

import numpy as np
import pytest
import sympy as sp

from cabledrive.reduction import averaging
from cabledrive.reduction.autoparametric import autoparametric_model
from cabledrive.reduction.continuation import follow_branch
from cabledrive.reduction.threshold import growth_rates
from oracles.averaged_motion import (
    Motion,
    Slow,
    exchange_period,
    largest_exchange,
    plucked,
    reconstruct,
    start_of,
    triangle_stretch,
)
from resonance_samples import (
    TUNED,
    averaged_step,
    bare_model,
    complex_of,
    damped,
    floquet,
    one_span,
    real,
    settings,
)


def problem(c):
    """Residual and Jacobian of the averaged equations over the force."""

    def residual(x, force):
        return real(averaging.averaged_rates(c._replace(force=np.array(force + 0j)), complex_of(x)))

    def slope(x, force):
        return averaging.jacobian(c._replace(force=np.array(force + 0j)), complex_of(x))

    return residual, slope


def followed(c, start_force, kind="one", **options):
    at = c._replace(force=np.array(start_force + 0j))
    state = averaging.steady_state(at, averaging.steady_amplitudes(at, kind)[-1], kind)
    if kind == "one":
        c, state = one_span(c), state[:2]
    scale = np.append(np.tile(np.abs(state), 2), start_force)
    residual, slope = problem(c)
    options = {"limits": (0.0, 5 * start_force), "step": 0.05, "scale": scale} | options
    return follow_branch(residual, slope, np.append(real(state), start_force), **options)


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
        for squared in averaging.steady_amplitudes(c, kind):
            state = averaging.steady_state(c, squared, kind)
            rates = averaging.averaged_rates(c, state)
            worst, found = max(worst, np.max(np.abs(rates)) / (20 * np.max(np.abs(state)))), found + 1
    assert found > 100
    assert worst < 1e-14, f"{worst:.1e}"


def test_jacobian_is_the_derivative_of_the_rates():
    rng = np.random.default_rng(5)
    for _ in range(10):
        c = random_settings(rng)
        state = 1e-3 * (rng.standard_normal(3) + 1j * rng.standard_normal(3))
        x, exact = real(state), averaging.jacobian(c, state)
        residual, _ = problem(c)
        force = float(c.force.real)
        h = 1e-8
        columns = [(residual(x + h * e, force) - residual(x - h * e, force)) / (2 * h) for e in np.eye(6)]
        np.testing.assert_allclose(np.array(columns).T, exact, atol=1e-6 * np.max(np.abs(exact)))


@pytest.mark.parametrize("kind", ["one", "both"])
def test_continuation_finds_the_fold_of_the_closed_form(kind, measured):
    c = settings(2.0, 2.0, 5.0, 6.0, 1e-3)
    force, squared = averaging.fold(c, kind)
    branch = followed(c, 1.5 * force, kind, step=-0.05)
    folds = [point for point in branch.special if point.kind == "fold"]
    measured(f"fold, {kind}: force within {abs(folds[0].parameter / force - 1.0):.1e} of the closed form")
    assert folds[0].parameter == pytest.approx(force, rel=1e-10)
    assert np.sum(np.abs(complex_of(folds[0].state)[1:]) ** 2) == pytest.approx(squared, rel=1e-6)


def test_continuation_finds_the_hopf_point_of_the_closed_form(measured):
    c = settings(0.83, 4.12, 2.83, -4.86, 1e-3, cubic=False)
    # Size of f at which one span's steady state gives way to permanent beats, Eq. (A.28).
    gamma, detuning = c.transverse_damping[0], c.transverse_detuning[0]
    damping, delta = c.damping, c.detuning
    size = damping**2 + 4 * delta**2
    opposed = -(8 * detuning * delta + 4 * delta**2 + damping * (damping + 2 * gamma))
    b = gamma * damping * size * (size + 4 * gamma * (gamma + damping))
    b /= 4 * (gamma + damping) ** 2 * opposed
    first = 0.5 * b + 0.25 * damping * gamma - delta * detuning
    second = 0.5 * (damping * detuning + delta * gamma)
    force = float(np.hypot(first, second) / abs(c.pump[0]))
    branch = followed(c, 1.6 * force, step=-0.05)
    hopf = [point for point in branch.special if point.kind == "hopf"]
    measured(f"Hopf point: force within {abs(hopf[0].parameter / force - 1.0):.1e} of the closed form")
    assert hopf[0].parameter == pytest.approx(force, rel=1e-10)


def test_a_stable_branch_is_where_time_integration_ends(measured):
    """A motion started nearby settles on it to 1e-6."""
    c = settings(2.0, 6.0, 1.0, -2.0, 3e-3)
    kind = "one"
    state = averaging.steady_state(c, averaging.steady_amplitudes(c, kind)[-1], kind)
    assert np.max(np.linalg.eigvals(averaging.jacobian(c, state)).real) < 0
    end = state * (1.05 + 0.02j)
    for n in range(18_000):
        end = averaged_step(Slow(c, second=False), end, 1e-3 * n, 1e-3)
    moving = np.abs(state) > 1e-9
    apart = np.max(np.abs(np.abs(end[moving]) / np.abs(state[moving]) - 1.0))
    measured(f"amplitudes after 18 s within {apart:.1e} of the branch")
    np.testing.assert_allclose(np.abs(end), np.abs(state), rtol=1e-6, atol=1e-9)


def test_a_continuation_that_cannot_go_on_keeps_what_it_found():
    """A branch that ends in a singular corner: reported, with every point up to there."""

    def residual(x, p):
        return np.array([x[0] - np.sqrt(np.maximum(1.0 - p, 0.0)) if p <= 1.0 else np.nan])

    branch = follow_branch(
        residual, lambda x, p: np.eye(1), np.array([1.0, 0.0]), limits=(0.0, 2.0), step=0.1, scale=np.ones(2)
    )
    assert not branch.complete
    assert "cannot go on" in branch.ended
    assert branch.parameters.size > 3
    assert branch.parameters[-1] <= 1.0


# --- The averaged equations against the oscillators they are made from, and the exchange between the span
def projected_residual(size, second):
    """What the reconstruction leaves of the equations at resonance, for amplitudes of a size."""
    model = bare_model(
        modes=2,
        natural=2.0 + 0.7 * size,
        modal_damping=0.9 * size,
        transverse=np.array([1.0 + 0.5 * size, 1.0 - 0.3 * size]),
        transverse_damping=0.6 * size,
        coupling=np.array([1.0, -0.8]),
        stiffening=np.array([[1.3, 0.4], [0.4, 0.9]]),
    )
    c = averaging.averaged_coefficients(model, torque=1.1 * size**2, forcing=2.0)
    start = size * np.array([0.6 - 0.8j, 0.9 + 0.3j, -0.5 + 1.1j])
    slow = Slow(c, second=second)
    instants, h = 2 * np.pi * np.arange(64) / 64, 1e-3

    def motion(t):
        steps = 16
        state = start
        for n in range(steps):
            d, at = t / steps, n * t / steps
            state = averaged_step(slow, state, at, d)
        m = reconstruct(slow, state, t)
        return np.append(m.q, m.a), np.append(m.q_rate, m.a_rate)

    left = np.zeros(3, dtype=complex)
    for t in instants:
        (place, rate), ahead, behind = motion(t), motion(t + h)[0], motion(t - h)[0]
        bend = (ahead - 2 * place + behind) / h**2
        q, a = place[0], place[1:]
        force = 1.1 * size**2 * np.sin(2 * t) - model.coupling @ a**2
        along = bend[0] + model.modal_damping * rate[0] + model.natural**2 * q - force
        across = bend[1:] + model.transverse_damping * rate[1:] + model.transverse**2 * a
        across = across + 2 * model.coupling * q * a + a * (model.stiffening @ a**2)
        left += np.append(along * np.exp(-2j * t), across * np.exp(-1j * t)) / instants.size
    return np.max(np.abs(left))


@pytest.mark.parametrize(("second", "power"), [(False, 3.0), (True, 4.0)])
def test_what_averaging_leaves_at_resonance_falls_with_its_order(second, power, measured):
    """Amplitudes, dampings, detunings of size e: first order leaves e^3, second e^4, (A.14), (A.15)."""
    sizes = np.array([0.04, 0.02])
    left = [projected_residual(size, second) for size in sizes]
    order = np.log(left[0] / left[1]) / np.log(2.0)
    measured(f"{'second' if second else 'first'} order leaves e^{order:.2f}")
    assert order == pytest.approx(power, abs=0.35), f"order {order:.2f}, left {left}"


def test_elastic_pendulum_swings_up_at_three_quarters_of_its_stroke(measured):
    """Pendulum tuned 1:2, length l, stroke z0: growth 0.75 w z0 / l, coupling from the Lagrangian."""
    x, z, length, rate, mass = sp.symbols("x z l w m", positive=True)
    stiffness, rest = 4 * mass * rate**2, sp.Rational(3, 4) * length
    potential = stiffness / 2 * (sp.sqrt((length + z) ** 2 + x**2) - rest) ** 2 - mass * rate**2 * length * z
    cubic = sp.diff(potential, x, 2, z).subs({x: 0, z: 0}) / 2
    assert sp.simplify(sp.diff(potential, x, 2).subs({x: 0, z: 0}) - mass * rate**2) == 0
    numbers = {length: 1.3, rate: 2.2, mass: 0.7}
    w, stroke = 2.2, 0.013
    model = bare_model(
        natural=2 * w,
        modal_mass=0.7,
        transverse=np.array([w]),
        transverse_mass=np.array([0.7]),
        coupling=np.array([float(cubic.subs(numbers))]),
    )
    c = averaging.averaged_coefficients(model)
    growth = float(abs(c.pump[0]) * stroke)

    def stiffness(t):
        """About the exact vertical oscillation."""
        return 4 * w**2 * (1 - 0.75 * 1.3 / (1.3 + stroke * np.cos(2 * w * t)))

    exact = np.log(floquet(stiffness, 0.0, 2 * np.pi / w)) * w / (2 * np.pi)
    closed = growth / (0.75 * w * stroke / 1.3) - 1.0
    measured(f"growth: {closed:.1e} from 0.75 w z0/l, {growth / exact - 1.0:.1e} from Floquet")
    assert growth == pytest.approx(0.75 * w * stroke / 1.3, rel=1e-12)
    assert growth == pytest.approx(exact, rel=1e-4)
    assert growth_rates(c, stroke)[0] == pytest.approx(growth, rel=1e-4)


@pytest.mark.parametrize("second", [False, True])
def test_start_map_reproduces_the_motion_at_rest(second):
    c = averaging.averaged_coefficients(autoparametric_model(damped(2.0, 10.0)), torque=0.03)
    slow = Slow(c, np.array([2e-7, 1e-7]), second=second)
    rest = Motion(q=np.array(0.0), q_rate=np.array(0.0), a=np.array([3e-3, -1e-3]), a_rate=np.zeros(2))
    found = reconstruct(slow, start_of(slow, rest), 0.0)
    np.testing.assert_allclose(found.a, rest.a, atol=1e-12)
    assert abs(found.q) < 1e-14
    assert np.max(np.abs(found.a_rate)) < 1e-10 * 250
    assert abs(found.q_rate) < 1e-11


def test_a_pluck_at_rest_starts_from_a_real_pulley_amplitude():
    """Q(0) cancels the static rotation lq a^2 / (2 W^2): starting from zero would miss it."""
    c = averaging.averaged_coefficients(autoparametric_model(TUNED))
    state = plucked(Slow(c), [4e-3, 0.0])
    assert state[0].real == pytest.approx(0.5 * c.static[0, 0] / c.pump[0] * 16e-6, rel=0.02)


def test_stretch_of_a_triangle_beyond_its_first_mode():
    m = np.arange(3, 20_001, 2)
    total = np.sum(m**2 * (8 / np.pi**2 / m**2) ** 2)
    assert triangle_stretch(1.0) == pytest.approx(total, abs=5e-5)
    assert triangle_stretch(1.0) == pytest.approx(0.1535, abs=1e-4)


def test_averaged_equations_swap_in_the_closed_period():
    """Without cubic terms the amplitudes are swapped after T/2 and back after T; AB is kept."""
    model = autoparametric_model(TUNED)
    c = averaging.averaged_coefficients(model)
    c = c._replace(
        cubic=0 * c.cubic, static=0 * c.static, detuning=np.array(0.0), transverse_detuning=np.zeros(2)
    )
    a, b = 3e-3, 1e-3
    steps = 2000
    h, state, most = exchange_period(model, a, b) / steps, np.array([0, a, b], dtype=complex), 0.0
    for n in range(steps):
        state = averaged_step(Slow(c, second=False), state, n * h, h)
        most = max(most, abs(state[0]))
        if n + 1 == steps // 2:
            np.testing.assert_allclose(np.abs(state), [0, b, a], atol=1e-9)
    np.testing.assert_allclose(np.abs(state), [0, a, b], atol=1e-9)
    assert most == pytest.approx(largest_exchange(model, a, b), rel=1e-5)
