"""Margins and ripple against perturbed loops and another assembly of the same loop."""

from dataclasses import replace

import numpy as np
import pytest

from cabledrive.parameters import load_drive
from cabledrive.rig import Motion, RigOptions
from cabledrive.rig.closed_loop.linear_loop import linear_loop
from cabledrive.rig.closed_loop.loop import close_loop
from cabledrive.rig.laws.registry import CONTROLLERS
from cabledrive.rig.ranking.margins import (
    SIGMAS,
    closed_loop,
    margins_of,
    sampled_controller,
    sampled_plant,
)
from cabledrive.rig.trial import spec_for

MOTION = Motion(angle=5.0, rise=0.2, dwell=0.05, order=11)


def loop_of(name, hertz, *overrides):
    drive = load_drive("dissertation-3", overrides=list(overrides))
    made = CONTROLLERS[name](spec_for(drive, MOTION, bandwidth=hertz))
    return close_loop(drive, drive, made, MOTION, RigOptions(), np.random.default_rng(0))


def stable_with(loop, factor):
    """Whether the loop is stable where the plant's torque is the command times a complex factor."""
    plant = sampled_plant(loop)
    scaled = replace(plant, b=plant.b * factor, a=plant.a.astype(complex))
    controller = sampled_controller(loop)
    m, p = plant.c.shape[0], len(plant.a)
    matrix, _, _ = closed_loop(controller, plant)
    command = np.concatenate((controller.d[:, :m] @ plant.c, controller.c), axis=1)[0]
    matrix = matrix.astype(complex)
    matrix[:p] += np.outer((scaled.b - plant.b)[:, 0], command)
    return bool(np.abs(np.linalg.eigvals(matrix)).max() < 1.0)


@pytest.mark.parametrize(
    "name, hertz", [("pd", 11.0), ("lqi", 30.0), ("lqg-dob", 20.0), ("darc-4-damped", 25.0)]
)
def test_the_gain_margin_is_the_factor_at_which_the_loop_becomes_unstable(name, hertz):
    loop = loop_of(name, hertz)
    margin = margins_of(loop).gain
    assert stable_with(loop, 0.98 * margin)
    assert not stable_with(loop, 1.02 * margin)


@pytest.mark.parametrize(
    "overrides", [(), ("sensors.delay=1 ms",), ("sensors.delay=0.3 ms", "motor.current_bandwidth=100 Hz")]
)
def test_every_gain_and_phase_in_the_disk_leaves_the_loop_stable(overrides):
    loop = loop_of("lqi", 12.0, *overrides)
    found = margins_of(loop)
    half = 0.99 * found.disk / 2.0
    for turn in np.exp(1j * np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)):
        assert stable_with(loop, (1.0 + half * turn) / (1.0 - half * turn))
    phase = 2.0 * np.arctan(half)
    assert phase <= found.phase
    assert stable_with(loop, np.exp(-1j * phase))


def test_ripple_is_that_of_the_linear_loop_of_the_best_gains(measured):
    """Another assembly of plant, filter and law: five deviations of the command by white rounding."""
    loop = loop_of("darc-4-damped", 30.0)
    theirs = SIGMAS * linear_loop(loop).noise(loop.rig.counts, 20_000)[1]
    ours = margins_of(loop).ripple
    measured(f"{ours:.4f} N m, the other {theirs:.4f}")
    assert ours == pytest.approx(theirs, rel=0.02)
