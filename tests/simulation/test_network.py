"""Machines with routes in time: loop, matrices by hand, certified modes, MuJoCo, EXUDYN and Eytelwein."""

from dataclasses import replace
from itertools import pairwise, product

import numpy as np
import pytest

import cabledrive as cd
from cabledrive.mechanics.compiled import numba_at_hand
from cabledrive.simulation import CarriageForce, Pluck, Recording, Scheme, Sine, Start
from cabledrive.simulation.case import case_of
from cabledrive.simulation.methods import time_grid
from command import refused
from network_samples import PRINTER_SPANS, as_route, as_routes, printer_belt, route, routed, without_gravity

PRINTER = route("printer")
UPPER = "drive pulley to load pulley"


def shaped(shape):
    """The start of the printer, one span plucked."""
    return Start(plucks=(Pluck(height=1e-3, span="motor to lower idler", shape=shape),))


LONG = {"segments": 8, "rate": 2000.0, "duration": 0.05, "frequency": 20.0}
SHORT = {"segments": 4, "rate": 10_000.0, "duration": 0.004, "frequency": 200.0}


@pytest.mark.parametrize(
    ("model", "damping", "asked"),
    [
        ("exact", 30.0, LONG),
        ("linear", 30.0, LONG),
        pytest.param("exact", 30.0, SHORT, marks=pytest.mark.kernel, id="short"),
    ],
)
def test_a_loop_as_a_route_moves_as_the_loop(model, damping, asked, measured):
    """Clockwise round both pulleys: angles have the other sign. Friction, joint and all dampings at work."""
    drive = without_gravity(cd.load_drive("dissertation-3").listed)
    drive = replace(drive, cable=replace(drive.cable, axial_damping=damping))
    assert drive.motor.offset_torque != 0.0
    common = {"scheme": Scheme(segments=asked["segments"], model=model)}
    loop = cd.simulate(
        drive,
        asked["duration"],
        recording=Recording(rate=asked["rate"], probes=(("upper", 0.2),)),
        torque=Sine(amplitude=1.0, frequency=asked["frequency"]),
        start=Start(plucks=(Pluck(height=1e-3),)),
        **common,
    )
    route = cd.simulate(
        as_route(drive),
        asked["duration"],
        recording=Recording(rate=asked["rate"], probes=((UPPER, 0.2),)),
        torque=Sine(amplitude=-1.0, frequency=asked["frequency"]),
        start=Start(plucks=(Pluck(height=1e-3, span=UPPER),)),
        **common,
    )
    assert route.step == pytest.approx(loop.step, rel=1e-9)
    pairs = [
        (-route.channel("load pulley"), loop.load_angle),
        (-route.channel("rotor of drive pulley"), loop.channel("motor_angle")),
        (route.channel(f"w at the middle of {UPPER}"), loop.midpoint("upper")[:, 2]),
        (route.channel(f"w at 0.2 m of {UPPER}"), loop.probe(2)[:, 2]),
        (route.channel("coulomb_loss"), loop.channel("coulomb_loss")),
        (route.channel("axial_loss"), loop.channel("axial_loss")),
    ]
    error = max(np.max(np.abs(a - b)) / max(np.max(np.abs(b)), 1e-300) for a, b in pairs)
    measured(f"loop as a route in time, {model}: largest relative difference {error:.1e}")
    assert np.abs(loop.load_angle).max() > 1e-4 * (asked is LONG)
    assert np.abs(loop.channel("motor_angle")).max() > 1e-4
    assert error < 1e-10, error


