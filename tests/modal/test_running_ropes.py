"""Ropes that run and hang, or bend, against divided cables and closed forms that know no element."""

from dataclasses import replace
from math import inf

import numpy as np
import pytest
from machines import held
from scipy.optimize import brentq, minimize_scalar

import cabledrive as cd
from cabledrive.mechanics.network import network_of
from cabledrive.mechanics.network.response import dynamic_stiffness
from cabledrive.modal.elements import ACROSS, ALONG, Rope
from cabledrive.modal.route_network import network_of_routes
from cabledrive.modal.spectrum import Spectrum
from cabledrive.parameters import Machine
from cabledrive.parameters.cable import Rope as Material
from cabledrive.parameters.route.parts import Route, RoutedMotor, RoutedPulley, RouteLayout
from network_samples import route
from oracles import hanging_machine
from other_units import in_other_units

FLOWS = [-0.7, 0.2, 0.6, 0.85]
"""Speed over that of waves across."""


def random_belt(rng):
    """A closed rope round two to four wheels on an ellipse; the first has a motor."""
    count, flow = int(rng.integers(2, 5)), rng.uniform(0.02, 0.85)
    angle = 2.0 * np.pi * (np.arange(count) + rng.uniform(-0.2, 0.2, count)) / count
    at = rng.uniform(20.0, 60.0) * np.column_stack((np.cos(angle), 0.6 * np.sin(angle)))
    density = rng.uniform(0.5, 3.0)
    longest = max(np.hypot(*(at[i] - at[i - 1])) for i in range(count))
    pull = density * 9.81 * longest / (2.0 * 10 ** rng.uniform(-3.0, -0.5))  # by the slope of its sag
    tension = pull / (1.0 - flow**2)
    rigidity = tension * 10 ** rng.uniform(1.7, 3.5)
    radius = rng.uniform(0.05, 0.5, count)
    inertia = rng.uniform(0.05, 3.0, count) * density * longest * radius**2
    return Machine(
        name="belt",
        cable=Material(given_rigidity=rigidity, mass_per_length=density, pretension=tension),
        layout=RouteLayout(gravity=9.81),
        pulley=tuple(
            RoutedPulley(name=f"wheel {i}", at=tuple(at[i]), radius=radius[i], inertia=inertia[i])
            for i in range(count)
        ),
        motor=(RoutedMotor(inertia=0.1 * inertia[0]),),
        route=(
            Route(
                name="belt",
                path=tuple(f"+wheel {i}" for i in range(count)),
                closed=True,
                speed=flow * np.sqrt(tension / density * (1.0 + tension / rigidity)),
            ),
        ),
    )


def frequencies_of(modes, plane):
    """Of modes in the plane, those along included, or out of it, each as often as it is there [Hz]."""
    return np.sort([m.frequency for m in modes for _ in range(m.multiplicity) if (m.plane or "w") == plane])


@pytest.mark.parametrize("seeds", [range(4), pytest.param(range(4, 80), marks=pytest.mark.verify)])
def test_random_belts_that_run_have_the_modes_of_the_divided_cable(seeds, measured):
    """Slopes from 0.1 % to 30 %, up to 85 % of the speed of waves; some ten modes in and out of the plane.

    A tension that sag changes by less than 5e-6 counts as even, which moves modes out of the plane by 1e-7.
    """
    worst = dict.fromkeys("wv", 0.0)
    for seed in seeds:
        drive = random_belt(np.random.default_rng([5, seed]))
        truth = dict(zip("wv", hanging_machine.frequencies(drive, degree=44), strict=True))
        found = cd.modes(drive, below=0.9999 * min(own[12] for own in truth.values()))
        assert found.certified, found.certified_reason
        for plane, expected in truth.items():
            own = frequencies_of(found.modes, plane)
            expected = expected[expected > 0.5 * own[0]][: own.size]  # behind the rope that runs round
            assert own.size > 8
            worst[plane] = max(worst[plane], float(np.max(np.abs(own / expected - 1.0))))
    measured(f"belts that run and hang: {worst['w']:.1e} off in the plane, {worst['v']:.1e} out of it")
    assert worst["w"] < 1e-10
    assert worst["v"] < 1e-7


