"""Frequencies that are known: the dissertation's, bars, beaded strings; pretension that tunes 1:2."""

from dataclasses import replace

import numpy as np
import pytest
from reproduction.chapter_3 import rigid_supports
from scipy.optimize import brentq

import cabledrive as cd
from cabledrive.mechanics.network import network_of
from cabledrive.mechanics.spans import lumped_cable_mode, transverse_chains
from cabledrive.modal import tuning
from cabledrive.modal.lowest import lowest_frequencies
from cabledrive.modal.natural import straight_limit
from network_samples import as_routes


@pytest.mark.parametrize(
    "name, frequencies",
    [
        ("dissertation-1", [116.32932059, 751.73269240, 769.66140323]),
        ("dissertation-2", [81.74207679, 751.73269240, 760.86097349]),
    ],
)
def test_dissertation_configurations_ring_where_they_must(name, frequencies, measured):
    """The second mode, pulleys at rest, is missing in Table 3.2; it is the kind drawn in Fig. 3.5(b)."""
    drive = cd.load_drive(name).listed
    found = cd.natural_frequencies(drive, count=3, taut=True)
    measured(", ".join(f"{frequency:.8f}" for frequency in found) + " Hz")
    np.testing.assert_allclose(found, frequencies, rtol=0, atol=5e-9)
    modes = cd.modes(drive, below=800.0)
    families = [mode.family for mode in modes.longitudinal]
    assert families == ["pulleys out of phase", "pulleys at rest", "pulleys in phase"]
    assert modes.certified
    assert modes.certificate.longitudinal == 3
    assert modes.rigid_body_modes == 1


def relative_error(found, expected):
    """Largest one, in words."""
    return f"relative error {np.max(np.abs(np.asarray(found) / expected - 1.0)):.1e}"


def bar(mass_ratio, fixed=(True, False)):
    """A line held at its first end with m/M = `mass_ratio`, mass of the bar over mass at its end."""
    cable = cd.Cable(youngs_modulus=2e11, area=1e-4, mass_per_length=0.8, pretension=10.0)
    end = cable.mass_per_length * 2.0 / mass_ratio
    pulleys = [cd.Pulley(radius=1.0, inertia=end, fixed=held) for held in fixed]
    return cd.Drive(name="bar", kind="line", cable=cable, layout=cd.Layout(span_length=2.0), pulley=pulleys)


@pytest.mark.parametrize(
    "mass_ratio, roots",
    [
        (0.1, [0.311053, 3.173097]),
        (1.0, [0.860334, 3.425618, 6.437298]),
        (10.0, [1.428870, 4.305801]),
    ],
)
def test_bar_with_end_mass_has_the_roots_of_beta_tan_beta(mass_ratio, roots, measured):
    """Textbook: beta tan(beta) = m/M with beta = omega L/c, one root in each half turn."""
    drive = bar(mass_ratio)
    speed = np.sqrt(drive.cable.axial_rigidity / drive.cable.mass_per_length)
    beta = 2 * np.pi * cd.natural_frequencies(drive, count=8, taut=True) * drive.span_length / speed
    exact = [
        brentq(lambda b: b * np.sin(b) - mass_ratio * np.cos(b), k * np.pi, (k + 0.5) * np.pi, xtol=1e-15)
        for k in range(8)
    ]
    measured(relative_error(beta, exact))
    np.testing.assert_allclose(beta[: len(roots)], roots, atol=5e-7, rtol=0)
    np.testing.assert_allclose(beta, exact, rtol=1e-13)


def test_free_bar_between_equal_masses_splits_into_two_held_bars(measured):
    """Symmetric modes of a free bar have an antinode half way, antisymmetric ones a node: halves of it."""
    drive = bar(0.5, fixed=(False, False))
    speed = np.sqrt(drive.cable.axial_rigidity / drive.cable.mass_per_length)
    half = 0.5 * 2 * np.pi * cd.natural_frequencies(drive, count=6, taut=True) * drive.span_length / speed
    node, antinode = half[0::2], half[1::2]  # end mass over half bar: twice the ratio
    measured(
        f"{relative_error(node * np.tan(node), 0.25)}; {relative_error(antinode / np.tan(antinode), -0.25)}"
    )
    np.testing.assert_allclose(node * np.tan(node), 0.25, rtol=1e-11)
    np.testing.assert_allclose(antinode / np.tan(antinode), -0.25, rtol=1e-11)