def test_a_loop_as_a_route_is_pushed_kicked_smoothed_and_estimated_as_the_loop(measured):
    """A sine on a hanging carriage along and across, a kick of the other span, friction by tanh."""
    drive = without_gravity(cd.load_drive("dissertation-3").listed)
    drive = replace(
        drive,
        carriage=(cd.Carriage(mass=2e-3, position=0.5 * drive.span_length, guided=False),),
    )
    push = Sine(amplitude=0.02, frequency=60.0)
    common = {
        "forces": [CarriageForce(signal=push, plane=plane) for plane in ("u", "w")],
        "scheme": Scheme(segments=16, friction="smoothed", step=5e-6),
        "recording": Recording(rate=2000.0),
        "error_estimate": True,
    }
    kick = {"height": 0.1, "shape": "half-sine"}
    loop = cd.simulate(drive, 0.02, start=Start(kicks=(Pluck(span="lower", **kick),)), **common)
    start = Start(kicks=(Pluck(span="load pulley to drive pulley", **kick),))
    found = cd.simulate(as_route(drive), 0.02, start=start, **common)
    pairs = [
        (-found.channel("load pulley"), loop.load_angle),
        (found.channel("carriage 0 across"), loop.midpoint("upper")[:, 2]),
        (found.channel("torque_work"), loop.channel("torque_work")),
        (found.channel("coulomb_loss"), loop.channel("coulomb_loss")),
    ]
    error = max(np.max(np.abs(a - b)) / max(np.max(np.abs(b)), 1e-300) for a, b in pairs)
    measured(f"loop as a route with forces and a kick: largest relative difference {error:.1e}")
    assert error < 1e-9, error
    estimate = found.summary()["error_estimate"]["load pulley"]["error"]
    assert estimate == pytest.approx(loop.error_estimate["load_angle"]["error"], rel=0.05)


@pytest.mark.kernel
@pytest.mark.parametrize(
    ("drive", "torque", "steps", "names"),
    [
        (PRINTER, 200.0, 240, [*(one.name for one in PRINTER.pulley if one.inertia > 0.0), "coulomb_loss"]),
        (cd.load_drive("dissertation-2").listed, 1000.0, 1200, ["load_angle", "drive_angle", "balance"]),
    ],
    ids=["route", "loop in one pass"],
)
def test_steps_that_meet_slack_do_not_depend_on_how_many_are_taken_at_once(drive, torque, steps, names):
    """Between two records taut steps are taken together, and taken back where a span goes slack."""
    step = 5e-7
    scheme = Scheme(segments=4, slack="tension-only", step=step)
    fine, coarse = (
        cd.simulate(
            drive, steps * step, torque=torque, scheme=scheme, recording=Recording(rate=1.0 / (every * step))
        )
        for every in (1, 120)
    )
    assert fine.slack_events
    assert fine.slack_events[0].time % (120 * step) > step
    for name in names:
        np.testing.assert_allclose(fine.channel(name)[::120], coarse.channel(name), rtol=1e-12, err_msg=name)


@pytest.mark.kernel
@pytest.mark.parametrize("model", ["exact", "weak"])
def test_steps_are_leapfrog_on_the_forces_of_the_law(model):
    """The kernels of cabledrive.simulation.kernels and cabledrive.simulation.coordinates against numpy."""
    step, count = 2e-6, 20
    given = {
        "torque": 0.05,
        "start": Start(plucks=(Pluck(height=1e-4, span="motor to lower idler"),)),
        "scheme": Scheme(segments=6, model=model, step=step),
        "recording": Recording(rate=1.0 / step),
    }
    found = cd.simulate(PRINTER, count * step, **given)
    case = case_of(PRINTER, count * step, **given)
    mesh, state = case.mesh, case.first_state()
    mass = np.where(mesh.cells > 0.0, mesh.cells, np.inf)
    places = []
    for number in range(count + 1):
        places.append(state.q.copy())
        node, body = np.zeros_like(state.x), mesh.motor.T @ case.inputs(number, 1)[0][0]
        body -= mesh.stiffness @ state.q
        for k, ((first, last), law) in enumerate(zip(mesh.nodes, case.laws, strict=True)):
            gradients = np.diff(state.x[:, first : last + 1], axis=1) / mesh.spacing[first:last]
            p = np.stack(law.excess_components(*gradients))
            node[:, first + 1 : last] = np.diff(p, axis=1)
            body += mesh.ropes[k] * (p[:, 0] @ mesh.ends[k, 0] - p[:, -1] @ mesh.ends[k, 1])
        state.x_t[...] += step * node / mass
        state.q_t[...] += step * np.linalg.solve(mesh.mass, body)
        state.x[...] += step * state.x_t
        state.q[...] += step * state.q_t
        for k, nodes in enumerate(mesh.nodes):
            state.x[:, nodes] = np.stack([mesh.ends[k, side] @ state.q for side in range(2)], axis=1)
    for k, name in enumerate(mesh.names):
        expected = np.array(places)[:, k]
        np.testing.assert_allclose(
            found.channel(name), expected, rtol=1e-9, atol=1e-12 * np.abs(expected).max()
        )
    assert found.energy_budget_error < 1e-4, found.energy_budget_error


