"""The modes agree with spectral elements, which share nothing with them, wherever their round-off allows."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from machines import machine, uneven_machine
from spectral_elements import frequencies
from transfer_roots import exact_chains

import cabledrive as cd

AGREEMENT = 1e-8
MODES = 12
MACHINES = [
    pytest.param(seed, marks=() if seed % 10 == 0 else pytest.mark.verify, id=f"machine-{seed}")
    for seed in range(100)
]


def longitudinal(drive):
    """Spectral frequencies of all chains of a drive [rad/s], and how far round-off blurs them."""
    parts = []
    for chain in exact_chains(drive):
        times, masses = np.array(chain.times, dtype=float), np.array(chain.masses, dtype=float)
        pendant = None
        if chain.pendant is not None:
            own, mass = map(float, chain.pendant)
            pendant = own**2 * mass, mass, chain.pendant_joint
        parts.append(
            frequencies(times, masses, 1.0, 1.0, closed=chain.closed, fixed=chain.fixed, pendant=pendant)
        )
    return merged(parts)


def transverse(drive):
    """Strings between the pulleys and guided carriages, in pretensioned coordinates; one plane."""
    stretch = 1.0 + drive.cable.prestrain
    tension, density = drive.cable.pretension, drive.cable.mass_per_length / stretch
    parts = []
    for span in drive.spans:
        carriages = drive.carriages_on(span)
        held = [0.0, *(c.position for c in carriages if c.guided), drive.span_length]
        for start, end in pairwise(held):
            hanging = [c for c in carriages if start < c.position < end]
            lengths = np.diff([start, *(c.position for c in hanging), end]) * stretch
            masses = [0.0, *(c.mass for c in hanging), 0.0]
            parts.append(frequencies(lengths, masses, tension, density, fixed=(True, True)))
    return merged(parts)


def merged(parts):
    omegas, blurs = (np.concatenate([part[i] for part in parts]) for i in (0, 1))
    order = np.argsort(omegas)
    return omegas[order], blurs[order]


def check_agreement(listed, spectral, measured):
    """Agreement to 1e-8 of every mode that round-off blurs less; most must be among them."""
    omegas, blurs = (values[:MODES] for values in spectral)
    clear = blurs < AGREEMENT
    error = np.abs(listed[:MODES] / omegas - 1.0)[clear]
    measured(f"relative error {error.max(initial=0.0):.1e} in {clear.sum()} modes clear of round-off")
    assert clear.sum() >= MODES / 2, f"only {clear.sum()} modes are clear of round-off"
    assert error.max() <= AGREEMENT, f"relative error {error.max():.2e} of mode {np.argmax(error) + 1}"


@pytest.mark.parametrize("seed", MACHINES)
def test_longitudinal_modes_agree_with_spectral_elements(seed, measured):
    drive = machine(np.random.default_rng(seed), contrast=100.0)
    check_agreement(2 * np.pi * cd.natural_frequencies(drive, count=MODES), longitudinal(drive), measured)


@pytest.mark.parametrize("seed", MACHINES)
def test_transverse_modes_agree_with_spectral_elements(seed, measured):
    """With hanging carriages as point masses, guided ones as supports; each frequency in both planes."""
    rng = np.random.default_rng(seed)
    drive = with_hanging_carriages(uneven_machine(rng, contrast=100.0), rng)
    modes = cd.modes(drive, count=2 * MODES)
    planes = {p: np.array([m.frequency for m in modes.transverse if m.plane == p]) for p in "vw"}
    np.testing.assert_array_equal(planes["v"], planes["w"])
    check_agreement(2 * np.pi * planes["v"], transverse(drive), measured)


def with_hanging_carriages(drive, rng):
    carriages = tuple(replace(c, guided=bool(rng.random() < 0.3)) for c in drive.carriage)
    return replace(drive, carriage=carriages)
