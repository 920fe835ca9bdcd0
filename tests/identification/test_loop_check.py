"""Wrong models in logs whose torque is no sum of lines: feedback loops, chirps, steps."""

import numpy as np
import pytest

from cabledrive.identification.axis.check import INNOVATIONS
from cabledrive.identification.axis.equation import observe, shadow
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
