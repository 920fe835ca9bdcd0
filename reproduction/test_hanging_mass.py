"""A mass that hangs on the cable: its lateral mode, its rest, and how a longitudinal mode drives it."""

from dataclasses import replace
from math import pi, radians, sin

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from cabledrive.mechanics.cable_laws import ExactLaw
from cabledrive.mechanics.mesh import mesh_of
from cabledrive.mechanics.statics import equilibrium
from cabledrive.modal import longitudinal_modes, modes
from cabledrive.modal.lateral import lateral_mode
from cabledrive.parameters import Carriage, InputRefused, NotComputed, load_drive
from reproduction.hanging_equilibrium import elastic_equilibrium, linear_equilibrium
from reproduction.hanging_mass import driven_mass, largest_displacement

LOOP = load_drive("dissertation-1")


def hung(mass, position=0.25, drive=LOOP, *, span="upper", **cable):
    drive = replace(drive, cable=replace(drive.cable, **cable)) if cable else drive
    return replace(drive, carriage=[Carriage(mass=mass, position=position, span=span, guided=False)])


@pytest.mark.parametrize("position", [0.5, 0.25, 0.03])
def test_error_of_3_35_vanishes_with_the_mass_of_the_cable(position):
    """A sixth of the mass ratio to first order; (M.8) leaves an error of second order. Nothing weighs."""
    drive = replace(LOOP, layout=replace(LOOP.layout, gravity=0.0))
    errors = [lateral_mode(hung(mass, position, drive)) for mass in (0.01, 0.1, 1.0)]
    ratio = np.array([mode.mass_ratio for mode in errors])
    first = np.array([mode.error for mode in errors])
    second = np.array([mode.corrected_error for mode in errors])
    assert np.all(np.abs(first / ratio - 1 / 6) < 0.5 * ratio), f"error / mass ratio {first / ratio}"
    slope = np.polyfit(np.log(ratio), np.log(second), 1)[0]
    assert slope == pytest.approx(2.0, abs=0.05), f"order {slope:.3f}, errors {second}"


def test_light_mass_hangs_in_the_mode_of_the_string_and_3_35_is_of_no_use():
    light = lateral_mode(hung(1e-9))
    assert light.exact == pytest.approx(50.394, abs=1e-3)
    assert light.error > 100.0


def test_lateral_mode_is_a_certified_transverse_mode():
    drive = hung(0.01)
    found = modes(drive, count=6)
    assert found.certified
    listed = np.array([mode.frequency for mode in found.transverse])
    assert np.min(np.abs(listed / lateral_mode(drive).exact - 1.0)) < 1e-14


def test_guided_neighbour_holds_the_cable_across():
    """A hanging mass between the pulley and a guided carriage swings on the shorter stretch."""
    rail = Carriage(mass=0.3, position=0.6, guided=True)
    drive = hung(0.1, 0.3)
    between = lateral_mode(replace(drive, carriage=(*drive.carriage, rail)))
    stretch = 1 + drive.cable.prestrain
    expected = np.sqrt(drive.cable.pretension / 0.1 * 2 / (0.3 * stretch)) / (2 * pi)
    assert between.approximate == pytest.approx(expected, rel=1e-12)
    assert between.corrected_error < 1e-6


@pytest.mark.parametrize("ask", [lateral_mode, linear_equilibrium, elastic_equilibrium])
def test_guided_carriage_has_no_transverse_motion(ask):
    drive = load_drive("dissertation-transporter")
    with pytest.raises(InputRefused, match=r"carriage\.0\.guided = true: .* no transverse motion"):
        ask(drive)
    with pytest.raises(InputRefused, match="numbered from 0"):
        ask(drive, 1)


def test_two_hanging_carriages_on_one_stretch_are_no_single_mass():
    drive = hung(0.1)
    drive = replace(drive, carriage=(*drive.carriage, replace(drive.carriage[0], position=0.7)))
    with pytest.raises(InputRefused, match="another hanging"):
        lateral_mode(drive)


def test_linear_equilibrium_balances_the_weight():
    """(3.29a) with the sines of (3.30)."""
    drive = hung(0.02)
    rest = linear_equilibrium(drive)
    lift = drive.cable.pretension * (rest.sine_before + rest.sine_after)
    assert lift == pytest.approx(0.02 * 9.81, rel=1e-14)
    assert rest.sag == pytest.approx(rest.sine_before * 0.25 * (1 + drive.cable.prestrain), rel=1e-14)


