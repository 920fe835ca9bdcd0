"""Machines with routes: balance at rest, dynamic stiffness against finite elements, ropes that hang."""

from dataclasses import replace

import numpy as np
import pytest

import cabledrive as cd
from cabledrive.mechanics.network import network_of, statics_of
from cabledrive.mechanics.network.response import dynamic_stiffness, hung_stiffness, responses
from cabledrive.mechanics.network.rest_forces import RestingStretch
from cabledrive.mechanics.network.span_table import pulley_rows
from network_samples import as_routes, hanging_drive, route, routed
from oracles.network_fem import matrices
from oracles.route_fem import Kinematics, system


def weight(drive):
    slope = drive.layout.inclination
    return -drive.layout.gravity * np.array([np.sin(slope), np.cos(slope)])


MACHINES = [
    *(cd.load_drive(name) for name in cd.packaged_drives("route")),
    *(as_routes(cd.load_drive(name)) for name in ("camera-line", "ropeway", "printer-belt")),
    route("elevator", "layout.gravity=9.81"),
]


def error_at_rest(drive):
    """Largest error of force and length, relative: forces fall by what hangs, ropes reach their wheels."""
    statics, g = statics_of(drive), weight(drive)
    places, weights = np.polynomial.legendre.leggauss(200)
    longer, errors = np.zeros(len(drive.route)), []
    for number, (span, ends) in enumerate(zip(drive.free_spans, statics.forces, strict=True)):
        frame, rope = np.array((span.along, span.across)), drive.ropes[span.route]
        own = sorted(
            (place, carriage.mass * frame @ g, carriage.guided)
            for carriage, (at, place) in zip(drive.carriage, drive.carriage_places, strict=True)
            if at == number
        )
        ends = ends @ frame.T / drive.route[span.route].ropes * [[1.0], [-1.0]]
        force, reached, pieces = ends[0], np.zeros(2), statics.stretches[number]
        wheels = [place.sense * place.radius for place in (span.start, span.end)]
        angles = np.arctan2(ends[:, 1], ends[:, 0]) * np.abs(np.sign(wheels))
        lifted = (np.array([np.sin(angles), 1.0 - np.cos(angles)]) * wheels).T
        wound = wheels * angles / (1.0 + np.hypot(*ends.T) / rope.axial_rigidity)
        for i, (_, weighs, held) in enumerate([*own, (span.length, np.zeros(2), True)]):
            half = 0.5 * pieces[i].length
            along = force - np.outer(half * (1.0 + places), rope.density * frame @ g)
            size = np.hypot(*along.T)[:, None]
            reached += half * weights @ (along / rope.axial_rigidity + along / size)
            force = force - 2.0 * half * rope.density * frame @ g - weighs
            if held:  # a guide bears what it must
                end = (lifted[1] if i == len(own) else np.zeros(2)) - lifted[0]
                errors.append(abs(reached[1] - end[1]) / span.length)
                force[1] = pieces[i + 1].force[1] if i < len(own) else force[1]
        errors.append(np.abs(force - ends[1]).max() / np.abs(ends).max())
        errors.append(0.0 if drive.body else abs(reached[0] - span.length - end[0]) / span.length)
        straight = span.length / (1.0 + (rope.pretension or 0.0) / rope.axial_rigidity)
        longer[span.route] += (
            sum(piece.length for piece in pieces) - straight + wound[0] - wound[1]
        ) / straight
    for one, rope, own, places in zip(drive.route, drive.ropes, longer, drive.places, strict=True):
        drum = places[-1].pulley
        if one.closed:
            errors.append(abs(own))
        elif drum is not None and not drive.pulley[drum].fixed and not drive.body:  # it keeps its torque
            load = rope.density * frame @ g @ lifted[1] / (1.0 + np.hypot(*ends[1]) / rope.axial_rigidity)
            errors.append(abs((np.hypot(*ends[1]) + load) / rope.pretension - 1.0))
    return max(errors)


@pytest.mark.parametrize("drive", MACHINES, ids=lambda drive: drive.name)
def test_every_span_is_in_balance_under_its_own_weight_and_its_carriages(drive):
    assert error_at_rest(drive) < 1e-9


