"""Machines with routes that hang: modes about catenaries, loops, a closed form, and rest that stays."""

from dataclasses import replace

import numpy as np
import pytest
from kernel_cases import heard

import cabledrive as cd
from cabledrive.mechanics import ExactLaw
from cabledrive.mechanics.mesh import divided
from cabledrive.mechanics.network import network_of, responses
from cabledrive.mechanics.network.motion import gravity
from cabledrive.parameters.route.two_pulleys import NAMES
from cabledrive.simulation import CarriageForce, Recording, Scheme, Sine, Start
from cabledrive.simulation.case import case_of
from cabledrive.simulation.network.mesh import rest_of
from network_samples import as_routes
from oracles.hanging_machine import catenary_sag


def cableway(irvine, *, kind="line", slope=0.0, fixed=(True, True), damped=0.0, cabin=True, far=0.1):
    """A rope of 40 m and 1 kN of pretension with a cabin of 3 kg that hangs on it, EA 500 times as much."""
    weight = 1000.0 * np.sqrt(irvine / 500.0) / 40.0
    return cd.Drive(
        schema=1,
        name="cableway",
        kind=kind,
        cable=cd.Cable(
            given_rigidity=5e5, mass_per_length=weight / 9.81, pretension=1000.0, axial_damping=damped
        ),
        layout=cd.Layout(span_length=40.0, inclination=np.radians(slope), gravity=9.81),
        pulley=tuple(
            cd.Pulley(radius=radius, inertia=5.0 * radius**2, fixed=own)
            for own, radius in zip(fixed, (0.1, far), strict=True)
        ),
        carriage=(cd.Carriage(mass=3.0, position=40.0 / 3.0, guided=False),) if cabin else (),
    )


@pytest.mark.parametrize("irvine", [1.0, 30.0, 120.0])
def test_a_hanging_cabin_rings_at_the_modes_about_its_catenary(irvine, measured):
    """Waves along and across are coupled by the sag: the lowest in the plane, with order two."""
    drive = as_routes(cableway(irvine, slope=20.0))
    exact = np.sort([mode.frequency for mode in cd.modes(drive).modes if mode.plane != "v"])[:2]
    errors = []
    for segments in (20, 40):
        run = cd.simulate(
            drive,
            400.0,
            start=Start(speeds={"carriage 0 along": 1e-5, "carriage 0 across": 1e-4}),
            scheme=Scheme(segments=segments),
            recording=Recording(rate=20.0),
        )
        signal = sum(run.channel(f"w at the middle of {span}") for span in run.spans)
        errors.append(heard(signal, run.time[1], exact) / exact - 1.0)
    limit = np.abs(4.0 * errors[1] - errors[0]).max() / 3.0
    order = np.log2(np.abs(errors[0]).max() / np.abs(errors[1]).max())
    measured(f"Irvine parameter {irvine:g}: order {order:.2f}, limit within {limit:.1e}")
    assert order == pytest.approx(2.0, abs=0.1)
    assert limit < 1e-6, limit


@pytest.mark.parametrize("wrap", [None, 1.2])
def test_a_loop_slips_on_its_pulleys_as_the_route_that_it_is(wrap, measured):
    """A drive pulley that swings a heavy load: both wraps slide, by the angle of wrap that the file gives."""
    drive = cd.load_drive("dissertation-2").listed
    near, far = (replace(own, capstan_friction=0.05, wrap_angle=wrap) for own in drive.pulley)
    drive = replace(drive, pulley=(near, replace(far, inertia=2e-3)))
    machine = as_routes(drive)
    if wrap:  # that of the drawing, and as much less friction
        less = [replace(own, wrap_angle=None, capstan_friction=0.05 * wrap / np.pi) for own in machine.pulley]
        machine = replace(machine, pulley=tuple(less))
    scheme = Scheme(segments=24, slack="tension-only")
    torque, start = Sine(amplitude=0.3, frequency=8.0), Start(from_equilibrium=True, hold="drive")
    loop = cd.simulate(drive, 0.3, torque=torque, scheme=scheme, start=start)
    pushed = {"drive pulley": Sine(amplitude=-0.3, frequency=8.0)}
    found = cd.simulate(machine, 0.3, torque=pushed, scheme=scheme)
    slips = [np.abs(found.channel(f"slip at {name} pulley")).max() for name in ("drive", "load")]
    off = np.abs(loop.load_angle + found.channel("load pulley")).max() / np.abs(loop.load_angle).max()
    measured(f"slip {1e3 * slips[0]:.1f} and {1e3 * slips[1]:.1f} mm, {off:.1e} apart")
    assert min(slips) > 1e-3
    assert off < 1e-8
    assert max(loop.energy_budget_error, found.energy_budget_error) < 1e-10
    assert {f"slip at {name}" for name in NAMES} < set(loop.extremes)


