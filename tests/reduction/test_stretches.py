"""The model of stretches: forces by its energy, a step of second order, what makes such models."""

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import eigh
from scipy.optimize import brentq
from scipy.special import ellipk

import cabledrive as cd
from cabledrive.mechanics.holding import FREE
from cabledrive.mechanics.network import network_of
from cabledrive.reduction import sagging_model as sagging
from cabledrive.reduction import stretch_kernels as kernels
from cabledrive.reduction import stretch_runs as runs
from cabledrive.reduction.autoparametric import autoparametric_model, oscillators
from cabledrive.reduction.stretches import StretchModel, new_stretch_state, numbers_of
from cabledrive.reduction.transverse_sections import fixed_length, largest_slope, span_tensions
from cabledrive.reduction.uniform_tension import integrate, uniform_tension_model
from cabledrive.studies import motion_stages
from cabledrive.studies.motion_snapshot import longitudinal_of, snapshot_of
from network_samples import as_routes
from resonance_samples import damped

TUNED = cd.load_drive(
    "dissertation-2",
    overrides=[
        "cable.pretension=3.28377",
        "layout.gravity=0",
        "cable.transverse_damping=2",
        "pulley.1.viscous_friction=2e-5",
    ],
).listed
SAMPLE, TORQUE, INPUTS = 0.2, 0.3, np.array([0.7, -0.4])
FORCES = np.array([[1.0, 0.3], [-0.6, 2.0]])  # modal, of each input
PLUCKS = np.array([0.5, -0.3, 0.2, 0.1])


def small_model(full):
    """Two modes along, two spans in two planes, three modes each; full: sag, two strands, a follower."""
    rng, shape, strands = np.random.default_rng(7), (4, 3), 1 + full
    rows, wide = 2 + full, (*shape, 3) if full else shape
    coupling = rng.normal(size=(rows, *wide))
    square = rng.normal(size=(4, strands, 3, 3) if full else shape)
    if full:
        coupling, square = coupling + coupling.swapaxes(2, 3), square + square.swapaxes(2, 3)
    carried = np.tile(np.eye(2), (2 * strands, 2 * strands))
    return StretchModel(
        natural=np.array([3.0, 5.0]),
        damping=np.array([[0.3, 0.1], [0.1, 0.5]]),
        torque_shape=np.array([[0.8], [-0.5]]) if full else np.array([0.8, -0.5]),
        transverse=np.tile([4.0, 8.0, 12.0], (4, 1)),
        mass=rng.uniform(0.5, 1.5, shape),
        loss=rng.uniform(0.0, 0.4, shape),
        sag=0.03 * rng.normal(size=shape),
        direct=full * rng.normal(size=(rows, *shape)),
        coupling=coupling,
        softness=full * np.array([0.1, 0.04]),
        bend=full * rng.normal(size=(4, strands, 3)),
        shoved=np.zeros((4, 3, rows - 2)),
        square=square,
        carried=carried,
        rest=np.array([5.0, 6.0]),
        tension=rng.normal(size=(2, rows)),
        raised=np.tile(np.eye(2), 2 * strands),
        slopes=np.array([1.0, 2.0, 3.0]),
        steepest=10.0,
        probes=np.tile(np.array([1.0, 0.0, -1.0])[:, None], (4, 1, 1)),
        motions=np.array([[0.2, -1.0]]),
        highest=5.0,
        friction=np.zeros(3),
        friction_shape=np.ones((3, 2)),
    )


def sums(model, a):
    """Q and P of the module, by their definition."""
    full = model.coupling.ndim == 4
    q, p = ("kbij,bi,bj->k", "bnij,bi,bj->bn") if full else ("kbi,bi,bi->k", "bi,bi,bi->b")
    along = np.einsum("kbi,bi->k", model.direct, a) + 0.5 * np.einsum(q, model.coupling, a, a)
    bent = np.einsum("bni,bi->bn", model.bend, a)
    return along, bent.ravel() + 0.5 * np.einsum(p, model.square, a, a).ravel()


