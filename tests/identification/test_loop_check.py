"""Wrong models in logs whose torque is no sum of lines: feedback loops, chirps, steps; the observer."""

import numpy as np
import pytest

from cabledrive.identification.axis.check import INNOVATIONS
from cabledrive.identification.axis.equation import SPARE, answers, loosen, observe, one_sample, shadow
from cabledrive.identification.axis.observer import observer_gains
from cabledrive.identification.logs.log import ColumnMap, with_choices
from cabledrive.identification.logs.reading import read_log
from cabledrive.identification.one_log import identify
from servo_logs import servo_log

VALUES = np.array([0.001742, 0.0031, 0.0376, -0.0006, 0.0])
STEP = 1e-3
WORDS = {"stribeck": "Stribeck", "backlash": "backlash", "flexible": "flexible joint"}
MOTIONS = ("trapezoids", "s-curves", "chirp", "steps")
SHOWN = [(m, r) for m in MOTIONS for r in WORDS if r != "flexible" or m in ("chirp", "steps")]


def named_first(findings, rig):
    return bool(findings) and WORDS[rig] in findings[-1].partition(";")[0]


@pytest.mark.kernel
def test_an_observer_foresees_a_rigid_axis_that_sticks_and_turns():
    """cabledrive.identification.axis.equation: no innovation without noise, to round-off."""
    t = STEP * np.arange(3000)
    torque = 0.12 * np.sin(2 * np.pi * 1.3 * t) * (np.sin(2 * np.pi * 0.35 * t) > 0)
    moved, out = np.empty((2, t.size)), np.empty((5, t.size))
    shadow(VALUES, np.array([0.0, 0.0, STEP]), torque, 0.0 * t, 0.0 * t, moved)
    observe(VALUES, observer_gains(60.0, STEP), torque, moved[0], np.zeros(2), out)
    assert np.abs(out[0]).max() < 1e-12 * np.ptp(moved[0]), f"observed {np.abs(out[0]).max():.2g} rad"
    assert 0.2 < np.mean(out[3] == 0.0) < 0.8, "the motion must hold sticking and slipping"


def logs_of(every, quick):
    """Forty logs of a minute of each case in `make verify`, one of half a minute of some in every run."""
    forty = (pytest.param(*case, range(60_000, 60_040), 60.0, marks=pytest.mark.verify) for case in every)
    return [*((*case, range(1, 2), 30.0) for case in quick), *forty]


@pytest.mark.parametrize(
    "motion, seeds, duration", logs_of([(motion,) for motion in MOTIONS], [("trapezoids",), ("steps",)])
)
def test_forty_sound_logs_of_each_motion(motion, seeds, duration, measured):
    """At most 8 % false alarms: 3 of 40."""
    found = [identify(servo_log(motion, "rigid", seed, duration)) for seed in seeds]
    alarms = sum(bool(one.findings) for one in found)
    measured(f"{alarms} false alarms in {len(seeds)}")
    assert all(one.method["model_check"] == INNOVATIONS for one in found)
    assert alarms <= 0.08 * len(seeds), f"{alarms} false alarms"


@pytest.mark.parametrize(
    "motion, rig, seeds, duration",
    logs_of(SHOWN, [("trapezoids", "stribeck"), ("steps", "backlash"), ("chirp", "flexible")]),
)
def test_forty_faulty_logs_of_each_motion(motion, rig, seeds, duration, measured):
    """At least 90 % named first: 36 of 40."""
    named = sum(named_first(identify(servo_log(motion, rig, seed, duration)).findings, rig) for seed in seeds)
    measured(f"{named} of {len(seeds)} named first")
    assert named >= 0.9 * len(seeds), f"{named} of {len(seeds)} named"


@pytest.mark.shared_data
def test_emps_has_friction_that_falls_behind_a_straight_line(shared_data, measured):
    """Beyond chance: a smooth law of friction. Two viscous frictions, as published, are not: moves repeat."""
    columns = with_choices(ColumnMap(), ["time=t", "position=qm", "force=vir:N*gtau"])
    found = identify(read_log(shared_data("emps/DATA_EMPS.mat"), columns))
    message = (
        f"{n} {s['significance']:.1f} of {s['critical']:.1f}" for n, s in found.method["suspicions"].items()
    )
    size = abs(found.method["suspicions"]["asymmetry"]["value"])
    measured(
        f"significance {', '.join(message)}; viscous friction {size:.0f} N s/m to either side of its mean"
    )
    assert "rises smoothly with speed" in found.findings[-1], found.findings
    beyond = {n for n, s in found.method["suspicions"].items() if s["significance"] > s["critical"]}
    assert "slope" in beyond, found.method["suspicions"]
    assert not beyond & {"backlash", "flexibility", "stribeck"}


