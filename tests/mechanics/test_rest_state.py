"""The tension at rest and the sag: against the divided cable, closed forms, and plain statics; the mesh."""

from dataclasses import replace
from math import pi, radians, sin

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

import cabledrive as cd
from cabledrive.mechanics import rest_state
from cabledrive.mechanics.cable_laws import LAWS, cable_law
from cabledrive.mechanics.mesh import gradients, mesh_of, weights_of
from cabledrive.mechanics.network.motion import gravity
from cabledrive.mechanics.network.statics import statics_of
from cabledrive.mechanics.spans import transverse_chains
from cabledrive.parameters.drive import SENSE
from cabledrive.parameters.drive_file import load_drive
from cabledrive.parameters.drive_parts import Carriage
from cabledrive.parameters.errors import InputRefused, NotComputed
from cabledrive.parameters.route.two_pulleys import NAMES
from cabledrive.simulation import Scheme, Start
from cabledrive.simulation.network.mesh import rest_of
from network_samples import as_routes, hanging_drive
from oracles.hanging_machine import catenary_sag


def cable_forces(mesh, law, displacement):
    """Forces of the cable on its nodes along u, v, w [N], (3, nodes), the pretension's own pull left out."""
    components = np.stack(law.excess_components(*gradients(mesh, displacement)))
    force = np.zeros((3, mesh.size))
    for first, last in mesh.nodes:
        force[:, first:last] += components[:, first:last]
        force[:, first + 1 : last + 1] -= components[:, first:last]
    return force


def hung(drive, mesh, law):
    """How its cable hangs."""
    return rest_of(mesh, [law] * len(mesh.pieces), gravity(drive.machine))


def weighed(drive, mesh):
    """Weights of the nodes, and those of the ends on the coordinates."""
    g = gravity(drive.machine)
    frames = np.array([(own[0].where.along, own[0].where.across) for own in mesh.parts])
    return weights_of(mesh, g), np.einsum("ks,kx,ksxn->n", mesh.half, frames @ g, mesh.ends[:, :, ::2])


@pytest.mark.parametrize("seed", range(12))
def test_a_divided_cable_rests_in_balance(seed):
    """Weights, carriages held and hanging, slopes, fixed and free pulleys, deep sag, every law.

    Rims so small that the rope which they have taken on weighs next to nothing.
    """
    drive = hanging_drive(np.random.default_rng(seed), heaviest=2.0, most=3, deepest=np.inf)
    drive = replace(drive, pulley=tuple(replace(own, radius=1e-5) for own in drive.pulley))
    mesh, law = mesh_of(drive.machine, 40), cable_law(drive.cable, list(LAWS)[seed % 4])
    left = cable_forces(mesh, law, hung(drive, mesh, law).x)
    weight, on_q = weighed(drive, mesh)
    ends = np.stack([left[:, own] for own in mesh.nodes]).transpose(0, 2, 1)  # (pieces, 2, 3)
    ends[:, :, 0] += law.pretension * np.array([1.0, -1.0])
    turning = np.einsum("ksx,ksxn->n", ends, mesh.ends) + on_q
    left[::2] += weight
    left[2, ~mesh.sways] = left[:, mesh.nodes] = 0.0
    error = np.abs(left).max() / drive.cable.pretension
    assert error < 1e-10, f"{error:.1e} of the pretension is left, seed {seed}"
    standing = (drive.kind == "line") * law.pretension
    for name, held in ((NAMES[0], rest_state(drive).holding_torque / 1e-5), (NAMES[1], 0.0)):
        if name in mesh.names:
            rim = SENSE * turning[mesh.names.index(name)] / 1e-5
            rim += standing * (1.0 if name == NAMES[1] else -1.0)
            assert abs(rim + held) < 1e-4 * drive.cable.pretension, (name, rim, held)


def test_steady_torque_splits_the_spans_of_a_loop():
    """T = T0 -+ tau / (2 r) where nothing weighs."""
    drive = cd.load_drive("dissertation-1", overrides=["layout.gravity=0"]).listed
    for fixed in (False, True):
        held = replace(drive, pulley=(drive.pulley[0], replace(drive.pulley[1], fixed=fixed)))
        upper, lower = rest_state(held, at_torque=0.05).stretches
        shift = 0.05 / 0.03 / 2
        assert_allclose([upper.mean_tension, lower.mean_tension], [5 - shift, 5 + shift], rtol=1e-12)


def test_rope_of_a_lift_carries_what_hangs_below(measured):
    """The elevator's ropes above and below the car differ by its weight; the motor holds none of it."""
    drive = cd.load_drive("elevator").listed
    rest = rest_state(drive)
    car = drive.carriage[0]
    above, below = rest.sections[0].stretches[0], rest.sections[1].stretches[0]
    step = above.tensions[1] - below.tensions[0]
    measured(f"step of the tension at the car {abs(step):.2f} N")
    assert abs(step) == pytest.approx(car.mass * 9.81, rel=1e-12)
    assert above.gradient == pytest.approx(-drive.cable.mass_per_length * 9.81, rel=1e-9)
    assert abs(rest.holding_torque) < 1e-3 * car.mass * 9.81 * drive.drive_pulley.radius  # ropes strain