def test_whole_fields_of_a_machine_with_routes_meet_its_channels(tmp_path):
    """Ends of pieces where the coordinates put them, middles as the channels have them; also in the file."""
    given = {"scheme": Scheme(segments=6), "recording": Recording(rate=1e4, fields=3)}
    start = Start(places={"head.x": 1e-4}, plucks=(Pluck(height=1e-4, span="motor to lower idler"),))
    run = cd.simulate(PRINTER, 1e-3, start=start, output=tmp_path / "run.nc", **given)
    mesh = case_of(PRINTER, 1e-3, **given).mesh
    q = np.stack([run.channel(name)[::3] for name in mesh.names])
    for k, (first, last) in enumerate(mesh.nodes):
        ends = np.einsum("sxn,nt->txs", mesh.ends[k], q)
        np.testing.assert_allclose(run.fields[:, :, [first, last]], ends, atol=1e-18)
        middle = [
            np.interp(0.5 * mesh.length[k], mesh.positions[k], own[2, first : last + 1]) for own in run.fields
        ]
        expected = run.channel(f"w at the middle of {mesh.pieces[k]}")[::3]
        np.testing.assert_allclose(middle, expected, atol=1e-18)
    field = run.to_xarray()["field"]
    assert field.dims == ("field_time", "node", "plane")
    np.testing.assert_array_equal(field.sel(plane="w"), run.fields[:, 2])


@pytest.mark.kernel
@pytest.mark.parametrize("name", ["serpentine", "tendon-finger", "corexy"])
def test_energy_of_every_machine_is_conserved_to_round_off(name):
    """Ropes of several tensions and in parallel, bodies that turn, dampers; Stoermer-Verlet's motion."""
    duration = 0.02 if numba_at_hand() else 0.001  # 34 steps at least
    given = {"torque": 0.02, "recording": Recording(rate=2e3)}
    found, verlet = (
        cd.simulate(cd.load_drive(name).listed, duration, scheme=Scheme(segments=12, method=method), **given)
        for method in ("energy-conserving", "verlet")
    )
    assert found.energy_budget_error < 1e-13
    moved = np.array([list(run.extremes.values()) for run in (found, verlet)])
    np.testing.assert_allclose(moved[0], moved[1], atol=1e-6 * np.abs(moved).max())


@pytest.mark.parametrize("duration", [0.05, pytest.param(0.01, marks=pytest.mark.kernel)])
def test_damped_ropes_of_a_machine_with_routes_go_slack_as_those_of_a_loop(duration):
    drive = cd.load_drive(
        "dissertation-2", overrides=["cable.axial_damping=0.1", "layout.gravity=0", "cable.pretension=1"]
    ).listed
    given = {"scheme": Scheme(segments=12, slack="tension-only"), "recording": Recording(rate=2e3)}
    loop, route = (
        cd.simulate(own, duration, torque=torque, **given)
        for own, torque in ((drive, 5.0), (as_routes(drive), -5.0))
    )
    assert loop.slack_events
    np.testing.assert_allclose(-route.channel("load pulley"), loop.load_angle, rtol=1e-9)
    np.testing.assert_allclose(route.channel("axial_loss"), loop.channel("axial_loss"), rtol=1e-9)


def printer_lumps(parts):
    """Masses and stiffness of the printer's belt as lumps on springs, about so many to the longest span."""
    counts = np.maximum(1, np.rint(parts * PRINTER_SPANS / PRINTER_SPANS.max())).astype(int)
    mass, matrix, starts = printer_belt(counts, lumped=True)
    return np.diag(mass), matrix, starts


