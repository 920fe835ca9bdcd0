"""Chains that are built in Python have certified modes as drives have: one cable or several, any pendants."""

from dataclasses import replace

import numpy as np
import pytest
from machines import LINE, MOTOR, by_multiplicity, finite_elements

import cabledrive as cd
from cabledrive.mechanics import Chain, Pendant
from cabledrive.mechanics.spans import longitudinal_chains
from cabledrive.modal.batch import batch_of, many_spectra

CABLES = {
    "rigidity": np.array([438.0, 9e4, 1.2e3]),
    "density": np.array([2.1e-4, 0.041, 6e-4]),
}
THREE = replace(LINE, **CABLES)


def random_chain(rng: np.random.Generator) -> Chain:
    """Up to six cables, their rigidities and densities a factor 30 apart; pendants and springs by chance."""
    n, closed = int(rng.integers(2, 7)), bool(rng.random() < 0.4)
    m = n if closed else n - 1
    pendants = tuple(
        Pendant(
            stiffness=spread(rng, 50.0),
            mass=spread(rng, 1.0),
            joint=int(rng.integers(n)),
            ground=spread(rng, 5.0) if rng.random() < 0.3 else 0.0,
        )
        for _ in range(int(rng.integers(0, 5)))
    )
    return Chain(
        rigidity=spread(rng, 10.0, m),
        density=spread(rng, 0.1, m),
        lengths=spread(rng, 0.5, m),
        masses=np.where(rng.random(n) < 0.3, 0.0, spread(rng, 0.2, n)),
        closed=closed,
        fixed=(False, False) if closed else (bool(rng.random() < 0.3), bool(rng.random() < 0.3)),
        pendants=pendants,
        grounds=np.where(rng.random(n) < 0.2, 3.0, 0.0),
    )


def spread(rng: np.random.Generator, middle: float, size: int | None = None):
    """Numbers about a middle, a factor of 30 from the least to the largest."""
    return middle * np.exp(rng.uniform(-1.7, 1.7, size))


@pytest.mark.parametrize(("seed", "chains"), [(17, 30), pytest.param(2026, 1000, marks=pytest.mark.verify)])
def test_no_random_chain_misses_a_mode_of_finite_elements(seed, chains, measured):
    """Chains whose list differs from finite elements or is not certified are wrong."""
    rng, wrong, compared = np.random.default_rng(seed), [], 0
    for number in range(chains):
        chain = random_chain(rng)
        slowest = 0.5 / np.max(chain.lengths / np.sqrt(chain.rigidity / chain.density))
        top = slowest * rng.uniform(0.5, 8.0)  # Hz: up to four waves in the slowest segment
        found, everything = cd.modes(chain, below=top), finite_elements(chain, 2.0 * np.pi * top)
        truth = everything[found.rigid_body_modes :] / (2.0 * np.pi)
        expected = truth[truth < found.certificate.below]
        frequencies = by_multiplicity(found.modes)
        compared += expected.size
        if frequencies.size != expected.size or not found.certified:
            wrong.append(f"chain {number}: {frequencies.size} listed, {expected.size} expected")
        elif np.any(np.abs(frequencies / expected - 1.0) > 3e-9):  # round-off of the elements
            wrong.append(f"chain {number}: off by {np.abs(frequencies / expected - 1.0).max():.1e}")
    measured(f"chains of up to six cables and four pendants: {len(wrong)} wrong, {compared:,} modes")
    assert compared > 5 * chains
    assert not wrong, "\n".join(wrong)


def test_equal_pendants_on_one_joint_have_a_multiple_mode():
    """Two of three equal absorbers move against the third and leave the joint at rest: sqrt(k/m), twice."""
    own = Pendant(stiffness=90.0, mass=0.4, joint=1)
    found = cd.modes(replace(THREE, pendants=(own, own, own)), count=5)
    (double,) = [mode for mode in found.modes if mode.multiplicity == 2]
    assert double.frequency == pytest.approx(np.sqrt(90.0 / 0.4) / (2.0 * np.pi), rel=1e-12)
    assert np.abs(double.joints["joint 1"]).max() < 1e-9
    assert found.certified