def test_inclined_rope_needs_its_weight_times_the_sine_at_the_drive_pulley(measured):
    """But for what sag turns, the tension times the square of a slope, which falls as the tension grows."""
    off = []
    for pretension in (4e5, 8e5):
        settings = ["carriage.1.mass=0.001", "layout.inclination=30 deg", f"cable.pretension={pretension} N"]
        drive = cd.load_drive("elevator", overrides=settings).listed
        weight = 9.81 * sin(radians(30)) * (drive.carriage[0].mass - 0.001)
        torque = rest_state(drive).holding_torque
        off.append(abs(torque) / (weight * drive.drive_pulley.radius) - 1.0)
    measured(f"{off[0]:.1e}, {off[1]:.1e} above")
    assert 0.0 < off[1] < 2e-4
    assert 1.7 < off[0] / off[1] < 2.1


def test_section_that_hangs_slack_is_refused():
    drive = cd.load_drive("elevator", overrides=["cable.pretension=2 kN"]).listed
    assert rest_state(drive).lowest_tension < 0.0
    with pytest.raises(cd.NotComputed, match="hangs slack at rest"):
        transverse_chains(drive, rest=rest_state(drive))


# --- Sag under gravity and carriages: closed forms, order of convergence, balance of the pulleys
DRIVE = load_drive("dissertation-2").listed
LEVEL = replace(DRIVE, layout=replace(DRIVE.layout, gravity=0.0))


def with_cable(drive, **changes):
    return replace(drive, cable=replace(drive.cable, **changes))


@pytest.mark.parametrize("pretension", [5.0, 0.05, 0.001])
def test_sag_converges_to_the_catenary_with_order_two(pretension, measured):
    drive = with_cable(DRIVE, pretension=pretension)
    drive = replace(drive, pulley=tuple(replace(own, radius=1e-12, fixed=True) for own in drive.pulley))
    expected, _ = catenary_sag(drive)
    n = np.array([20, 40, 80])
    at_rest = [hung(drive, mesh_of(drive.machine, int(k)), cable_law(drive.cable)) for k in n]
    error = [abs(np.max(np.abs(one.x[2])) - expected) for one in at_rest]
    order = -np.polyfit(np.log(n), np.log(error), 1)[0]
    measured(f"order {order:.3f}")
    assert order == pytest.approx(2.0, abs=0.05), f"observed order {order:.3f}, errors {error}"
    assert error[-1] < 1e-3 * expected


def test_a_fixed_load_pulley_keeps_a_hanging_carriage_higher():
    """A carriage that hangs on the upper span stretches it; a free pulley shares that with the lower span."""
    drive = replace(DRIVE, carriage=(Carriage(mass=0.05, position=0.3, guided=False),))
    fixed = replace(drive, pulley=(drive.pulley[0], replace(drive.pulley[1], fixed=True)))
    free, held = (rest_state(own).sections[0].sag for own in (drive, fixed))
    assert free > 1.05 * held


def test_gravity_on_a_slope_asks_for_a_held_pulley():
    """A carriage at 30 deg pulls m g sin(30 deg) along the loop."""
    layout = replace(DRIVE.layout, inclination=pi / 6)
    drive = replace(DRIVE, layout=layout, carriage=(Carriage(mass=1e-2, position=0.5),))
    with pytest.raises(InputRefused, match="N m would hold them; hold the drive pulley"):
        cd.simulate(drive, 1e-3, start=Start(from_equilibrium=True))


def test_a_loop_that_hangs_slack_at_rest_has_no_equilibrium_of_a_cable_that_cannot_push():
    """Below half the weights the lower ends go slack: nothing holds the nodes there across."""
    lift = load_drive("elevator").listed
    slack, scheme = with_cable(lift, pretension=0.8 * lift.cable.pretension), Scheme(slack="tension-only")
    with pytest.raises(NotComputed, match=r"hangs slack; raise cable\.pretension"):
        cd.simulate(slack, 1e-3, start=Start(from_equilibrium=True, hold="drive"), scheme=scheme)


# --- The divided cable: mass, weight, places of carriages, conservative forces
places = st.lists(st.floats(0.001, 0.999), max_size=6, unique_by=lambda x: round(x, 4))


