"""Parts of the loop that few runs enter: a part of a step, an eccentric encoder."""

import numpy as np
import pytest
from cabledrive.rig.closed_loop.disturbed_kernels import UNDISTURBED
from cabledrive.rig.closed_loop.plant import plant_numbers
from cabledrive.rig.closed_loop.plant_kernels import MOST_TERMS, advance
from scipy.linalg import expm

import cabledrive as cd
from cabledrive.reduction.lumped_chain import state_space
from cabledrive.rig import Motion, RigOptions
from cabledrive.rig.closed_loop.loop import close_loop, loop_at_rest
from cabledrive.rig.closed_loop.loop_kernels import see_chain
from cabledrive.rig.laws.own_law import own_law
from cabledrive.rig.trial import spec_for
from control_chains import INTERVAL, model

pytestmark = pytest.mark.kernel
CHAIN = model(4)
SHORT = Motion(angle=0.05, rise=0.02, dwell=0.002)


def test_a_part_of_a_step_with_smoothed_friction_is_that_of_the_linear_plant_with_it_held():
    """Against the matrix exponential, with the friction of the speed at its beginning."""
    numbers, size = plant_numbers(CHAIN, INTERVAL, smooth=True), CHAIN.size
    scalars = numbers[-1]
    a, b = state_space(CHAIN)
    x = 0.1 * np.sin(1.0 + np.arange(2.0 * size + 1.0))
    friction = CHAIN.coulomb[0] * np.tanh(scalars[8] * x[size])
    assert abs(friction) > 0.5 * CHAIN.coulomb[0]
    part, command, push, pull = 0.37 * INTERVAL, 0.05, 0.04, -0.02
    torques = np.zeros(size)
    torques[0], torques[-1] = command + push + CHAIN.offsets[0] - friction, pull
    held = np.zeros((2 * size + 1, 2 * size + 1))
    held[:-1, :-1], held[:-1, -1] = a, b @ torques
    expected = (expm(part * held) @ np.append(x[:-1], 1.0))[:-1]
    advance(*numbers, x, 0, command, push, pull, part, np.zeros((MOST_TERMS, x.size)), np.zeros(x.size))
    np.testing.assert_allclose(x[:-1], expected, rtol=1e-10, atol=1e-13)


def test_an_eccentric_encoder_shows_the_load_off_by_its_sine():
    drive = cd.load_drive("dissertation-3")
    controller = own_law(cd.OwnController(step=max, initial_state=np.zeros(3)), spec_for(drive, SHORT))
    loop = close_loop(drive, drive, controller, SHORT, RigOptions(), np.random.default_rng(1))
    state = loop_at_rest(loop)
    state.x[:] = 0.1 * np.arange(1.0, state.x.size + 1.0)
    eccentric = UNDISTURBED._replace(
        inertias=np.ones(3), eccentricity=2e-3, turning=2.0, phases=np.array([0.0, 0.0, 0.4])
    )
    see_chain(UNDISTURBED, state)
    np.testing.assert_array_equal(state.work[: state.x.size], state.x)
    see_chain(eccentric, state)
    off = state.work[: state.x.size] - state.x
    assert off[2] == pytest.approx(2e-3 * np.sin(2.0 * 0.3 + 0.4), rel=1e-12)
    assert np.count_nonzero(off) == 1