@pytest.mark.parametrize("hold", ["drive", "both"])
def test_elastic_equilibrium_tends_to_the_linear_one_with_the_square_of_the_sag(hold):
    masses = np.array([1e-4, 1e-3, 1e-2])
    gap = [1 - elastic_equilibrium(hung(m), hold=hold).sag / linear_equilibrium(hung(m)).sag for m in masses]
    slope = np.polyfit(np.log(masses), np.log(gap), 1)[0]
    assert slope == pytest.approx(2.0, abs=0.02), f"order {slope:.3f}, differences {gap}"


@pytest.mark.parametrize("span", ["upper", "lower"])
@pytest.mark.parametrize("hold", ["drive", "both"])
@pytest.mark.parametrize(("mass", "inclination"), [(0.02, 0.0), (1.0, 0.0), (0.1, 20.0), (0.1, -35.0)])
def test_elastic_equilibrium_is_that_of_the_divided_cable_without_weight(span, hold, mass, inclination):
    """The mesh of the simulation, statics by its own Newton method; a cable of 1e-9 of its weight."""
    layout = replace(LOOP.layout, inclination=radians(inclination))
    drive = hung(mass, 0.25, replace(LOOP, layout=layout), span=span, mass_per_length=4.9e-13)
    found = elastic_equilibrium(drive, hold=hold)
    mesh = mesh_of(drive, 8)
    law = ExactLaw(pretension=drive.cable.pretension, axial_rigidity=drive.cable.axial_rigidity)
    there = equilibrium(mesh, law, hold=hold)
    node = mesh.carriage_node[0]
    assert found.sag == pytest.approx(abs(there.displacement[2, node]), rel=1e-6)
    assert found.shift == pytest.approx(there.displacement[0, node], rel=1e-5, abs=1e-9)


@given(mass=st.floats(1e-6, 100.0), position=st.floats(0.01, 0.99), hold=st.sampled_from(["drive", "both"]))
def test_elastic_equilibrium_balances_all_forces(mass, position, hold):
    """Vertical: the two tensions carry the weight; horizontal: nothing is left on the level."""
    rest = elastic_equilibrium(hung(mass, position), hold=hold)
    weight = mass * 9.81
    lift = rest.tension_before * rest.sine_before + rest.tension_after * rest.sine_after
    assert lift == pytest.approx(weight, abs=1e-10 * max(weight, 5.0))
    pull = rest.tension_after * np.sqrt(1 - rest.sine_after**2)
    assert pull == pytest.approx(
        rest.tension_before * np.sqrt(1 - rest.sine_before**2), abs=1e-10 * max(weight, 5.0)
    )


def test_load_pulley_that_turns_lets_the_other_span_give_way():
    held, free = (elastic_equilibrium(hung(0.1), hold=hold) for hold in ("both", "drive"))
    assert free.sag > held.sag
    assert free.tension_after < held.tension_after


def test_cable_below_a_mass_on_a_vertical_span_goes_slack():
    steep = replace(LOOP.layout, inclination=radians(90.0))
    with pytest.raises(NotComputed, match="slack"):
        elastic_equilibrium(hung(1.0, 0.25, replace(LOOP, layout=steep)), hold="both")


def test_deep_sag_has_no_linear_equilibrium():
    with pytest.raises(NotComputed, match="use elastic_equilibrium"):
        linear_equilibrium(hung(1.0))


def test_slopes_at_a_carriage_jump_by_its_inertia():
    """EA (u'(+) - u'(-)) = -m omega^2 u: the boundary condition (3.16a)."""
    drive = hung(0.01, 0.3)
    for mode in longitudinal_modes(drive, count=8):
        before, after = (slope[0] for slope in mode.slopes_at("carriage 0"))
        displacement = mode.joints["carriage 0"][0]
        jump = drive.cable.axial_rigidity * (after - before)
        size = drive.cable.axial_rigidity * (abs(after) + abs(before))
        assert jump == pytest.approx(-0.01 * (2 * pi * mode.frequency) ** 2 * displacement, abs=1e-9 * size)


def test_slopes_agree_with_differences_of_the_shape():
    drive = hung(0.01, 0.3)
    for mode in longitudinal_modes(drive, count=5):
        u = mode.shape("upper", [0.3 - 2e-6, 0.3 - 1e-6, 0.3 + 1e-6, 0.3 + 2e-6])[0]
        before, after = (slope[0] for slope in mode.slopes_at("carriage 0"))
        scale = np.abs(u).max() * 2 * pi * mode.frequency / 1503.0
        assert (u[1] - u[0]) / 1e-6 == pytest.approx(before, abs=1e-4 * scale + 1e-3 * abs(before))
        assert (u[3] - u[2]) / 1e-6 == pytest.approx(after, abs=1e-4 * scale + 1e-3 * abs(after))


