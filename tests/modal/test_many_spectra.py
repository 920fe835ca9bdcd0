"""Spectra of many drives in one call equal those of each drive alone."""

import numpy as np
import pytest

import cabledrive as cd
from cabledrive.mechanics.chain import Chain, Pendant
from cabledrive.mechanics.spans import longitudinal_chains
from cabledrive.modal.batch import ChainBatch, many_spectra


def batch(chains: list[Chain]) -> ChainBatch:
    pendants = [chain.pendant or Pendant(stiffness=0.0, mass=0.0) for chain in chains]
    return ChainBatch(
        times=np.array([chain.travel_times for chain in chains]),
        masses=np.array([chain.masses for chain in chains]),
        grounds=np.array([chain.ground_springs for chain in chains]),
        impedance=np.array([chain.impedance for chain in chains]),
        pendant=np.array([[own.stiffness, own.mass, own.ground] for own in pendants]),
        closed=chains[0].closed,
    )


@pytest.mark.parametrize("name", ["dissertation-2", "dissertation-3", "printer-belt", "elevator"])
def test_each_row_equals_the_drive_alone(name):
    generator = np.random.default_rng(11)
    drives = []
    for factors in np.exp(generator.normal(0.0, 1.0, (12, 3))):
        base = cd.load_drive(name)
        values = (base.cable.mass_per_length, base.pulley[0].inertia, base.pulley[1].inertia)
        keys = ("cable.mass_per_length", "pulley.0.inertia", "pulley.1.inertia")
        changes = [f"{key}={float(v * f)!r}" for key, v, f in zip(keys, values, factors, strict=True)]
        drives.append(cd.load_drive(name, overrides=["carriage=[]", *changes]))
    omegas, done = many_spectra(batch([longitudinal_chains(drive)[0].chain for drive in drives]), 5)
    assert np.count_nonzero(done) >= 11, "rows are left to the search of one chain without need"
    for drive, omega in zip([d for d, ok in zip(drives, done, strict=True) if ok], omegas[done], strict=True):
        alone = cd.natural_frequencies(drive, count=5)[:5]
        np.testing.assert_allclose(omega / (2 * np.pi), alone, rtol=1e-12)


def test_a_line_with_free_ends_has_the_roots_of_its_equation():
    """Two equal masses m on a line of impedance Z: Z/(m w) = tan(w t/2), -cot(w t/2)."""
    time, mass, impedance = np.array([[0.7]]), np.array([[2.0, 2.0]]), np.array([3.0])
    line = ChainBatch(
        times=time,
        masses=mass,
        grounds=np.zeros((1, 2)),
        impedance=impedance,
        pendant=np.zeros((1, 3)),
        closed=False,
    )
    (omega,), done = many_spectra(line, 4)
    assert done.all()
    half = 0.5 * omega * 0.7
    opposed = 3.0 * np.cos(half) - 2.0 * omega * np.sin(half)
    together = 3.0 * np.sin(half) + 2.0 * omega * np.cos(half)
    np.testing.assert_allclose(np.minimum(np.abs(opposed), np.abs(together)), 0.0, atol=1e-10)
    assert np.all(np.diff(omega) > 0.0)


def test_modes_of_one_frequency_are_left_to_the_search_of_one_chain():
    """A ring of equal spans without masses has every frequency twice."""
    ring = ChainBatch(
        times=np.array([[1.0, 1.0]]),
        masses=np.zeros((1, 2)),
        grounds=np.zeros((1, 2)),
        impedance=np.ones(1),
        pendant=np.zeros((1, 3)),
        closed=True,
    )
    _, done = many_spectra(ring, 3)
    assert not done.any()
