"""The compiled integrators, `cabledrive.simulation.kernels`, equal their readable twins.

What it calls is tested with it: `cabledrive.simulation.segment_laws`, `cabledrive.simulation.node_motion`,
`cabledrive.simulation.observe`, all compiled by `cabledrive.mechanics.compiled`; and the node-centred scheme,
which shares all but the equations at the nodes.
"""

from dataclasses import replace

import numpy as np
import pytest
from kernel_cases import CARRIAGES, CASES, EVERY, LOOP, SLOPED, as_bent, hung, joined, setting, taken
from kernel_cases import ENERGY as conserving
from kernel_cases import NODE_CENTRED as node_centred
from kernel_cases import VERLET as integrate

from cabledrive.mechanics.cable_laws import LAWS, cable_law
from cabledrive.mechanics.compiled import njit, njit_in_place
from cabledrive.mechanics.mesh import mesh_of
from cabledrive.simulation.channels import TALLIES
from cabledrive.simulation.coordinates import turn
from cabledrive.simulation.damped import end_tensions
from cabledrive.simulation.methods import auxiliary
from cabledrive.simulation.network.mesh import network_plan
from cabledrive.simulation.plan import (
    EVENTS,
    LARGEST_Z,
    PRETENSION,
    RIGIDITY,
    moved_by,
    new_state,
    new_workspace,
)
from cabledrive.simulation.segment_laws import segment_tensions
from cabledrive.simulation.start import Scheme
from cabledrive.simulation.taut import rows_of, step_taut
from oracles.readable_chain import energy_conserving
from oracles.readable_chain import node_centred as readable_node_centred
from oracles.readable_chain.verlet import (
    balance_of,
    integrate_reference,
    law_of,
    solve_shafts_reference,
)

pytestmark = pytest.mark.kernel

CONSERVED = [case for case in CASES if case != "weak" and not case.startswith("slack")]
NODE_CENTRED = [*LAWS, "line", "damped", "sloped", "held load", "stick-slip", "smoothed", "motor", "steep"]


def start_of(case, *, planar=False):
    """Inputs of the energy-conserving scheme, which keeps an energy besides."""
    plan, start, torque, forces = setting(case)
    if planar:
        start.x[1], start.x_t[1] = 0.0, 0.0
    return (
        as_bent(plan),
        start._replace(extra=auxiliary(plan, [law_of(plan)] * len(plan.nodes), start)),
        torque,
        forces,
    )


def assert_equal_runs(inputs, compiled, readable, every=EVERY):
    """Displacements, velocities, tallies, extremes, events, records, fields after the steps, to round-off."""
    code, state, rows, fields = taken(compiled, *inputs, every)
    code_r, state_r, rows_r, fields_r = taken(readable, *inputs, every)
    assert code == code_r == 0
    for name, ours, theirs in zip(state._fields, state, state_r, strict=True):
        if name == "tallies":
            ours, theirs = ours[0] - ours[1], theirs[0]
        if name == "extra":  # without what rounding took away
            ours, theirs = ours[:2], theirs[:2]
        scale = np.max(np.abs(theirs.astype(float)), initial=1e-300)
        error = np.max(np.abs(ours - theirs), initial=0.0) / scale
        assert error < 1e-10, f"{name}: {error:.2e} of its largest entry"
    np.testing.assert_allclose(fields, fields_r, atol=1e-10 * np.max(np.abs(fields_r)))
    scale = np.max(np.abs(rows_r), axis=0) + 1e-12 * np.max(np.abs(rows_r[:, balance_of(inputs[0])]))
    error = np.max(np.abs(rows - rows_r) / scale, axis=0)
    assert error.max() < 1e-9, f"column {error.argmax()}: {error.max():.2e}"
    return state


@pytest.mark.parametrize(
    ("case", "compiled", "readable"),
    [(case, integrate, integrate_reference) for case in CASES]
    + [(case, node_centred, readable_node_centred.integrate_reference) for case in NODE_CENTRED],
)
def test_the_compiled_integration_equals_the_readable_one(case, compiled, readable):
    state = assert_equal_runs(setting(case), compiled, readable)
    if case.startswith("slack"):
        assert state.counts[1] > 0, "the case meant to go slack did not"


@pytest.mark.parametrize(
    ("case", "planar"),
    [(case, False) for case in CONSERVED] + [(case, True) for case in ("exact", "line", "damped", "motor")],
)
def test_the_energy_conserving_integration_equals_the_readable_one(case, planar):
    assert_equal_runs(start_of(case, planar=planar), conserving, energy_conserving.integrate_reference)


