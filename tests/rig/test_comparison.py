"""Feedforward and feedback distinguished, and causes taken away one at a time."""

import numpy as np
import pytest

from cabledrive.parameters import InputRefused, NotComputed, load_drive
from cabledrive.rig.comparison import compared, controller, loops_of, tuned
from cabledrive.rig.error_budget import error_sources, in_degrees
from cabledrive.rig.setting import Motion, RigOptions
from cabledrive.rig.trial import spec_for

DRIVE = load_drive("dissertation-3")
OPTIONS = RigOptions(forbid_slack=False)


def test_damped_inverse_is_the_better_feedforward_under_the_same_pd():
    """PD at 11 Hz, four draws: rigid above 1 deg, undamped above the damped inverse."""
    spec, settings = (
        spec_for(DRIVE, Motion()),
        {("pd", kind): 11.0 for kind in ("damped", "undamped", "rigid")},
    )
    found = compared(DRIVE, ["pd"], ["damped", "undamped", "rigid"], 4, 1, spec, Motion(), settings=settings)
    damped, undamped, rigid = (float(np.median(one.draws.degrees("peak"))) for one in found)
    assert rigid > 1.0
    assert damped < 0.7 * undamped, f"observed {damped:.3f}, {undamped:.3f} deg"


def test_tuning_takes_the_setting_with_the_smallest_worst_error():
    spec = spec_for(DRIVE, Motion())
    put = loops_of(spec, Motion(), OPTIONS)
    assert tuned("pd", spec, put, OPTIONS, draws=2, settings=(2.0, 11.0)) == 11.0
    assert tuned("lqg", spec, put, OPTIONS, draws=2, settings=(0.2, 2.0)) == 0.2


def test_a_law_of_which_no_setting_leaves_torque_to_spare_is_not_tuned():
    """lqg that weighs 2 N m as one count asks for the whole torque limit."""
    spec = spec_for(DRIVE, Motion())
    with pytest.raises(NotComputed, match="no setting of lqg among 2 "):
        tuned("lqg", spec, loops_of(spec, Motion(), OPTIONS), OPTIONS, draws=1, settings=(2.0,))


def test_feedforward_that_does_not_exist_is_refused():
    spec = spec_for(DRIVE, Motion(), feedforward="perfect")
    with pytest.raises(InputRefused, match="feedforward = 'perfect'"):
        controller("pd", spec)


def test_counts_limit_the_law_and_sampling_does_not():
    """One phase: without any counts a quarter of a count is left at most; a faster clock gains far less."""
    found = {one.away: in_degrees(one)[1] for one in error_sources(DRIVE, "darc-4-damped", Motion(), 1)}
    assert found["counts of every encoder"] < 0.01 < found["nothing"]
    faster = next(value for away, value in found.items() if "sample time" in away)
    assert faster > found["counts of every encoder"]
    assert len(found) == 8