@pytest.mark.parametrize("seeds", [(22,), pytest.param((4, 13, 25, 27, 36), marks=pytest.mark.verify)])
def test_above_the_edge_of_sag_the_modes_are_those_of_the_rope_that_hangs(seeds, measured):
    """Beyond where sag moves no mode by 1e-4 a rope that runs counts as straight, and its count agrees."""
    worst = 0.0
    for seed in seeds:
        whole = network_of_routes(network_of(random_belt(np.random.default_rng([5, seed]))))
        hanging = replace(whole, ropes=tuple(replace(rope, edge=inf) for rope in whole.ropes))
        top = 1.2 * whole.edges[-1]
        own, expected = (
            np.repeat([m.frequency for m in found], [m.multiplicity for m in found])
            for found in (Spectrum(whole).below(top), Spectrum(hanging).below(top))
        )
        assert own.size == expected.size
        worst = max(worst, float(np.max(np.abs(own / expected - 1.0))))
    measured(f"belts above the edge of sag: {worst:.1e} from the rope that hangs")
    assert 0.0 < worst < 1e-4


def test_the_response_of_a_belt_that_runs_has_its_poles_at_the_certified_modes():
    for seed in (1, 3):
        drive = random_belt(np.random.default_rng([5, seed]))
        network = network_of(drive)
        for frequency in [mode.frequency for mode in cd.modes(drive, count=6).modes if mode.plane != "v"][:4]:
            omega = 2.0 * np.pi * frequency * np.array([1.0 - 1e-5, 1.0 + 1e-5])
            stiffness = dynamic_stiffness(network, omega + 0j, damped=False, hanging=True)
            below, above = (np.linalg.eigvalsh(own) < 0.0 for own in stiffness)
            assert below.sum() + 1 == above.sum(), (seed, frequency)


def beam_residual(omega, flow, bending, held_too):
    """Zero at a mode of a beam that runs, in lengths of the span and speeds of waves.

    B k^4 + (1 - v^2) k^2 - 2 v w k - w^2 = 0 has four waves; a determinant holds both ends, with their slope
    (``held_too`` 1) or without moments (2).
    """
    k = np.roots([bending, 0.0, 1.0 - flow**2, -2.0 * flow * omega, -(omega**2)])
    near = np.exp(-np.maximum(0.0, -k.imag))  # of waves that grow, by their far end
    far = np.exp(1j * k - np.maximum(0.0, -k.imag))
    matrix = np.array([near, k**held_too * near, far, k**held_too * far])
    return np.linalg.det(matrix) / np.prod([k[i] - k[j] for i in range(4) for j in range(i)])


@pytest.mark.parametrize("flow", FLOWS)
@pytest.mark.parametrize("bending", [1e-6, 1e-3, 0.1])
def test_a_clamped_beam_that_runs_has_the_roots_of_its_characteristic_equation(flow, bending):
    given = {"bend": bending, "speed": flow}
    beam = Rope(((), ()), ((), ()), 1.0, even(1.0 - flow**2), 1.0, ((0, ACROSS),), inf, **given)
    top = 16.0 + 250.0 * bending
    own = held(beam, top)
    assert own.size > 2
    for omega in own:
        near, middle, far = (
            beam_residual(omega * (1.0 + step), flow, bending, 1) for step in (-1e-6, 0.0, 1e-6)
        )
        assert abs(middle) < 1e-4 * min(abs(near), abs(far)), omega
    np.testing.assert_allclose(own, held(replace(beam, speed=-flow), top), rtol=1e-12)


@pytest.mark.parametrize("speed", [10.0, 30.0, 45.0])
def test_a_stiff_belt_that_runs_has_the_modes_of_beams_hinged_where_it_meets_its_wheels(speed, measured):
    """To first order in e = sqrt(EI/T) over the span; beams between hinges have closed forms."""
    drive = route("serpentine", f"route.belt.speed={speed}", "cable.bending_stiffness=0.002")
    listed, network = cd.modes(drive, below=200.0).modes, network_of(drive)
    worst = 0.0
    for piece in network.pieces:
        rope, tension, length = piece.rope, piece.start_tension, piece.rest.length
        stretch = 1.0 + tension / rope.axial_rigidity
        waves = np.sqrt(tension / stretch / rope.density)
        flow = speed / stretch / waves
        given = flow, rope.bending_stiffness / (tension / stretch) / stretch**3 / length**2, 2
        mode = next(m for m in listed if m.span == piece.where.name and m.plane == "v")

        def residual(omega, given=given):
            return abs(beam_residual(omega, *given))

        omega = 2.0 * np.pi * mode.frequency * length / waves
        near = minimize_scalar(residual, bracket=(0.99 * omega, omega, 1.01 * omega), tol=1e-10).x
        edge = np.sqrt(rope.bending_stiffness / tension / (1.0 - flow**2)) / piece.where.length
        off, bent = abs(near / omega - 1.0), abs(near / (np.pi * (1.0 - flow**2)) - 1.0)
        worst = max(worst, off / edge**2)
        assert bent > 5.0 * off
    measured(f"a stiff belt at {speed:g} m/s: {worst:.2g} (e/L)^2 from beams between hinges")
    assert worst < 20.0