def forces(model, q, a, held):
    """Minus the gradient of V by modes and rows, by steps into the complex plane."""

    def energy(x):
        along, stretched = sums(model, x[2:].reshape(a.shape))
        softened = 0.5 * model.softness @ along[:2] ** 2
        return np.append(x[:2], held) @ along + softened + 0.5 * stretched @ model.carried @ stretched

    at = np.concatenate((q, a.ravel())).astype(complex)
    slopes = np.array([energy(at + 1e-30j * one).imag / 1e-30 for one in np.eye(at.size)])
    return -slopes[:2], -slopes[2:].reshape(a.shape)


def held_by(model):
    return np.full(len(model.direct) - 2, TORQUE)


def started(model, step, **more):
    numbers = numbers_of(model, step, **more)
    state = new_stretch_state(numbers)
    kernels.start_cable(PLUCKS, state)
    state.held[:] = held_by(model)
    return numbers, state


@pytest.mark.kernel
@pytest.mark.parametrize("full", [False, True])
def test_forces_are_the_gradient_of_the_energy_of_the_stretches(full):
    model = small_model(full)
    numbers, state = started(model, 0.1)
    rng = np.random.default_rng(2)
    state.modes[:], state.sines[:] = rng.normal(size=4), rng.normal(size=(4, 3))
    (kernels.pull_coupled if full else kernels.pull_sines)(numbers, state)
    along, across = forces(model, state.modes[:2], state.sines, state.held)
    np.testing.assert_allclose(state.force, along, rtol=1e-12)
    np.testing.assert_allclose(state.pull * model.mass, across, rtol=1e-11)
    np.testing.assert_allclose(state.stretched, sums(model, state.sines)[1], rtol=1e-12)


def exact(model, push):
    """Modes, rows and their rates after a sample under modal forces, from the pluck, without splitting."""

    def rates(_, y):
        q, p, a, b = y[:2], y[2:4], y[4:16].reshape(4, 3), y[16:].reshape(4, 3)
        along, across = forces(model, q, a, held_by(model))
        along = along + push - model.natural**2 * q - model.damping @ p
        across = across / model.mass - model.transverse**2 * (a - model.sag) - model.loss * b
        return np.concatenate((p, along, b.ravel(), across.ravel()))

    start = np.zeros(28)
    start[4:16:3] = PLUCKS
    end = solve_ivp(rates, (0.0, SAMPLE), start, method="DOP853", rtol=1e-12, atol=1e-14).y[:, -1]
    return end[:2], end[4:16].reshape(4, 3), end[2:4], end[16:].reshape(4, 3)


def sampled(steps):
    numbers, state = started(small_model(False), SAMPLE / steps, steps=steps, inputs=FORCES)
    tensions = np.zeros(2)
    kernels.cable_step(numbers, state, INPUTS, tensions)
    return numbers, state, tensions


def recorded(steps):
    numbers, state = started(small_model(False), SAMPLE / steps)
    along, across, _, _ = runs.recorded_run(numbers, state, np.full(steps + 1, TORQUE), steps)
    return along[-1, 0], across[-1, 0], along[-1, 1], across[-1, 1]


def lanes(steps):
    """The motion along alone, in the second of two lanes."""
    numbers, _ = started(small_model(False)._replace(motions=np.eye(2)), SAMPLE / steps)
    start = np.zeros((4, 3, 2))
    start[:, 0, 1] = PLUCKS
    waves = np.ones(steps + 1), np.array([0.0, TORQUE]), 0.0
    return (runs.ensemble_run(numbers, start, waves, steps)[0][-1, :, 1],)


def run(steps):
    """Places alone: the rates lack the last half kick."""
    numbers, state = started(small_model(True), SAMPLE / steps)
    seen = np.zeros((4, 1)), np.zeros((4, 3)), np.zeros((4, 3)), np.array([np.inf]), np.zeros((0, 3))
    runs.extremes_run(numbers, state, np.full((steps, 1), TORQUE), 0, 0.0, seen)
    return state.modes[:2], state.sines