@pytest.mark.parametrize("drive", [one for one in MACHINES if one.body], ids=lambda drive: drive.name)
def test_ropes_carry_what_slides_without_a_spring(drive):
    """Along every slide the pull of all ropes on what a body carries is its weights and loads."""
    kin, statics, g = Kinematics(drive), statics_of(drive), weight(drive)
    springs = {body.name: body.stiffness for body in drive.body}
    total, size = np.zeros(kin.size), np.zeros(kin.size)

    def add(force, at, on):
        own = np.asarray(force) @ kin.slope(at, on)
        total[:], size[:] = total + own, size + np.abs(own)

    for body in drive.body:
        add(body.mass * g + np.array(body.load), body.at, body.name)
    for pulley in drive.pulley:
        add(pulley.mass * g, pulley.at, pulley.on)
    parts = {part.name: part for part in (*drive.pulley, *drive.anchor)}
    for span, ends in zip(drive.free_spans, statics.forces, strict=True):
        for place, force in zip((span.start, span.end), ends, strict=True):
            add(force, place.centre, parts[place.name].on)
    for number, (name, move) in enumerate(kin.moves):
        if move != "turn" and springs[name] == 0.0:
            assert abs(total[number]) < 1e-6 * size[number], f"{name}.{move}"


@pytest.mark.parametrize(
    "drive",
    [route("corexy"), route("serpentine"), route("serpentine", "route.belt.speed=30"), route("printer")],
    ids=["corexy", "an arm that turns", "a running belt", "an elastic beam"],
)
@pytest.mark.parametrize("hertz", [11.0, 87.3, 240.0])
def test_the_dynamic_stiffness_is_that_of_finite_elements_seen_from_the_coordinates(drive, hertz, measured):
    """Strings by polynomials, inner coordinates eliminated at the frequency; gyroscopic where they run."""
    network, omega = network_of(drive), 2.0 * np.pi * hertz
    tensions = list(zip(network.statics.start, network.statics.end, strict=True))
    strings, beams, hanging, mass, stiffness = system(drive, tensions)
    assert not beams
    assert not hanging
    n = len(network.motion.names)
    assert len(mass) == n
    mass, gyroscopic, stiffness = matrices(strings, mass, stiffness, 24)
    whole = stiffness - omega**2 * mass + 1j * omega * gyroscopic
    inner = np.linalg.solve(whole[n:, n:], whole[n:, :n])
    expected = whole[:n, :n] - whole[:n, n:] @ inner
    found = dynamic_stiffness(network, omega + 0j, damped=False)
    scale = np.sqrt(np.outer(np.abs(expected.diagonal()), np.abs(expected.diagonal())))
    error = np.abs((found - expected) / scale).max()
    measured(f"{drive.name} at {hertz:g} Hz: {error:.1e} of the diagonal")
    assert error < 2e-10, error


def test_friction_needed_on_a_wrap_is_euler_and_eytelwein():
    """ln(T1/T2)/phi with what the running belt presses off the pulley; none where the tensions are equal."""
    drive = route("serpentine", "route.belt.speed=20")
    for row in pulley_rows(drive, statics_of(drive)):
        assert row["tension_in"] == pytest.approx(row["tension_out"], rel=1e-12)
        assert row["needed_friction"] == 0.0
    lift = cd.load_drive("lift-2-to-1")
    rows = [row for row in pulley_rows(lift, statics_of(lift)) if row["needed_friction"]]
    assert rows
    for row in rows:
        ratio = max(row["tension_in"], row["tension_out"]) / min(row["tension_in"], row["tension_out"])
        assert ratio == pytest.approx(np.exp(row["needed_friction"] * row["wrap"]), rel=1e-9)


def test_a_stiff_rope_that_passes_a_small_angle_is_bent_less_than_its_pulley_is():
    """Beam of stiffness EI under a tension T: where a load turns it by a, its curvature is a sqrt(T/EI)/2."""
    drive = cd.load_drive("tendon-finger", overrides=["cable.least_radius=1", "cable.bending_stiffness=0.01"])
    for row in pulley_rows(drive, statics_of(drive)):
        assert row["bend_ratio"] == pytest.approx(2.0 / (row["wrap"] * np.sqrt(20.0 / 0.01)), rel=1e-6)


