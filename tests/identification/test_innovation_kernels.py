"""What cabledrive.identification.axis.equation adds to the observer of a rigid axis."""

import numpy as np
import pytest

from cabledrive.identification.axis.equation import SPARE, answers, loosen, observe, one_sample, shadow

pytestmark = pytest.mark.kernel
H = 1e-3
AXIS = np.array([2e-3, 3e-3, 0.02, 0.001, 0.0])  # inertia, viscous and Coulomb friction, offset; it jumps
GAINS = np.array([0.1, 3.0, H])
TIME = H * np.arange(300)


def observed(torque, axis=AXIS):
    out = np.zeros((5, TIME.size))
    observe(axis, GAINS, torque, np.zeros(TIME.size), np.array([0.0, 5.0]), out)
    return out


@pytest.mark.parametrize("slope", [0.0, 0.5])
def test_what_a_disturbance_adds_to_the_angle_is_the_derivative_of_the_observer(slope):
    """By central differences, along a motion that does not turn, to first order in h (b + c K) / J."""
    torque, axis = 0.03 + 0.01 * np.sin(40.0 * TIME), np.array([*AXIS[:4], slope])
    disturbances = np.array([np.cos(25.0 * TIME), 1.0 - TIME])
    *_, side, jump = observed(torque, axis)
    assert np.all(side == 1.0) or slope > 0.0
    found = np.zeros_like(disturbances)
    answers(axis, GAINS, disturbances, jump, found)
    step = 1e-5
    for answer, disturbance in zip(found, disturbances, strict=True):
        up, down = (observed(torque + sign * step * disturbance, axis)[0] for sign in (1.0, -1.0))
        expected = (down - up) / (2.0 * step)  # an innovation is the angle less the predicted one
        gap = np.abs(answer - expected).max() / np.abs(expected).max()
        assert gap < H * (axis[1] + axis[2] * slope) / axis[0], f"observed {gap:.1e}"


def test_a_disturbance_adds_nothing_more_where_the_axis_sticks():
    found = np.zeros((1, 5))
    answers(AXIS, GAINS, np.ones((1, 5)), np.zeros(5), found)
    np.testing.assert_array_equal(found, 0.0)


def test_a_loose_load_is_caught_after_the_play_and_takes_back_what_the_motor_got():
    """Under a brake a of the motor the play g lasts sqrt(2 g / a); all torques added sum up to nothing."""
    gap, brake, start, contact, turn = 0.02, 40.0, 4.1, 7, 100
    net = np.where(np.arange(TIME.size) < turn, 0.5, -0.8)
    speed = start - brake * np.maximum(TIME - TIME[turn], 0.0)
    added = np.zeros(TIME.size)
    loosen(net, speed, gap, H, contact, added)
    first = int(SPARE * 0.5 * gap / (H * start)) + 1  # from the middle of the play, to the side it came from
    np.testing.assert_allclose(added[:first], 0.5)
    np.testing.assert_allclose(added[first : first + contact], -0.5 * first / contact)
    np.testing.assert_array_equal(added[first + contact : turn], 0.0)
    loose = np.flatnonzero(added[turn:] == -0.8).size
    assert loose == pytest.approx(np.sqrt(2.0 * gap / brake) / H, abs=1.5), f"observed {loose} samples"
    np.testing.assert_allclose(added[turn + loose : turn + loose + contact], 0.8 * loose / contact)
    np.testing.assert_allclose(added.sum(), 0.0, atol=1e-12)


def test_the_shadow_of_a_frictionless_axis_is_the_semi_discrete_servo():
    """Inertia alone under a held torque: angle and speed by the exact step of a double integrator."""
    axis, gains = np.array([2e-3, 0.0, 0.0, 0.0, 0.0]), np.array([0.5, 0.02, H])
    angle, speed = np.sin(8.0 * TIME), 8.0 * np.cos(8.0 * TIME)
    torque, out = 0.01 * np.cos(30.0 * TIME), np.zeros((2, TIME.size))
    shadow(axis, gains, torque, angle, speed, out)
    moved, acting = out
    state = np.array([angle[0], speed[0]])
    for k in range(TIME.size):
        u = torque[k] + gains[:2] @ (np.array([angle[k], speed[k]]) - state)
        assert moved[k] == pytest.approx(state[0], rel=1e-12, abs=1e-15)
        assert acting[k] == pytest.approx(u, rel=1e-12, abs=1e-15)
        state = np.array([[1.0, H], [0.0, 1.0]]) @ state + np.array([0.5 * H * H, H]) * u / axis[0]


DRY = np.array([2e-3, 0.0, 0.02, 0.001, 0.0])  # no viscous friction: constant acceleration between turns
STEP = 0.01


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_sample_in_which_the_axis_turns_is_two_parabolas(sign):
    """Braked by torque and friction to its zero, then driven on by the torque less the friction."""
    speed, torque = 0.05, -0.06
    brake = (torque + sign * DRY[3] - DRY[2]) / DRY[0]
    drive = (torque + sign * DRY[3] + DRY[2]) / DRY[0]
    first = -speed / brake
    rest = STEP - first
    assert 0.0 < first < STEP
    gone = 0.5 * speed * first + 0.5 * drive * rest**2
    expected = (drive * rest, gone, (drive * rest - speed) / STEP, -1.0)
    *found, jump = one_sample(DRY, sign * speed, sign * torque, STEP)
    np.testing.assert_allclose(found, sign * np.array(expected), rtol=1e-12)
    assert jump == pytest.approx(drive / brake, rel=1e-12)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_an_axis_sticks_up_to_its_coulomb_friction_and_starts_above_it(sign):
    sticking = np.array([*DRY[:3], 0.0, 0.0])
    inside, above = sign * 0.99 * DRY[2], sign * 2.0 * DRY[2]
    assert one_sample(sticking, 0.0, inside, STEP) == (0.0, 0.0, 0.0, 0.0, 0.0)
    rate = sign * DRY[2] / DRY[0]
    found = one_sample(sticking, 0.0, above, STEP)
    np.testing.assert_allclose(found, (STEP * rate, 0.5 * STEP**2 * rate, rate, sign, 1.0), rtol=1e-12)
    stopped = one_sample(sticking, sign * 0.01, -inside, STEP)  # brought to rest within the sample, and held
    braked = 0.5 * 0.01**2 / (1.99 * DRY[2] / DRY[0])
    np.testing.assert_allclose(stopped, (0.0, sign * braked, -sign * 0.01 / STEP, 0.0, 0.0), rtol=1e-12)
