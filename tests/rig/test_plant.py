"""The plant of the rig: exact between samples, with friction that sticks.

Compiled modules under test: cabledrive.rig.closed_loop.plant_kernels,
cabledrive.rig.closed_loop.series_kernels.
"""

from dataclasses import replace

import numpy as np
import pytest

from cabledrive.parameters import InputRefused
from cabledrive.reduction.friction_integration import integrate_chain
from cabledrive.rig.closed_loop.piecewise_kernels import advance_piecewise
from cabledrive.rig.closed_loop.plant import piecewise_numbers, plant_numbers
from cabledrive.rig.closed_loop.plant_kernels import MOST_TERMS, advance
from control_chains import INTERVAL, model
from oracles.readable_plant import ReadablePlant

CHAIN = model(4)
LOOSE = replace(CHAIN, coulomb=(0.0,) * 3, offsets=(0.0,) * 3)


def readable(commands, plant, start=None, load=0.0):
    """States after each command by the plant for the reader, from rest or a state."""
    x, slip, states = [0.0] * 7 if start is None else [float(v) for v in start], 0, []
    if start is not None and start[3] != 0.0:
        slip = int(np.sign(start[3]))
    for u in commands:
        x, slip = plant.moved(x, slip, float(u), INTERVAL, load=load)
        states.append(x)
    return np.array(states)


def motion(commands, *, substeps=1, rate=0.0, smooth=False, chain=CHAIN, hold=INTERVAL):
    """States after each command, from rest."""
    numbers = plant_numbers(chain, hold, current_rate=rate, substeps=substeps, smooth=smooth)
    x, slip = np.zeros(2 * chain.size + 1), 0
    terms, work, states = np.zeros((MOST_TERMS, len(x))), np.zeros(len(x)), []
    for u in commands:
        slip = advance(*numbers, x, slip, u, 0.0, 0.0, hold, terms, work)
        states.append(x.copy())
    return np.array(states)


def wave(samples):
    t = INTERVAL * np.arange(samples)
    return 0.12 * np.sin(2 * np.pi * 2.0 * t) + 0.05 * np.sin(2 * np.pi * 9.0 * t)


@pytest.mark.parametrize("rate", [0.0, 2 * np.pi * 1000.0])
def test_motion_does_not_depend_on_the_internal_step(rate, measured):
    """Sticking, breaking loose and turning are found on the exact motion, not at steps."""
    one = motion(wave(1500), rate=rate)
    for substeps in (3, 10):
        other = motion(wave(1500), rate=rate, substeps=substeps)
        worst = np.abs(one - other)[:, :3].max()
        measured(f"{substeps} internal steps move it by {worst:.1e} rad")
        assert worst < 1e-10, f"{substeps} steps: observed {worst:.2e} rad"


def test_motion_is_that_of_small_runge_kutta_steps(measured):
    u = wave(1500)
    fine = integrate_chain(CHAIN, np.append(u, 0.0), INTERVAL, substeps=8, hold="step")
    worst = np.abs(fine.angles[1:] - motion(u)[:, :3]).max()
    measured(f"{worst:.1e} rad")
    assert worst < 1e-8, f"observed {worst:.2e} rad"


@pytest.mark.kernel
@pytest.mark.parametrize("rate", [0.0, 2 * np.pi * 1000.0])
def test_motion_is_that_of_the_equations_written_out(rate):
    """Sticking, letting go and turning under a wave of torque, with and without a torque loop."""
    u = wave(300)[::2]
    theirs = readable(u, ReadablePlant(chain=CHAIN, rate=rate))
    ours = motion(u, rate=rate)
    assert np.ptp(np.sign(theirs[:, 3])) >= 1.0, "the motor neither sticks nor turns"
    np.testing.assert_allclose(ours, theirs, atol=1e-9 * np.abs(theirs).max(axis=0).max())


@pytest.mark.kernel
def test_a_motor_that_stops_and_goes_on_within_one_internal_step_sticks_between():
    """Friction stops it before the torque loop has passed on enough of the command to let it go again."""
    rate = 2 * np.pi * 1000.0
    start = np.array([0.0, 0.0, 0.0, 2e-4, 0.0, 0.0, 0.0])
    numbers = plant_numbers(CHAIN, INTERVAL, current_rate=rate)
    x, terms, work = start.copy(), np.zeros((MOST_TERMS, 7)), np.zeros(7)
    advance(*numbers, x, 1, 0.2, 0.0, 0.0, INTERVAL, terms, work)
    fine = ReadablePlant(chain=CHAIN, rate=rate, step=1e-6)
    theirs = readable([0.2], fine, start)[0]
    assert fine.moved(list(start), 1, 0.2, 2e-5)[1] == 0, "the motor does not stop"
    assert theirs[3] > 5e-3
    np.testing.assert_allclose(x, theirs, rtol=1e-8, atol=1e-12)


