"""The model of internal resonance: its coefficients from mode shapes, and the energy they come from."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
import sympy as sp

import cabledrive as cd
from cabledrive.mechanics.spans import transverse_chains
from cabledrive.modal.tuning import pulley_mode, section_modes
from cabledrive.modal.waves import waves
from cabledrive.reduction.autoparametric import at_pretension, autoparametric_model
from cabledrive.reduction.coupling_integrals import fourth_power_of_slope, squared_slope, stretch_by
from cabledrive.reduction.uniform_tension import uniform_tension_model
from resonance_samples import TUNED, damped


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


def test_pulley_mode_nearly_halves_the_spans_own_stiffening_and_couples_them():
    """With the static rotation, own-span cubic 0.503 beta and 0.247 beta between the spans."""
    model = autoparametric_model(TUNED)
    beta = model.stiffening.sum(axis=1)[0]
    static = model.coupling[0] ** 2 / (model.modal_mass * model.natural**2)
    assert (0.75 * model.stiffening[0, 0] - static) / beta == pytest.approx(0.5, abs=0.003)
    assert (static + 0.25 * model.stiffening[0, 1]) / beta == pytest.approx(0.2473, abs=0.001)


@pytest.mark.parametrize("number", [1, 2, 3])
def test_coupling_equals_the_closed_formula_of_the_uniform_tension_model(number):
    """g_m = 1 - x^2/(4 pi^2 m^2 - x^2), Eq. (R.3), against the integral over the waves, Eq. (A.10)."""
    model = autoparametric_model(TUNED, number=number)
    uniform = uniform_tension_model(TUNED, number)
    factor = np.sqrt(model.modal_mass)
    closed = uniform.coupling[1, :, number - 1] * factor * np.sign(uniform.rims[1, 1])
    np.testing.assert_allclose(model.coupling, closed, rtol=1e-11)
    assert model.modal_damping == pytest.approx(uniform.damping[1, 1], abs=1e-12)


@pytest.mark.parametrize("name", ["dissertation-transporter", "linear-axis", "ropeway", "camera-line"])
def test_integrals_over_waves_equal_quadrature(name):
    """Eqs. (A.6)-(A.8) on drives whose waves are cut by carriages."""
    drive = cd.load_drive(name)
    mode = pulley_mode(drive)
    along = waves(mode.chain, mode.solved, mode.shape)
    for chain in transverse_chains(drive):
        across = waves(chain, section_modes(chain, 2)[1])
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


def test_energy_of_the_cable_gives_the_coefficients():
    """T0 (l - 1) + K (l - 1)^2 / 2 with the local stretch l: its cubic part has K - T0 = EA, Eq. (A.10)."""
    u, s, tension, stiffness = sp.symbols("u s T0 K", positive=True)
    eps = sp.symbols("epsilon")
    local = sp.sqrt((1 + eps**2 * u) ** 2 + eps**2 * s) - 1
    energy = sp.series(tension * local + stiffness * local**2 / 2, eps, 0, 7).removeO()
    cubic = sp.expand(energy).coeff(eps, 4)
    assert sp.simplify(cubic - (stiffness * u**2 / 2 + (stiffness - tension) * (u * s / 2 + s**2 / 8))) == 0


def test_slaved_longitudinal_modes_give_the_stiffening():
    """Least K u'^2/2 + EA u' s/2 + EA s^2/8 over u between held ends, s = (kappa a cos)^2: Eq. (A.11)."""
    x, a, kappa, rigidity, tension = sp.symbols("x a kappa EA T0", positive=True)
    length, stiffness = sp.pi / kappa, rigidity + tension
    s = (kappa * a * sp.cos(kappa * x)) ** 2
    mean = sp.integrate(s, (x, 0, length)) / length
    strain = -rigidity / (2 * stiffness) * (s - mean)
    density = stiffness * strain**2 / 2 + rigidity * strain * s / 2 + rigidity * s**2 / 8
    energy = sp.integrate(sp.expand(density), (x, 0, length))
    rho = sp.symbols("rho", positive=True)
    beta = sp.diff(energy, a) / a**3 / (rho * length / 2)
    expected = rigidity * (rigidity + sp.Rational(3, 2) * tension) * kappa**4 / (4 * rho * stiffness)
    assert sp.simplify(beta - expected) == 0


@pytest.mark.parametrize("name", ["dissertation-2", "dissertation-transporter", "linear-axis"])
@pytest.mark.parametrize("planes", [1, 2])
def test_another_pretension_by_scaling_equals_the_model_made_there(name, planes):
    drive = cd.load_drive(name)
    numbers = [mode.number for mode in autoparametric_model(drive).modes]
    model = autoparametric_model(drive, number=numbers[0], planes=planes)
    other = replace(drive, cable=replace(drive.cable, pretension=1.7 * drive.cable.pretension))
    made, scaled = (
        autoparametric_model(other, number=numbers[0], planes=planes),
        at_pretension(model, other.cable.pretension),
    )
    for field in ("transverse", "coupling", "stiffening", "uneven", "slack_amplitude"):
        np.testing.assert_allclose(getattr(scaled, field), getattr(made, field), rtol=1e-10, err_msg=field)


def test_a_batch_of_pretensions_holds_the_models_one_by_one():
    model = autoparametric_model(TUNED, planes=2, load_torque=0.02)
    tensions = np.array([2.0, 3.0, 5.0])
    lanes = at_pretension(model, tensions)
    for i, tension in enumerate(tensions):
        single = at_pretension(model, float(tension))
        np.testing.assert_allclose(lanes.stiffening[:, :, i], single.stiffening, rtol=1e-14)
        np.testing.assert_allclose(lanes.transverse[:, i], single.transverse, rtol=1e-14)


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


def test_steady_load_that_slackens_a_span_is_refused():
    with pytest.raises(cd.InputRefused, match="lower span without tension"):
        autoparametric_model(TUNED, load_torque=1.0)


def test_viscous_friction_at_the_load_damps_the_pulley_mode_and_couples_it_to_the_rotation():
    """c_q = b2 phi2^2 / (r2^2 M): 1.304e5 per N m s; c12 = sum b phi / r^2."""
    model = autoparametric_model(damped(0.0, 13.043))
    assert model.modal_damping == pytest.approx(13.043, rel=2e-3)
    assert model.cross_damping / model.rigid_damping == pytest.approx(model.rims[1], rel=1e-12)
