"""Ropes that are no straight string of even tension, and the elastic modes of machines with routes."""

from dataclasses import replace

import numpy as np
import pytest
from machines import by_multiplicity, held

import cabledrive as cd
from cabledrive.mechanics.network import statics_of
from cabledrive.modal.elements import ACROSS, OUT, Rope
from cabledrive.modal.motion import HeldMode
from network_samples import as_routes, evenly, route, vanishing, without_gravity
from oracles import hanging_machine
from oracles.rope_fem import Beam, frequencies
from oracles.route_fem import frequencies_of_route


def clamped(tension, bending, *, length=1.0, density=1.0, first=6):
    """First frequencies [rad/s] of a rope between ends that are held and, if it bends, clamped."""
    ends = ((), ()) if bending else ((),)
    own = evenly(tension, length), density, ((0, ACROSS),)
    rope = Rope(ends, ends, length, *own, bend=bending, vanishes=vanishing(tension, length))
    number, mean = (first + 1.6) * np.pi / length, 0.5 * sum(tension)
    return held(rope, number * np.sqrt((mean + bending * number**2) / density))[:first]


@pytest.mark.parametrize("least", [1e-1, 1e-3, 1e-5])
def test_a_rope_whose_tension_nearly_vanishes_inside_misses_no_mode(least):
    """Of T = |x - a - ib| with x = a + b sinh y it is w'' + omega^2 b cosh y w = 0, by collocation in y."""
    p = complex(0.03, least)
    rope = Rope(((),), ((),), 1.0, lambda x: np.abs(x - p), 1.0, ((0, OUT),), vanishes=p)
    found, (low, high) = held(rope, 40.0), np.arcsinh((np.array([0.0, 1.0]) - p.real) / p.imag)
    order = np.arange(401)
    places, weight = np.cos(np.pi * order / 400), (-1.0) ** order * np.where(order % 400, 1.0, 2.0)
    apart = places[:, None] - places + np.eye(401)
    slope = weight[:, None] / weight / apart - np.eye(401)
    slope -= np.diag(slope.sum(axis=1))
    curvature = (slope @ slope * (2.0 / (high - low)) ** 2)[1:-1, 1:-1]
    mass = p.imag * np.cosh(low + 0.5 * (high - low) * (1.0 + places[1:-1]))
    inverse = np.linalg.eigvals(-np.linalg.inv(curvature) * mass)
    exact = np.sort(1.0 / np.sqrt(inverse[inverse > 1e-4]))
    np.testing.assert_allclose(found, exact[exact < 40.0], rtol=1e-9)


def test_without_tension_it_is_the_clamped_beam():
    """(4.73004, 7.85320, 10.99561, 14.13717)^2 sqrt(EI/rho)/L^2."""
    found = clamped((1e-12, 1e-12), 2.0, length=0.5, density=3.0, first=4)
    roots = np.array([4.730040744862704, 7.853204624095838, 10.995607838001671, 14.137165491257464])
    np.testing.assert_allclose(found, roots**2 * np.sqrt(2.0 / 3.0) / 0.25, rtol=1e-12)


def test_with_little_bending_stiffness_it_is_morses_stiff_string():
    """n pi c/L (1 + 2e + (4 + n^2 pi^2/2) e^2), e = sqrt(EI/T)/L: the next term is of order e^3."""
    n = np.arange(1, 7)
    for e in (1e-3, 1e-4):
        found = clamped((1.0, 1.0), e**2)
        expected = n * np.pi * (1 + 2 * e + (4 + n**2 * np.pi**2 / 2) * e**2)
        np.testing.assert_allclose(found, expected, rtol=2e3 * e**3)


@pytest.mark.parametrize(
    ("tension", "bending", "tolerance"),
    [
        ((1.0, 1.0), 1e-4, 1e-12),
        ((1.0, 1.0), 1e-8, 1e-12),
        ((1e-9, 1e-9), 1.0, 1e-12),
        ((1.0, 5.0), 0.0, 1e-12),
        ((1.0, 1.2), 0.0, 1e-12),
        ((1.0, 1.2), 1e-9, 1e-11),
        ((1.0, 1.2), 1e-7, 1e-11),
        ((3.0, 1.0), 1e-7, 1e-11),
    ],
)
def test_held_ropes_have_the_frequencies_of_finite_elements(tension, bending, tolerance, measured):
    found = clamped(tension, bending)
    ends = 4 if bending else 2
    beam = Beam(np.zeros((ends, 0)), 1.0, 1.0, bending, tension)
    mass, stiffness = (own[ends:, ends:] for own in beam.matrices(8, 12))
    truth = frequencies(mass, stiffness, found[-1])[: found.size]
    measured(f"relative difference {np.max(np.abs(found / truth - 1.0)):.1e}")
    np.testing.assert_allclose(found, truth, rtol=tolerance)


