"""`cabledrive.reduction.uniform_tension_single` equals the readable one, with and without a motor joint."""

import numpy as np
import pytest

import cabledrive as cd
from cabledrive.reduction.uniform_tension import uniform_tension_model
from cabledrive.reduction.uniform_tension_integration import coefficients
from cabledrive.reduction.uniform_tension_kernels import integrate_reference
from cabledrive.reduction.uniform_tension_single import single_sine_kernel

DAMPED = ["cable.transverse_damping=2", "pulley.1.viscous_friction=2e-5", "cable.pretension=3.26"]
JOINTED = [*DAMPED[:2], "motor.coulomb_friction=0"]


@pytest.mark.kernel
@pytest.mark.parametrize("name, overrides", [("dissertation-2", DAMPED), ("dissertation-3", JOINTED)])
@pytest.mark.parametrize("stride", [1, 7])
def test_one_sine_in_one_plane_equals_the_readable_integration(name, overrides, stride):
    """Gravity, torque, every loss; records, final state, lowest tension and largest displacement."""
    model = uniform_tension_model(cd.load_drive(name, overrides=overrides), 1)
    modes, rng = model.natural.size, np.random.default_rng(4)
    start = [
        scale * rng.standard_normal(shape)
        for scale, shape in ((1e-4, modes), (1e-2, modes), (1e-3, (1, 2, 1)), (0.1, (1, 2, 1)))
    ]
    torque, h = 0.05 * rng.standard_normal(141), 1e-4
    ours, theirs = [part.copy() for part in start], [part.copy() for part in start]
    found = single_sine_kernel(coefficients(model, h), *ours, torque, h, stride)
    expected = integrate_reference(coefficients(model, h), *theirs, torque, h, stride)
    for mine, other in zip((*found, *ours), (*expected, *theirs), strict=True):
        assert mine.shape == other.shape
        error = np.max(np.abs(mine - other)) / np.max(np.abs(other))
        assert error < 1e-12, f"{error:.1e}"