def sample(steps):
    _, state, _ = sampled(steps)
    return state.modes[:2], state.sines, state.modes[2:], state.rates


@pytest.mark.kernel
@pytest.mark.parametrize(
    "way, full, push",
    [
        (sample, False, FORCES @ INPUTS),
        (recorded, False, TORQUE * small_model(False).torque_shape),
        (lanes, False, TORQUE * small_model(False).torque_shape),
        (run, True, TORQUE * small_model(True).torque_shape[:, 0]),
    ],
)
def test_a_motion_is_that_of_the_equations_to_second_order_of_its_steps(way, full, push):
    expected, errors = exact(small_model(full), push), []
    for steps in (40, 80):
        pairs = zip(way(steps), expected, strict=False)
        errors.append([np.abs(one - other).max() / np.abs(other).max() for one, other in pairs])
    np.testing.assert_allclose(np.log2(np.divide(*errors)), 2.0, atol=0.1, err_msg=f"errors {errors}")
    assert max(errors[1]) < 2e-3, errors


@pytest.mark.kernel
def test_tension_middle_and_motion_are_their_sums_over_modes_and_sines():
    numbers, state, tensions = sampled(5)
    model, modes = numbers.model, state.modes[:2]
    expected = model.rest + model.tension @ modes + model.raised @ sums(model, state.sines)[1]
    np.testing.assert_allclose(tensions, expected, rtol=1e-14)
    middles, places, speeds = np.zeros(4), np.zeros(1), np.zeros(1)
    kernels.cable_middle(numbers, state, middles)
    kernels.cable_motion(numbers, state, places, speeds)
    np.testing.assert_allclose(middles, state.sines[:, 0] - state.sines[:, 2], rtol=1e-14)
    np.testing.assert_allclose(places, model.motions @ modes, rtol=1e-14)
    np.testing.assert_allclose(speeds, model.motions @ state.modes[2:], rtol=1e-14)


@pytest.mark.parametrize(
    ("change", "holds"),
    [({}, 1), ({"rest": np.array([-9.0, 6.0])}, 0), ({"steepest": 0.1}, 0)],
    ids=["taut and shallow", "slack", "steep"],
)
def test_the_model_holds_while_every_span_is_taut_and_shallow(change, holds):
    numbers, state, tensions = sampled(5)
    kernels.cable_tension(numbers._replace(model=numbers.model._replace(**change)), state, tensions)
    assert state.holds[0] == holds


# --- A loop under uniform tension
def rest(model):
    k, rows = model.natural.size, model.sag.shape
    return np.zeros(k), np.zeros(k), np.zeros(rows), np.zeros(rows)


@pytest.mark.parametrize("whirling", [False, True])
def test_one_mode_limit_is_the_nonlinear_string(whirling, measured):
    """Heavy pulleys, one sine: elliptic integral in a plane, sqrt(w0^2 + alpha A^2) on a circle."""
    heavy = [replace(pulley, inertia=1e6) for pulley in TUNED.pulley]
    cable = replace(TUNED.cable, transverse_damping=0.0)
    drive = replace(
        TUNED, pulley=tuple(replace(pulley, viscous_friction=0.0) for pulley in heavy), cable=cable
    )
    model = uniform_tension_model(drive, 1, planes=2)
    step, amplitude = 1e-5, 4e-3
    alpha = 0.5 * model.carried[0, 0] * model.square[0, 0] ** 2 / model.mass[0, 0]
    w0 = model.transverse[0, 0]
    hardened = np.sqrt(w0**2 + alpha * amplitude**2)
    q, p, a, b = rest(model)
    a[0, 0] = amplitude
    if whirling:
        b[2, 0] = amplitude * hardened
        expected = hardened
    else:
        parameter = alpha * amplitude**2 / (2 * hardened**2)
        expected = np.pi * hardened / (2 * ellipk(parameter))
    motion = integrate(numbers_of(model, step), (q, p, a, b), np.zeros(100_001), 1)
    w = motion.across[:, 0, 0, 0]
    down = np.flatnonzero((w[:-1] > 0) & (w[1:] <= 0))
    crossings = (down + w[down] / (w[down] - w[down + 1])) * step
    observed = 2 * np.pi * (down.size - 1) / (crossings[-1] - crossings[0])
    way = "whirling" if whirling else "planar"
    measured(f"{way}: frequency within {abs(observed / expected - 1.0):.1e} of the string's")
    assert observed == pytest.approx(expected, rel=1e-6), (
        f"observed {observed:.9f}, expected {expected:.9f} rad/s"
    )


