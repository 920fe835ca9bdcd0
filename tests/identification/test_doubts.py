"""What widens the intervals of output error: noise of the torque at turns, scores that remember."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import signal

from cabledrive.identification.axis_case import case_of
from cabledrive.identification.method_error import _noisier
from cabledrive.identification.regression import factor, suited_segments
from cabledrive.identification.rigid_axis import AxisOptions, equation_for
from cabledrive.reduction.friction_march import march_rigid_axis
from cabledrive.rig.chapter_4 import BENCH_TESTS, bench_command, bench_rig
from cabledrive.rig.virtual_rig import run_rig


@pytest.mark.parametrize("friction, least", [(0.0, 0.0), (0.024, 1e-4)])
def test_noise_of_the_torque_moves_the_mean_of_a_motion_with_friction_only(friction, least):
    """Without friction the axis is linear: noise of either sign cancels to rounding."""
    test = replace(BENCH_TESTS[0], duration=8.0)
    rng = np.random.default_rng(61)
    log = run_rig(bench_rig(test), bench_command(test, rng), rng)
    case = case_of(log, "torque", "angle", equation_for([log], "torque", "angle", AxisOptions()))
    values = np.array([test.inertia, test.viscous, friction, test.offset])
    moved, _ = march_rigid_axis(values, case.torque, case.interval, start=case.start)
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