def test_two_idlers_move_as_lumps_on_springs():
    """The linear law, from the head's displacement: exact motion of the lumps by their eigenvectors."""
    parts, distance = 6, 1e-5
    found = cd.simulate(
        PRINTER,
        0.02,
        scheme=Scheme(segments=parts, model="linear", step=2e-7),
        recording=Recording(rate=5000.0),
        start=Start(places={"head.x": distance}),
    )
    mass, matrix, starts = printer_lumps(parts)
    root = 1.0 / np.sqrt(mass)
    squares, vectors = np.linalg.eigh(root[:, None] * matrix * root)
    initial = np.zeros(mass.size)  # the belt follows its ends linearly: head (node 0) to motor and idler
    initial[: starts[1]] = -distance * (1.0 - np.arange(starts[1]) / starts[1])
    last = starts[3] + np.arange(starts[4] - starts[3])
    initial[last] = -distance * (last - starts[3]) / (starts[4] - starts[3])
    initial[0] = -distance
    modal = vectors.T @ (initial / root)
    swing = np.cos(np.sqrt(np.abs(squares)) * found.time[:, None]) * modal
    motion = (swing @ vectors.T) * root
    head, motor = -motion[:, 0], motion[:, starts[1]] / 6.366e-3
    np.testing.assert_allclose(found.channel("head.x"), head, atol=2e-4 * distance)
    np.testing.assert_allclose(found.channel("motor"), motor, atol=2e-4 * np.abs(motor).max())


GUIDE = """
layout = { gravity = "0 m/s^2" }
anchor = [{ name = "end", on = "load", at = ["0.21 m", "-0.3 m"] }]
route = [{ name = "tendon", path = ["-drum", "-guide", "end"] }]
[cable]
axial_rigidity = "10 kN"
mass_per_length = "5 g/m"
pretension = "20 N"
transverse_damping = "200 1/s"
[[body]]
name = "load"
at = ["0.21 m", "-0.3 m"]
moves = "y"
mass = "0.5 kg"
stiffness = "4 kN/m"
damping = "60 N s/m"
[[pulley]]
name = "drum"
at = ["0 m", "0 m"]
radius = "10 mm"
inertia = "2e-5 kg m^2"
viscous_friction = "0.01 N m s/rad"
[[pulley]]
name = "guide"
at = ["0.2 m", "0 m"]
radius = "10 mm"
fixed = true
capstan_friction = 0.25
"""


def test_a_rope_slides_on_a_guide_at_eytelweins_ratio(measured):
    r"""Pulled slowly by the drum, T_1 = T_2 e^{\mu\varphi} over a quarter turn; the budget closes."""
    drive = routed(GUIDE)
    found = cd.simulate(
        drive,
        0.4,
        torque=lambda t: 0.15 * np.minimum(t / 0.3, 1.0),  # the drum pulls the rope in
        scheme=Scheme(segments=6),
        recording=Recording(rate=2000.0),
    )
    before, behind = (found.channel(f"mean tension, {span}")[-1] for span in found.spans)
    ratio = before / behind
    measured(f"rope on a guide: ratio of tensions {ratio:.5f}, e^(mu phi) {np.exp(0.25 * np.pi / 2):.5f}")
    assert before > 30.0
    assert ratio == pytest.approx(np.exp(0.25 * np.pi / 2), rel=2e-3)
    assert found.channel("coulomb_loss")[-1] > 0.0
    assert found.energy_budget_error < 1e-6, found.energy_budget_error


SLIDING = """
[layout]
span_length = "0.5 m"
gravity = "0 m/s^2"
[cable]
axial_rigidity = "20 kN"
mass_per_length = "1 g/m"
pretension = "50 N"
axial_damping = "{damping} N s"
[[pulley]]
radius = "20 mm"
inertia = "1e-4 kg m^2"
capstan_friction = 0.1
wrap_angle = "180 deg"
[[pulley]]
radius = "20 mm"
inertia = "1e-4 kg m^2"
fixed = true
"""