@pytest.mark.parametrize("beads", [1, 2, 7])
def test_beaded_string_rings_like_lagranges(beads, measured):
    """w_k = 2 sqrt(T/(m a)) sin(k pi/(2(N + 1))), N beads at equal gaps a on a string of no mass."""
    length, mass, tension = 3.0, 0.7, 20.0
    gap = length / (beads + 1)
    cable = cd.Cable(youngs_modulus=1e12, area=1e-3, mass_per_length=1e-14, pretension=tension)
    carriages = [cd.Carriage(mass=mass, position=gap * (k + 1), guided=False) for k in range(beads)]
    drive = cd.Drive(
        name="beads",
        kind="line",
        cable=cable,
        layout=cd.Layout(span_length=length, gravity=0.0),
        pulley=[cd.Pulley(radius=1.0, inertia=1.0)] * 2,
        carriage=carriages,
    )
    planes = [m.frequency for m in cd.modes(drive, count=beads).transverse if m.plane == "w"]
    k = np.arange(1, beads + 1)
    lagrange = 2 * np.sqrt(tension / (mass * gap)) * np.sin(k * np.pi / (2 * (beads + 1)))
    stretch = np.sqrt(1.0 + cable.prestrain)  # the gap is unstretched; the string pulls on the stretched one
    measured(relative_error(2 * np.pi * np.array(planes) * stretch, lagrange))
    np.testing.assert_allclose(2 * np.pi * np.array(planes) * stretch, lagrange, rtol=1e-12)


def test_rigid_supports_leave_the_multiples_of_a_half_wave(measured):
    """Eq. (3.14): both pulleys held, c_u/(2 Le) and its multiples, on either span."""
    drive = cd.load_drive("dissertation-1").listed
    held = replace(drive, pulley=tuple(replace(pulley, fixed=True) for pulley in drive.pulley))
    half_wave = drive.cable.axial_wave_speed / (2 * drive.pulley_distance)
    expected = np.repeat(half_wave * np.arange(1, 6), 2)
    measured(relative_error(cd.natural_frequencies(held, count=10, taut=True), expected))
    np.testing.assert_allclose(cd.natural_frequencies(held, count=10, taut=True), expected, rtol=1e-14)
    modes = cd.modes(held, count=10)
    assert modes.rigid_body_modes == 0
    assert modes.certified


@pytest.mark.parametrize("name", ["camera-line", "ropeway", "linear-axis", "lift-2-to-1", "corexy"])
def test_the_lowest_frequencies_are_the_first_of_the_list_however_a_machine_is_written(name):
    """Of the ropes that hang: the taut cable of `camera-line` is off by 4e-3."""
    drive = cd.load_drive(name)
    found = lowest_frequencies(drive)
    for motor in ("free", "held"):
        listed = cd.modes(drive, count=1, motor=motor).longitudinal[0].frequency
        assert getattr(found, motor) == pytest.approx(listed, rel=1e-9), motor


def test_no_mode_below_a_bound_leaves_no_doubt_of_straight_ropes():
    """The lowest mode of `camera-line`, whose span sags, lies above 0.1 Hz."""
    network = network_of(as_routes(cd.load_drive("camera-line").listed))
    assert straight_limit(network, 2 * np.pi * 0.1) is None
    assert "sag" in straight_limit(network, 2 * np.pi * 6.0)


def test_modes_warn_of_strained_ropes_and_of_ends_that_nothing_holds_on_every_machine():
    strained = cd.load_drive("corexy", overrides=["cable.strain_limit=1e-3"])
    assert any("beyond 0.001, its elastic range" in line for line in cd.modes(strained, count=1).warnings)
    for fixed in (False, True):
        line = cd.load_drive("camera-line", overrides=[f"pulley.1.fixed={str(fixed).lower()}"]).listed
        warned = any("nothing in the file holds it" in words for words in cd.modes(line, count=1).warnings)
        assert warned is not fixed


# --- Rigid supports and springs without mass: where the simple formulas hold, and how they fail
LOOP = cd.load_drive("dissertation-1").listed


def test_rigid_supports_miss_the_pulley_mode_of_both_configurations_by_a_factor():
    """Section 3.2.1: 751.73 Hz against 116.33 and 81.74 Hz; transverse modes do not see the pulleys."""
    for number, factor in ((1, 751.7327 / 116.3293), (2, 751.7327 / 81.7421)):
        drive = cd.load_drive(f"dissertation-{number}", overrides=["layout.gravity=0"]).listed
        (along, across), found = rigid_supports(drive), cd.modes(drive, count=1)
        assert along / found.longitudinal[0].frequency == pytest.approx(factor, rel=1e-5)
        assert across == pytest.approx(found.transverse[0].frequency, rel=1e-12)