def between_pulleys(bending):
    """The first belt span of a printer, out of plane, its bending stiffness given [N m^2]."""
    drive = cd.load_drive(
        "printer-idlers", overrides=[f"cable.bending_stiffness={bending}"] if bending else []
    ).listed
    found = cd.modes(drive, below=400.0)
    return drive, [mode for mode in found.transverse if mode.clamped and mode.plane == "v"]


def test_a_belt_between_pulleys_vibrates_as_a_hinged_beam_between_the_tangent_points():
    """The clamps lie sqrt(EI/T) further out than the string's ends, so that the first order cancels."""
    bending = 2e-5
    drive, plain = between_pulleys(None)
    _, stiff = between_pulleys(bending)
    checked = 0
    for span in drive.free_spans:
        if not (span.start.sense and span.end.sense):
            continue
        strings = [mode.frequency for mode in plain if mode.span == span.name]
        beams = [mode for mode in stiff if mode.span == span.name]
        for n, mode in enumerate(beams, 1):
            x = np.sqrt(bending / 30.0) / span.length
            assert mode.model == "tensioned beam"
            rise = mode.frequency / strings[n - 1] - 1.0
            assert rise == pytest.approx((n * np.pi * x) ** 2 / 2, rel=0.1, abs=20 * x**3)
            checked += 1
    assert checked


def test_shapes_of_a_heavy_rope_and_of_a_beam_are_those_that_belong_to_their_strain():
    """Of unit modal mass: the integral of the squared shape over the mass of one rope is one."""
    for name, below, model in (("8x19-8mm", 4.0, "tensioned beam"), ("Dyneema-4mm", 15.0, "heavy string")):
        drive = cd.load_drive("lift-2-to-1", overrides=[f"route.suspension.type={name}"])
        found = cd.modes(drive, below=below).transverse
        mode = next(one for one in found if one.span == "weight pulley to weight hitch")
        assert mode.model == model
        span = next(s for s in drive.free_spans if s.name == mode.span)
        x, weights = np.polynomial.legendre.leggauss(60)
        shape = mode.shape(span.name, span.length * (1 + x) / 2)
        rope = drive.ropes[span.route]
        assert shape.shape[0] == mode.multiplicity
        modal = rope.density * span.length / 2 * float(weights @ shape[0] ** 2)
        assert modal == pytest.approx(1.0, rel=3e-3)  # mass per unstretched length


@pytest.mark.parametrize("case", ["bare", "guided", "hanging"])
def test_a_loop_bends_as_the_same_machine_with_routes(case):
    """With its weight, a carriage on a rail or on the cable: the same modes; at pulleys a hinged beam."""
    drive = cd.load_drive("dissertation-transporter", overrides=["cable.bending_stiffness=5e-5 N m^2"]).listed
    carriage = replace(drive.carriage[0], guided=case == "guided")
    drive = replace(drive, carriage=() if case == "bare" else (carriage,))
    own, routed = cd.modes(drive, count=6), cd.modes(as_routes(drive), count=6)
    found = [[mode.frequency for mode in listed.modes] for listed in (own, routed)]
    np.testing.assert_allclose(*found, rtol=1e-12)
    assert own.certified
    assert any("limp cable" in line for line in cd.drive_warnings(drive)) == bool(drive.carriage)
    if not drive.carriage:  # out of plane, where nothing sags
        cable, length = drive.cable, drive.pulley_distance
        bent = cable.bending_stiffness * (np.pi / length) ** 2
        hinged = np.sqrt((cable.pretension + bent) / cable.stretched_mass_per_length) / (2.0 * length)
        assert own.transverse[0].frequency == pytest.approx(hinged, rel=5e-5)


@pytest.mark.parametrize("bending", [2e-5, 2e-3])
def test_a_loop_whose_cable_leaves_its_pulleys_in_a_wide_curve_is_not_certified(bending):
    """EA EI^2 (1/r1 + 1/r2)^2 / (4 T^3 L^2) is 4e-6 and 4e-2."""
    drive = cd.load_drive("dissertation-1", overrides=[f"cable.bending_stiffness={bending} N m^2"]).listed
    found = cd.modes(drive, count=3)
    assert found.certified == (bending < 1e-4)
    assert found.certified or "curvature at the pulleys" in found.certified_reason


# --- Certified modes of machines with routes: drives with two pulleys, closed forms, reference machines
FIVE = ("dissertation-1", "dissertation-2", "dissertation-3", "printer-belt", "linear-axis")
MOTORS = ("free", "held")
AT_REST = ("camera-line", "elevator", "linear-axis", "printer-belt", "ropeway")


UNLIKE = cd.load_drive("dissertation-1", overrides=["pulley.1.radius=0.15 m"]).listed


