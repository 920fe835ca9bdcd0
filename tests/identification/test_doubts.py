"""What widens the intervals of output error: noise of the torque at turns, scores that remember."""

from dataclasses import replace

import numpy as np
import pytest

from cabledrive.identification.one_log import IdentifyOptions, identify
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