@pytest.mark.parametrize("irvine, slope", [(0.0, 0.0), (1.0, 20.0), (30.0, 0.0), (30.0, 20.0)])
@pytest.mark.parametrize("kind, cabin, far", [("loop", True, 0.1), ("line", False, 0.1), ("loop", True, 2.0)])
def test_a_loop_or_a_line_moves_as_the_route_that_it_is(kind, cabin, far, irvine, slope, measured):
    """From where it hangs: a cabin that is pushed, or a load pulley that begins to turn."""
    drive = cableway(max(irvine, 1.0), kind=kind, slope=slope, fixed=(True, False), cabin=cabin, far=far)
    drive = drive if irvine else replace(drive, layout=replace(drive.layout, gravity=0.0))
    common = {"scheme": Scheme(segments=48), "recording": Recording(rate=500.0)}
    speed = 0.0 if cabin else 0.1 / far
    common["forces"] = [CarriageForce(signal=Sine(amplitude=1.0, frequency=1.0), plane="w")] * cabin
    loop = cd.simulate(drive, 1.0, start=Start(from_equilibrium=True, load_speed=speed), **common)
    found = cd.simulate(as_routes(drive), 1.0, start=Start(speeds={"load pulley": -speed}), **common)
    turned = loop.load_angle - loop.load_angle[0]
    apart = np.abs(turned + found.channel("load pulley")).max() / np.abs(turned).max()
    lost = max(loop.energy_budget_error, found.energy_budget_error)
    measured(f"{kind} as a route: {apart:.1e}, budgets {lost:.1e}")
    assert apart < 1e-10
    assert lost < 1e-6


@pytest.mark.parametrize("name", ["camera-line", "ropeway", "elevator", "dissertation-2"])
def test_a_straight_cable_begins_at_angle_zero_and_falls_towards_its_rest(name, measured):
    """No sag, one tension; what it stores above rest is what its weight has let go when it hangs."""
    drive = cd.load_drive(name).listed
    scheme, recording = Scheme(segments=20, slack="record"), Recording(rate=1000.0)
    begun = cd.simulate(drive, 1e-3, scheme=scheme, recording=recording)
    hung = Start(from_equilibrium=True, hold="drive")
    still = cd.simulate(drive, 1e-3, start=hung, scheme=scheme, recording=recording)
    tension = np.concatenate([begun.channel(f"mean tension, {span}")[:1] for span in drive.spans])
    measured(f"{name}: tension {np.ptp(np.append(tension, drive.cable.pretension)):.1e} N off")
    assert tension == pytest.approx(drive.cable.pretension, rel=2e-3)  # slopes at rims to the third power
    assert begun.load_angle[0] == begun.drive_angle[0] == 0.0
    assert not begun.midpoint()[0].any() or np.abs(begun.midpoint()[0]).max() < 1e-12 * drive.span_length
    energies = ("strain_energy", "spring_energy")
    low, high = (sum(run.channel(one)[0] for one in energies) for run in (still, begun))
    assert low <= high
    assert begun.energy_handled == pytest.approx(high - low, rel=1e-2)


