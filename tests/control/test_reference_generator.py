"""The generator of a target makes the rows that the law's reference table holds."""

import numpy as np
import pytest

import cabledrive as cd
from cabledrive.control.load_torque import load_regressors, load_row_numbers
from cabledrive.control.numbers import KALMAN, ObserverNumbers
from cabledrive.control.reference import MotionNumbers, reference_numbers
from cabledrive.control.reference_kernels import reference_table
from cabledrive.reduction.lumped_chain import LumpedChain
from cabledrive.rig import Motion
from cabledrive.rig.laws.controllers import DesignSpec, motion_numbers
from cabledrive.rig.laws.load_learning import KINDS as LOAD_LEARNING
from cabledrive.rig.laws.load_learning import load_blocks
from cabledrive.rig.laws.registry import CONTROLLERS, OPEN_LOOPS, needed_order
from cabledrive.trajectories import rise_coefficients

DRIVE = cd.load_drive("dissertation-3")


def table_of(name: str, motion: Motion, drive: cd.Drive = DRIVE):
    spec = DesignSpec(drive, motion)
    made = CONTROLLERS[name](spec)
    assert made.generator is not None
    numbers = motion_numbers(drive, motion)
    return made.reference, reference_table(made.generator, numbers, spec.interval, spec.samples)


@pytest.mark.kernel  # cabledrive.control.reference_kernels, cabledrive.control.reference_kernels
@pytest.mark.parametrize("name", [name for name in CONTROLLERS if name not in (*LOAD_LEARNING, *OPEN_LOOPS)])
def test_the_generator_makes_the_rows_of_the_table(name, measured):
    order = needed_order(name, DRIVE) + 2  # nothing jumps at an edge, which rounding may put to either side
    motion = Motion(angle=-20.0, rise=0.04, dwell=0.01, pulses=2, order=order)
    table, rows = table_of(name, motion)
    peak = np.abs(table).max(axis=0)  # another load adds nothing to its own angle and speed
    gap = float(np.max(np.abs(rows - table) / np.where(peak > 0.0, peak, 1.0)))
    measured(f"{gap:.1e} of the peak")
    assert gap < 1e-9, f"observed {gap:.1e} of each column's peak"


@pytest.mark.kernel  # cabledrive.control.reference_kernels
@pytest.mark.parametrize("inertias", [2, 3])
def test_columns_of_a_law_that_learns_are_those_of_whole_arrays(inertias, measured):
    """A random chain and a random stable filter; the arrays smooth and filter whole signals."""
    generator = np.random.default_rng(inertias)
    n, states, m, interval, turning = inertias, 2 * inertias + 2, 2, 1e-3, 0.012
    chain = LumpedChain(
        names=tuple(f"{i}" for i in range(n)),
        inertias=tuple(generator.uniform(1e-3, 3e-3, n)),
        stiffness=tuple(generator.uniform(50.0, 200.0, n - 1)),
        damping=tuple(generator.uniform(0.0, 0.3, n - 1)),
        viscous=tuple(generator.uniform(0.0, 1e-3, n)),
        coulomb=(0.0,) * n,
        offsets=(0.0,) * n,
        ratios=((1.0, 1.0),) * (n - 1),
    )
    model = generator.normal(size=(states, states))
    model *= 0.95 / np.abs(np.linalg.eigvals(model)).max()
    observer = ObserverNumbers(
        kind=KALMAN,
        chosen=np.arange(2 * n)[::-1].copy(),
        places=np.zeros(2, dtype=np.int64),
        model=np.hstack((model, np.zeros((states, 4)))),
        output=generator.normal(size=(m, states)),
        gains=0.1 * generator.normal(size=(1, states, m)),
        scalars=np.zeros(9),
    )
    white = generator.normal(size=(m, m))
    load = load_row_numbers(chain, observer, white, turning, interval)
    numbers = reference_numbers(np.eye(2 * n + 1))._replace(load=load)
    motion = MotionNumbers(
        coefficients=np.array(rise_coefficients(4 * n + 1)), scalars=np.array([-0.3, 0.04, 0.01, 2.0])
    )
    rows = reference_table(numbers, motion, interval, 220)
    torques = load_regressors(rows[:, : 2 * n + 1].T, turning, interval)
    blocks, _ = load_blocks(chain, observer, white, torques, interval)
    gap = np.abs(rows[:, 2 * n + 1 :] - blocks).max(axis=0) / np.abs(blocks).max(axis=0)
    measured(f"{gap.max():.1e} of the peak")
    assert load.columns == blocks.shape[1] == 3 * (2 * n + 1 + m)
    assert gap.max() < 1e-9
