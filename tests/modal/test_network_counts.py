"""The count of a network against finite elements that know no wave formula, still and moving."""

import numpy as np
import pytest

from cabledrive.modal.network.band_kernels import for_lapack
from cabledrive.modal.network.refining_kernels import solved
from cabledrive.modal.network.structure import MULTIPLE, ComponentStructure
from cabledrive.modal.solver import ENCLOSURES, modes_of
from network_samples import random_network
from oracles.network_fem import natural_frequencies

DEGREE = 26


def wrong_counts(seed, networks, moving):
    """Counts at eight frequencies of each network that differ from the oracle's; and how many were made."""
    rng, wrong, made = np.random.default_rng(seed), 0, 0
    for _ in range(networks):
        component, strings, mass, spring, others = random_network(rng, moving)
        frequencies = rng.uniform(0.05, 1.0, 8)
        tied = sum(string.start**2 + string.end**2 for string in strings) + np.diag(mass) + np.diag(spring)
        if not tied.all():  # a coordinate that nothing moves, ties or holds: no machine
            continue
        truth = natural_frequencies(strings, mass, spring, DEGREE)
        slowest = min(string.wave_speed - abs(string.speed) for string in strings)
        counter = ComponentStructure(component)
        for omega in frequencies * slowest * DEGREE / 2.4:
            if np.min(np.abs(truth - omega)) < 1e-4 * omega:  # closer than the oracle knows its frequencies
                continue
            own = counter.count(omega) + int(others @ np.floor(omega * component.time / np.pi))
            wrong += own != int(np.sum(truth < omega))
            made += 1
    return wrong, made


@pytest.mark.kernel  # of cabledrive.modal.network.band_kernels
@pytest.mark.parametrize("moving", [False, True])
def test_counts_of_random_networks_are_those_of_finite_elements(moving):
    wrong, made = wrong_counts(11 + moving, 12, moving)
    assert made > 80
    assert wrong == 0, f"{wrong} of {made} counts"


@pytest.mark.kernel  # of cabledrive.modal.network.refining_kernels
@pytest.mark.parametrize("width", [1, 3])
def test_the_solution_of_a_band_is_that_of_the_whole_matrix(width):
    """Hermitian bands with pivots on the diagonal that are zero or small, which ask for exchanges of rows."""
    rng, size = np.random.default_rng(width), 9
    for kind in (np.float64, np.complex128):
        whole = rng.normal(size=(size, size)) + (
            1j * rng.normal(size=(size, size)) if kind is np.complex128 else 0
        )
        near = np.abs(np.subtract.outer(np.arange(size), np.arange(size))) <= width
        whole = np.where(near, whole + whole.conj().T, 0.0).astype(kind)
        whole[np.arange(0, size, 2), np.arange(0, size, 2)] = [0.0, 1e-12, 0.0, 1.0, 2.0]
        load = rng.normal(size=(size, 1)).astype(kind)
        expected = np.linalg.solve(whole, load)
        band = np.zeros((size, width + 1), dtype=kind)
        for i in range(size):
            for d in range(min(width, i) + 1):
                band[i, d] = whole[i, i - d]
        matrix = np.empty((3 * width + 1, size), dtype=kind, order="F")
        for_lapack(band, matrix)
        solved(matrix, width, load)
        np.testing.assert_allclose(load, expected / np.abs(expected).max(), atol=1e-8)


@pytest.mark.verify
@pytest.mark.parametrize("moving", [False, True])
def test_no_count_of_two_thousand_random_networks_is_wrong(moving, measured):
    wrong, made = wrong_counts(2024 + moving, 1000, moving)
    measured(f"random networks, {'moving to 0.85 c' if moving else 'still'}: {wrong} of {made} counts wrong")
    assert wrong == 0, f"{wrong} of {made} counts"


@pytest.mark.parametrize("moving", [False, True])
def test_modes_of_random_networks_are_those_of_finite_elements(moving):
    rng = np.random.default_rng(5)
    for _ in range(4):
        component, strings, mass, spring, others = random_network(rng, moving)
        if others.any():
            strings = [type(s)(s.start, s.end, s.density * s.ropes, s.wave_speed, s.speed) for s in strings]
        truth = natural_frequencies(strings, mass, spring, DEGREE)
        top = 0.5 * min(string.wave_speed - abs(string.speed) for string in strings) * DEGREE / 2.4
        found = list(modes_of(ComponentStructure(component), top, enclosures=ENCLOSURES, multiple=MULTIPLE))
        listed = np.repeat([mode.omega for mode in found], [mode.multiplicity for mode in found])
        rigid = int(np.sum(truth < 1e-5 * top))
        expected = truth[rigid : rigid + listed.size]
        assert all(mode.enclosure is not None for mode in found)
        np.testing.assert_allclose(listed[listed > 1e-4 * top], expected[expected > 1e-4 * top], rtol=2e-8)


def test_a_count_never_falls():
    rng = np.random.default_rng(3)
    component, *_ = random_network(rng, True)
    counter = ComponentStructure(component)
    counts = [counter.count(omega) for omega in np.linspace(0.01, 60.0, 400)]
    assert np.all(np.diff(counts) >= 0)
    assert counts[-1] > counts[0]