def test_a_large_motion_raises_the_shift_and_conserves_energy_all_the_same():
    """The energy beyond the linear one falls below minus the first shift: C is doubled until it does not."""
    plan, start, torque, forces = start_of("steep")
    start.extra[energy_conserving.SHIFT] *= 1e-6
    plan = plan._replace(stop_when_slack=False)
    state, rows = taken(conserving, plan, start, torque, forces)[1:3]
    assert state.extra[energy_conserving.SHIFT] > start.extra[energy_conserving.SHIFT]
    pieces, last = len(plan.nodes), balance_of(plan) - TALLIES
    stored = np.abs(rows[:, [*range(2 * pieces, 5 * pieces), *range(last - 3, last)]]).sum(axis=1)
    assert np.ptp(rows[:, balance_of(plan)]) < 1e-12 * np.max(stored)


@pytest.mark.parametrize(
    ("case", "method"), [("exact", conserving), ("linear", conserving), ("axial damping", integrate)]
)
def test_slack_stops_the_integration_before_the_step(case, method):
    """In the quick loop and in the long ones: one slack segment among all."""
    plan, start, torque, forces = start_of(case) if method == conserving else setting(case)
    start.x[:] = 0.0
    start.x[0, 1] = -1.1 * plan.piece[0, PRETENSION] / plan.piece[0, RIGIDITY] * plan.segment[0, 0]
    code, state = taken(method, plan._replace(stop_when_slack=True), start, torque, forces)[:2]
    assert (code, state.counts[0]) == (1, 0)


def test_a_run_goes_on_from_its_state_alone():
    """To the bit, with a work space of its own for each part: nothing is remembered from step to step."""
    plan, start, torque, forces = setting("everything")
    whole = taken(integrate, plan, start, torque, forces, 6)[1]
    half = len(torque) // 2
    first = taken(integrate, plan, start, torque[:half], forces[:half], 6)[1]
    parts = taken(integrate, plan, first, torque[half:], forces[half:], 6)[1]
    for name in ("x", "x_t", "q", "q_t", "tallies"):
        np.testing.assert_array_equal(getattr(parts, name), getattr(whole, name), err_msg=name)


@njit
def tensions(*arguments):
    """The part of a kernel, which has no entry of its own from Python."""
    return segment_tensions(*arguments)


@njit
def shafts(*arguments):
    turn(*arguments)


@pytest.mark.parametrize("model", LAWS)
@pytest.mark.parametrize("tension_only", [False, True])
@pytest.mark.parametrize("size", [1e-6, 1e-3, 0.02, 0.3])
def test_the_compiled_laws_equal_the_readable_ones(model, tension_only, size):
    """Also beyond the range of the polynomial that stands for the root, and where segments are slack."""
    if model == "linear" and tension_only:
        pytest.skip("a linear cable cannot go slack")
    law = cable_law(LOOP.cable, model, tension_only=tension_only)
    x = np.cumsum(np.random.default_rng(1).uniform(-size, size, (3, 500)), axis=1)
    p = np.zeros((3, 499))
    number = list(LAWS).index(model)
    rope = number, tension_only, law.pretension, law.axial_rigidity
    slack = tensions(rope, (0, 499), x, np.full(499, 1.0), p)
    gradients = np.diff(x, axis=1)
    expected = np.stack(law.excess_components(*gradients))
    np.testing.assert_allclose(p, expected, rtol=1e-12, atol=2e-15 * np.max(np.abs(expected)))
    assert slack == np.sum(law.strain(*gradients) < law.slack_strain)
    largest = np.max(np.abs((1.0 + gradients[0]) ** 2 + gradients[1] ** 2 + gradients[2] ** 2 - 1.0))
    assert (largest > LARGEST_Z) == (size > 0.01), "the sizes are meant to lie on both sides of the range"


@pytest.mark.parametrize("smooth", [0.0, 0.05])
@pytest.mark.parametrize("seed", range(30))
def test_shafts_stick_and_slip_as_the_readable_ones(seed, smooth):
    """Random inertias, joint damping, friction and pushes, stuck and slipping alike."""
    rng = np.random.default_rng(seed)
    joint = rng.uniform(0.0, 3.0)
    matrix = np.diag(rng.uniform(0.5, 2.0, 3)) + joint * np.array([[1, 0, -1], [0, 0, 0], [-1, 0, 1]])
    matrix[0, 1] = matrix[1, 0] = -rng.uniform(0.0, 0.3) * (seed % 2)
    coulomb = rng.uniform(0.0, 1.0, 3) * rng.integers(0, 2, 3)
    turns = rng.integers(0, 4, 3) > 0
    old, right = rng.uniform(-1.0, 1.0, 3) * turns, rng.uniform(-1.5, 1.5, 3)
    rubs = np.flatnonzero(coulomb * turns)
    made = moved_by(matrix, (np.zeros((3, 3)),) * 2, 1.0 * turns, 1.0, np.eye(3)[rubs], coulomb[rubs])
    plan = setting("motor")[0]._replace(
        **made | {"loss": matrix},
        smooth=np.full(rubs.size, smooth),
        wrap=np.full((rubs.size, 2), -1),
    )
    work = new_workspace(plan)
    work.force[:] = right
    shafts(plan, old, plan.inverse, plan.rub_mobility, plan.rub_own, work)
    new, friction = solve_shafts_reference(plan, matrix, right, old)
    np.testing.assert_allclose(work.new, new, atol=1e-13)
    np.testing.assert_allclose(work.friction, friction[rubs], atol=1e-12)
    if smooth == 0.0:
        assert (np.abs(work.friction) <= coulomb[rubs] * (1.0 + 1e-12)).all()


