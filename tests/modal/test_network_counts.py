"""The count of a network against finite elements that know no wave formula, still and moving."""

import numpy as np
import pytest
from parts import listed

from cabledrive.modal import rows, search
from cabledrive.modal.kernels import compiled_counts
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
        for omega in frequencies * slowest * DEGREE / 2.4:
            if np.min(np.abs(truth - omega)) < 1e-4 * omega:  # closer than the oracle knows its frequencies
                continue
            own = (
                component.count(omega)
                + component.rigid
                + int(others @ np.floor(omega * component.time / np.pi))
            )
            wrong += own != int(np.sum(truth < omega))
            made += 1
    return wrong, made


@pytest.mark.parametrize("moving", [False, True])
def test_counts_of_random_networks_are_those_of_finite_elements(moving):
    wrong, made = wrong_counts(11 + moving, 12, moving)
    assert made > 80
    assert wrong == 0, f"{wrong} of {made} counts"


@pytest.mark.verify
@pytest.mark.parametrize("moving", [False, True])
def test_no_count_of_two_thousand_random_networks_is_wrong(moving, measured):
    wrong, made = wrong_counts(2024 + moving, 1000, moving)
    measured(f"random networks, {'moving to 0.85 c' if moving else 'still'}: {wrong} of {made} counts wrong")
    assert wrong == 0, f"{wrong} of {made} counts"


@pytest.mark.kernel  # of cabledrive.modal.kernels: what refines the modes of large tables
@pytest.mark.parametrize(("moving", "large"), [(False, False), (False, True), (True, False)])
def test_modes_of_random_networks_are_those_of_finite_elements(moving, large, monkeypatch):
    monkeypatch.setattr(search, "_large", lambda table: large)
    rng = np.random.default_rng(5)
    for _ in range(4):
        component, strings, mass, spring, others = random_network(rng, moving)
        if others.any():
            strings = [type(s)(s.start, s.end, s.density * s.ropes, s.wave_speed, s.speed) for s in strings]
        truth = natural_frequencies(strings, mass, spring, DEGREE)
        top = 0.5 * min(string.wave_speed - abs(string.speed) for string in strings) * DEGREE / 2.4
        own = listed(component.modes(0.0, top))
        rigid = int(np.sum(truth < 1e-5 * top))
        expected = truth[rigid : rigid + own.size]
        np.testing.assert_allclose(own[own > 1e-4 * top], expected[expected > 1e-4 * top], rtol=2e-8)


def test_a_count_never_falls():
    rng = np.random.default_rng(3)
    component, *_ = random_network(rng, True)
    counts = [component.count(omega) for omega in np.linspace(0.01, 60.0, 400)]
    assert np.all(np.diff(counts) >= 0)
    assert counts[-1] > counts[0]


@pytest.mark.kernel  # of cabledrive.modal.kernels
@pytest.mark.parametrize("moving", [False, True])
@pytest.mark.parametrize("growth", [rows.GROWTH, 1.0])
def test_compiled_counts_are_those_of_many_lanes(moving, growth, monkeypatch):
    """Loops over one matrix against numpy over many, from either end and by eigenvalues where digits go."""
    monkeypatch.setattr("cabledrive.modal.kernels.GROWTH", growth)
    rng = np.random.default_rng(21)
    for _ in range(6):
        component, *_ = random_network(rng, moving)
        top = 8.0 / component.longest
        table = component.cut(top).table
        lanes = rows.lanes_at(rng.uniform(0.01, 1.0, 40) * top)
        np.testing.assert_array_equal(compiled_counts(table)(lanes), rows.counted(table, lanes))


def test_a_band_turned_round_and_solved_is_the_whole_matrix():
    """Hermitian bands with pivots on the diagonal that are zero or small, which ask for exchanges of rows."""
    rng = np.random.default_rng(4)
    for kind, size in ((float, 9), (complex, 9), (float, 23), (complex, 23)):
        whole = rng.normal(size=(size, size)) + (1j * rng.normal(size=(size, size)) if kind is complex else 0)
        near = np.abs(np.subtract.outer(np.arange(size), np.arange(size))) <= 3
        whole = np.where(near, whole + whole.conj().T, 0.0).astype(kind)
        whole[np.arange(0, size, 4), np.arange(0, size, 4)] = 0.0
        band = np.zeros((size, 4, 1), kind)
        for j in range(size):
            for d in range(min(3, size - 1 - j) + 1):
                band[j, d, 0] = whole[j + d, j]
        np.testing.assert_array_equal(rows.dense(band)[0], whole)
        np.testing.assert_array_equal(rows.dense(rows.turned_round(band))[0], whole[::-1, ::-1])
        load = rng.normal(size=(size, 1, 1)).astype(kind)
        expected = np.linalg.solve(whole, load[:, 0])
        found = rows.solved(band, load)[:, 0]
        np.testing.assert_allclose(found, expected / np.abs(expected).max(), atol=1e-9)