@pytest.mark.parametrize("segments", [10, 60])
@pytest.mark.parametrize("damping", [0.3, 2.0, 20.0])
def test_a_pulley_that_turns_under_its_rope_gains_speed_by_eytelweins_ratio(damping, segments, tmp_path):
    """The rope stands still, so no damper acts; the torque beyond the limit turns the pulley alone."""
    path = tmp_path / "loop.toml"
    path.write_text('schema = 1\nname = "loop"\nkind = "loop"' + SLIDING.format(damping=damping))
    most = 2.0 * 50.0 * np.tanh(0.5 * 0.1 * np.pi) * 0.02
    scheme, recording = Scheme(segments=segments, slack="record"), Recording(rate=2000.0)
    found = cd.simulate(
        cd.load_drive(path).listed, 0.03, torque=1.05 * most, scheme=scheme, recording=recording
    )
    upper, lower = (found.channel(f"mean tension, {span}")[-1] for span in ("upper", "lower"))
    assert max(upper / lower, lower / upper) == pytest.approx(np.exp(0.1 * np.pi), rel=1e-9)
    late = found.time > 0.02
    gain = np.polyfit(found.time[late], found.channel("drive_speed")[late], 1)[0]
    assert gain == pytest.approx(0.05 * most / 1e-4, rel=1e-6)


@pytest.mark.parametrize("damping", [0.0, 1.0])
def test_a_force_out_of_the_plane_that_begins_at_nothing_moves_as_one_across(damping):
    """A straight line with a hanging mass and no weight is alike both ways, as a line and as a route."""
    pulley = cd.Pulley(radius=0.02, inertia=1e-4, fixed=True)
    line = cd.Drive(
        name="line",
        kind="line",
        cable=cd.Cable(given_rigidity=2e4, mass_per_length=1e-3, pretension=50.0, axial_damping=damping),
        layout=cd.Layout(span_length=1.0, gravity=0.0),
        pulley=(pulley, pulley),
        carriage=(cd.Carriage(mass=0.1, position=0.5, guided=False),),
    )
    signal, reached = Sine(amplitude=0.5, frequency=4.77), []
    for drive, plane in product((line, as_routes(line)), "vw"):
        pushed = [CarriageForce(signal=signal, plane=plane)]
        found = cd.simulate(drive, 0.05, scheme=Scheme(segments=24), forces=pushed)
        sideways = found.probe(0)[:, 1:] if drive is line else found.rows[:, [1, 2]]
        reached.append(np.abs(sideways).max())
        assert found.energy_budget_error < 1e-8
    assert min(reached) > 2e-3
    np.testing.assert_allclose(reached, reached[0], rtol=1e-4)


@pytest.mark.kernel
def test_what_the_weight_of_a_heavy_rope_pulls_behind_a_guide_friction_holds_from_the_first_step_on():
    heavy = GUIDE.replace("0 m/s^2", "9.81 m/s^2").replace("5 g/m", "500 g/m")
    held = cd.simulate(routed(heavy), 1e-4, scheme=Scheme(segments=6))
    assert not held.channel("speed of slip at guide").any()


def test_the_energy_handled_is_what_a_plucked_machine_starts_with():
    found = cd.simulate(PRINTER, 2e-3, start=shaped("triangle"), scheme=Scheme(segments=8))
    tension = found.channel("mean tension, motor to lower idler")[0]
    length = next(span.length for span in PRINTER.free_spans if span.name == "motor to lower idler")
    assert found.energy_handled == pytest.approx(0.5 * tension * 4e-6 / length, rel=0.02)