def test_a_wall_to_wall_string_and_a_ring_of_one_segment_have_their_harmonics():
    """No coordinate moves, or one that some modes leave at rest: n c / (2 l)."""
    wall = Chain(rigidity=[4.0], density=[1.0], lengths=[0.5], masses=[0.0, 0.0], fixed=(True, True))
    np.testing.assert_allclose(
        by_multiplicity(cd.modes(wall, count=5).modes), 2.0 * np.arange(1, 6), rtol=1e-12
    )
    ring = Chain(rigidity=[4.0], density=[1.0], lengths=[0.5], masses=[0.0], closed=True)
    found = cd.modes(ring, below=13.0)
    assert [mode.multiplicity for mode in found.modes] == [2, 2, 2]
    np.testing.assert_allclose([mode.frequency for mode in found.modes], [4.0, 8.0, 12.0], rtol=1e-12)
    assert found.rigid_body_modes == 1


def test_forces_of_two_cables_balance_at_their_joint():
    """R u' jumps by -omega^2 m u: the slopes of each side come from its own wave number."""
    for mode in cd.modes(THREE, count=12).modes:
        before, after = ([own for own in mode.slope_waves() if own.span == f"segment {i}"] for i in (0, 1))
        before, after = before[-1].slope_at(float(THREE.lengths[0])).real, after[0].slope.real
        pull = CABLES["rigidity"][1] * after - CABLES["rigidity"][0] * before
        omega = 2.0 * np.pi * mode.frequency
        inertia = -(omega**2) * 0.05 * float(mode.joints["joint 1"][0])
        assert pull == pytest.approx(inertia, rel=1e-6, abs=1e-6 * abs(CABLES["rigidity"][1] * after))


def test_a_soft_spring_names_the_mode_that_it_holds():
    found = cd.modes(replace(LINE, grounds=np.array([0.0, 900.0, 0.0, 40.0])), count=1).modes[0]
    assert found.family == "spring to the ground"
    soft = replace(THREE, pendants=(Pendant(stiffness=1e-3, mass=0.4), MOTOR))
    assert cd.modes(soft, count=1).modes[0].family == "spring of pendant 0"


# --- Spectra of many chains in one call are those of each alone
@pytest.mark.parametrize("name", ["dissertation-2", "dissertation-3", "printer-belt", "elevator"])
def test_each_row_equals_the_drive_alone(name):
    generator = np.random.default_rng(11)
    drives = []
    for factors in np.exp(generator.normal(0.0, 1.0, (12, 3))):
        base = cd.load_drive(name).listed
        values = (base.cable.mass_per_length, base.pulley[0].inertia, base.pulley[1].inertia)
        keys = ("cable.mass_per_length", "pulley.0.inertia", "pulley.1.inertia")
        changes = [f"{key}={float(v * f)!r}" for key, v, f in zip(keys, values, factors, strict=True)]
        drives.append(cd.load_drive(name, overrides=["carriage=[]", *changes]).listed)
    omegas, done = many_spectra(batch_of([longitudinal_chains(drive)[0].chain for drive in drives]), 5)
    assert np.count_nonzero(done) >= 11, "rows are left to the search of one chain without need"
    for drive, omega in zip([d for d, ok in zip(drives, done, strict=True) if ok], omegas[done], strict=True):
        alone = cd.natural_frequencies(drive, count=5, taut=True)[:5]
        np.testing.assert_allclose(omega / (2 * np.pi), alone, rtol=1e-12)


def test_a_line_with_free_ends_has_the_roots_of_its_equation():
    """Two equal masses m on a line of impedance Z: Z/(m w) = tan(w t/2), -cot(w t/2)."""
    ends = np.full(2, 2.0)
    line = batch_of([Chain(rigidity=3.0 / 0.7, density=3.0 * 0.7, lengths=np.ones(1), masses=ends)])
    (omega,), done = many_spectra(line, 4)
    assert done.all()
    half = 0.5 * omega * 0.7
    opposed = 3.0 * np.cos(half) - 2.0 * omega * np.sin(half)
    together = 3.0 * np.sin(half) + 2.0 * omega * np.cos(half)
    np.testing.assert_allclose(np.minimum(np.abs(opposed), np.abs(together)), 0.0, atol=1e-10)
    assert np.all(np.diff(omega) > 0.0)


def test_modes_of_one_frequency_are_left_to_the_search_of_one_chain():
    """A ring of equal spans without masses has every frequency twice."""
    ring = batch_of([Chain(rigidity=1.0, density=1.0, lengths=np.ones(2), masses=np.zeros(2), closed=True)])
    _, done = many_spectra(ring, 3)
    assert not done.any()
