"""What mechanics demands of every list of modes: limits, scaling, interlacing, and lists that agree."""

from dataclasses import replace

import numpy as np
import pytest
from machines import machine, uneven_machine
from scipy.optimize import bisect

import cabledrive as cd
from cabledrive.mechanics import rest_state
from cabledrive.modal.mode_rows import mode_rows
from cabledrive.modal.route_network import network_at_rest
from cabledrive.modal.spectrum import Spectrum

SEEDS = range(12)


def drawn(seed, contrast=1e3):
    return machine(np.random.default_rng(seed), contrast)


def difference(found, expected):
    """Largest relative difference of frequencies."""
    return np.max(np.abs(np.asarray(found) / expected - 1.0))


@pytest.mark.parametrize("seed", SEEDS)
def test_longitudinal_frequencies_do_not_depend_on_pretension(seed, measured):
    """At one unstretched span c_u/Le = sqrt(EA/rho0)/L; the pretension drops out."""
    drive = drawn(seed)
    slack, taut = (
        cd.natural_frequencies(replace(drive, cable=replace(drive.cable, pretension=t)), count=10, taut=True)
        for t in (1e-3, 1e3)
    )
    measured(f"relative difference {difference(slack, taut):.1g} at a million times the pretension")
    np.testing.assert_allclose(slack, taut, rtol=1e-14)


@pytest.mark.parametrize("seed", SEEDS)
def test_scaling_stiffness_masses_and_lengths_scales_the_frequencies(seed, measured):
    """EA and k_m by s: sqrt(s). All masses by s: 1/sqrt(s). All lengths by s, masses per length kept: 1/s."""
    drive = drawn(seed)
    base = cd.natural_frequencies(drive, count=10, taut=True)
    stiffer = replace(
        drive,
        cable=replace(drive.cable, youngs_modulus=4.0 * drive.cable.youngs_modulus),
        motor=scaled_motor(drive.motor, stiffness=4.0),
    )
    scaled = {2.0: stiffer, 0.5: scaled_drive(drive, 4.0), 0.25: scaled_drive(drive, 4.0, 4.0)}
    found = {factor: cd.natural_frequencies(one, count=10, taut=True) for factor, one in scaled.items()}
    worst = max(difference(frequencies, factor * base) for factor, frequencies in found.items())
    measured(f"relative difference {worst:.2g}")
    for factor, frequencies in found.items():
        np.testing.assert_allclose(frequencies, factor * base, rtol=1e-13)


def scaled_motor(motor, stiffness=1.0, inertia=1.0):
    if motor is None:
        return None
    joint = motor.joint_stiffness
    joint = None if joint is None else stiffness * joint
    return replace(motor, inertia=inertia * motor.inertia, joint_stiffness=joint)


def scaled_drive(drive, mass, length=1.0):
    """Every mass and length by a factor, mass per length by their ratio; the joint as the spans: EA/L."""
    return replace(
        drive,
        cable=replace(drive.cable, mass_per_length=mass / length * drive.cable.mass_per_length),
        layout=cd.Layout(span_length=length * drive.layout.span_length),
        pulley=tuple(replace(p, inertia=mass * p.inertia) for p in drive.pulley),
        carriage=tuple(replace(c, mass=mass * c.mass, position=length * c.position) for c in drive.carriage),
        motor=scaled_motor(drive.motor, stiffness=1 / length, inertia=mass),
    )


def check_interlacing(low, high, measured):
    """f_k(low) <= f_k(high) <= f_(k+1)(low), to round-off."""
    crossed = max(np.max(low[: high.size] / high - 1), np.max(high / low[1 : high.size + 1] - 1), 0.0)
    measured(f"order broken by {crossed:.1g}, relative, in {high.size} modes")
    assert crossed < 1e-12


@pytest.mark.parametrize("seed", SEEDS)
def test_added_mass_lowers_every_frequency_and_the_old_ones_interlace(seed, measured):
    """Rayleigh: one more mass at one place, f_k(with) <= f_k(without) <= f_(k+1)(with)."""
    rng = np.random.default_rng(seed)
    drive = uneven_machine(rng, 1e3)
    mass = drive.cable.mass_per_length * drive.span_length * 10 ** rng.uniform(-3, 3)
    place = rng.uniform(0.05, 0.95) * drive.span_length
    loaded = replace(drive, carriage=(*drive.carriage, cd.Carriage(mass=mass, position=place)))
    without = cd.natural_frequencies(drive, count=12, taut=True)
    with_mass = cd.natural_frequencies(loaded, count=13, taut=True)
    check_interlacing(with_mass, without, measured)
    assert np.any(with_mass[:12] < without[:12] * (1 - 1e-9))


@pytest.mark.parametrize("seed", SEEDS)
def test_holding_a_pulley_raises_every_frequency_and_interlaces(seed, measured):
    """A constraint: f_k(free) <= f_k(held) <= f_(k+1)(free), the rigid-body mode among the free ones."""
    rng = np.random.default_rng(seed)
    drive = uneven_machine(rng, 1e3)
    free = replace(drive, pulley=tuple(replace(p, fixed=False) for p in drive.pulley))
    held = replace(free, pulley=(free.pulley[0], replace(free.pulley[1], fixed=True)))
    free = np.append(0.0, cd.natural_frequencies(free, count=12, taut=True))
    check_interlacing(free, cd.natural_frequencies(held, count=11, taut=True), measured)


