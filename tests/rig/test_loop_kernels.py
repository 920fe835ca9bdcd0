"""Parts of the loop that few runs enter: an eccentric encoder, sensors of a pair, an exported plant."""

import numpy as np
import pytest

import cabledrive as cd
from cabledrive.control.observers import FlankLaw
from cabledrive.rig import Motion
from cabledrive.rig.closed_loop.cable_plant import CableNumbers, CableRun, act
from cabledrive.rig.closed_loop.chain_kernels import DIVERGED, WENT_SLACK, PairNumbers
from cabledrive.rig.closed_loop.loop import close_loop, loop_at_rest
from cabledrive.rig.closed_loop.loop_kernels import new_plant_state, plant_step, see_chain, sense_pair
from cabledrive.rig.front_door import own_law
from cabledrive.rig.laws.controllers import DesignSpec

pytestmark = pytest.mark.kernel
SHORT = Motion(angle=0.05, rise=0.02, dwell=0.002)


def test_an_eccentric_encoder_shows_the_load_off_by_its_sine():
    loop = short_loop()
    state = loop_at_rest(loop)
    state.x[:] = 0.1 * np.arange(1.0, state.x.size + 1.0)
    eccentric = loop.plant._replace(eccentricity=2e-3, turning=2.0, phases=np.array([0.0, 0.0, 0.4]))
    see_chain(loop.plant, 10.0, state)
    np.testing.assert_array_equal(state.work[: state.x.size], state.x)
    assert see_chain(eccentric, 10.0, state) == 0
    off = state.work[: state.x.size] - state.x
    assert off[2] == pytest.approx(2e-3 * np.sin(2.0 * 0.3 + 0.4), rel=1e-12)
    assert np.count_nonzero(off) == 1
    assert see_chain(loop.plant, 0.2, state) == DIVERGED
    assert see_chain(loop.plant._replace(twist_limit=0.05), 10.0, state) == WENT_SLACK


def short_loop():
    drive = cd.load_drive("dissertation-3")
    controller = own_law(cd.OwnController(step=max, initial_state=np.zeros(3)), DesignSpec(drive, SHORT))
    return close_loop(DesignSpec(drive, SHORT), controller, np.random.default_rng(1))


def test_both_encoders_of_a_pair_count_from_places_of_their_own():
    loop, count = short_loop(), 6e-4
    law = FlankLaw(*np.zeros(len(FlankLaw._fields)))._replace(preload=0.2, stiffness=100.0)
    pair = PairNumbers(law=law, phase=0.3, start=0.01, joint=np.array([-1, -1]), record=np.zeros((0, 6)))
    rig = loop.rig._replace(counts=np.full(3, count), phases=np.full(3, -0.3))
    state = loop_at_rest(loop)
    first, second = 500.35 * count, 466.4 * count
    state.x[:2], state.work[0] = (first - second + 0.02, 0.0), 0.5 * (first + second)
    pressed = sense_pair(pair, rig, state)
    seen = [count * np.floor(angle / count + phase + 0.5) for angle, phase in ((first, -0.3), (second, 0.3))]
    assert state.readings[0] == pytest.approx(np.mean(seen), abs=1e-15)
    assert pressed == pytest.approx(0.5 * (seen[0] - seen[1]) + 0.002, abs=1e-15)


def test_a_plant_takes_all_the_momentum_that_its_command_gives_after_the_delay():
    loop = short_loop()
    still = dict.fromkeys(("viscous", "coulomb", "offset"), np.zeros(3))
    plant = loop.plant._replace(**still, current_rate=0.0, twist_limit=np.inf)
    rig = loop.rig._replace(late_samples=0, late_part=0.3 * loop.rig.interval)
    state = new_plant_state(plant, rig)
    for _ in range(6):
        plant_step(plant, rig, state, 0.1, 0.0, 0.0)
    assert plant.inertia @ state.x[3:6] == pytest.approx(0.1 * 5.7 * rig.interval, rel=1e-12)


def test_the_motor_of_a_cable_has_its_older_command_until_the_delay_has_passed():
    """A step spreads its torque half a step to both sides; a torque loop follows by its time constant."""
    rig = short_loop().rig._replace(interval=1e-3, late_part=0.3e-3)
    at_rest = dict.fromkeys(CableNumbers._fields, 0)
    for rate in (0.0, 700.0):
        numbers = CableNumbers(**at_rest)._replace(steps=5, rate=rate)
        run = CableRun(**dict.fromkeys(CableRun._fields))._replace(numbers=numbers, torques=np.empty((5, 1)))
        kernel = getattr(act, "py_func", act)
        end = kernel(run, rig, np.array([2.0, -1.0]), 0.4, 0.25)
        given = run.torques[:, 0] - 0.25
        if rate:
            kept = np.exp(-rate * 0.2e-3)
            filtered = [0.4]
            for command in (2.0, 0.5, -1.0, -1.0, -1.0):
                filtered.append(kept * filtered[-1] + (1.0 - kept) * command)
            np.testing.assert_allclose([*given, end], filtered, rtol=1e-14)
        else:
            np.testing.assert_allclose(given, [2.0, 2.0, -1.0, -1.0, -1.0], atol=1e-12)
            assert end == -1.0
