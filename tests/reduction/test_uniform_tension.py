"""The uniform-tension model: coefficients, exact linear part, its kernels, ensembles of its one mode."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import ellipk

import cabledrive as cd
from cabledrive.reduction.autoparametric import at_pretension, autoparametric_model
from cabledrive.reduction.oscillators import Largest, oscillator_coefficients, oscillator_ensemble
from cabledrive.reduction.uniform_tension import coefficients, integrate, uniform_tension_model
from resonance_samples import damped

TUNED = cd.load_drive(
    "dissertation-2",
    overrides=[
        "cable.pretension=3.28377",
        "layout.gravity=0",
        "cable.transverse_damping=2",
        "pulley.1.viscous_friction=2e-5",
    ],
)


def rest(model, planes=1):
    k, m = model.natural.size, model.transverse.size
    return np.zeros(k), np.zeros(k), np.zeros((planes, 2, m)), np.zeros((planes, 2, m))


def test_coupling_is_the_integral_of_strain_and_squared_slope():
    """G of (R.3) by quadrature of the certified shape: EA kappa^2/2 times the integral of U' cos^2."""
    model = uniform_tension_model(TUNED, 3)
    s = np.linspace(0.0, TUNED.span_length, 20_001)
    mode = cd.modes(TUNED, below=200.0).longitudinal[0]
    for j, span in enumerate(TUNED.spans):
        shape = mode.shape(span, s)[0]
        for m in (1, 2, 3):
            middle = np.cos(m * np.pi * 0.5 * (s[1:] + s[:-1]) / TUNED.span_length) ** 2
            integral = (
                0.5
                * TUNED.cable.axial_rigidity
                * model.wave_numbers[m - 1] ** 2
                * np.sum(np.diff(shape) * middle)
            )
            assert abs(model.coupling[1, j, m - 1]) == pytest.approx(abs(integral), rel=1e-7)


def integrate_reference(model, h, start, torque, stride):
    """Readable twin of the compiled integrator: records, tallies and peaks of `IntegratedMotion`."""
    q, p, a, b = start
    numbers, n_end = coefficients(model, h), torque.size - 1
    across_loss, stretching = model.transverse_mass * model.transverse_damping, numbers.stretching
    along, across, tallies, tally = [], [], [], np.zeros(3)
    peaks = np.array([[np.inf, 0.0], [np.inf, 0.0]])
    for n in range(n_end + 1):
        stretched = np.einsum("pjm,m->j", a**2, stretching)
        tension = model.pretension + numbers.tension @ q + model.axial_rigidity / model.span * stretched
        peaks[:, 0] = np.minimum(peaks[:, 0], tension)
        peaks[:, 1] = np.maximum(peaks[:, 1], np.sqrt(np.sum(np.sum(np.abs(a), axis=2) ** 2, axis=0)))
        stiffening = 2.0 / model.transverse_mass * np.einsum("k,kjm->jm", q, model.coupling)
        pull = -(stiffening + stretched[:, None] * numbers.carried) * a
        force = model.torque_shape * torque[n] - np.einsum("kjm,pjm->k", model.coupling, a**2)
        half, rest = 0.5 * h * (n > 0), 0.5 * h * (n < n_end)
        speed, swing = p + half * force, b + half * pull
        lost = across_loss * np.sum(swing**2), speed @ model.damping @ speed
        power = np.array([torque[n] * (model.torque_shape @ speed), *lost])
        tally += power * half
        if n % stride == 0:
            along.append([q.copy(), speed])
            across.append([a.copy(), swing])
            tallies.append(tally.copy())
        tally += power * rest
        p += (half + rest) * force
        b += (half + rest) * pull
        if n < n_end:
            q[:], p[:] = np.split(numbers.along @ np.concatenate((q, p)), 2)
            a[0] -= numbers.sag
            flow = numbers.across
            a[:], b[:] = flow[0] * a + flow[1] * b, flow[2] * a + flow[3] * b
            a[0] += numbers.sag
    return np.array(along), np.array(across), np.array(tallies), peaks


