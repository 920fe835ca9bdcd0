"""The generator of a target makes the rows that the law's reference table holds."""

import numpy as np
import pytest

import cabledrive as cd
from cabledrive.control.reference_kernels import reference_table
from cabledrive.control.reference_numbers import MotionNumbers
from cabledrive.rig import Motion
from cabledrive.rig.laws.controllers import motion_numbers
from cabledrive.rig.laws.registry import CONTROLLERS, needed_order
from cabledrive.rig.trial import spec_for

DRIVE = cd.load_drive("dissertation-3")


def table_of(name: str, motion: Motion, drive: cd.Drive = DRIVE):
    given = 20.0 if name == "lqi-learning" else None  # which would be found by runs, slow without the compiler
    spec = spec_for(drive, motion, bandwidth=given)
    made = CONTROLLERS[name](spec)
    assert made.generator is not None
    numbers = motion_numbers(drive, motion)
    rows = reference_table(made.generator, numbers, spec.interval, spec.samples)
    followed = len(made.generator.output)  # what is learnt by goes with the filter: tests/rig has its columns
    return made.reference[:, :followed], rows[:, :followed]


@pytest.mark.kernel  # cabledrive.control.reference_kernels, cabledrive.control.load_row_kernels,
# cabledrive.control.reference_part_kernels
@pytest.mark.parametrize("name", list(CONTROLLERS))
def test_the_generator_makes_the_rows_of_the_table(name, measured):
    order = needed_order(name, DRIVE) + 2  # nothing jumps at an edge, which rounding may put to either side
    motion = Motion(angle=-20.0, rise=0.04, dwell=0.01, pulses=2, order=order)
    table, rows = table_of(name, motion)
    gap = float(np.max(np.abs(rows - table) / np.abs(table).max(axis=0)))
    measured(f"{gap:.1e} of the peak")
    assert gap < 1e-9, f"observed {gap:.1e} of each column's peak"


@pytest.mark.kernel
def test_a_motion_twice_as_slow_is_the_same_motion_at_half_the_speed():
    """y(t) in the time 2t: derivative k is smaller by 2^k."""
    spec = spec_for(DRIVE, Motion(rise=0.04, dwell=0.01))
    made = CONTROLLERS["backstepping"](spec)
    fast, slow = (motion_numbers(DRIVE, Motion(rise=s * 0.04, dwell=s * 0.01)) for s in (1.0, 2.0))
    rows = reference_table(made.generator, fast, 2e-4, 200)
    slowed = reference_table(made.generator, slow, 4e-4, 200)
    gap = np.abs(slowed * 2.0 ** np.arange(5) - rows) / np.abs(rows).max(axis=0)
    assert gap.max() < 1e-10, f"observed {gap.max():.1e} of each column's peak"


@pytest.mark.kernel
def test_nothing_moves_before_the_start_and_after_the_end():
    spec = spec_for(DRIVE, Motion(rise=0.04, dwell=0.01))
    made = CONTROLLERS["backstepping"](spec)
    late = made.generator._replace(taps=np.array([[0.02, 1.0]]))
    numbers: MotionNumbers = motion_numbers(DRIVE, Motion(rise=0.04, dwell=0.01))
    rows = reference_table(late, numbers, 2e-4, 900)
    assert not np.any(rows[:100])
    assert np.abs(rows[620:]).max() == 0.0