# --- The pass over taut segments, `cabledrive.simulation.taut`, equals the readable integration
TAUT_SEGMENTS, TAUT_STEPS, TAUT_EVERY = 9, 60, 20
DRIVES = {
    "loop": (LOOP, ()),
    "line": (replace(LOOP, kind="line"), ()),
    "sloped loop": (SLOPED, ()),
    "carriage": (replace(LOOP, carriage=CARRIAGES[:1]), ()),
    "carriages side by side": (replace(SLOPED, carriage=CARRIAGES), ()),
    "forces": (replace(LOOP, carriage=CARRIAGES), ((3, 0), (3, 2), (5, 2))),
}


def taut_setting(kind, *, planar, speed):
    """A start in motion; the faster the drive pulley turns, the sooner a span is slack."""
    drive, forces = DRIVES[kind]
    drive = replace(drive, cable=replace(drive.cable, transverse_damping=20.0, axial_damping=0.0))
    mesh, law = mesh_of(drive.machine, TAUT_SEGMENTS), cable_law(drive.cable)
    step = 0.8 * mesh.spacing[mesh.spacing > 0.0].min() / drive.cable.axial_wave_speed
    rest = hung(drive, mesh, law)
    plan = network_plan(mesh, [law] * len(mesh.pieces), rest, (), step, Scheme(slack="record"), forces)
    x, x_t = np.zeros((3, mesh.size)), np.zeros((3, mesh.size))
    rng = np.random.default_rng(3)
    x[1 if not planar else 2 :, mesh.sways] = 1e-4 * rng.uniform(-1.0, 1.0, (2 - planar, mesh.sways.sum()))
    x_t[0, 0] = speed
    start = new_state(plan, *joined(mesh, x, x_t, rest.x))
    pushed = 1e-2 * np.sin(np.arange(TAUT_STEPS * len(plan.force))).reshape(TAUT_STEPS, -1)
    return plan, start, 0.2 * np.cos(np.arange(TAUT_STEPS))[:, None], pushed


@pytest.mark.parametrize("kind", DRIVES)
@pytest.mark.parametrize("planar", [True, False])
@pytest.mark.parametrize("speed", [0.1, 6.0])
def test_quick_steps_equal_the_readable_ones(kind, planar, speed):
    """Taut all the time, or slack from the midst of the steps between two records on."""
    inputs = taut_setting(kind, planar=planar, speed=speed)
    state = assert_equal_runs(inputs, integrate, integrate_reference, TAUT_EVERY)
    goes_slack = speed > 1.0
    assert (state.counts[EVENTS] > 0) == goes_slack
    if goes_slack:
        assert state.events[0, 0] % TAUT_EVERY not in (0, TAUT_EVERY - 1), "meant to go slack between records"


@njit_in_place
def steps(*arguments):
    """The part of a kernel, which has no entry of its own from Python."""
    return step_taut(*arguments)


@pytest.mark.parametrize("planar", [True, False])
def test_quick_steps_are_taken_while_taut_and_refused_when_slack(planar):
    for speed, expected in ((0.1, True), (6.0, False)):
        plan, state, *inputs = taut_setting("loop", planar=planar, speed=speed)
        plane, out = rows_of(plan, state)
        assert (out is None) == planar
        went = steps(plan, state, new_workspace(plan), tuple(inputs), plane, out)
        assert went == expected


@njit_in_place
def tensions_at_ends(*arguments):
    """The part of a kernel, which has no entry of its own from Python."""
    return end_tensions(*arguments)


@pytest.mark.parametrize(("size", "reach"), [(5, 5), (64, 64), (100, 100), (150, 70), (190, 129)])
def test_dampers_at_the_ends_answer_to_all_segments_within_reach(size, reach):
    """Sums over a piece in the middle of a table, block by block, against dot products."""
    rng = np.random.default_rng(size)
    table, rate = rng.normal(size=(5, size + 6)), rng.normal(size=size + 6)
    own = slice(3, size + 3)
    table[3, own][reach:], table[4, own][: size - reach] = 0.0, 0.0
    expected = table[3, own] @ rate[own], table[4, own] @ rate[own]
    assert tensions_at_ends(table, (3, size + 3), rate) == pytest.approx(expected, rel=1e-12)
