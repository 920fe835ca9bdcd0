"""Many plants in vector lanes: the same runs as one by one.

Compiled modules under test: cabledrive.rig.closed_loop.batch_kernels.
"""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import expm

from cabledrive.parameters import load_drive
from cabledrive.rig import Motion, RigOptions
from cabledrive.rig.closed_loop.batch_kernels import integrate_many, integrate_one, smooth_sign
from cabledrive.rig.closed_loop.batch_tables import exponentials, free_transitions
from cabledrive.rig.closed_loop.loop import close_loop, run
from cabledrive.rig.closed_loop.plant import plant_numbers
from cabledrive.rig.closed_loop.plant_batch import fits_batch, run_one
from cabledrive.rig.laws.registry import design
from cabledrive.rig.plant_samples import run_samples, sampled_chain, sampled_loops
from cabledrive.rig.trial import spec_for

DRIVE = load_drive("dissertation-3")
SMOOTH = RigOptions(ideal_sensors=True, smooth_friction=True)
SHORT = Motion(angle=20.0, rise=0.2, dwell=0.05)


def loop_of(law, options=SMOOTH, motion=SHORT, plant_model=None):
    spec = spec_for(DRIVE, motion)
    generator = np.random.default_rng(0)
    return close_loop(DRIVE, DRIVE, design(law, spec), motion, options, generator, plant_model=plant_model)


@pytest.mark.parametrize(
    "law, plant",
    [("darc-1", 1), ("darc-2", 2), ("darc-3", 3), ("darc-3", 4), ("darc-4", 4), ("darc-4-damped", 4)],
)
def test_a_batch_scores_what_single_runs_score(law, plant, measured):
    """Twenty plants: two groups of lanes, the second with lanes to spare."""
    loop = loop_of(law, plant_model=plant)
    assert fits_batch(loop)
    lanes = run_samples(loop, SMOOTH, 20, 5).scores[:, :6]
    single = np.array([run(one, log=False).state.summary[:6] for one in sampled_loops(loop, SMOOTH, 20, 5)])
    off, size = np.abs(lanes - single).max(axis=0), np.abs(single).max(axis=0)
    measured(f"within {(off[size > 0.0] / size[size > 0.0]).max():.1e} of each score")
    np.testing.assert_allclose(lanes, single, rtol=1e-8, atol=1e-11)
    np.testing.assert_allclose(
        run_one(loop)[:6], run(loop, log=False).state.summary[:6], rtol=1e-8, atol=1e-11
    )


@pytest.mark.kernel
def test_short_run_as_a_batch_of_one_is_the_run():
    loop = loop_of("darc-4", motion=Motion(angle=0.1, rise=0.004, dwell=0.001))
    np.testing.assert_allclose(
        run_one(loop)[:6], run(loop, log=False).state.summary[:6], rtol=1e-8, atol=1e-13
    )


@pytest.mark.kernel
def test_smooth_sign_is_the_hyperbolic_tangent():
    x = np.concatenate((np.linspace(-25.0, 25.0, 501), [-1e9, 1e9]))
    worst = max(abs(smooth_sign(float(v)) - np.tanh(v)) for v in x)
    assert worst < 2e-14, f"observed {worst:.1e}"


@pytest.mark.parametrize("kernel", [integrate_many, integrate_one])
def test_kernels_hold_numbers_alone_so_that_one_process_finds_what_another_has_compiled(kernel):
    """A kernel in a closure has another key in each process: all of them would compile it anew."""
    cells = getattr(kernel, "py_func", kernel).__closure__
    assert [type(cell.cell_contents) for cell in cells] == [int]


def test_transitions_made_at_once_are_those_made_singly():
    chain = loop_of("darc-4").chain
    chains = [sampled_chain(chain, np.random.default_rng(seed)) for seed in range(5)]
    together = free_transitions(chains, 2e-4, 6000.0)
    for made, row in zip(together, chains, strict=True):
        alone = plant_numbers(row, 2e-4, current_rate=6000.0).tables[1]
        np.testing.assert_allclose(made, alone, rtol=1e-11, atol=1e-13 * np.abs(alone).max())


def test_exponentials_of_small_matrices_are_scipys():
    matrices = np.random.default_rng(3).normal(size=(20, 8, 8)) * np.geomspace(1e-6, 8.0, 20)[:, None, None]
    for made, matrix in zip(exponentials(matrices), matrices, strict=True):
        exact = expm(matrix)
        assert np.abs(made - exact).max() <= 1e-12 * np.abs(exact).max()


@pytest.mark.parametrize(
    "options",
    [
        RigOptions(),
        replace(SMOOTH, smooth_friction=False),
        replace(SMOOTH, jitter=1e-5),
        replace(SMOOTH, substeps=2),
    ],
)
def test_what_a_batch_cannot_follow_runs_one_by_one(options):
    assert not fits_batch(loop_of("darc-4", options))


def test_a_slack_span_fails_the_draw_in_its_batch():
    loop = replace(loop_of("darc-4"), twist_limit=0.02)
    assert run_samples(loop, SMOOTH, 18, 1).failed == 18