@pytest.mark.verify
@pytest.mark.parametrize("motion", ["trapezoids", "s-curves"])
def test_a_joint_too_stiff_for_the_moves_is_called_nothing_else(motion, measured):
    """Resonance, 92 Hz, ten times above the moves: seldom named; another fault in at most 3 of 40."""
    logs = [identify(servo_log(motion, "flexible", 60_000 + k)) for k in range(40)]
    found = [one.findings for one in logs]
    wrong = sum(bool(f) and WORDS["flexible"] not in f[-1] for f in found)
    named = sum(named_first(f, "flexible") for f in found)
    checks = [one.method["suspicions"]["flexibility"] for one in logs if "suspicions" in one.method]
    middle = np.median([check["significance"] for check in checks])
    measured(
        f"{named} of 40 named, {wrong} called another fault; "
        f"significance {middle:.1f} at the median of {len(checks)} checked"
    )
    assert wrong <= 3, f"{wrong} of 40 called something else"


def test_of_several_logs_the_largest_unexplained_torque_is_told():
    """Whichever comes first."""
    logs = [servo_log("trapezoids", "rigid", seed, 15.0) for seed in (1, 2)]
    one, other = (identify(both).method["unexplained_torque"] for both in (logs, logs[::-1]))
    assert one == pytest.approx(other, rel=1e-6)


# --- What axis.equation adds to the observer of a rigid axis
H = 1e-3
AXIS = np.array([2e-3, 3e-3, 0.02, 0.001, 0.0])  # inertia, viscous and Coulomb friction, offset; it jumps
GAINS = np.array([0.1, 3.0, H])
TIME = H * np.arange(300)


def observed(torque, axis=AXIS):
    out = np.zeros((5, TIME.size))
    observe(axis, GAINS, torque, np.zeros(TIME.size), np.array([0.0, 5.0]), out)
    return out


@pytest.mark.kernel
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


@pytest.mark.kernel
def test_a_disturbance_adds_nothing_more_where_the_axis_sticks():
    found = np.zeros((1, 5))
    answers(AXIS, GAINS, np.ones((1, 5)), np.zeros(5), found)
    np.testing.assert_array_equal(found, 0.0)


@pytest.mark.kernel
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


@pytest.mark.kernel
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
LONG = 0.01


@pytest.mark.kernel
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_sample_in_which_the_axis_turns_is_two_parabolas(sign):
    """Braked by torque and friction to its zero, then driven on by the torque less the friction."""
    speed, torque = 0.05, -0.06
    brake = (torque + sign * DRY[3] - DRY[2]) / DRY[0]
    drive = (torque + sign * DRY[3] + DRY[2]) / DRY[0]
    first = -speed / brake
    rest = LONG - first
    assert 0.0 < first < LONG
    gone = 0.5 * speed * first + 0.5 * drive * rest**2
    expected = (drive * rest, gone, (drive * rest - speed) / LONG, -1.0)
    *found, jump = one_sample(DRY, sign * speed, sign * torque, LONG)
    np.testing.assert_allclose(found, sign * np.array(expected), rtol=1e-12)
    assert jump == pytest.approx(drive / brake, rel=1e-12)


@pytest.mark.kernel
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_an_axis_sticks_up_to_its_coulomb_friction_and_starts_above_it(sign):
    sticking = np.array([*DRY[:3], 0.0, 0.0])
    inside, above = sign * 0.99 * DRY[2], sign * 2.0 * DRY[2]
    assert one_sample(sticking, 0.0, inside, LONG) == (0.0, 0.0, 0.0, 0.0, 0.0)
    rate = sign * DRY[2] / DRY[0]
    found = one_sample(sticking, 0.0, above, LONG)
    np.testing.assert_allclose(found, (LONG * rate, 0.5 * LONG**2 * rate, rate, sign, 1.0), rtol=1e-12)
    stopped = one_sample(sticking, sign * 0.01, -inside, LONG)  # brought to rest within the sample, and held
    braked = 0.5 * 0.01**2 / (1.99 * DRY[2] / DRY[0])
    np.testing.assert_allclose(stopped, (0.0, sign * braked, -sign * 0.01 / LONG, 0.0, 0.0), rtol=1e-12)