CAR = """
cable = { axial_rigidity = "100 kN", mass_per_length = "0.1 g/m", pretension = "2 kN" }
body = [{ name = "car", at = ["0 m", "-2 m"], moves = "y", mass = "50 kg" }]
anchor = [
    { name = "top", at = ["0 m", "0 m"] },
    { name = "roof", on = "car", at = ["0 m", "-2 m"] },
    { name = "floor", on = "car", at = ["0 m", "-2.5 m"] },
    { name = "pit", at = ["0 m", "-12 m"] },
]
route = [
    { name = "upper", path = ["top", "roof"], pretension = "4 kN" },
    { name = "lower", path = ["floor", "pit"], ropes = 2 },
]
"""


def test_a_weight_between_pretensioned_ropes_is_shared_by_their_stiffness():
    """The short rope takes what its stiffness is of the sum; the two long ones are relieved by the rest."""
    statics = statics_of(routed(CAR))
    stiffness = np.array([(100e3 + 4e3) / 2.0, 2 * (100e3 + 2e3) / 9.5])
    moved = 50.0 * 9.81 / stiffness.sum()
    expected = np.array([4000.0, 2000.0]) + moved * stiffness / [1.0, -2.0]
    np.testing.assert_allclose(statics.mean, expected, rtol=1e-5)


def test_random_loops_and_lines_hang_in_catenaries_of_their_lengths(measured):
    """Sloping, vertical, with carriages: integrated from the force at the start of each span."""
    rng, worst = np.random.default_rng(2026), []
    for number in range(60):
        drive = hanging_drive(rng, vertical=number % 6 == 0)
        worst.append(error_at_rest(as_routes(replace(drive, motor=cd.Motor(inertia=1e-3)))))
    measured(f"{len(worst)} machines: {max(worst):.1e}, median {np.median(worst):.1e}")
    assert max(worst) < 1e-9, worst


@pytest.mark.parametrize("speed", [0.0, 20.0, 30.0])
def test_a_rope_that_runs_sags_as_one_at_rest_whose_tension_is_less_by_its_momentum(speed):
    """A free belt over two pulleys: T - rho v^2 in place of T across; at 30 m/s that is more than T0."""
    (mean, _) = statics_of(routed(RUNNING.replace("SPEED", f"{speed} m/s"))).mean
    shear, flow = (0.3 * 9.81) ** 2 * 2.0**3 / 12.0, 0.3 / (1.0 + mean / 5e4) * speed**2
    stretched = 2.0 * (mean - 180.0) / 5e4
    assert mean > flow
    assert stretched == pytest.approx(0.5 * shear / (mean - flow) ** 2, rel=0.02)


SLIDE = """
cable = { axial_rigidity = "100 kN", mass_per_length = "0.2 kg/m", pretension = "1 kN" }
body = [{ name = "slide", at = ["4 m", "0 m"], moves = "x", mass = "1 kg", load = ["LOAD", "0 N"] }]
anchor = [
    { name = "wall", at = ["0 m", "0 m"] },
    { name = "near", on = "slide", at = ["4 m", "0 m"] },
    { name = "far", at = ["9 m", "0 m"] },
]
route = [{ name = "left", path = ["wall", "near"] }RIGHT]
"""


def test_a_rope_that_a_load_slackens_hangs_and_one_that_would_have_to_push_is_refused():
    """5 kN on a slide: the far rope keeps the tension of its sag; alone, the near one cannot push back."""
    both = SLIDE.replace("RIGHT", ', { name = "right", path = ["near", "far"] }')
    statics = statics_of(routed(both.replace("LOAD", "5 kN")))
    near, far = statics.forces[0, 1, 0], statics.forces[1, 0, 0]
    assert -near - far == pytest.approx(5000.0, rel=1e-9)
    assert 0.0 < far < 100.0
    alone = SLIDE.replace("RIGHT", "").replace("LOAD", "-1 kN")
    with pytest.raises(cd.InputRefused, match="cannot push"):
        statics_of(routed(alone))