@given(upper=places, lower=places, segments=st.integers(3, 60))
def test_carriages_sit_on_nodes_and_mass_is_conserved(upper, lower, segments):
    """Whatever the places: each carriage at its place to round-off, and the whole mass of the cable."""
    on = [(p, "upper") for p in upper] + [(p, "lower") for p in lower]
    carriages = tuple(Carriage(mass=1e-3 * (k + 1), position=p, span=s) for k, (p, s) in enumerate(on))
    drive = replace(LEVEL, carriage=carriages)
    mesh = mesh_of(drive.machine, segments)
    stretch = 1.0 + drive.cable.prestrain
    for carriage, node in zip(carriages, mesh.carriages, strict=True):
        span = mesh.pieces.index(carriage.span)
        place = mesh.positions[span][node - mesh.nodes[span, 0]]
        assert place == pytest.approx(carriage.position * stretch)
        assert mesh.carried[node] == carriage.mass
    cable = drive.cable.mass_per_length * drive.span_length * 2
    assert mesh.cells.sum() + mesh.half.sum() == pytest.approx(cable, rel=1e-12)
    assert mesh.spacing.sum() == pytest.approx(2 * drive.pulley_distance, rel=1e-12)
    assert mesh.nodes[0, 1] >= max(segments, len(upper) + 1, len(lower) + 1)


def test_gravity_has_the_printed_signs_and_follows_the_slope():
    """(2.26), (2.27): -g on w1, +g on w2; on a slope the rest goes along u, downhill in both spans."""
    small = replace(DRIVE, pulley=tuple(replace(own, radius=1e-5) for own in DRIVE.pulley))
    mesh, sloped = (
        mesh_of(small.machine, 10),
        replace(small, layout=replace(DRIVE.layout, inclination=pi / 6)),
    )
    (level_u, level_w), _ = weighed(small, mesh)
    assert (level_w[1:10] < 0.0).all()
    assert (level_w[12:21] > 0.0).all()
    assert not level_u.any()
    (steep_u, steep_w), on_q = weighed(sloped, mesh)
    np.testing.assert_allclose(steep_w, level_w * np.cos(pi / 6), rtol=1e-12)
    np.testing.assert_allclose(steep_u[1:10], level_w[1:10] * 0.5, rtol=1e-12)
    pull = np.abs(on_q) / 1e-5
    assert (pull < 1e-3 * abs(steep_u[1])).all(), "the half cells at a rim pull apart, but for their slope"


@pytest.mark.parametrize("name", [name for name, law in LAWS.items() if law.has_potential])
@pytest.mark.parametrize("kind", ["loop", "line"])
def test_forces_are_minus_the_derivative_of_the_energy(name, kind):
    """Complex step through every nodal displacement of a small chain."""
    drive = replace(DRIVE, kind=kind)
    mesh, law = mesh_of(drive.machine, 4), cable_law(drive.cable, name)
    displacement = 1e-3 * np.random.default_rng(2).standard_normal((3, mesh.size))
    force = cable_forces(mesh, law, displacement)
    for axis in range(3):
        for node in range(mesh.size):
            stepped = displacement.astype(complex)
            stepped[axis, node] += 1e-30j
            slope = np.imag(mesh.spacing @ law.energy_density(*gradients(mesh, stepped))) / 1e-30
            assert force[axis, node] == pytest.approx(-slope, rel=1e-11, abs=1e-11 * law.pretension)


@pytest.mark.parametrize(
    ("segments", "words"),
    [
        (2, "needs at least 3"),
        (10**7, "at most 1000000"),
        (10.5, "not a whole number"),
        (True, "not a whole"),
    ],
)
def test_a_useless_division_is_refused(segments, words):
    with pytest.raises(InputRefused, match=words):
        mesh_of(DRIVE.machine, segments)


@pytest.mark.parametrize("name", ["elevator", "camera-line", "dissertation-2"])
def test_a_torque_on_the_load_pulley_holds_nothing_at_rest(name):
    """A column of load torque makes its pulley one that a torque turns, which stands where it would."""
    drive = load_drive(name).listed
    plain, loaded = (statics_of(as_routes(drive, loaded=own)) for own in (False, True))
    assert_allclose(loaded.start, plain.start, rtol=1e-12)
    assert_allclose(loaded.end, plain.end, rtol=1e-12)


@pytest.mark.parametrize("name", ["ropeway", "elevator", "dissertation-transporter"])
def test_a_machine_with_routes_rests_as_the_loop_that_it_is(name):
    """Section by section; its first pulley counts the other way round."""
    loop = cd.load_drive(name).listed
    known, found = rest_state(loop), rest_state(as_routes(loop))
    for own, same in zip(known.sections, found.sections, strict=True):
        for key in ("start", "end", "sag", "lowest_tension"):
            assert getattr(same, key) == pytest.approx(getattr(own, key), rel=1e-12, abs=1e-12)
    scale = loop.drive_pulley.radius * loop.cable.pretension
    assert found.holding_torque == pytest.approx(-known.holding_torque, abs=1e-12 * scale)


def test_a_winch_holds_its_line_at_rest():
    """By the tension with which the rope leaves its drum."""
    drive = cd.load_drive("camera-winches")
    found, drum = rest_state(drive), drive.pulley[drive.turned[0]]
    pulls = [own for own in found.sections if drum.name in own.span]
    assert abs(found.holding_torque) == pytest.approx(
        drum.radius * pulls[0].stretches[0].tensions[0], rel=1e-6
    )
