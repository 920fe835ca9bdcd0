"""The pass over taut segments, `cabledrive.simulation.taut`, equals the readable integration."""

from dataclasses import replace

import numpy as np
import pytest
from kernel_cases import CARRIAGES, LOOP, SLOPED
from kernel_cases import VERLET as integrate

from cabledrive.mechanics.cable_laws import cable_law
from cabledrive.mechanics.compiled import njit_in_place
from cabledrive.mechanics.mesh import mesh_of
from cabledrive.simulation.channels import WIDTH
from cabledrive.simulation.plan import EVENTS, copy_state, new_state, new_workspace, plan_of
from cabledrive.simulation.taut import rows_of, step_taut
from oracles.readable_chain.verlet import integrate_reference

pytestmark = pytest.mark.kernel

SEGMENTS, STEPS, EVERY = 9, 60, 20
DRIVES = {
    "loop": (LOOP, ()),
    "line": (replace(LOOP, kind="line"), ()),
    "sloped loop": (SLOPED, ()),
    "carriage": (replace(LOOP, carriage=CARRIAGES[:1]), ()),
    "carriages side by side": (replace(SLOPED, carriage=CARRIAGES), ()),
    "forces": (replace(LOOP, carriage=CARRIAGES), ((3, 0), (3, 2), (5, 2))),
}


def setting(kind, *, planar, speed):
    """A start in motion; the faster the drive pulley turns, the sooner a span is slack."""
    drive, forces = DRIVES[kind]
    mesh, law = mesh_of(drive, SEGMENTS), cable_law(drive.cable)
    step = 0.8 * mesh.spacing.min() / drive.cable.axial_wave_speed
    plan = plan_of(mesh, law, step=step, transverse_damping=20.0, stop_when_slack=False, forces=forces)
    x, x_t = np.zeros((3, mesh.nodes)), np.zeros((3, mesh.nodes))
    rng = np.random.default_rng(3)
    x[1 if not planar else 2 :, mesh.sways] = 1e-4 * rng.uniform(-1.0, 1.0, (2 - planar, mesh.sways.sum()))
    x_t[0, 0] = x_t[0, -1 if mesh.closed else 0] = speed
    return plan, new_state(x, x_t, (0.0, 0.0))


def taken(function, plan, start):
    state = copy_state(start)
    rows, fields = np.zeros((STEPS // EVERY, WIDTH + 3 * len(plan.probe))), np.zeros((0, *state.x.shape))
    torque = 0.2 * np.cos(np.arange(STEPS))
    forces = 1e-2 * np.sin(np.arange(STEPS * len(plan.force))).reshape(STEPS, -1)
    code = function(plan, state, new_workspace(plan), torque, forces, EVERY, rows, fields)
    return code, state, rows


@pytest.mark.parametrize("kind", DRIVES)
@pytest.mark.parametrize("planar", [True, False])
@pytest.mark.parametrize("speed", [0.1, 6.0])
def test_quick_steps_equal_the_readable_ones(kind, planar, speed):
    """Taut all the time, or slack from the midst of the steps between two records on."""
    plan, start = setting(kind, planar=planar, speed=speed)
    code, state, rows = taken(integrate, plan, start)
    code_r, state_r, rows_r = taken(integrate_reference, plan, start)
    assert code == code_r == 0
    for name in ("x", "x_t", "extremes", "events", "counts"):
        ours, theirs = getattr(state, name), getattr(state_r, name)
        error = np.max(np.abs(ours - theirs)) / np.max(np.abs(theirs), initial=1e-300)
        assert error < 1e-10, f"{name}: {error:.2e}"
    error = np.max(np.abs(rows - rows_r), axis=0) / (np.max(np.abs(rows_r), axis=0) + 1e-15)
    assert error.max() < 1e-9, f"column {error.argmax()}: {error.max():.2e}"
    goes_slack = speed > 1.0
    assert (state.counts[EVENTS] > 0) == goes_slack
    if goes_slack:
        assert state.events[0, 0] % EVERY not in (0, EVERY - 1), "meant to go slack between records"


@njit_in_place
def steps(*arguments):
    """The part of a kernel, which has no entry of its own from Python."""
    return step_taut(*arguments)


@pytest.mark.parametrize("planar", [True, False])
def test_quick_steps_are_taken_while_taut_and_refused_when_slack(planar):
    for speed, expected in ((0.1, True), (6.0, False)):
        plan, state = setting("loop", planar=planar, speed=speed)
        rows = rows_of(state)
        assert (rows[1] is None) == (rows[4] is None) == planar
        went = steps(plan, state, new_workspace(plan), np.zeros(STEPS), np.zeros((STEPS, 0)), *rows)
        assert went == expected


def test_a_drive_of_equal_segments_is_one_run_and_stops_divide_it():
    assert setting("loop", planar=True, speed=0.1)[0].runs.tolist() == [[0, 2 * SEGMENTS]]
    plan = setting("carriage", planar=True, speed=0.1)[0]
    assert plan.runs[1:, 0].tolist() == [plan.stop[0], SEGMENTS]
