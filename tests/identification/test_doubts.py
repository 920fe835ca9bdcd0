"""What widens the intervals of output error: noise of the torque at turns, scores that remember."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import signal

from cabledrive.identification.axis_case import case_of
from cabledrive.identification.method_error import _noisier
from cabledrive.identification.one_log import IdentifyOptions, identify
from cabledrive.identification.regression import factor, suited_segments
from cabledrive.identification.rigid_axis import AxisOptions, equation_for
from cabledrive.reduction.friction_integration import integrate_rigid_axis
from cabledrive.rig.bench.chapter_4 import BENCH_TESTS, bench_command, bench_rig
from cabledrive.rig.bench.virtual_rig import Imperfections, run_rig

DRIVES = {
    "500 Hz": {"rate": 500.0},
    "2 kHz": {"rate": 2000.0},
    "400 counts": {"counts": 400},
    "20,000 counts": {"counts": 20_000},
    "10 s": {"duration": 10.0},
    "inertia ten times": {"inertia": 10.0, "amplitude": 3.0},
    "all ten times": {"inertia": 10.0, "friction": 10.0, "amplitude": 10.0},
    "all a tenth": {"inertia": 0.1, "friction": 0.1, "amplitude": 0.1},
}
"""Against the motor alone, 55 s at 1 kHz with 2,600 counts; the noise stays."""


def held(test, repeats, seed, *, rate=1000.0, counts=2600, **flaws):
    """Share of the 95 % intervals of J, b, c, d that hold the truth."""
    rig = replace(bench_rig(test, Imperfections(**flaws)), sample_rate=rate, encoders={"angle": counts})
    inside = []
    for k in range(seed, seed + repeats):
        rng = np.random.default_rng(k)
        found = identify(run_rig(rig, bench_command(test, rng, rate), rng), IdentifyOptions(check=False))
        truth = (test.inertia, test.viscous, test.coulomb, test.offset)
        inside.append([e.low < v < e.high for e, v in zip(found.parameters.values(), truth, strict=True)])
    return np.mean(inside, axis=0)


def changed(*, duration=55.0, inertia=1.0, friction=1.0, amplitude=1.0):
    motor = BENCH_TESTS[0]
    return replace(
        motor,
        duration=duration,
        inertia=inertia * motor.inertia,
        viscous=friction * motor.viscous,
        coulomb=friction * motor.coulomb,
        offset=friction * motor.offset,
        amplitudes=tuple(amplitude * a for a in motor.amplitudes),
    )


def held_by(name, repeats, seed):
    """The same for one of the other drives and logs."""
    case = dict(DRIVES[name])
    instruments = {key: case.pop(key) for key in ("rate", "counts") if key in case}
    return held(changed(**case), repeats, seed, **instruments)


@pytest.mark.parametrize("friction, least", [(0.0, 0.0), (0.024, 1e-4)])
def test_noise_of_the_torque_moves_the_mean_of_a_motion_with_friction_only(friction, least):
    """Without friction the axis is linear: noise of either sign cancels to rounding."""
    test = replace(BENCH_TESTS[0], duration=8.0)
    rng = np.random.default_rng(61)
    log = run_rig(bench_rig(test), bench_command(test, rng), rng)
    case = case_of(log, "torque", "angle", equation_for([log], "torque", "angle", AxisOptions()))
    values = np.array([test.inertia, test.viscous, friction, test.offset])
    moved, _ = integrate_rigid_axis(values, case.torque, case.interval, start=case.start)
    changed = float(np.std(_noisier(case, values, case.start, moved)))
    assert (changed < 1e-10) if least == 0.0 else (changed > least), f"observed {changed:.3g} rad/s"


def test_segments_grow_until_the_slowest_score_forgets():
    """Three regressors see white noise, one sees a drift: its scores alone make the segments longer."""
    rng = np.random.default_rng(62)
    rows = 12_000
    regressors = rng.choice([-1.0, 1.0], size=(rows, 4))
    white = factor(regressors, rng.normal(size=rows), ("a", "b", "c", "d"), 240)
    regressors[:, 3] = 1.0
    drift = signal.lfilter([0.02], [1.0, -0.998], rng.normal(size=rows))
    slow = factor(regressors, rng.normal(size=rows) + drift, ("a", "b", "c", "d"), 240)
    kept, joined = (suited_segments(f, each=True).triangles.shape[0] for f in (white, slow))
    assert kept >= 30 > joined, f"observed {kept} and {joined} segments"


@pytest.mark.verify
@pytest.mark.parametrize("test", BENCH_TESTS, ids=lambda test: test.name)
def test_intervals_hold_where_the_torque_is_measured_without_noise(test, measured):
    """100 repeats; fewer than 88 of 100 would be a sign of a defect (one standard error: 2.2 %)."""
    share = held(test, 100, 900_000, torque_noise=1e-5)
    measured("J, b, c, d: " + ", ".join(f"{100 * one:.0f} %" for one in share))
    assert np.all(share >= 0.88), f"observed {share}"


@pytest.mark.verify
@pytest.mark.parametrize("name", DRIVES)
def test_intervals_hold_for_other_drives_encoders_and_rates(name, measured):
    """60 repeats; the four together at least 90 % (three standard errors of 240 below 95 %)."""
    share = held_by(name, 60, 840_000)
    measured(f"{100 * share.mean():.1f} %; J, b, c, d: " + ", ".join(f"{100 * one:.0f} %" for one in share))
    assert share.mean() >= 0.90, f"observed {share}"