def chain_response(drive, segments, omega, name):
    """Motion of a coordinate under its own force, of the divided machine about where it hangs, (p,) [m/N]."""
    mesh = divided(network_of(drive), segments)
    laws = [
        ExactLaw(pretension=t, axial_rigidity=ea) for t, ea in zip(mesh.tension, mesh.rigidity, strict=True)
    ]
    rest, n = rest_of(mesh, laws, gravity(drive)), len(mesh.names)
    nodes = np.cumsum(mesh.cells > 0.0) - 1
    size = 3 * (nodes[-1] + 1)
    stiff, lossy, mass = (np.zeros((size + n, size + n)) for _ in range(3))
    stiff[size:, size:], mass[size:, size:] = mesh.stiffness, mesh.mass
    lossy[size:, size:] = mesh.damping.sum(axis=0)
    for k, ((first, last), law) in enumerate(zip(mesh.nodes, laws, strict=True)):
        rope = mesh.parts[k][0].rope
        moves = np.zeros((last - first + 1, 3, size + n))
        for i in range(first + 1, last):
            own = slice(3 * nodes[i], 3 * nodes[i] + 3)
            moves[i - first, :, own] = np.eye(3)
            mass[own, own] = mesh.cells[i] * np.eye(3)
            lossy[own, own] = rope.transverse_damping * mesh.cells[i] * np.diag([0.0, 1.0, 1.0])
        moves[[0, -1], :, size:] = mesh.ends[k]
        h = mesh.spacing[first:last]
        gradients = np.diff(rest.x[:, first : last + 1], axis=1) / h
        way = np.stack(law.strain_gradient(*gradients), axis=-1)
        damped = rope.axial_damping * (1.0 + law.pretension / law.axial_rigidity)
        for stretch, slope, d, width in zip(
            np.diff(moves, axis=0), law.stiffness_matrix(*gradients), way, h, strict=True
        ):
            stiff += stretch.T @ slope @ stretch / width
            lossy += damped / width * np.outer(d @ stretch, d @ stretch)
    force = np.zeros(size + n)
    force[size + mesh.names.index(name)] = 1.0
    return np.array([np.linalg.solve(stiff + 1j * w * lossy - w**2 * mass, force) @ force for w in omega])


@pytest.mark.parametrize("irvine, slope", [(1.0, 20.0), (30.0, 0.0)])
def test_the_response_about_the_catenary_is_the_limit_of_the_divided_machine(irvine, slope, measured):
    """Damped along and across, with a cabin, up to some modes in the plane."""
    drive = cableway(irvine, kind="loop", slope=slope, fixed=(True, False), damped=2000.0)
    drive = as_routes(replace(drive, cable=replace(drive.cable, transverse_damping=0.5)))
    own = [mode.frequency for mode in cd.modes(drive, count=4).modes if mode.plane != "v"]
    frequency = np.linspace(0.2, 1.3, 12) * sorted(own)[1]
    exact = responses(drive, frequency, ("load pulley",))[:, 0, 0]
    coarse, fine = (chain_response(drive, n, 2.0 * np.pi * frequency, "load pulley") for n in (32, 64))
    off = [np.abs(own / exact - 1.0).max() for own in (coarse, fine, (4.0 * fine - coarse) / 3.0)]
    measured(f"order {np.log2(off[0] / off[1]):.2f}, limit within {off[2]:.1e}")
    assert np.log2(off[0] / off[1]) == pytest.approx(2.0, abs=0.2)
    assert off[2] < 2e-2 * off[0] + 1e-5


def test_a_rope_between_anchors_hangs_as_the_catenary_formula_says():
    drive = cableway(30.0, cabin=False)
    drive = replace(drive, pulley=tuple(replace(own, radius=1e-6) for own in drive.pulley))
    expected, _ = catenary_sag(drive)
    errors = [
        np.abs(case_of(as_routes(drive), 1.0, scheme=Scheme(segments=n)).rest.x[2]).max() / expected - 1
        for n in (20, 40)
    ]
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.05)
    assert abs(errors[1]) < 1e-3


@pytest.mark.parametrize("model", ["exact", "weak-consistent", "linear"])
@pytest.mark.parametrize("name", ["lift-2-to-1", "camera-winches", "cableway"])
def test_a_machine_under_gravity_stays_where_it_hangs(name, model):
    """Thousands of steps from rest move nothing beyond round-off, whatever the cable law."""
    hung = cableway(120.0, kind="loop", slope=20.0, fixed=(True, False))
    drive = as_routes(hung) if name == "cableway" else cd.load_drive(name).listed
    run = cd.simulate(drive, 1.0, scheme=Scheme(segments=20, model=model), recording=Recording(rate=50.0))
    moved = max(np.abs(list(run.extremes.values())).max(), max(run.midpoint_peaks.values()))
    assert run.steps > 100
    assert moved < 1e-11, moved


@pytest.mark.parametrize("model, named", [("exact", False), ("linear", True)])
def test_a_linear_run_names_the_spans_whose_sag_it_leaves_out(model, named):
    run = cd.simulate(as_routes(cableway(30.0)), 1e-2, scheme=Scheme(segments=20, model=model))
    assert any("first mode" in line for line in run.doubts) == named
