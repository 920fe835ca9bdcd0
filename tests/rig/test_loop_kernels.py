"""Parts of the loop that few runs enter: a part of a step, samples round a controller of the user's own."""

from dataclasses import replace

import numba
import numpy as np
import pytest
from scipy.linalg import expm

import cabledrive as cd
from cabledrive.control.linear_laws import pid_law
from cabledrive.reduction.lumped_chain import state_space
from cabledrive.reduction.models import lumped_model
from cabledrive.reduction.reflected import reflected
from cabledrive.rig import Motion, RigOptions
from cabledrive.rig.closed_loop.loop import close_loop, loop_at_rest, run
from cabledrive.rig.closed_loop.own_loop import run_own
from cabledrive.rig.closed_loop.plant import plant_numbers
from cabledrive.rig.closed_loop.plant_kernels import MOST_TERMS, advance
from cabledrive.rig.laws.own_law import own_law
from cabledrive.rig.setting import sample_interval
from cabledrive.rig.trial import spec_for
from control_chains import INTERVAL, model

pytestmark = pytest.mark.kernel
CHAIN = model(4)


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


def with_memory(gains, state, measurement, reference):
    """A linear law with states, as its matrices say: command first, then the next state."""
    matrix, row = gains
    both = np.concatenate((state, measurement - reference[:-1]))
    return matrix @ np.append(both, 0.0), reference[-1] + row @ both


def test_the_samples_round_a_controller_of_ones_own_are_those_of_the_plain_loop():
    """With a dropout of an encoder, in which the last command is held."""
    drive = cd.load_drive("dissertation-3")
    chain, interval = reflected(lumped_model(drive, 4))[0], sample_interval(drive)
    motion = Motion(angle=0.05, rise=0.04, dwell=0.002, order=11)
    law = pid_law(chain, 2.0, 28.0, interval)
    own = cd.OwnController(step=with_memory, gains=(law.matrix, law.rows[0]), initial_state=np.zeros(3))
    controller = own_law(own, spec_for(drive, motion))
    options = RigOptions(blind=("load", 0.01, 0.011))
    plain, ours = (
        close_loop(drive, drive, controller, motion, options, np.random.default_rng(1)) for _ in "ab"
    )
    expected = run(plain)
    compiled = replace(own, step=numba.njit(with_memory))
    ours = replace(ours, controller=replace(ours.controller, own=compiled))
    state, log = loop_at_rest(ours), np.zeros_like(expected.log)
    assert run_own(ours, 0, len(log), state, log) == len(log)
    np.testing.assert_allclose(log, expected.log, rtol=0.0, atol=1e-9)
    assert state.summary[6] == expected.state.summary[6] > 0