def test_equations_at_the_nodes_of_a_machine_with_routes_tend_to_the_chain_with_order_two(measured):
    """Pieces of different lengths, and of a single segment."""
    apart = []
    for segments in (10, 20, 40):
        schemes = (Scheme(segments=segments, method=method) for method in ("verlet", "node-centred"))
        runs = [cd.simulate(PRINTER, 0.02, start=shaped("half-sine"), scheme=own) for own in schemes]
        one, other = (own.channel("w at the middle of motor to lower idler") for own in runs)
        apart.append(np.abs(one - other).max())
    order = np.log2(apart[0] / apart[2]) / 2.0
    measured(f"order {order:.2f}, {apart[2]:.1e} m apart")
    assert order == pytest.approx(2.0, abs=0.05)
    winches = cd.load_drive("elevator").listed
    refused(lambda: cd.simulate(winches, 1e-3, scheme=Scheme(method="node-centred")), "carriages")


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"start": Start(drive_angle=0.1)}, "angles at the start"),
        ({"torque": {"engine": 1.0}}, "the motors are motor"),
        ({"start": Start(plucks=(Pluck(height=1e-3, span="upper"),))}, "is no span"),
        ({"start": shaped("sine-x")}, 'shape = "sine-x" is not one'),
        ({"start": shaped("sine-0")}, 'shape = "sine-0" is not one'),
        ({"start": Start(places={"tail": 1.0})}, "take one of"),
        ({"travel": True, "error_estimate": True}, "without forces and error_estimate"),
    ],
)
def test_what_cannot_be_run_is_refused_in_one_line(options, words):
    refused(lambda: cd.simulate(PRINTER, 0.01, **options), words)


def test_the_printer_moves_as_in_mujoco(measured):
    """Every lump a slide joint of MuJoCo, every segment a spring tendon; torque on the motor."""
    mujoco = pytest.importorskip("mujoco")
    parts, step, torque = 4, 2e-6, 0.05
    mass, matrix, starts = printer_lumps(parts)
    bodies = "".join(
        f'<body><joint name="j{k}" type="slide" axis="1 0 0"/>'
        f'<inertial pos="0 0 0" mass="{m!r}" diaginertia="1 1 1"/></body>'
        for k, m in enumerate(mass.tolist())
    )
    tendons = "".join(
        f'<fixed name="t{k}" springlength="0" stiffness="{float(-matrix[k, (k + 1) % mass.size])!r}">'
        f'<joint joint="j{k}" coef="-1"/><joint joint="j{(k + 1) % mass.size}" coef="1"/></fixed>'
        for k in range(mass.size)
    )
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="{step}" gravity="0 0 0" integrator="RK4"/><worldbody>{bodies}</worldbody>'
        f"<tendon>{tendons}</tendon></mujoco>"
    )
    data = mujoco.MjData(model)
    motor, head = [], []
    for number in range(5000):
        data.qfrc_applied[starts[1]] = torque / 6.366e-3
        if number % 50 == 0:
            motor.append(data.qpos[starts[1]] / 6.366e-3)
            head.append(-data.qpos[0])
        mujoco.mj_step(model, data)
    found = cd.simulate(
        PRINTER,
        0.01,
        torque=torque,
        scheme=Scheme(segments=parts, model="linear", step=2e-7),
        recording=Recording(rate=10_000.0),
    )
    errors = [
        np.abs(found.channel(name)[:100] - other).max() / np.abs(other).max()
        for name, other in (("motor", np.array(motor)), ("head.x", np.array(head)))
    ]
    measured(f"printer with two idlers against MuJoCo, 10 ms: {max(errors):.1e}")
    assert max(errors) < 1e-4, errors