def test_midpoint_carriage_leaves_the_fundamental_alone_up_to_its_crossing(measured):
    """Up to chi_m = m/(2 Le rho) = 16.59 the mass sits at a node; then the in-phase mode is the lower one."""
    drive = cd.load_drive("dissertation-1").listed
    empty = cd.natural_frequencies(drive, count=1, taut=True)[0]
    low = bisect(lambda ratio: loaded_fundamental(drive, ratio) / empty - 1 + 1e-12, 16.0, 17.0, xtol=1e-6)
    heavy = loaded_fundamental(drive, 50.0)
    measured(f"crossing at {low:.4f}; {heavy:.2f} Hz at 50, {empty:.2f} Hz empty")
    assert low == pytest.approx(16.59, abs=0.005)
    assert loaded_fundamental(drive, 16.58) == pytest.approx(empty, rel=1e-13)
    assert loaded_fundamental(drive, 16.60) < empty * (1 - 1e-5)
    assert heavy == pytest.approx(94.5, abs=0.05)


def loaded_fundamental(drive, ratio):
    mass = ratio * 2 * drive.span_length * drive.cable.mass_per_length
    carriage = cd.Carriage(mass=mass, position=0.5 * drive.span_length)
    return cd.natural_frequencies(replace(drive, carriage=(carriage,)), count=1, taut=True)[0]


@pytest.mark.parametrize("seed", SEEDS)
def test_drive_seen_from_its_other_end_has_the_same_modes(seed, measured):
    """Pulleys changed about, every carriage where it was as seen from there: a rotated plan."""
    drive = replace(drawn(seed), motor=None)
    length = drive.span_length
    other = {"upper": "lower", "lower": "upper"}
    if drive.kind == "loop":
        carriages = tuple(replace(c, span=other[c.span]) for c in drive.carriage)
    else:
        carriages = tuple(replace(c, position=length - c.position) for c in drive.carriage)
    turned = replace(drive, pulley=drive.pulley[::-1], carriage=carriages)
    there, here = (cd.natural_frequencies(one, count=10, taut=True) for one in (turned, drive))
    measured(f"relative difference {difference(there, here):.2g}")
    np.testing.assert_allclose(there, here, rtol=1e-11)


def test_below_a_mode_leaves_it_out_and_above_takes_it_in():
    drive = cd.load_drive("dissertation-1").listed
    fundamental = cd.natural_frequencies(drive, count=1, taut=True)[0]
    assert cd.natural_frequencies(drive, below=fundamental * (1 - 1e-9), taut=True).size == 0
    assert cd.natural_frequencies(drive, below=fundamental * (1 + 1e-9), taut=True).size == 1
    at = cd.modes(drive, below=float(fundamental))
    assert at.certified
    assert at.certificate.below <= fundamental


def test_a_count_of_thousands_of_heavy_strings_is_that_of_their_travel_times():
    """n pi / t of each span and plane, less than one mode each apart."""
    drive = cd.load_drive("elevator").listed
    spectrum = Spectrum(network_at_rest(drive.machine)[0])
    turns = [
        np.sqrt(drive.cable.mass_per_length) * sum(own.travel_time for own in section.stretches) / np.pi
        for section in rest_state(drive).sections
    ]
    omega = 4000.0 / sum(turns)
    across = sum(part.count(omega) for part in spectrum._windows[0].parts if part.kinds == {"transverse"})
    assert abs(across - 2 * sum(int(omega * turn) for turn in turns)) <= 2 * len(turns)


def test_equal_modes_of_both_spans_are_one_row_and_other_modes_are_not():
    found = cd.modes(cd.load_drive("dissertation-2", overrides=["layout.gravity=0"]).listed, count=12).modes
    across = [mode for mode in found if mode.kind == "transverse"]
    rows = mode_rows(across)
    assert max(row.count for row in rows) == 4  # two spans, two planes
    assert len(rows) < len(across)
    for row in rows:
        first = row.modes[0].frequency
        assert all(mode.frequency == pytest.approx(first, rel=1e-6) for mode in row.modes)


def test_ropes_that_sag_move_with_the_rims_that_they_pass():
    """At 58.6 Hz one of two lines is straight above its edge; beside a sheave it moves as the rim does."""
    drive = cd.load_drive("camera-winches")
    mode = cd.modes(drive, below=60.0).longitudinal[3]
    assert 2.0 * np.pi * mode.frequency < mode.network.edges[0]
    for before, after in (drive.free_spans[:2], drive.free_spans[2:]):
        rim = before.end.radius * abs(mode.joints[before.end.name][0])
        beside = (mode.shape(before.name, [before.length])[0, 0], mode.shape(after.name, [0.0])[0, 0])
        np.testing.assert_allclose(np.abs(beside), rim, rtol=1e-5)  # but for the cosine of its slope
        along = mode.shape(after.name, np.linspace(0.0, after.length, 400))[0]
        assert np.abs(along).max() < 1.01 * rim