@pytest.mark.kernel
def test_oscillators_are_those_of_internal_resonance():
    """Eq. (A.9): forces of stretches and torque, damping, in the amplitudes v, q and a."""
    model, rng = autoparametric_model(damped(2.0, 8.0), planes=2), np.random.default_rng(3)
    numbers, root = numbers_of(oscillators(model), 1e-4), np.sqrt([model.rigid_mass, model.modal_mass])
    state, q, a = new_stretch_state(numbers), 1e-4, 1e-3 * rng.normal(size=4)
    state.modes[1], state.sines[:, 0] = root[1] * q, a
    kernels.pull_sines(numbers, state)
    np.testing.assert_allclose(root * state.force, [0.0, -model.coupling @ a**2], rtol=1e-12)
    across = -(2.0 * q * model.coupling + model.stiffening @ a**2) * a
    np.testing.assert_allclose(state.pull[:, 0] * model.transverse_mass, across, rtol=1e-12)
    shape, damping = root * numbers.model.torque_shape, np.outer(root, root) * numbers.model.damping
    np.testing.assert_allclose(shape, [model.rigid_arm, model.torque_arm], rtol=1e-12)
    friction = model.rigid_damping, model.cross_damping, model.modal_mass * model.modal_damping
    np.testing.assert_allclose([damping[0, 0], damping[0, 1], damping[1, 1]], friction, rtol=1e-12)


# --- A sagging loop, Eq. (A.36)
def made(drive, count):
    """Its model about the state of rest with the first modes of every row, and their waves."""
    network = network_of(as_routes(drive), motor=FREE)
    top = (count + 0.5) * np.pi / float(network.time[1])
    one = snapshot_of(network, longitudinal_of(network, 4), top, shapes=False)
    waves = one.waves(range(len(one.keys)))
    rows = sagging.rows_of(np.array([key[1] for key in one.keys]), waves.moved > 0.0)
    return sagging.sagging_model(waves, [(own, np.array([0])) for own in rows]), waves


@pytest.mark.parametrize("scale", [3.0, 6.0])
def test_sag_raises_the_first_symmetric_mode_in_the_plane_as_irvine_says(scale, measured):
    """tan x = x - 4 x^3 / lambda^2 with x half the wave number times the span; uniform tension along it."""
    cable = cd.Cable(youngs_modulus=1e12, area=1e-6, mass_per_length=0.08, pretension=250.0 * scale)
    layout, pulley = cd.Layout(span_length=50.0), cd.Pulley(radius=0.05, inertia=1.0, fixed=True)
    drive = cd.Drive(name="line", kind="line", cable=cable, layout=layout, pulley=(pulley, pulley))
    model, waves = made(drive, 11)
    row = next(row for row in range(2) if model.bend[row].any())
    stiffness = np.diag(model.mass[row] * model.transverse[row] ** 2)
    stiffness += model.carried[row, row] * np.outer(model.bend[row, 0], model.bend[row, 0])
    found = np.sqrt(eigh(stiffness, np.diag(model.mass[row]), eigvals_only=True))
    tension, rigidity = float(sagging.sag_slopes(waves)[1].mean()), drive.cable.axial_rigidity
    ratio = 0.08 * 9.81 * 50.0 / tension
    measured(f"first mode in the plane {found[0] / (2.0 * np.pi):.4f} Hz under {tension:.1f} N")
    parameter = ratio**2 * rigidity / tension
    x = brentq(lambda x: np.sin(x) - (x - 4 * x**3 / parameter) * np.cos(x), 0.5 * np.pi + 1e-9, np.pi - 1e-9)
    string = float(model.transverse[row, 0]) / np.pi
    expected = 2.0 * x * string
    seen = min(found, key=lambda w: abs(w - expected))
    assert seen == pytest.approx(expected, rel=3e-3), (
        f"lambda^2 = {parameter:.3g}: {found[:3]} for {expected}"
    )