@pytest.mark.parametrize(
    ("drive", "motor"),
    [
        *((without_gravity(cd.load_drive(n).listed), motor) for n in (*FIVE, AT_REST[0]) for motor in MOTORS),
        *((cd.load_drive(name).listed, "free") for name in AT_REST),
        (without_gravity(UNLIKE), "free"),
    ],
)
def test_a_drive_as_a_route_has_all_its_modes_with_their_number(drive, motor):
    """Strings in both planes, where they weigh with slopes to 10 %; hanging carriages swing in both."""
    expected, found = (cd.modes(one, count=10, motor=motor) for one in (drive, as_routes(drive)))
    assert found.certified or drive.layout.gravity
    assert found.certificate.count == expected.certificate.count
    assert found.rigid_body_modes == expected.rigid_body_modes
    np.testing.assert_allclose(by_multiplicity(found.modes), by_multiplicity(expected.modes), rtol=1e-12)


def test_spans_between_unlike_pulleys_are_as_long_as_those_of_the_loop():
    """Their slopes of 7 degrees up and down move modes by 3e-5 where they weigh; nothing drives the loop."""
    expected, found = (cd.modes(one, below=200.0) for one in (UNLIKE, as_routes(UNLIKE)))
    np.testing.assert_allclose(by_multiplicity(found.modes), by_multiplicity(expected.modes), rtol=5e-5)
    hung = replace(UNLIKE, carriage=(cd.Carriage(mass=0.1, position=0.3),))
    with pytest.raises(cd.InputRefused, match="one way"):
        cd.modes(replace(as_routes(replace(hung, layout=replace(hung.layout, inclination=0.5))), stops=()))


def test_strain_energy_is_kinetic_energy():
    """What springs, turning bodies and spans store in a mode is what moves in it, row by row."""
    for name in ("printer", "serpentine", "finger"):
        for mode in cd.modes(route(name), below=3000.0 / (2 * np.pi)).modes:
            if not isinstance(mode, HeldMode):
                own = mode.solved
                strain, kinetic = mode.row_energies
                assert kinetic.sum() == pytest.approx(2.0 * own.omega**2, rel=1e-9)
                assert strain.sum() == pytest.approx(2.0 * own.omega**2, rel=1e-9)


def test_a_belt_near_the_speed_of_its_waves_is_warned_of():
    warnings = " ".join(cd.modes(route("serpentine", "route.belt.speed=45"), below=100.0).warnings)
    assert "83% of the wave speed" in warnings


def test_a_span_that_sags_deep_is_certified(measured):
    """A camera of 1 kg lets its lines sag more than any is taken for shallow."""
    drive = cd.load_drive("camera-winches", overrides=["body.camera.mass=1"])
    found, statics = cd.modes(drive, below=2.0), statics_of(drive)
    truth = np.sort(np.concatenate(hanging_machine.frequencies(drive, tensions=statics.start)))
    listed = by_multiplicity(found.modes)
    expected = truth[truth < 2.0][found.rigid_body_modes :]
    steepest = max(abs(own[0].force[1] / own[0].force[0]) for own in statics.stretches)
    error = np.max(np.abs(listed / expected - 1.0))
    measured(f"slopes up to {steepest:.2g}: {listed.size} modes, largest relative difference {error:.1e}")
    assert found.certified
    assert steepest > 0.04
    assert error < 1e-6


# --- The packaged machines: certified modes against finite elements from their files
PACKAGED = cd.packaged_drives("route")
BELOW = {
    "camera-winches": 10.0,
    "capstan-arm": 1800.0,
    "corexy": 320.0,
    "lift-2-to-1": 4.0,
    "printer-idlers": 400.0,
    "ropeway-towers": 0.6,
    "serpentine": 260.0,
    "tendon-finger": 700.0,
}
DEGREE = {"lift-2-to-1": 14}


@pytest.mark.parametrize("name", PACKAGED)
def test_its_modes_are_those_of_finite_elements(name, measured):
    drive, below = cd.load_drive(name).listed, BELOW[name]
    found, statics = cd.modes(drive, below=below), statics_of(drive)
    tensions = list(zip(statics.start, statics.end, strict=True))
    if name == "camera-winches":  # which hangs
        both = hanging_machine.frequencies(drive, tensions=statics.start)
        truth = np.sort(np.concatenate(both))
        assert max(own[0] for own in both) < below < min(own[-1] for own in both)
    else:
        truth = frequencies_of_route(drive, tensions, DEGREE.get(name, 16), below)
    listed = by_multiplicity(found.modes)
    expected = truth[truth < below][found.rigid_body_modes :]
    assert found.certified
    assert listed.size == found.certificate.count == expected.size > 0
    error = np.max(np.abs(listed / expected - 1.0))
    measured(f"{name}: {listed.size} modes below {below:g} Hz, largest relative difference {error:.1e}")
    assert error < 1e-6, error
