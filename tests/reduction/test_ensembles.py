"""Ensembles of the resonance model: compiled against readable, averaged against oscillators."""

import numpy as np
import pytest

import cabledrive as cd
from cabledrive.reduction.autoparametric import at_pretension, autoparametric_model
from cabledrive.reduction.averaging import averaged_coefficients
from cabledrive.reduction.ensembles import averaged_ensemble, oscillator_ensemble
from cabledrive.reduction.oscillators import oscillator_coefficients
from cabledrive.reduction.start_map import plucked
from cabledrive.reduction.uniform_tension import uniform_tension_model
from cabledrive.reduction.uniform_tension_integration import coefficients, integrate
from oracles.ensembles import averaged_ensemble_reference, oscillator_ensemble_reference
from resonance_samples import damped


def lanes(count, seed=0):
    rng = np.random.default_rng(seed)
    return rng.uniform(3.1, 3.5, count), rng.uniform(0.0, 0.05, count), rng.uniform(3e-4, 3e-3, (2, count))


@pytest.mark.kernel
@pytest.mark.parametrize("threads", [1, 2])
def test_compiled_averaged_ensemble_equals_its_readable_twin(threads):
    """cabledrive.reduction.ensemble_kernels, compiled and as Python; lanes that do not fill a block."""
    tension, torque, plucks = lanes(70)
    model = at_pretension(autoparametric_model(damped(2.0, 8.0)), tension)
    c = averaged_coefficients(model, torque=torque, passive=0.15 * plucks**2)
    start = plucked(c, plucks, second=False)
    compiled = averaged_ensemble(c, start, 0.1, threads=threads)
    readable = averaged_ensemble_reference(c, start, 0.1)
    for one, other in zip(compiled, readable, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-10, atol=1e-15)


@pytest.mark.kernel
@pytest.mark.parametrize("threads", [1, 2])
def test_compiled_oscillator_ensemble_equals_its_readable_twin(threads):
    """cabledrive.reduction.ensemble_kernels, the oscillators."""
    tension, torque, plucks = lanes(70)
    model = at_pretension(autoparametric_model(damped(2.0, 8.0)), tension)
    c = oscillator_coefficients(model, 1e-3, torque=torque)
    compiled = oscillator_ensemble(c, plucks, 100, threads=threads)
    readable = oscillator_ensemble_reference(c, plucks, 100)
    for one, other in zip(compiled, readable, strict=True):
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
    run = integrate(coefficients(uniform, h), q, p, a, np.zeros_like(a), wave, h, 1)
    relative = run.along[:, 0, 1] * (uniform.rims[1, 1] - uniform.rims[1, 0])
    assert largest.pulley[0] == pytest.approx(np.max(np.abs(relative)), rel=5e-3)
    spans = np.max(np.abs(run.across[:, 0, 0, :, 0]), axis=0)
    np.testing.assert_allclose(largest.spans[:, 0], spans, rtol=5e-3)


def test_averaged_and_oscillating_ensembles_agree_on_the_largest_motion():
    """100 sets at tuning, 0.5 s: largest amplitudes within 3 % of the largest, first order."""
    _, torque, plucks = lanes(100, 4)
    model = autoparametric_model(damped(2.0, 8.0))
    c = averaged_coefficients(model, torque=torque)
    averaged = averaged_ensemble(c, plucked(c, plucks, second=False), 0.5)
    h = 2 * np.pi / model.natural / 16
    exact = oscillator_ensemble(oscillator_coefficients(model, h, torque=torque), plucks, int(0.5 / h))
    error = np.abs(averaged.spans - exact.spans) / exact.spans.max()
    assert np.max(error) < 0.03, f"{np.max(error):.4f}"


def test_more_sections_than_the_kernel_takes_are_refused():
    model = autoparametric_model(cd.load_drive("linear-axis"))
    c = averaged_coefficients(model, torque=np.ones(4))
    with pytest.raises(cd.InputRefused, match="3 transverse modes"):
        averaged_ensemble(c, np.zeros((4, 4), dtype=complex), 1.0)