def steady_amplitude(drive, mode, stroke):
    """In-phase amplitude of y per stroke, from the nonlinear equation of the mass in time.

    The mass follows the mode along the cable, and so do the forces on its two sides; across, it is free, at
    the exact angles of its place. A slight damping brings it to the steady state.
    """
    position, mass = drive.carriage[0].position, drive.carriage[0].mass
    stretch = 1 + drive.cable.prestrain
    l1, l2 = position * stretch, (drive.span_length - position) * stretch
    rest, omega = linear_equilibrium(drive), 2 * pi * mode.frequency
    scale = stroke / largest_displacement(drive, mode)
    pulls = [drive.cable.axial_rigidity * slope[0] * scale for slope in mode.slopes_at("carriage 0")]
    weight = drive.cable.pretension * (np.sin(np.arctan(rest.sag / l1)) + np.sin(np.arctan(rest.sag / l2)))

    def rates(t, z):
        y, speed = z
        angles = np.arctan((rest.sag - y) / l1), np.arctan((rest.sag - y) / l2)
        tensions = (drive.cable.pretension + pull * sin(omega * t) for pull in pulls)
        lift = sum(t0 * np.sin(a) for t0, a in zip(tensions, angles, strict=True))
        return [speed, (lift - weight) / mass - 0.02 * omega * speed]

    period = 2 * pi / omega
    run = solve_ivp(
        rates, (0, 120 * period), [0, 0], method="DOP853", rtol=1e-10, atol=1e-14, dense_output=True
    )
    t = np.linspace(100, 120, 20_001)[:-1] * period
    return 2 * np.mean(run.sol(t)[0] * np.sin(omega * t)) / stroke


@pytest.mark.parametrize(("mass", "number"), [(0.002, 0), (0.002, 1), (0.01, 0)])
def test_driven_motion_is_that_of_the_nonlinear_equation_at_small_strokes(mass, number):
    """(3.32): y per stroke of the mode, checked against integration in time with exact angles."""
    drive = hung(mass, 0.3)
    mode = longitudinal_modes(drive, count=3)[number]
    found = driven_mass(drive, mode)
    simulated = steady_amplitude(drive, mode, stroke=1e-7)
    damped = found.amplitude_ratio
    assert simulated == pytest.approx(damped, rel=5e-3), f"simulated {simulated:.6g}, (3.32) {damped:.6g}"


def test_vertical_motion_grows_without_bound_where_the_frequencies_meet():
    """Near the meeting pretension the amplitude is as one over the distance to it, and changes sign there."""
    base = hung(0.0005, 0.4)
    mode = longitudinal_modes(base, count=1)[0]
    meeting = driven_mass(base, mode).coincidence_pretension
    assert meeting is not None

    def ratio(share):
        drive = hung(0.0005, 0.4, pretension=meeting * (1 + share))
        return driven_mass(drive, longitudinal_modes(drive, count=1)[0])

    above, nearer, below = (ratio(share) for share in (1e-4, 1e-5, -1e-5))
    assert nearer.vertical_frequency == pytest.approx(nearer.mode_frequency, rel=1e-5)
    assert abs(nearer.amplitude_ratio / above.amplitude_ratio) == pytest.approx(10.0, rel=0.01)
    assert below.amplitude_ratio * nearer.amplitude_ratio < 0


def test_coincidence_needs_more_than_any_pretension_when_the_mass_is_heavy():
    """T0/(1 + T0/EA) stays below EA: a heavy mass never swings as fast as the longitudinal mode."""
    drive = hung(1.0, 0.4)
    mode = longitudinal_modes(drive, count=1)[0]
    rest = elastic_equilibrium(drive)
    assert driven_mass(drive, mode, equilibrium=rest).coincidence_pretension is None


def test_mass_without_sag_is_not_driven():
    """On the vertical, or without gravity, the forcing of (3.32) is zero."""
    drive = hung(0.01)
    drive = replace(drive, layout=replace(drive.layout, gravity=0.0))
    found = driven_mass(drive, longitudinal_modes(drive, count=1)[0])
    assert (found.forcing, found.amplitude_ratio, found.sag_stiffening) == (0.0, 0.0, 0.0)


def test_transverse_mode_does_not_drive_the_mass():
    drive = hung(0.01)
    with pytest.raises(InputRefused, match="longitudinal"):
        driven_mass(drive, modes(drive, count=1).transverse[0])
