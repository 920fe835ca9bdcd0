"""Modes that meet: exact doubles are one mode of multiplicity two, pairs split by a millionth are two."""

from dataclasses import replace

import numpy as np
import pytest
from machines import ring_of, some_cable
from transfer_roots import exact_roots

import cabledrive as cd
from cabledrive.parameters import Motor

SPLITS = [1e-3, 1e-6, 1e-8]


def even_ring(detuning=0.0, parts=4, seed=0):
    """Equal masses at equal distances on a loop; one carriage heavier by a share."""
    cable = some_cable(np.random.default_rng(seed))
    mass = 0.7 * cable.mass_per_length
    masses = [mass] * parts
    masses[1] *= 1.0 + detuning
    return ring_of([0.5] * parts, masses, cable)


def longitudinal(drive, count):
    modes = cd.modes(drive, count=count)
    assert modes.certified
    return modes.longitudinal


@pytest.mark.parametrize("parts", [4, 8, 16])
def test_even_ring_rings_where_its_dispersion_relation_says(parts, measured):
    """cos(qa) = cos(ka) - (omega m/2Z) sin(ka), q a = 2 pi n/N: Bloch waves; those that travel, twice."""
    drive = even_ring(parts=parts)
    cable = drive.cable
    time = 0.5 * np.sqrt(cable.mass_per_length / cable.axial_rigidity)
    ratio = 0.7 / 2 / 0.5  # half of the mass over that of a gap
    listed = longitudinal(drive, 3 * parts)
    phase = 2 * np.pi * np.array([mode.frequency for mode in listed]) * time
    phases = np.arccos(np.clip(np.cos(phase) - ratio * phase * np.sin(phase), -1, 1)) * parts / (2 * np.pi)
    measured(f"Bloch waves whole to {np.max(np.abs(phases - np.round(phases))):.1e}")
    for mode, bloch in zip(listed, phases, strict=True):
        assert bloch == pytest.approx(round(bloch), abs=1e-6)
        standing = round(bloch) in (0, parts // 2)
        assert mode.multiplicity == (1 if standing else 2)


@pytest.mark.parametrize("split", SPLITS)
def test_pairs_split_by_a_small_share_are_two_modes(split, measured):
    """A detuned mass parts each pair; both are listed, each as exactly as any simple mode."""
    drive = even_ring(detuning=8.0 * split)
    listed = longitudinal(drive, 9)
    roots = [float(root) / (2 * np.pi) for root in exact_roots(drive, 9)]
    error = max(abs(mode.frequency / root - 1.0) for mode, root in zip(listed, roots, strict=False))
    measured(f"{len(listed)} modes in {len(roots)}, relative error {error:.1e}")
    assert [mode.multiplicity for mode in listed] == [1] * 9
    parted = (roots[1] - roots[0]) / roots[0]
    assert 0.1 * split < parted < 10 * split, f"split by {parted:.1e}"
    np.testing.assert_allclose([mode.frequency for mode in listed], roots, rtol=1e-12)


def test_pair_closer_than_its_claim_is_one_mode_of_multiplicity_two(measured):
    """Below 1e-10, relative, round-off may look like a split."""
    listed = longitudinal(even_ring(detuning=1e-13), 3)
    measured(f"multiplicity {listed[0].multiplicity}")
    assert listed[0].multiplicity == 2


def test_modes_at_the_poles_of_the_span_stiffness_are_found(measured):
    """sin(omega L/c) = 0 for both spans at once: the stiffness of a span is infinite, the mode is not."""
    errors = []
    for seed in range(20):
        rng = np.random.default_rng(seed)
        cable = some_cable(rng)
        drive = ring_of([1.0, 1.0], (10 ** rng.uniform(-3, 3, 2)).tolist(), cable)
        half_wave = np.sqrt(cable.axial_rigidity / cable.mass_per_length) / 2
        listed = np.array([mode.frequency for mode in longitudinal(drive, 12)])
        errors.append(max(np.min(np.abs(listed / (n * half_wave) - 1)) for n in range(1, 5)))
    measured(f"relative error {max(errors):.1e}")
    assert max(errors) < 1e-14


def test_pendant_tuned_to_the_mode_of_resting_pulleys_leaves_it_where_it_was(measured):
    """Motor and joint ring at the same frequency: a pole of the span meets the pole of the pendant."""
    drive = cd.load_drive("dissertation-1")
    half_wave = 2 * np.pi * cd.natural_frequencies(drive, count=2)[1]
    motor = Motor(inertia=1e-6, joint_stiffness=float(1e-6 * half_wave**2))
    tuned = replace(drive, motor=motor)
    listed = cd.natural_frequencies(tuned, count=5)
    roots = [float(root) / (2 * np.pi) for root in exact_roots(in_metres(tuned), 5)]
    measured(f"relative error {np.max(np.abs(listed / roots - 1.0)):.1e}")
    np.testing.assert_allclose(listed, roots, rtol=1e-12)
    assert np.min(np.abs(2 * np.pi * listed / half_wave - 1)) < 1e-14


def in_metres(drive):
    """The same drive with its span given unstretched, as the reference wants it."""
    return replace(drive, layout=replace(drive.layout, span_length=drive.span_length, pulley_distance=None))