LOSSES = ["cable.transverse_damping=2", "pulley.1.viscous_friction=2e-5"]
DAMPED = cd.load_drive("dissertation-2", overrides=[*LOSSES, "cable.pretension=3.26"])
JOINTED = cd.load_drive("dissertation-3", overrides=[*LOSSES, "motor.coulomb_friction=0"])
SIZES = (1e-4, 1e-2, 1e-3, 0.1)
"""Of modes [m], their rates, sines and theirs at the start."""


@pytest.mark.kernel
@pytest.mark.parametrize(("sines", "planes"), [(1, 1), (5, 1), (5, 2)])
@pytest.mark.parametrize("drive", [DAMPED, JOINTED], ids=["loop", "motor joint"])
@pytest.mark.parametrize("stride", [1, 7])
def test_compiled_integration_equals_its_readable_twin(drive, sines, planes, stride):
    """cabledrive.reduction.modal_cable_kernels: torque, every loss; records, tallies, peaks and the end."""
    model, rng = uniform_tension_model(drive, sines), np.random.default_rng(4)
    state = [
        size * rng.standard_normal(part.shape) for size, part in zip(SIZES, rest(model, planes), strict=True)
    ]
    torque, h, runs = 0.05 * rng.standard_normal(141), 1e-4, []
    for method, numbers in ((integrate, coefficients(model, h)), (integrate_reference, h)):
        start = [part.copy() for part in state]
        runs.append((*method(model, numbers, start, torque, stride), *start))
    for compiled, readable in zip(*runs, strict=True):
        assert compiled.shape == readable.shape
        error = np.max(np.abs(compiled - readable)) / np.max(np.abs(readable))
        assert error < 1e-12, f"{error:.1e}"


@pytest.mark.parametrize("whirling", [False, True])
def test_one_mode_limit_is_the_nonlinear_string(whirling, measured):
    """Heavy pulleys, one sine: elliptic integral in a plane, sqrt(w0^2 + alpha A^2) on a circle."""
    heavy = [replace(pulley, inertia=1e6) for pulley in TUNED.pulley]
    cable = replace(TUNED.cable, transverse_damping=0.0)
    drive = replace(
        TUNED, pulley=tuple(replace(pulley, viscous_friction=0.0) for pulley in heavy), cable=cable
    )
    model = uniform_tension_model(drive, 1)
    step, amplitude = 1e-5, 4e-3
    alpha = model.carrier * model.wave_numbers[0] ** 4 * model.span / 4
    w0 = model.transverse[0]
    hardened = np.sqrt(w0**2 + alpha * amplitude**2)
    q, p, a, b = rest(model, planes=2)
    a[0, 0, 0] = amplitude
    if whirling:
        b[1, 0, 0] = amplitude * hardened
        expected = hardened
    else:
        parameter = alpha * amplitude**2 / (2 * hardened**2)
        expected = np.pi * hardened / (2 * ellipk(parameter))
    recorded = integrate(model, coefficients(model, step), (q, p, a, b), np.zeros(100_001), 1)
    w = recorded.across[:, 0, 0, 0, 0]
    down = np.flatnonzero((w[:-1] > 0) & (w[1:] <= 0))
    crossings = (down + w[down] / (w[down] - w[down + 1])) * step
    observed = 2 * np.pi * (down.size - 1) / (crossings[-1] - crossings[0])
    motion = "whirling" if whirling else "planar"
    measured(f"{motion}: frequency within {abs(observed / expected - 1.0):.1e} of the string's")
    assert observed == pytest.approx(expected, rel=1e-6), (
        f"observed {observed:.9f}, expected {expected:.9f} rad/s"
    )