def printer_in_exudyn(elements, torque, steps, duration=0.01):
    """Printer's belt laid out straight, cubic ANCF elements; turns of the motor and places of the head."""
    exu = pytest.importorskip("exudyn")
    from exudyn import utilities as item

    container = exu.SystemContainer()
    system = container.AddSystem()
    rigidity, tension = 19.4e3, 30.0
    belt = {
        "massPerLength": 8.3e-3 / (1.0 + tension / rigidity),
        "axialStiffness": rigidity + tension,
        "bendingStiffness": 0.0,
    }
    lengths = PRINTER_SPANS
    ground = system.AddMarker(
        item.MarkerNodeCoordinate(nodeNumber=system.AddNode(item.NodePointGround()), coordinate=0)
    )

    def moving(node, coordinate=0):
        return system.AddMarker(item.MarkerNodeCoordinate(nodeNumber=node, coordinate=coordinate))

    def tied(one, other):
        system.AddObject(item.CoordinateConstraint(markerNumbers=[one, other]))

    def lump(mass):
        node = system.AddNode(item.NodePoint2D())
        system.AddObject(item.MassPoint2D(mass=mass, nodeNumber=node))
        tied(ground, moving(node, 1))
        return node

    head, motor, *idlers = map(lump, (0.35, (1.6e-7 + 54e-7) / 6.366e-3**2, 3e-8 / 4e-3**2, 3e-8 / 4e-3**2))
    rims, x, joints = [head, motor, *idlers, head], 0.0, []
    for span, length in enumerate(lengths):
        count = max(1, round(elements * length / lengths.max()))
        nodes = [
            system.AddNode(item.Point2DS1(referenceCoordinates=[x + length * i / count, 0.0, 1.0, 0.0]))
            for i in range(count + 1)
        ]
        for pair in pairwise(nodes):
            system.AddObject(item.Cable2D(nodeNumbers=list(pair), length=length / count, **belt))
        joints += [(nodes[0], rims[span]), (nodes[-1], rims[span + 1])]
        x += length
    for node, rim in joints:
        tied(moving(rim), moving(node))
        tied(ground, moving(node, 1))
    system.AddLoad(item.LoadCoordinate(markerNumber=moving(motor), load=torque / 6.366e-3))
    sensors = [
        system.AddSensor(
            item.SensorNode(
                nodeNumber=node, outputVariableType=exu.OutputVariableType.Displacement,
                storeInternal=True, writeToFile=False,
            )
        )
        for node in (motor, head)
    ]  # fmt: skip
    system.Assemble()
    settings = exu.SimulationSettings()
    settings.timeIntegration.numberOfSteps = steps
    settings.timeIntegration.endTime = duration
    settings.timeIntegration.verboseMode = 0
    settings.solution.file.write = False
    settings.solution.sensors.writePeriod = 1e-4
    system.SolveDynamic(settings, solverType=exu.DynamicSolverType.TrapezoidalIndex2)
    found = [system.GetSensorStoredData(sensor) for sensor in sensors]
    return found[0][:, 0], found[0][:, 1] / 6.366e-3, -found[1][:, 1]


@pytest.mark.verify
def test_the_printer_moves_as_in_exudyn(measured):
    """Cubic elements (ANCF) and the trapezoidal rule: neither elements nor time scheme are shared."""
    torque, radius = 0.05, 6.366e-3
    found = cd.simulate(
        PRINTER,
        0.01,
        torque=torque,
        scheme=Scheme(segments=8, model="linear", step=2e-7),
        recording=Recording(rate=10_000.0),
    )

    def distance(elements, steps):
        """Largest difference of motor, head, and stretch between them, relative to the largest of each."""
        time, motor, head = printer_in_exudyn(elements, torque, steps)
        ours = [np.interp(time, found.time, found.channel(name)) for name in ("motor", "head.x")]
        pairs = ((ours[0], motor), (ours[1], head), (radius * ours[0] + ours[1], radius * motor + head))
        return [float(np.abs(one - other).max() / np.abs(other).max()) for one, other in pairs]

    fine = distance(8, 5000)
    measured(f"printer with two idlers against EXUDYN, 10 ms: {fine[0]:.1e}, {fine[1]:.1e}, {fine[2]:.1e}")
    assert max(fine[:2]) < 1e-3, fine
    assert fine[2] < 5e-3, fine


def test_a_torque_that_ends_says_when_and_a_run_says_how_fine_it_is():
    """The last number of a torque is at 3.1 ms."""
    found = cd.simulate(
        PRINTER, 0.01, torque=lambda t: np.where(t > 3.1e-3, np.nan, 0.01), recording=Recording(rate=1e3)
    )
    assert float(found.stopped.split("t = ")[1].split()[0]) == pytest.approx(3.1e-3, abs=2.0 * found.step)
    assert found.summary()["cfl"] == pytest.approx(found.step / found.largest_step)


def test_a_run_shorter_than_a_record_has_one():
    grid = time_grid(1e-4, 1e-3, Scheme(), rate=10.0, nodes=10)
    assert (grid.records, grid.every) == (1, 1)