RUNNING = """
cable = { axial_rigidity = "50 kN", mass_per_length = "0.3 kg/m", pretension = "180 N" }
pulley = [
    { name = "a", at = ["0 m", "0 m"], radius = "0.1 m", inertia = "1 kg m^2" },
    { name = "b", at = ["2 m", "0 m"], radius = "0.1 m", inertia = "1 kg m^2" },
]
route = [{ name = "belt", path = ["+a", "+b"], closed = true, speed = "SPEED" }]
"""


def test_a_wave_never_arrives_where_a_rope_is_slack_somewhere():
    """Upright, 10 N above and 10 N of push below; with 10 N more it arrives by the closed form."""
    upright = RestingStretch(
        span="a", start=0.0, end=2.0, force=(10.0, 0.0), load=(10.0, 0.0), axial_rigidity=1e9
    )
    assert upright.travel_time == np.inf
    taut = replace(upright, force=(40.0, 0.0))
    assert taut.travel_time == pytest.approx(2.0 * (np.sqrt(40.0) - np.sqrt(20.0)) / 10.0, rel=1e-6)


def test_a_rope_without_weight_has_by_steps_the_waves_of_its_closed_form(measured):
    """Both dampings, ten half waves."""
    drive = as_routes(cd.load_drive("dissertation-2", overrides=["layout.gravity=0"]))
    piece, omega = network_of(drive).pieces[0], 2.0 * np.pi * np.linspace(5.0, 500.0, 60)
    rope, found, off = piece.rope, hung_stiffness(piece, omega.astype(complex), damped=True), []
    tension = piece.start_tension
    soft = tension / (1.0 + tension / rope.axial_rigidity)
    lost, drag = (
        rope.axial_rigidity + 1j * omega * rope.axial_damping,
        1.0 - 1j * rope.transverse_damping / omega,
    )
    for axis, rigidity, density in ((0, lost, rope.density), (1, soft, rope.density * drag)):
        impedance, phase = (
            np.sqrt(rigidity * density),
            omega * piece.rest.length * np.sqrt(density / rigidity),
        )
        own, other = impedance * omega / np.tan(phase), -impedance * omega / np.sin(phase)
        off += [
            np.abs(found[:, axis, axis] / own - 1.0).max(),
            np.abs(found[:, axis, axis + 3] / other - 1.0).max(),
        ]
    measured(f"within {max(off):.1e}")
    assert max(off) < 1e-11


@pytest.mark.parametrize("name", ["camera-line", "camera-winches", "ropeway"])
def test_the_response_of_a_machine_that_hangs_has_its_poles_at_the_certified_modes(name):
    """The stiffness of straight ropes has them 1 to 60 % away."""
    drive = as_routes(cd.load_drive(name))
    network = network_of(drive)
    listed = [mode.frequency for mode in cd.modes(drive, count=6).modes if mode.plane != "v"][:4]
    for frequency in listed:
        omega = 2.0 * np.pi * frequency * np.array([1.0 - 1e-6, 1.0 + 1e-6])
        stiffness = dynamic_stiffness(network, omega, damped=False, hanging=True)
        below, above = (np.linalg.eigvalsh(own.real) < 0.0 for own in stiffness)
        assert below.sum() + 1 == above.sum(), (frequency, below.sum(), above.sum())


def test_transverse_damping_takes_power_at_every_frequency():
    """All other dampers taken out, the force on a body leads its motion there by less than half a turn."""
    drive = cd.load_drive("camera-winches")
    bare = replace(
        drive,
        cable=replace(drive.cable, axial_damping=0.0, transverse_damping=5.0),
        pulley=tuple(replace(own, viscous_friction=0.0) for own in drive.pulley),
        motor=tuple(replace(own, viscous_friction=0.0, joint_damping=0.0) for own in drive.motor),
    )
    moved = responses(bare, np.linspace(0.05, 20.0, 100), ("camera.y",))[:, 0, 0]
    assert moved.imag.max() < 0.0, moved.imag.max()