@pytest.mark.parametrize("flow", FLOWS)
@pytest.mark.parametrize("irvine", [0.5, 20.0, 200.0])
def test_a_level_span_that_runs_has_the_modes_of_a_shallow_cable_that_stretches_evenly(flow, irvine):
    """As Triantafyllou (1985) and Perkins and Mote (1987) take it: two waves, and an even strain.

    In lengths of the span and speeds of waves; the strain is proportional to the mean of w.
    """
    strain = 1e-9
    slope = np.sqrt(irvine * strain)

    def direction(x):
        size = np.hypot(1.0, slope * (0.5 - x))
        return 1.0 / size, slope * (0.5 - x) / size

    tags = ((0, ALONG), (0, ACROSS))
    given = {"direction": direction, "pull": 1.0 / strain - flow**2, "speed": flow}
    rope = Rope(((), ()), ((), ()), 1.0, even(1.0 - flow**2), 1.0, tags, inf, **given)

    def residual(omega):
        k = np.array([omega / (1.0 - flow), -omega / (1.0 + flow)])
        shares = np.linalg.solve([[1.0, 1.0], np.exp(1j * k)], [1.0, 1.0])
        return omega**2 / irvine - 1.0 + float((shares @ ((np.exp(1j * k) - 1.0) / (1j * k))).real)

    own = held(rope, 4.9 * np.pi * (1.0 - flow**2))
    assert own.size > 2
    for omega in own:
        brentq(residual, omega * (1.0 - 1e-5), omega * (1.0 + 1e-5))


def even(force):
    """A force that is the same everywhere."""
    return lambda x: np.full(np.shape(x), force)


def test_shares_of_the_strain_energy_of_a_belt_that_runs_are_shares():
    """Where a mode along meets waves across near the speed of waves, whose momentum is no strain."""
    for seed in (1, 5, 12):
        for mode in cd.modes(random_belt(np.random.default_rng([5, seed])), count=8).modes:
            shares = np.array([*mode.strain_by_span.values()])
            assert shares.min() >= 0.0
            assert shares.sum() == pytest.approx(1.0, abs=1e-9)  # nothing else of the machine is strained


def test_the_shape_of_a_straight_rope_that_runs_is_the_sum_of_its_two_waves():
    """Also where the lag turns a part of it by more than half a turn from end to end."""
    drive = route("serpentine", "route.belt.speed=45")
    network, worst, furthest = network_of(drive), 0.0, 0.0
    for mode in [own for own in cd.modes(drive, below=400.0).transverse if own.plane == "w"]:
        piece = next(own for own in network.pieces if own.where.name == mode.span)
        rest, rope = piece.rest, piece.rope
        waves = np.sqrt(rest.tensions[0] / (1.0 + rest.tensions[0] / rope.axial_rigidity) / rope.density)
        speeds, share = np.array([waves, -waves]) - piece.speed, np.linspace(0.0, 1.0, 101)
        phase = 2.0 * np.pi * mode.frequency * rest.length / speeds
        both, shape = np.exp(1j * np.outer(share, phase)), mode.shape(mode.span, share * piece.end)[0]
        left = shape - both @ np.linalg.lstsq(both, shape)[0]
        worst = max(worst, float(np.abs(left).max() / np.abs(shape).max()))
        furthest = max(furthest, 0.5 * float(np.abs(phase.sum())))
    assert furthest > 2.0 * np.pi
    assert worst < 1e-9


def test_a_stiff_belt_that_runs_has_the_same_modes_by_any_unit_of_length():
    drive = route("serpentine", "route.belt.speed=30", "cable.bending_stiffness=0.002")
    metres, longer = drive, in_other_units(drive, (1.0, 1e-6, 1.0))
    own, expected = ([mode.frequency for mode in cd.modes(one, count=3).modes] for one in (longer, metres))
    np.testing.assert_allclose(own, expected, rtol=1e-12)
