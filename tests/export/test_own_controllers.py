"""A controller of the user's own is exported by the same door: C is its step to the bit."""

import numpy as np
import pytest

import cabledrive as cd
from cabledrive.control.controller_kernels import own_target_step, start_target
from cabledrive.export.blocks import target_kernel
from cabledrive.export.source import designed, designed_loop
from export.compilers import WARNINGS, checked, needs_cc
from export.designs import DRIVE, OWN, replayed, step


def on_readings(gains, state, measurement, reference):
    stiffness, damping = gains
    speed = (measurement[0] - state[0]) / 2e-4
    state[0] = measurement[0]
    return state, stiffness * (reference[0] - measurement[0]) - damping * speed


UNFILTERED = cd.OwnController(
    step=on_readings,
    gains=(0.5, 0.02),
    initial_state=[0.0],
    name="unfiltered",
    measures="readings",
    follows="motion",
)


@pytest.fixture(scope="module")
def exported(tmp_path_factory):
    """Folder of a controller exported once, and what the export said."""
    kept = {}

    def export(own):
        if own.name not in kept:
            folder = tmp_path_factory.mktemp(own.name) / "c"
            kept[own.name] = folder, cd.export_to(folder, DRIVE, "c99", controller=own)
        return kept[own.name]

    return export


@needs_cc
@pytest.mark.parametrize("own", [OWN, UNFILTERED], ids=lambda own: own.name)
def test_a_controller_of_ones_own_passes_its_self_test_to_the_bit(own, exported):
    folder, made = exported(own)
    assert made["sample_time"] == pytest.approx(2e-4)
    done = checked(folder, "-O2", *WARNINGS)
    assert done.returncode == 0, done.stdout
    assert "1000 samples, command kept at 7, largest difference 0 N m" in done.stdout


def test_the_target_steps_as_the_rig_does():
    """Readings of a run on the rig, replayed; the rig's filter settled from the start."""
    law = designed(DRIVE, OWN).law
    kernel = target_kernel(law)
    target = own_target_step(step, True)
    found, rig = replayed(
        designed_loop(DRIVE, OWN), law,
        lambda y: start_target(kernel.begin, kernel.state, y),
        lambda y, row: target(*kernel.numbers.values(), law.torque_limit, kernel.state, y, row), 300,
    )  # fmt: skip
    np.testing.assert_allclose(found, rig, rtol=1e-6, atol=1e-11)