@pytest.mark.parametrize(("kind", "springs"), [("loop", 2), ("line", 1)])
@pytest.mark.parametrize("rims", [(1.0, 1.0), (0.2, 3.0), (1e-2, 1e2)])
def test_lumped_springs_are_right_to_first_order_in_the_mass_of_the_cable(kind, springs, rims):
    """The excess tends to Eq. (M.7) as the cable gets lighter, and what is left is of second order."""
    first, second = rims
    reduced = first * second / (first + second)
    pulleys = tuple(replace(p, inertia=m * p.radius**2) for p, m in zip(LOOP.pulley, rims, strict=True))
    shares, excess = np.array([1e-2, 1e-3]), []
    for share in shares:
        mass_per_length = share * reduced / (springs * LOOP.span_length)
        cable = replace(LOOP.cable, mass_per_length=mass_per_length)
        drive = replace(LOOP, kind=kind, cable=cable, pulley=pulleys)
        springs_alone = lumped_cable_mode(replace(drive, lumped=None))
        excess.append(springs_alone / tuning.pulley_mode(drive).omega - 1.0)
    predicted = shares / 6 * (1 - 3 * reduced / (first + second))
    left = np.abs(np.array(excess) - predicted)
    assert np.all(left < 0.1 * shares**2), f"excess {excess}, predicted {predicted}"


# --- Pretension that tunes a pair of modes to 1:2, exactly
CONFIGURATION_2 = cd.load_drive("dissertation-2").listed


def test_tuned_pretension_of_configuration_2(measured):
    """3.28377 N; the modes 2 and 3 at 0.819 N and 0.364 N."""
    found = tuning.tuned_pretension(CONFIGURATION_2)
    measured(f"{found:.6f} N")
    assert found == pytest.approx(3.28377, abs=5e-6)
    weightless = replace(CONFIGURATION_2, layout=replace(CONFIGURATION_2.layout, gravity=0.0))
    tuned = [pair.tuned_pretension for pair in tuning.resonant_pairs(weightless)[:3]]
    np.testing.assert_allclose(tuned, [3.28377, 0.8191, 0.3639], atol=6e-5)


@pytest.mark.parametrize("name", [*cd.packaged_drives("loop", "line")])
def test_every_pair_is_tuned_by_its_pretension(name):
    """Set to its tuned pretension, every pair has the ratio one half; carriages and joints included."""
    drive = cd.load_drive(name).listed
    for place, pair in enumerate(tuning.resonant_pairs(drive, 2)):
        if pair.tuned_pretension is None:
            assert any(word in pair.reason for word in ("EA", "weights", "slack", "does not settle"))
            continue
        tuned = replace(drive, cable=replace(drive.cable, pretension=pair.tuned_pretension))
        ratio = tuning.resonant_pairs(tuned, 2)[place].ratio
        assert ratio == pytest.approx(0.5, rel=1e-10), f"{pair}"


def test_tuned_pretension_of_a_drive_given_by_its_pulley_distance():
    """There the unstretched length follows the tension; the formula is repeated until it stands."""
    layout = cd.Layout(pulley_distance=1.0)
    drive = replace(CONFIGURATION_2, layout=layout)
    tuned = replace(drive, cable=replace(drive.cable, pretension=tuning.tuned_pretension(drive)))
    ratio = tuning.span_frequency(tuned) / cd.natural_frequencies(tuned, count=1, taut=True)[0]
    assert ratio == pytest.approx(0.5, rel=1e-12)


def test_no_pretension_tunes_a_pair_that_would_need_the_tension_EA():
    """A heavy mass hanging on the cable swings too slowly for half the pulley mode at any tension."""
    drive = cd.load_drive("camera-line", overrides=["carriage.0.mass=400"]).listed
    first = tuning.resonant_pairs(drive)[0]
    assert first.tuned_pretension is None
    assert "EA" in first.reason
    assert "\n" not in first.reason


@pytest.mark.parametrize("name", ["dissertation-2", "dissertation-3", "ropeway", "camera-line"])
def test_waves_add_up_to_the_mode(name):
    """Slope of each piece, Eq. (A.3), against differences of the shape; its largest displacement."""
    drive = cd.load_drive(name).listed
    pulley = tuning.pulley_mode(drive)
    for mode in (pulley.mode, *(tuning.section_modes(chain, 3)[2] for chain in transverse_chains(drive))):
        for wave in mode.slope_waves():
            s = wave.start + wave.length * np.array([0.3, 0.30001])
            slope = np.diff(mode.shape(wave.span, s)[0])[0] / np.diff(s)[0]
            exact = wave.slope_at(wave.start + 0.300005 * wave.length).real
            assert abs(slope - exact) < 1e-5 * abs(wave.slope)
            u = mode.shape(wave.span, wave.start + wave.length * np.linspace(0, 1, 4001)[1:-1])[0]
            assert np.max(np.abs(u)) == pytest.approx(wave.largest_displacement, rel=2e-3)
