"""The generator of a target makes the rows that the law's reference table holds."""

import numpy as np
import pytest

from cabledrive.control import reference
from cabledrive.control.numbers import KALMAN, ObserverNumbers
from cabledrive.control.reference_kernels import reference_table
from cabledrive.trajectories import pulse
from cabledrive.trajectories.limits import rise_coefficients
from control_chains import carried, flat_rows, model, row_of


@pytest.mark.kernel
@pytest.mark.parametrize("number", [1, 3, 4])
def test_rows_of_a_flat_output_are_those_of_whole_arrays(number, measured):
    """Two pulses of an order at which nothing jumps at an edge, which rounding may put to either side."""
    flat, interval, order = reference.flat_output(model(number)), 1e-3, 15
    numbers = np.array([-20.0, 0.04, 0.01, 2.0])
    motion = reference.MotionNumbers(coefficients=np.array(rise_coefficients(order)), scalars=numbers)
    rows = reference_table(reference.flat_generator(flat, interval), motion, interval, 201)
    wanted = pulse(-20.0, 0.04, 0.01, pulses=2, order=order)(interval * np.arange(201), 2 * flat.size)
    table = flat_rows(flat, wanted, interval)
    gap = float(np.max(np.abs(rows - table) / np.abs(table).max(axis=0)))
    measured(f"{gap:.1e} of the peak")
    assert gap < 1e-9, f"observed {gap:.1e} of each column's peak"


def smoothed_sign(speed, weights):
    """Sign of a speed, smoothed evenly to both sides, with derivatives, (rows, samples)."""
    sign = np.pad(np.tanh(reference.TURN * speed / np.abs(speed).max()), weights.shape[1] // 2, mode="edge")
    return np.array([np.convolve(sign, row[::-1], "valid") for row in weights])


def missed_by(load, torque):
    """States less what the filter takes them for, and innovations, by a torque at the load."""
    mean, missed, seen = 0.5 * (torque + np.append(torque[1:], torque[-1])), [], []
    error = np.zeros(len(load.transition))
    for k, one in enumerate(mean):
        seen.append(load.seen @ error)
        error = error - load.gains[min(k, len(load.gains) - 1)] @ seen[-1]
        missed.append(error[load.chosen])
        error = load.transition[:, :-1] @ error + load.transition[:, -1] * one
    return np.array(missed), np.array(seen)


@pytest.mark.kernel  # cabledrive.control.reference_kernels
@pytest.mark.parametrize("inertias", [2, 3])
def test_columns_of_a_law_that_learns_are_those_of_whole_arrays(inertias, measured):
    """A random chain and a random stable filter; the arrays smooth and filter whole signals."""
    generator = np.random.default_rng(inertias)
    n, states, m, interval, turning = inertias, 2 * inertias + 2, 2, 1e-3, 0.012
    chain = row_of(n, generator)
    model = generator.normal(size=(states, states))
    model *= 0.95 / np.abs(np.linalg.eigvals(model)).max()
    observer = ObserverNumbers(
        kind=KALMAN,
        chosen=np.arange(2 * n)[::-1].copy(),
        places=np.zeros(2, dtype=np.int64),
        model=np.hstack((model, np.zeros((states, 4)))),
        output=generator.normal(size=(m, states)),
        gains=0.1 * generator.normal(size=(40, states, m)),
        scalars=np.zeros(9),
    )
    white = generator.normal(size=(m, m))
    load = reference.load_row_numbers(chain, observer, white, turning, interval)
    numbers = reference.reference_numbers(np.eye(2 * n + 1))._replace(load=load)
    motion = reference.MotionNumbers(
        coefficients=np.array(rise_coefficients(4 * n + 1)), scalars=np.array([-0.3, 0.04, 0.01, 2.0])
    )
    rows = reference_table(numbers, motion, interval, 220)
    y, blocks = rows[:, : 2 * n + 1].T, np.zeros((220, 0))
    for torque in (smoothed_sign(y[1], load.sign), y[1 : 2 * n], y[2:]):
        states_asked, motor = carried(chain, torque, interval)
        missed, seen = missed_by(load, torque[0])
        asked = states_asked[:, observer.chosen] - missed
        blocks = np.hstack((blocks, asked, motor[:, None], seen @ white.T))
    gap = np.abs(rows[:, 2 * n + 1 :] - blocks).max(axis=0) / np.abs(blocks).max(axis=0)
    measured(f"{gap.max():.1e} of the peak")
    assert load.columns == blocks.shape[1] == 3 * (2 * n + 1 + m)
    assert gap.max() < 1e-9
