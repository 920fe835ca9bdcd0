"""Threshold, growth and instability region of the internal resonance, against Floquet's theory."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import cabledrive as cd
from cabledrive.reduction.autoparametric import at_pretension, autoparametric_model
from cabledrive.reduction.averaging import averaged_coefficients
from cabledrive.reduction.threshold import (
    coulomb_onset_torque,
    critical_pumping,
    growth_rates,
    growth_torque,
    instability_half_width,
    pulley_amplitude,
    required_detuning,
    threshold_torque,
)
from resonance_samples import TUNED, bare_model, damped


def largest_multiplier(squared, damping, depth, forcing):
    """Of a'' + damping a' + (squared + depth cos(forcing t)) a = 0 over one period of the forcing."""

    def rates(t, y):
        stiffness = squared + depth * np.cos(forcing * t)
        return [y[1], -damping * y[1] - stiffness * y[0], y[3], -damping * y[3] - stiffness * y[2]]

    end = solve_ivp(rates, (0, 2 * np.pi / forcing), [1, 0, 0, 1], rtol=1e-12, atol=1e-14, method="DOP853")
    a, b, c, d = end.y[:, -1]
    return np.max(np.abs(np.linalg.eigvals([[a, c], [b, d]])))


@pytest.mark.parametrize("seed", range(4))
def test_critical_pumping_is_where_floquet_says_growth_begins(seed, measured):
    """Random Gamma 1-8 1/s, detuning up to 14 rad/s: second order within 3e-4, first order within 1.5 %."""
    rng = np.random.default_rng(seed)
    gamma, detuning = rng.uniform(1, 8), rng.uniform(-14, 14)
    c = averaged_coefficients(autoparametric_model(TUNED))
    c = c._replace(transverse_damping=np.array(gamma), transverse_detuning=np.array([detuning, detuning]))
    nu = 0.5 * float(c.forcing)

    def excess(pumping):
        return largest_multiplier(nu**2 + 2 * nu * detuning, gamma, 4 * nu * pumping, 2 * nu) - 1

    second, first = critical_pumping(c)[0], critical_pumping(c, second=False)[0]
    exact = brentq(excess, 0.5 * second, 1.6 * second, rtol=1e-10)
    measured(f"second order {second / exact - 1:.1e}, first order {first / exact - 1:.1e} from Floquet")
    assert second == pytest.approx(exact, rel=3e-4), f"{second / exact - 1:.2e}"
    assert first == pytest.approx(exact, rel=1.5e-2), f"{first / exact - 1:.2e}"


def test_threshold_at_tuning_is_the_product_of_the_dampings():
    """tau = 2 r1 M W^2 / (la |phi1|) (Gamma/2) (c/2), coefficient 1.712e-3 N m s^2."""
    model = autoparametric_model(damped(2.0, 2.6))
    rate = model.coupling[0] / model.transverse_mass[0]
    radius = TUNED.drive_pulley.radius
    coefficient = 2 * radius * model.modal_mass * model.natural**2 / (rate * abs(model.rims[0]))
    assert coefficient == pytest.approx(1.712e-3, rel=5e-3)
    threshold = float(threshold_torque(model))
    assert threshold == pytest.approx(coefficient * 1.0 * model.modal_damping / 2, rel=2e-4)


@pytest.mark.parametrize("transverse, pulley", [(0.0, 5.0), (5.0, 0.0), (0.0, 0.0)])
def test_threshold_is_zero_where_one_of_the_two_is_undamped(transverse, pulley):
    model = autoparametric_model(damped(transverse, pulley))
    tuned = replace(model, transverse=np.full(2, 0.5 * model.natural))
    assert float(threshold_torque(tuned)) == pytest.approx(0.0, abs=1e-15)


def test_undamped_pulley_mode_grows_steadily_and_has_no_threshold_whatever_the_spans_damping():
    c = averaged_coefficients(autoparametric_model(damped(5.0, 0.0)), torque=1e-3)
    assert np.isinf(pulley_amplitude(c))
    two, one = pulley_amplitude(c, 2.0), pulley_amplitude(c, 1.0)
    assert two == pytest.approx(2 * one, rel=1e-9)


def test_torque_for_tenfold_growth_in_a_second():
    """Undamped pulley mode at tuning: k f T^2 / 2 = ln F + Gamma T / 2, k f = 584 tau."""
    model = autoparametric_model(damped(2.0, 0.0))
    c = averaged_coefficients(model, torque=1.0)
    rate = float(abs(c.pump[0]) * abs(c.force))
    assert rate == pytest.approx(584, rel=5e-3)
    torque = growth_torque(model, 10.0, 1.0)
    assert rate * torque / 2 == pytest.approx(np.log(10) + 1.0, rel=2e-3)


def test_growth_in_the_instability_region_is_what_floquet_finds():
    model = bare_model(transverse=np.array([1.004]), transverse_damping=0.003)
    c = averaged_coefficients(model)
    amplitude = 0.02
    multiplier = largest_multiplier(1.004**2, 0.003, 2 * amplitude, 2.0)
    exact = np.log(multiplier) / np.pi
    assert growth_rates(c, amplitude)[0] == pytest.approx(exact, rel=4e-3)


def test_instability_region_opens_at_the_threshold_and_widens_with_the_torque():
    model = autoparametric_model(damped(2.0, 5.0))
    threshold = float(threshold_torque(model))
    widths = []
    for share in (0.99, 1.01, 2.0, 4.0):
        c = averaged_coefficients(model, torque=share * threshold)
        widths.append(float(np.max(instability_half_width(c, pulley_amplitude(c)))))
    assert widths[0] == 0.0
    assert widths[1] > 0.0
    assert widths[3] == pytest.approx(np.sqrt(16 - 1), rel=1e-3)
    assert required_detuning(model, 4 * threshold) == pytest.approx(widths[3], rel=1e-12)


def test_edge_of_the_instability_region_is_where_the_growth_vanishes():
    model = autoparametric_model(damped(2.0, 5.0))
    torque = 3 * float(threshold_torque(model))

    def growth(tension):
        c = averaged_coefficients(at_pretension(model, tension), torque=torque)
        return float(np.max(growth_rates(c, pulley_amplitude(c))))

    edge = brentq(growth, 3.28377, 3.6)
    assert float(threshold_torque(at_pretension(model, edge))) == pytest.approx(torque, rel=1e-6)


def test_coulomb_friction_at_the_load_asks_for_180_times_its_torque():
    """(4/pi) (phi2 r1 / (|phi1| r2)) c2."""
    load = replace(TUNED.load_pulley, coulomb_friction=1e-4)
    model = autoparametric_model(replace(TUNED, pulley=(TUNED.drive_pulley, load)))
    assert coulomb_onset_torque(model) == pytest.approx(180e-4, rel=5e-3)


@pytest.mark.parametrize("factor, duration, word", [(1.0, 1.0, "factor"), (10.0, 0.0, "duration")])
def test_growth_asked_for_in_vain_is_refused(factor, duration, word):
    with pytest.raises(cd.InputRefused, match=word):
        growth_torque(autoparametric_model(TUNED), factor, duration)
