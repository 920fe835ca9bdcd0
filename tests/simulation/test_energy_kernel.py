"""The compiled step of `cabledrive.simulation.energy_step` equals its readable twin."""

import numpy as np
import pytest
from kernel_cases import CASES, setting, taken
from kernel_cases import ENERGY as integrate

from cabledrive.simulation.channels import CHANNELS, WIDTH
from cabledrive.simulation.methods import method_named
from oracles.readable_chain.energy_conserving import SHIFT, integrate_reference

pytestmark = pytest.mark.kernel

METHOD = method_named("energy-conserving")
KNOWN = [case for case in CASES if case != "weak" and not case.startswith("slack")]


def start_of(case, *, planar=False):
    plan, start, torque, forces = setting(case)
    if planar:
        start.x[1], start.x_t[1] = 0.0, 0.0
    return plan, start._replace(extra=METHOD.extra(plan, start)), torque, forces


def assert_equal_runs(inputs):
    code, state, rows, fields = taken(integrate, *inputs)
    code_r, state_r, rows_r, fields_r = taken(integrate_reference, *inputs)
    assert code == code_r == 0
    for name, ours, theirs in zip(state._fields, state, state_r, strict=True):
        if name == "tallies":
            ours, theirs = ours[0] - ours[1], theirs[0]
        if name == "extra":  # without what rounding took away
            ours, theirs = ours[:2], theirs[:2]
        error = np.max(np.abs(ours - theirs), initial=0.0) / np.max(np.abs(theirs), initial=1e-300)
        assert error < 1e-10, f"{name}: {error:.2e} of its largest entry"
    np.testing.assert_allclose(fields, fields_r, atol=1e-10 * np.max(np.abs(fields_r)))
    scale = np.max(np.abs(rows_r), axis=0) + 1e-12 * np.max(np.abs(rows_r[:, WIDTH - 1]))
    names = [channel.name for channel in CHANNELS] + ["probe"] * (rows.shape[1] - WIDTH)
    error = np.max(np.abs(rows - rows_r) / scale, axis=0)
    assert error.max() < 1e-9, f"{names[int(error.argmax())]}: {error.max():.2e}"


@pytest.mark.parametrize("case", KNOWN)
def test_the_compiled_integration_equals_the_readable_one(case):
    """Displacements, velocities, tallies, stored energy, records after 36 steps, to round-off."""
    assert_equal_runs(start_of(case))


@pytest.mark.parametrize("case", ["exact", "line", "damped", "motor"])
def test_motion_in_the_psingle_batch_the_pulleys_equals_the_readable_one(case):
    assert_equal_runs(start_of(case, planar=True))


@pytest.mark.parametrize("case", KNOWN)
def test_the_budget_closes_at_every_step(case):
    """Balance of energy, works and losses over 36 steps of rough motion: 1e-13 of the energy in it."""
    plan, start, torque, forces = start_of(case)
    rows = taken(integrate, plan, start, torque, forces)[2]
    balance = rows[:, WIDTH - 1]
    error = np.max(np.abs(balance - balance[0])) / np.max(np.abs(rows[:, : WIDTH - 1][:, 11:21].sum(axis=1)))
    assert error < 1e-13, f"{error:.2e}"


@pytest.mark.parametrize("case", ["steep"])
def test_a_large_motion_raises_the_shift_and_conserves_energy_all_the_same(case):
    """The energy beyond the linear one falls below minus the first shift: C is doubled until it does not."""
    plan, start, torque, forces = start_of(case)
    start.extra[SHIFT] *= 1e-6
    plan = plan._replace(stop_when_slack=False)
    state, rows = taken(integrate, plan, start, torque, forces)[1:3]
    assert state.extra[SHIFT] > start.extra[SHIFT]
    balance = rows[:, WIDTH - 1]
    assert np.ptp(balance) < 1e-12 * np.max(np.abs(rows[:, 11:21]).sum(axis=1))


@pytest.mark.parametrize("case", ["exact", "linear"])
def test_slack_stops_the_integration_before_the_step(case):
    """In the quick loop and in the long one."""
    plan, start, torque, forces = start_of(case)
    start.x[0, 1] = start.x[0, 0] - 1.1 * plan.pretension / plan.rigidity * plan.segment[0, 0]
    code, state = taken(integrate, plan._replace(stop_when_slack=True), start, torque, forces)[:2]
    assert code == 1
    assert state.counts[0] == 0