def test_integration_converges_with_order_two_against_its_own_law():
    """Strang splitting: halving the step divides the error of the coupled motion by four."""
    model = uniform_tension_model(TUNED, 2)
    ends = []
    for halvings in range(5):
        step = 8e-4 / 2**halvings
        q, p, a, b = rest(model)
        a[0, :, 0] = 3e-3, 1e-3
        steps = round(0.2 / step)
        integrate(model, coefficients(model, step), (q, p, a, b), np.full(steps + 1, 0.01), steps)
        ends.append(np.concatenate((q * 100, a.ravel())))
    errors = [np.linalg.norm(end - ends[-1]) for end in ends[:3]]
    order = np.log2(errors[0] / errors[1]), np.log2(errors[1] / errors[2])
    assert order[1] == pytest.approx(2.0, abs=0.15), f"orders {order}, errors {errors}"


def lanes(count, seed=0):
    rng = np.random.default_rng(seed)
    return rng.uniform(3.1, 3.5, count), rng.uniform(0.0, 0.05, count), rng.uniform(3e-4, 3e-3, (2, count))


@pytest.mark.kernel
@pytest.mark.parametrize("threads", [1, 2])
def test_compiled_ensembles_equal_their_readable_twins(threads):
    """cabledrive.reduction.oscillators, compiled and as numpy over all lanes at once."""
    tension, torque, plucks = lanes(70)
    model = at_pretension(autoparametric_model(damped(2.0, 8.0)), tension)
    c = oscillator_coefficients(model, 1e-3, torque=torque)
    compiled = oscillator_ensemble(c, plucks, 100, threads=threads)
    for one, other in zip(compiled, oscillator_ensemble_reference(c, plucks, 100), strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-14)


def test_oscillators_equal_the_uniform_tension_model_of_one_mode():
    """The same physics integrated by another code: largest values over 0.5 s within half a per cent."""
    drive, torque, plucks = damped(1.5, 9.0), 0.03, np.array([2e-3, 5e-4])
    model, uniform = autoparametric_model(drive), uniform_tension_model(drive, 1)
    h = 2 * np.pi / model.natural / 32
    steps = int(0.5 / h)
    largest = oscillator_ensemble(oscillator_coefficients(model, h, torque=[torque]), plucks[:, None], steps)
    q, p = np.zeros(uniform.natural.size), np.zeros(uniform.natural.size)
    a = np.zeros((1, 2, 1))
    a[0, :, 0] = plucks
    wave = torque * np.sin(model.natural * h * np.arange(steps + 1))
    run = integrate(uniform, coefficients(uniform, h), (q, p, a, np.zeros_like(a)), wave, 1)
    relative = run.along[:, 0, 1] * (uniform.rims[1, 1] - uniform.rims[1, 0])
    assert largest.pulley[0] == pytest.approx(np.max(np.abs(relative)), rel=5e-3)
    spans = np.max(np.abs(run.across[:, 0, 0, :, 0]), axis=0)
    np.testing.assert_allclose(largest.spans[:, 0], spans, rtol=5e-3)


# --- Ensembles in readable steps, for any number of transverse modes
def oscillator_ensemble_reference(c, plucks, steps):
    """Largest displacements by the oscillators themselves: half a kick, exact flow, half a kick."""
    a = np.array(plucks, dtype=float)
    b, q, p, v = np.zeros_like(a), np.zeros(a.shape[1:]), np.zeros(a.shape[1:]), np.zeros(a.shape[1:])
    largest = np.zeros((1 + len(a), *a.shape[1:]))
    for n in range(steps + 1):
        largest = np.maximum(largest, np.abs(np.concatenate((q[None], a))))
        h = (0.5 if n in (0, steps) else 1.0) * c.step
        wave = np.sin(n * c.turn)
        q_force = c.force * wave - c.cross * v - np.sum(c.push * a**2, axis=0)
        v_force = c.rigid_force * wave - c.rigid_decay * v - c.rigid_cross * p
        b = b - h * (c.pump * q + np.einsum("jk...,k...->j...", c.cubic, a**2)) * a
        p, v = p + h * q_force, v + h * v_force
        if n < steps:
            q, p = c.along[0] * q + c.along[1] * p, c.along[2] * q + c.along[3] * p
            a, b = c.across[0] * a + c.across[1] * b, c.across[2] * a + c.across[3] * b
    return Largest(largest[0], largest[1:], np.concatenate((q[None], a)))
