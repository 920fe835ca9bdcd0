"""The model of internal resonance: coefficients from mode shapes and energy; threshold against Floquet."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.optimize import brentq

import cabledrive as cd
from cabledrive.mechanics.spans import transverse_chains
from cabledrive.modal.tuning import pulley_mode, section_modes
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
from cabledrive.reduction.transverse_sections import fourth_power_of_slope, squared_slope, stretch_by
from cabledrive.reduction.uniform_tension import uniform_tension_model
from resonance_samples import TUNED, bare_model, damped, floquet


def test_coefficients_of_configuration_2_per_pretensioned_metre():
    """With 1 m and 0.49 g/m counted under 3.2838 N: W/2pi, shares of the rims, M, G/M, G/m_t, N_11 + N_12."""
    strain = 3.2838 / TUNED.cable.axial_rigidity
    cable = replace(TUNED.cable, pretension=3.2838, mass_per_length=4.9e-4 * (1 + strain))
    model = autoparametric_model(replace(TUNED, cable=cable, layout=cd.Layout(pulley_distance=1.0)))
    assert model.natural / (2 * np.pi) == pytest.approx(81.8632, abs=1e-4)
    np.testing.assert_allclose(model.rims, [-0.007004, 0.992996], atol=1e-6)
    assert model.modal_mass == pytest.approx(8.40026e-3, rel=1e-6)
    np.testing.assert_allclose(model.transverse_mass, 2.45e-4, rtol=1e-12)
    np.testing.assert_allclose(model.coupling / model.modal_mass, [3.2437e5, -3.2437e5], rtol=2e-5)
    np.testing.assert_allclose(model.coupling / model.transverse_mass, [1.11216e7, -1.11216e7], rtol=2e-5)
    row = model.stiffening.sum(axis=1) / model.transverse_mass
    kappa, rigidity = np.pi, cable.axial_rigidity
    beta = rigidity * (rigidity + 1.5 * 3.2838) * kappa**4 / (4 * 4.9e-4 * (rigidity + 3.2838))
    np.testing.assert_allclose(row, beta, rtol=2e-5)
    assert beta == pytest.approx(5.5127e7, rel=2e-5)


@pytest.mark.parametrize("number", [1, 2, 3])
def test_coupling_equals_the_closed_formula_of_the_uniform_tension_model(number):
    """g_m = 1 - x^2/(4 pi^2 m^2 - x^2), Eq. (R.3), against the integral over the waves, Eq. (A.10)."""
    model = autoparametric_model(TUNED, number=number)
    uniform = uniform_tension_model(TUNED, number)
    factor = np.sqrt(model.modal_mass)
    closed = 0.5 * uniform.coupling[1, :, number - 1] * factor * np.sign(uniform.motions[1, 1])
    np.testing.assert_allclose(model.coupling, closed, rtol=1e-11)
    assert model.modal_damping == pytest.approx(uniform.damping[1, 1], abs=1e-12)


@pytest.mark.parametrize("name", ["dissertation-transporter", "linear-axis", "ropeway", "camera-line"])
def test_integrals_over_waves_equal_quadrature(name):
    """Eqs. (A.6)-(A.8) on drives whose waves are cut by carriages."""
    drive = cd.load_drive(name).listed
    mode = pulley_mode(drive)
    along = mode.mode.slope_waves(mode.shape)
    for chain in transverse_chains(drive):
        across = section_modes(chain, 2)[1].slope_waves()
        by_sum = np.zeros(3)
        edges = sorted({w.start for w in (*along, *across)} | {w.start + w.length for w in (*along, *across)})
        nodes, weights = np.polynomial.legendre.leggauss(40)
        for left, right in pairwise(edges):
            if right - left < 1e-12:
                continue
            s = 0.5 * (left + right) + 0.5 * (right - left) * nodes
            u, w = (slope_on(part, across[0].span, s) for part in (along, across))
            by_sum += 0.5 * (right - left) * np.array([weights @ (u * w**2), weights @ w**2, weights @ w**4])
        exact = stretch_by(along, across), squared_slope(across), fourth_power_of_slope(across)
        scale = squared_slope(across) * max(abs(w.slope) for w in along)
        assert abs(exact[0] - by_sum[0]) < 1e-11 * scale
        np.testing.assert_allclose(exact[1:], by_sum[1:], rtol=1e-11)


def slope_on(pieces, span, s):
    out = np.zeros(s.size)
    for wave in pieces:
        inside = (wave.span == span) & (s >= wave.start) & (s <= wave.start + wave.length)
        out[inside] = (wave.slope * np.exp(1j * wave.wave_number * (s[inside] - wave.start))).real
    return out


@pytest.mark.parametrize("name", ["dissertation-2", "dissertation-transporter", "linear-axis"])
@pytest.mark.parametrize("planes", [1, 2])
def test_another_pretension_by_scaling_equals_the_model_made_there(name, planes):
    drive = cd.load_drive(name).listed
    numbers = [mode.number for mode in autoparametric_model(drive).modes]
    model = autoparametric_model(drive, number=numbers[0], planes=planes)
    other = replace(drive, cable=replace(drive.cable, pretension=1.7 * drive.cable.pretension))
    made, scaled = (
        autoparametric_model(other, number=numbers[0], planes=planes),
        at_pretension(model, other.cable.pretension),
    )
    for field in ("transverse", "coupling", "stiffening", "uneven", "slack_amplitude"):
        np.testing.assert_allclose(getattr(scaled, field), getattr(made, field), rtol=1e-10, err_msg=field)


def test_steady_load_tunes_one_span_early_and_the_other_late():
    """The spans bear T0 +- tau / (2 r2): each is tuned when its own tension is the tuned one."""
    torque = 0.01
    half = torque / (2 * TUNED.load_pulley.radius)
    early = autoparametric_model(
        replace(TUNED, cable=replace(TUNED.cable, pretension=TUNED.cable.pretension - half)),
        load_torque=torque,
    )
    assert 2 * early.transverse[0] == pytest.approx(early.natural, rel=1e-3)
    assert 2 * early.transverse[1] < 0.97 * early.natural


def largest_multiplier(squared, damping, depth, forcing):
    """Of a'' + damping a' + (squared + depth cos(forcing t)) a = 0 over one period of the forcing."""
    return floquet(lambda t: squared + depth * np.cos(forcing * t), damping, 2 * np.pi / forcing)