@pytest.mark.kernel
def test_friction_above_the_torque_holds_the_rims():
    """Below its Coulomb friction neither pulley turns, and the modes keep still."""
    drive = cd.load_drive("dissertation-2").listed
    drive = replace(drive, pulley=tuple(replace(p, coulomb_friction=0.02) for p in drive.pulley))
    (model, _), torque = made(drive, 1), np.full((400, 1), 0.01)
    moved = [
        motion_stages.integrate([(own, torque)], 1e-5, history=True)[1][-1, : model.natural.size]
        for own in (model, model._replace(friction=np.zeros(2)))
    ]
    held, free = (model.friction_shape[:2] @ own for own in moved)
    assert np.max(np.abs(held)) < 1e-3 * np.abs(free[0]), (held, free)


@pytest.mark.kernel
def test_a_free_mode_across_dies_out_at_its_rate_down_to_the_floor():
    """exp(-c t/2) of the amplitude is left; a mode that has died out is kept at the floor."""
    settings = ["cable.transverse_damping=8", "layout.gravity=0"]
    model, _ = made(cd.load_drive("dissertation-3", overrides=settings).listed, 2)
    numbers, steps, h = numbers_of(model, 1e-5), 1500, 1e-5
    left = np.exp(-0.5 * model.loss * steps * h)
    for floor, expected in ((0.0, 1e-9 * left), (0.99e-9, np.full(left.shape, 0.99e-9))):
        state, (rows, m) = new_stretch_state(numbers), model.sag.shape
        state.sines[:] = 1e-9
        seen = np.zeros((rows, model.probes.shape[2])), np.zeros((rows, m)), np.zeros((rows, m))
        rest_of = np.array([np.inf]), np.zeros((0, len(model.direct)))
        runs.extremes_run(numbers, state, np.zeros((steps, 1)), 0, floor, (*seen, *rest_of))
        size = np.hypot(state.sines, state.rates / model.transverse)
        np.testing.assert_allclose(size, expected, rtol=2e-3)
        np.testing.assert_allclose(seen[1], 1e-9, rtol=1e-3)


# --- Limits and sizes that models of the loop state: slack, a span outside a mode, length of the cable
DRIVE = cd.load_drive("dissertation-2").listed


def test_the_stated_limit_of_the_load_torque_is_where_a_span_goes_slack():
    with pytest.raises(cd.InputRefused) as refused:
        span_tensions(DRIVE, 1e3)
    limit = float(re.search(r"stay below (\S+) N m", str(refused.value))[1])
    assert 0.0 < min(span_tensions(DRIVE, 0.999 * limit).values()) < 2e-3 * DRIVE.cable.pretension
    with pytest.raises(cd.InputRefused):
        span_tensions(DRIVE, 1.001 * limit)


def test_a_span_outside_a_mode_is_not_strained():
    assert largest_slope((), "upper") == 0.0


def test_the_cable_of_a_loop_is_as_long_as_its_stretched_spans():
    stretched = 1.0 + DRIVE.cable.pretension / DRIVE.cable.axial_rigidity
    assert fixed_length(DRIVE) == pytest.approx(2.0 * DRIVE.span_length * stretched, rel=1e-12)
