"""Kernels of cabledrive.reduction: lines between two motors, the cable in modes."""

from math import cos, sin

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from cabledrive.reduction import modal_cable_kernels
from cabledrive.reduction.two_motors import TwoMotors, line_at, pulled

pytestmark = pytest.mark.kernel


def machine(radius: float) -> TwoMotors:
    two, none = np.ones(2), np.zeros(2)
    anchor, centre = np.array([[0.1, 0.2], [-0.1, 0.2]]), np.array([[1.0, 0.9], [-1.2, 0.8]])
    x, y = (anchor - centre).T
    span = np.sqrt(x**2 + y**2 - radius**2)
    bearing = np.array([span * x - radius * y, span * y + radius * x]).T / (x**2 + y**2)[:, None]
    return TwoMotors(
        mass=two, force=none, viscous=none, coulomb=none, frame=np.array([[1.0, 0.2], [0.0, 1.0]]),
        centre=centre, radius=radius * two, anchor=anchor, bearing=bearing, fixed=np.array([0.5, 0.7]),
        unwound=none, rigidity=two, loss=none, drum=two, inertia=two, turning_viscous=none,
        turning_coulomb=none, limit=two,
    )  # fmt: skip


@pytest.mark.parametrize("radius", [0.0, 0.05, -0.05])
def test_a_line_is_as_long_as_its_tangent_and_the_arc_behind_it(radius):
    """Its derivative is the unit vector of the tangent; a point for a pulley leaves the distance."""
    lines, q = machine(radius), np.array([0.15, -0.2])
    for i in range(2):
        along, scratch = np.zeros(2), np.zeros(2)
        length, free, last = line_at(lines, i, q, along)
        step = 1e-6
        slopes = [
            (line_at(lines, i, q + d, scratch)[0] - line_at(lines, i, q - d, scratch)[0]) / (2.0 * step)
            for d in step * np.eye(2)
        ]
        np.testing.assert_allclose(along, slopes, atol=1e-9)
        at_rest = lines.anchor[i] - lines.centre[i]
        away = np.linalg.norm(at_rest + lines.frame @ q)
        assert last == pytest.approx(np.sqrt(away**2 - radius**2), rel=1e-12)
        assert free == pytest.approx(lines.fixed[i] + last, rel=1e-12)
        if radius == 0.0:
            assert length == pytest.approx(away - np.linalg.norm(at_rest), rel=1e-12)
        assert line_at(lines, i, np.zeros(2), scratch)[0] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(
    ("stretch", "speed", "tension"), [(2e-3, 0.1, 5.0), (2e-3, -3.0, 0.0), (-1e-4, 9.0, 0.0), (0.0, 9.0, 0.0)]
)
def test_a_line_only_pulls_and_only_while_it_is_stretched(stretch, speed, tension):
    assert pulled(stretch, speed, 2000.0, 10.0) == pytest.approx(tension, abs=1e-15)


# --- The modal cable's kernels against the equations that they split, by scipy
SAMPLE, INPUTS = 0.2, np.array([0.7, -0.4])
ALONG = np.block([[np.zeros((2, 2)), np.eye(2)], [-np.diag([9.0, 25.0]), -np.diag([0.3, 0.5])]])
PUSH = np.array([[0.0, 0.0], [0.0, 0.0], [1.0, 0.3], [-0.6, 2.0]])
SINES = np.array([4.0, 8.0, 12.0])  # rad/s
SAG = np.array([[0.02, 0.0, -0.01], [0.03, 0.01, 0.0]])
COUPLING = np.random.default_rng(7).normal(size=(2, 2, 3))
PLUCKS = np.array([0.5, -0.3])