@pytest.mark.parametrize("seed", range(4))
def test_critical_pumping_is_where_floquet_says_growth_begins(seed, measured):
    """Random Gamma 1-8 1/s, detuning up to 14 rad/s: second order within 3e-4, first order within 1.5 %."""
    rng = np.random.default_rng(seed)
    gamma, detuning = rng.uniform(1, 8), rng.uniform(-14, 14)
    c = averaged_coefficients(autoparametric_model(TUNED))
    both = {"transverse_damping": gamma, "transverse_detuning": detuning}
    c = c._replace(**{name: np.array([value, value]) for name, value in both.items()})
    nu = 0.5 * float(c.forcing)

    def excess(pumping):
        return largest_multiplier(nu**2 + 2 * nu * detuning, gamma, 4 * nu * pumping, 2 * nu) - 1

    second, first = critical_pumping(c)[0], np.hypot(0.5 * gamma, detuning)
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


def test_coulomb_friction_at_the_load_asks_for_180_times_its_torque():
    """(4/pi) (phi2 r1 / (|phi1| r2)) c2."""
    load = replace(TUNED.load_pulley, coulomb_friction=1e-4)
    model = autoparametric_model(replace(TUNED, pulley=(TUNED.drive_pulley, load)))
    assert coulomb_onset_torque(model) == pytest.approx(180e-4, rel=5e-3)


def test_a_held_motor_takes_its_share_of_the_strain_and_damps_nothing():
    """Two rims on a light cable, the motor's rim on a spring: c = phi C phi / phi M phi of two masses."""
    held = ["motor.inertia=0.001", "motor.holding_stiffness=30", "cable.axial_damping=0.4"]
    drive = cd.load_drive("dissertation-2", overrides=[*held, "cable.mass_per_length=1e-9"]).listed
    drive = replace(drive, layout=replace(drive.layout, gravity=0.0))
    (first, second), stiff = drive.pulley, 2.0 * drive.cable.axial_rigidity / drive.span_length
    mass = np.diag([(first.inertia + 0.001) / first.radius**2, second.inertia / second.radius**2])
    pull = np.array([[1.0, -1.0], [-1.0, 1.0]])
    spring = stiff * pull + np.diag([30.0 / first.radius**2, 0.0])
    values, shapes = eigh(spring, mass)
    model = autoparametric_model(drive)
    k = int(np.argmin(np.abs(np.sqrt(values) - model.natural)))
    assert model.natural == pytest.approx(np.sqrt(values[k]), rel=1e-6)
    lost = 2.0 * 0.4 / drive.span_length * shapes[:, k] @ pull @ shapes[:, k]
    rubbing = sum(
        p.viscous_friction / p.radius**2 * x**2 for p, x in zip(drive.pulley, shapes[:, k], strict=True)
    )
    assert model.modal_damping == pytest.approx(lost + rubbing, rel=1e-5)