@pytest.mark.kernel
@pytest.mark.parametrize("speed", [3.0, -3.0])
def test_friction_of_the_load_slows_it_whichever_way_it_turns(speed):
    """c tanh(50 w) of the load, against the equations, which do not hold it over a step: first order."""
    chain = replace(LOOSE, coulomb=(0.0, 0.0, 0.02))
    numbers = plant_numbers(chain, INTERVAL, substeps=20)
    start = np.array([0.0, 0.0, 0.0, speed, speed, speed, 0.0])
    x, terms, work = start.copy(), np.zeros((MOST_TERMS, 7)), np.zeros(7)
    for _ in range(50):
        advance(*numbers, x, 1, 0.0, 0.0, 0.0, INTERVAL, terms, work)
    theirs, free = (readable(np.zeros(50), ReadablePlant(chain=one), start)[-1] for one in (chain, LOOSE))
    assert abs(x[5]) < abs(free[5])
    np.testing.assert_allclose(x - free, theirs - free, atol=1e-4 * np.abs(theirs - free).max())


@pytest.mark.kernel
@pytest.mark.parametrize("play, slack, start", [(0.03, np.inf, 0.04), (0.0, 0.05, -0.15), (0.03, 0.05, 0.15)])
def test_backlash_and_slack_spans_move_as_the_equations_written_out(play, slack, start):
    """Released from a wound-up joint and cable; a piece begins at an internal step, hence the tolerance."""
    given, substeps = np.array([start, 0.0, -start, 0.0, 0.0, 0.0, 0.0]), 40
    step = INTERVAL / substeps
    piecewise = piecewise_numbers(LOOSE, step, play=play, slack=slack)
    scalars = plant_numbers(LOOSE, INTERVAL, substeps=substeps).scalars
    x, terms, work, ours = given.copy(), np.zeros((MOST_TERMS, 7)), np.zeros(7), []
    for _ in range(100):
        advance_piecewise(piecewise, scalars, x, 1, 0.0, 0.0, 0.0, INTERVAL, terms, work)
        ours.append(x.copy())
    theirs = readable(np.zeros(100), ReadablePlant(chain=LOOSE, play=play, slack=slack), given)
    size = np.abs(theirs).max(axis=0) + 1e-12
    np.testing.assert_array_less(np.abs(np.array(ours) - theirs).max(axis=0) / size, 2e-3)


@pytest.mark.kernel
def test_torque_below_the_friction_moves_nothing_and_a_load_lets_it_go():
    held = motion(np.full(200, 0.9 * CHAIN.coulomb[0]))
    assert np.all(held[:, :6] == 0.0)
    loose = motion(np.full(200, 1.1 * CHAIN.coulomb[0] + abs(CHAIN.offsets[0])))
    assert loose[-1, 0] > 0.0


@pytest.mark.kernel
def test_torque_loop_of_first_order_follows_its_time_constant():
    """After one time constant the shaft has 1 - 1/e of the command."""
    rate = 2 * np.pi * 100.0
    states = motion(np.full(1, 0.2), rate=rate, hold=1.0 / rate)
    assert states[0, -1] == pytest.approx(0.2 * (1 - np.exp(-1.0)), rel=1e-12)


def test_smoothed_friction_is_of_second_order_in_the_step():
    u = wave(1000)
    fine = motion(u, smooth=True, substeps=64)[-1, 2]
    errors = [abs(motion(u, smooth=True, substeps=k)[-1, 2] - fine) for k in (1, 2, 4)]
    assert errors[0] < 1e-5
    assert errors[1] < errors[0] / 3.0, f"observed {errors}"
    assert errors[2] < errors[1] / 3.0, f"observed {errors}"


def test_energy_only_falls_without_torque():
    """Stored energy after each sample, from a wound-up cable with the motor stuck and free."""
    chain = replace(CHAIN, offsets=(0.0, 0.0, 0.0))
    numbers = plant_numbers(chain, INTERVAL)
    x, slip = np.zeros(7), 0
    x[2] = 0.2
    terms, work, energy = np.zeros((MOST_TERMS, 7)), np.zeros(7), []
    for _ in range(2000):
        slip = advance(*numbers, x, slip, 0.0, 0.0, 0.0, INTERVAL, terms, work)
        theta, omega = x[:3], x[3:6]
        stored = theta @ chain.stiffness_matrix @ theta + omega @ np.diag(chain.inertias) @ omega
        energy.append(0.5 * stored)
    rises = np.diff(energy).max()
    assert rises < 1e-15, f"observed {rises:.2e} J"
    assert slip == 0


def test_friction_of_a_pulley_inside_the_row_is_refused():
    with pytest.raises(InputRefused, match="beside a flexible joint"):
        plant_numbers(replace(CHAIN, coulomb=(0.03, 0.01, 0.0)), INTERVAL)