def numbers(steps: int) -> modal_cable_kernels.ModalCableNumbers:
    step = SAMPLE / steps
    flow = expm(step * np.block([[ALONG, PUSH], [np.zeros((2, 6))]]))
    across = [
        [f(w * step) * factor for w, factor in zip(SINES, factors, strict=True)]
        for f, factors in ((cos, (1, 1, 1)), (sin, 1 / SINES), (sin, -SINES), (cos, (1, 1, 1)))
    ]
    return modal_cable_kernels.ModalCableNumbers(
        steps=steps,
        step=step,
        along=flow[:4, :4].copy(),
        push=flow[:4, 4:].copy(),
        across=np.array(across),
        sag=SAG,
        coupling=COUPLING,
        carried=np.array([1.0, 4.0, 9.0]),
        stretching=np.array([0.5, 2.0, 4.5]),
        wave_numbers=np.array([1.0, 2.0, 3.0]),
        middle=np.array([1.0, 0.0, -1.0]),
        factors=np.array([2.0, 3.0, 10.0]),
        motions=np.array([[0.2, -1.0]]),
        rest=np.array([5.0, 6.0]),
        tension=np.array([[1.0, -0.5], [-1.0, 0.5]]),
    )  # fmt: skip


def exact(given: modal_cable_kernels.ModalCableNumbers) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Modes and rates, sines and their rates after a sample, from the pluck, without any splitting."""

    def rates(_, y):
        modes, sines, speeds = y[:4], y[4:10].reshape(2, 3), y[10:]
        stretched = (given.stretching * sines**2).sum(axis=1)
        carried = given.factors[0] * np.einsum("i,ijm->jm", modes[:2], COUPLING)
        stiffening = stretched[:, None] * given.carried + carried
        force = -np.einsum("ijm,jm->i", COUPLING, sines**2)
        along = ALONG @ modes + PUSH @ INPUTS + np.concatenate((np.zeros(2), force))
        across = -(SINES**2) * (sines - SAG) - stiffening * sines
        return np.concatenate((along, speeds, across.ravel()))

    start = np.zeros(16)
    start[[4, 7]] = PLUCKS
    end = solve_ivp(rates, (0.0, SAMPLE), start, method="DOP853", rtol=1e-12, atol=1e-14).y[:, -1]
    return end[:4], end[4:10].reshape(2, 3), end[10:].reshape(2, 3)


def stepped(steps: int):
    given = numbers(steps)
    state, tensions = modal_cable_kernels.new_modal_cable_state(given), np.zeros(2)
    modal_cable_kernels.start_cable(PLUCKS, state)
    modal_cable_kernels.cable_step(given, state, INPUTS, tensions)
    return given, state, tensions


def test_a_sample_is_that_of_the_equations_to_second_order_of_its_steps():
    errors = []
    for steps in (20, 40):
        given, state, _ = stepped(steps)
        pairs = zip((state.modes, state.sines[0], state.rates[0]), exact(given), strict=True)
        errors.append([np.abs(one - other).max() / np.abs(other).max() for one, other in pairs])
    orders = np.log2(np.divide(*errors))
    np.testing.assert_allclose(orders, 2.0, atol=0.1, err_msg=f"errors {errors}")
    assert max(errors[1]) < 2e-3, errors


def test_tension_middle_and_motion_are_their_sums_over_modes_and_sines():
    given, state, tensions = stepped(5)
    stretched = given.factors[1] * (given.stretching * state.sines[0] ** 2).sum(axis=1)
    np.testing.assert_allclose(tensions, given.rest + given.tension @ state.modes[:2] + stretched, rtol=1e-14)
    middles, places, speeds = np.zeros(2), np.zeros(1), np.zeros(1)
    modal_cable_kernels.cable_middle(given, state, middles)
    modal_cable_kernels.cable_motion(given, state, places, speeds)
    np.testing.assert_allclose(middles, state.sines[0, :, 0] - state.sines[0, :, 2], rtol=1e-14)
    np.testing.assert_allclose(places, given.motions @ state.modes[:2], rtol=1e-14)
    np.testing.assert_allclose(speeds, given.motions @ state.modes[2:], rtol=1e-14)


@pytest.mark.parametrize(
    ("change", "holds"),
    [({}, 1), ({"rest": np.array([-9.0, 6.0])}, 0), ({"factors": np.array([2.0, 3.0, 0.1])}, 0)],
    ids=["taut and shallow", "slack", "steep"],
)
def test_the_model_holds_while_every_span_is_taut_and_shallow(change, holds):
    given, state, tensions = stepped(5)
    modal_cable_kernels.cable_tension(given._replace(**change), state, tensions)
    assert state.holds[0] == holds
