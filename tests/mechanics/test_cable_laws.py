"""Cable laws: the printed equations of motion, potentials, limits, slack."""

import numpy as np
import pytest
from reproduction import expanded_equations

from cabledrive.mechanics import cable_laws
from cabledrive.parameters.cable import Cable
from cabledrive.parameters.errors import InputRefused

DENSITY = 0.49e-3
TAUT = {"pretension": 3.26, "axial_rigidity": 379.6}
SEEDS = range(20)
LAW_NAMES = sorted(cable_laws.LAWS)


def smooth_fields(seed, steepest):
    """Three random trigonometric fields on a metre: (order of derivative, x) -> values, x may be complex."""
    rng = np.random.default_rng(seed)
    waves = np.arange(1, 6) * np.pi
    amplitude = rng.standard_normal((3, 5)) / waves
    phase = rng.uniform(0.0, 2.0 * np.pi, (3, 5))
    amplitude *= steepest / np.abs(amplitude * waves).sum(axis=1, keepdims=True)

    def derivative(order, x):
        turned = waves * x[:, None] + phase[:, None, :] + order * np.pi / 2
        return tuple(np.sum(amplitude[:, None, :] * waves**order * np.sin(turned), axis=-1))

    return derivative


@pytest.mark.parametrize("name", LAW_NAMES)
@pytest.mark.parametrize("steepest", [1e-4, 0.02, 0.3])
def test_equations_written_out_equal_the_conservative_form(name, steepest, measured):
    """(2.15)-(2.17), (2.23)-(2.25), (3.7): d/dx of the tension over rho, on random smooth fields.

    By a complex step: exact to round-off.
    """
    law, x, errors = cable_laws.LAWS[name](**TAUT), np.linspace(0.0, 1.0, 101), {}
    for seed in SEEDS:
        fields = smooth_fields(seed, steepest)
        printed = expanded_equations.accelerations(law, DENSITY, fields(1, x), fields(2, x))
        expected = np.imag(law.components(*fields(1, x + 1e-30j))) / 1e-30 / DENSITY
        for axis, ours, theirs in zip("uvw", printed, expected, strict=True):
            errors[seed, axis] = np.max(np.abs(ours - theirs)) / np.max(np.abs(theirs))
    measured(f"largest relative error {max(errors.values()):.1e} in {len(SEEDS)} fields")
    for (seed, axis), error in errors.items():
        assert error < 1e-12, f"{axis} of field {seed}: relative error {error:.2e}"


def circulation(law, size):
    """Work of the components round a small square in the (u', v') plane, over its area."""
    u, v = 0.01, 0.02
    centre = np.linspace(-0.5, 0.5, 4001)
    mid = 0.5 * (centre[1:] + centre[:-1]) * size
    zero = np.zeros_like(mid)
    ds = size / mid.size

    def along(axis, du, dv):
        return np.sum(law.excess_components(u + du + zero, v + dv + zero, zero)[axis]) * ds

    half = size / 2
    loop = along(0, mid, -half) + along(1, half, mid) - along(0, mid, half) - along(1, -half, mid)
    return loop / size**2


def test_the_printed_weak_form_has_no_potential():
    """Curl of the printed components: -EA u' v' / (1 + lambda)^2; the consistent truncation has none."""
    strain = 0.01 + 0.5 * 0.02**2
    expected = -TAUT["axial_rigidity"] * 0.01 * 0.02 / (1.0 + strain) ** 2
    assert circulation(cable_laws.WeakLaw(**TAUT), 1e-3) == pytest.approx(expected, rel=1e-4)
    assert abs(circulation(cable_laws.ConsistentWeakLaw(**TAUT), 1e-3)) < 1e-5 * abs(expected)


@pytest.mark.parametrize("name", LAW_NAMES)
@pytest.mark.parametrize("tension_only", [False, True])
def test_the_stiffness_matrix_is_the_derivative_of_the_components(name, tension_only):
    if name == "linear" and tension_only:
        pytest.skip("a linear cable cannot go slack")
    law = cable_laws.LAWS[name](**TAUT)
    law = cable_laws.without_pushing(law) if tension_only else law
    gradients = np.random.default_rng(5).uniform(-0.1, 0.1, (3, 100))
    matrix = law.stiffness_matrix(*gradients)
    taut = cable_laws.LAWS[name](**TAUT)
    slack = taut.strain(*gradients) < law.slack_strain
    for column in range(3):
        stepped = gradients.astype(complex)
        stepped[column] += 1e-30j
        for row, part in enumerate(taut.components(*stepped)):
            slope = np.imag(part) / 1e-30
            expected = np.where(slack, 0.0, slope) if tension_only else slope
            np.testing.assert_allclose(matrix[:, row, column], expected, atol=1e-11 * law.stiffness)
    assert slack.any()


def test_the_exact_law_does_not_see_a_rotation():
    """Turning a segment as a whole turns its tension with it and leaves its energy alone."""
    law = cable_laws.ExactLaw(**TAUT)
    angle, stretch = np.linspace(0.0, 1.2, 25), 1.004
    gradients = stretch * np.cos(angle) - 1.0, np.zeros_like(angle), stretch * np.sin(angle)
    x, _, z = law.components(*gradients)
    np.testing.assert_allclose(np.hypot(x, z), law.pretension + law.stiffness * 0.004, rtol=1e-12)
    np.testing.assert_allclose(np.arctan2(z, x), angle, atol=1e-12)
    np.testing.assert_allclose(law.strain(*gradients), 0.004, rtol=1e-10)


def test_small_displacements_keep_their_digits():
    """A gradient of 1e-9 gives its linear tension to 1e-8: no digits are lost against the pretension."""
    u_x, v_x, w_x = (np.array([g]) for g in (1e-9, 2e-9, -1e-9))
    for name in LAW_NAMES:
        law = cable_laws.LAWS[name](**TAUT)
        x, y, z = law.excess_components(u_x, v_x, w_x)
        np.testing.assert_allclose(x, law.stiffness * u_x, rtol=1e-8)
        np.testing.assert_allclose(np.hstack([y, z]), law.pretension * np.hstack([v_x, w_x]), rtol=1e-6)


@pytest.mark.parametrize("name", ["exact", "weak", "weak-consistent"])
def test_a_slack_cable_carries_nothing_and_keeps_its_energy(name):
    law = cable_laws.without_pushing(cable_laws.LAWS[name](**TAUT))
    u_x = np.array([1.5, 2.0]) * law.slack_strain
    zero = np.zeros(2)
    for part in law.components(u_x, zero, zero):
        np.testing.assert_array_equal(part, 0.0)
    stored = law.energy_density(u_x, zero, zero) + law.pretension * u_x
    assert stored[0] == pytest.approx(stored[1], rel=1e-12)
    assert stored[0] == pytest.approx(-0.5 * law.pretension**2 / law.stiffness, rel=1e-12)


def test_an_unknown_law_and_a_slack_linear_cable_are_refused():
    cable = Cable(youngs_modulus=2.6e9, area=1.46e-7, mass_per_length=DENSITY, pretension=3.0)
    with pytest.raises(InputRefused, match='model = "cubic" is no cable law'):
        cable_laws.cable_law(cable, "cubic")
    with pytest.raises(InputRefused, match="cannot go slack"):
        cable_laws.cable_law(cable, "linear", tension_only=True)
    assert cable_laws.cable_law(cable).stiffness == pytest.approx(
        cable.axial_rigidity * (1.0 + cable.prestrain)
    )
