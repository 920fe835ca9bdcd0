"""Counts and modes of networks against finite elements that know no wave formula: still, moving, elastic."""

from dataclasses import replace
from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from machines import alone, listed

from cabledrive.modal import rows, runs
from cabledrive.modal.component import Component, Fixed
from cabledrive.modal.elements import ALONG, Wave
from cabledrive.modal.rows import MASS, SPRING
from network_samples import random_elastic_network, random_hanging_network, random_network, row_of
from oracles.network_fem import matrices, natural_frequencies
from oracles.rope_fem import frequencies, with_ropes

DEGREE = 26
BEAMS, HANGING = "tensioned beams and heavy strings", "hanging ropes"
ELASTIC = {BEAMS: (random_elastic_network, 8), HANGING: (random_hanging_network, 9)}


def plain_sample(rng, moving):
    """A network of strings, its true frequencies below a top [rad/s], or none where it is no machine."""
    component, strings, mass, spring, others = random_network(rng, moving)
    places = rng.uniform(0.05, 1.0, 8)
    tied = sum(string.start**2 + string.end**2 for string in strings) + np.diag(mass) + np.diag(spring)
    if not tied.all():  # a coordinate that nothing moves, ties or holds
        return None
    top = min(string.wave_speed - abs(string.speed) for string in strings) * DEGREE / 2.4
    truth = natural_frequencies(strings, mass, spring, DEGREE)
    return component, others, truth, places * top


def elastic_sample(rng, kind):
    """The same of a network with elements beside its strings."""
    sample, degree = ELASTIC[kind]
    component, strings, parts, mass, spring, others = sample(rng)
    speeds = [np.sqrt(min(part.tension) / part.density) / part.length for part in parts]
    top = min([*speeds, *(string.wave_speed for string in strings)]) * DEGREE / 2.4
    coordinates = mass.shape[0]
    mass, _, spring = matrices(strings, mass, spring, DEGREE)
    truth = frequencies(*with_ropes(mass, spring, parts, coordinates, elements=4, degree=degree), top)
    return component, others, truth, rng.uniform(0.05, 1.0, 8) * top


FEW = [("still", 11, 12, 80), ("moving", 12, 12, 80), (BEAMS, 3, 3, 15), (HANGING, 5, 8, 40)]
MANY = [("still", 2024, 1000), ("moving", 2025, 1000), (BEAMS, 2026, 300), (HANGING, 2026, 500)]


@pytest.mark.parametrize(
    ("kind", "seed", "networks", "least"),
    [*FEW, *(pytest.param(*whole, 80, marks=pytest.mark.verify) for whole in MANY)],
)
def test_no_count_of_random_networks_differs_from_finite_elements(kind, seed, networks, least, measured):
    """At eight frequencies of each."""
    rng, wrong, made = np.random.default_rng(seed), 0, 0
    for _ in range(networks):
        sample = elastic_sample(rng, kind) if kind in ELASTIC else plain_sample(rng, kind == "moving")
        if sample is None:
            continue
        component, others, truth, places = sample
        held = [(alone(rope), rope.ropes - 1) for rope in component.ropes]
        for omega in places:
            if np.min(np.abs(truth - omega)) < 1e-4 * omega:  # closer than the oracle knows its frequencies
                continue
            own = component.count(omega) + component.rigid
            own += int(others @ np.floor(omega * component.time / np.pi))
            own += sum(ropes * one.count(omega) for one, ropes in held)
            wrong += own != int(np.sum(truth < omega))
            made += 1
    measured(f"random networks, {kind}: {wrong} of {made} counts wrong")
    assert made > least
    assert wrong == 0, f"{wrong} of {made} counts"


@pytest.mark.parametrize("moving", [False, True])
def test_modes_of_random_networks_are_those_of_finite_elements(moving):
    rng = np.random.default_rng(5)
    for _ in range(4):
        component, strings, mass, spring, others = random_network(rng, moving)
        if others.any():
            strings = [alike(one) for one in strings]
        truth = natural_frequencies(strings, mass, spring, DEGREE)
        top = 0.5 * min(string.wave_speed - abs(string.speed) for string in strings) * DEGREE / 2.4
        own = listed(component.modes(0.0, top))
        rigid = int(np.sum(truth < 1e-5 * top))
        expected = truth[rigid : rigid + own.size]
        np.testing.assert_allclose(own[own > 1e-4 * top], expected[expected > 1e-4 * top], rtol=2e-8)


def alike(part):
    """Ropes that move alike as one of so many times the mass and the forces."""
    scaled = ("density", "rigidity", "bending", "shear", "load")
    own = {key: getattr(part, key) * part.ropes for key in scaled if hasattr(part, key)}
    if hasattr(part, "tension"):
        own["tension"] = tuple(one * part.ropes for one in part.tension)
    return replace(part, ropes=1, **own)


@pytest.mark.parametrize(
    ("kind", "seed", "networks", "top", "tolerance"),
    [(BEAMS, 8, 2, 12.0, 2e-5), *((HANGING, seed, 1, 10.0, 1e-6) for seed in range(3))],
)
def test_modes_of_networks_with_ropes_that_bend_or_hang_are_those_of_finite_elements(
    kind, seed, networks, top, tolerance, measured
):
    rng, (sample, _) = np.random.default_rng(seed), ELASTIC[kind]
    for _ in range(networks):
        component, strings, parts, mass, spring, _ = sample(rng)
        strings, parts, coordinates = list(map(alike, strings)), list(map(alike, parts)), mass.shape[0]
        mass, _, spring = matrices(strings, mass, spring, DEGREE)
        mass, spring = with_ropes(mass, spring, parts, coordinates, elements=4, degree=10)
        highest = top / component.longest
        truth, own = frequencies(mass, spring, highest), listed(component.modes(0.0, highest))
        own = own[own > 1e-4 * highest]
        error = np.max(np.abs(own / truth[truth > 1e-4 * highest][: own.size] - 1.0))
        measured(f"{kind}: {own.size} modes, largest relative difference {error:.1e}")
        assert error < tolerance


@pytest.mark.parametrize("moving", [False, True])
def test_counts_from_the_other_end_and_by_eigenvalues_are_the_same(moving, monkeypatch):
    """Where terms outgrow the matrix; a few lanes at a time, too."""
    rng = np.random.default_rng(21)
    for _ in range(6):
        component, *_ = random_network(rng, moving)
        top = 8.0 / component.longest
        table = component.cut(top).table
        lanes = rows.lanes_at(rng.uniform(0.01, 1.0, 40) * top)
        plain = rows.counted(table, lanes)
        with monkeypatch.context() as changed:
            changed.setattr(rows, "GROWTH", 1.0)
            changed.setattr(rows, "TOGETHER", 7 * table.first.size)
            np.testing.assert_array_equal(rows.counted(table, lanes), plain)


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


def test_the_growth_of_an_elimination_is_that_of_its_terms():
    """Largest sum of |l|^2 |d| over a row, over the largest diagonal, from LDL^T of the whole matrix."""
    rng = np.random.default_rng(8)
    whole = rng.normal(size=(9, 9))
    whole = np.where(np.abs(np.subtract.outer(np.arange(9), np.arange(9))) <= 2, whole + whole.T, 0.0)
    whole += 4.0 * np.diag(np.sign(rng.normal(size=9)))
    band = np.array([[[whole[min(j + d, 8), j] * (j + d < 9)] for d in range(3)] for j in range(9)])
    lower, rest = np.eye(9), whole.copy()
    for k in range(9):
        lower[k + 1 :, k] = rest[k + 1 :, k] / rest[k, k]
        rest[k + 1 :, k + 1 :] -= np.outer(lower[k + 1 :, k], rest[k, k + 1 :])
    pivots = np.diag(rest)
    terms = (lower**2 * np.abs(pivots)).sum(axis=1) - np.abs(pivots)
    count, growth = rows.negative_pivots(band)
    assert count[0] == np.sum(np.linalg.eigvalsh(whole) < 0.0)
    assert growth[0] == pytest.approx(terms.max() / np.abs(np.diag(whole)).max(), rel=1e-12)


def chains_of_unknowns(rng):
    """A symmetric matrix of long chains between a few unknowns that are tied to more, numbered at random."""
    hubs = int(rng.integers(1, 5))
    size, pairs = hubs, [(i, i + 1) for i in range(hubs - 1)]
    for _ in range(int(rng.integers(1, 3))):
        inner = int(rng.integers(3, 40) if size > hubs else rng.integers(30, 80))
        path = [int(rng.integers(hubs)), *range(size, size + inner), int(rng.integers(hubs))]
        pairs += pairwise(path)
        size += inner
    order = rng.permutation(size)
    whole = np.diag(rng.normal(size=size))
    for i, j in pairs:
        whole[order[i], order[j]] = whole[order[j], order[i]] = rng.normal()
    i, j = (order[list(own)] for own in zip(*pairs, strict=True))
    return whole, np.maximum(i, j), np.minimum(i, j)


def test_long_runs_keep_the_signs_of_eigenvalues_and_solve():
    """Chains, rings and several at once: counts and solutions of the whole matrix."""
    rng, counted = np.random.default_rng(12), 0
    for number in range(60):
        whole, upper, lower = chains_of_unknowns(rng)
        size, shifts = whole.shape[0], rng.normal(size=4)
        found = runs.long_runs(upper, lower, size)[number % 3]
        own = [whole - shift * np.eye(size) for shift in shifts]
        padded = [np.pad(one, ((0, size), (0, 0))) for one in own]
        band = np.array([[[one[j + d, j] for one in padded] for d in range(size)] for j in range(size)])
        x = rng.normal(size=(size, 4, 2))
        left, negative, growth = runs.eliminated(found, band, x)
        solved = runs.solved_run(found, left, size)
        for lane in np.flatnonzero(growth < 1e2):
            below = negative[lane] + np.sum(np.linalg.eigvalsh(left[0][lane]) < 0.0)
            assert below == np.sum(np.linalg.eigvalsh(own[lane]) < 0.0)
            counted += 1
            np.testing.assert_allclose(own[lane] @ solved[:, lane], x[:, lane], atol=1e-6)
    assert counted > 100


def rank(rows):
    """Rank of a matrix of fractions, exact."""
    left, found = [list(row) for row in rows], 0
    for column in range(len(left[0])):
        place = next((k for k in range(found, len(left)) if left[k][column]), None)
        if place is None:
            continue
        left[found], left[place] = left[place], left[found]
        for row in left[found + 1 :]:
            share = row[column] / left[found][column]
            row[:] = [one - share * other for one, other in zip(row, left[found], strict=True)]
        found += 1
    return found


@pytest.mark.parametrize("decades", [0, 2, 6])
def test_motions_that_strain_nothing_are_counted_in_whatever_units_coordinates_have(decades):
    """Ropes and springs between coordinates, most of them a tree: what is left of their exact rank.

    Ratios of hundredths between 0.2 and 3; each coordinate then in units that many decades either way.
    """
    rng = np.random.default_rng(decades)

    def moved(coordinate, size):
        row = np.zeros(size)
        row[coordinate] = round(float(rng.uniform(0.2, 3.0)), 2) * rng.choice([1.0, -1.0])
        return row

    for _ in range(300):
        n = int(rng.integers(2, 9))
        order, units = rng.permutation(n), 10.0 ** rng.uniform(-decades, decades, n)
        pairs = [
            (order[k], order[k + 1 if rng.random() < 0.8 else rng.integers(k + 1)]) for k in range(n - 1)
        ]
        pairs += [tuple(rng.integers(n, size=2)) for _ in range(rng.integers(3))]
        ends = [(moved(a, n), moved(b, n)) for a, b in pairs]
        ends += [(moved(rng.integers(n), n), np.zeros(n))] * int(rng.random() < 0.3)
        joints = [np.eye(n)[a] - np.eye(n)[b] for a, b in rng.integers(n, size=(int(rng.integers(2)), 2))]
        strains = [start - end for start, end in ends] + joints
        exact = [[Fraction(str(round(float(one), 2))) for one in row] for row in strains]
        waves = [
            Wave(row_of(start * units), row_of(end * units), rng.uniform(0.3, 3.0), 1e-2, (number, ALONG))
            for number, (start, end) in enumerate(ends)
        ]
        masses = [
            Fixed(MASS, own, ((i, 1.0),)) for i, own in enumerate(10 ** rng.uniform(-3, 3, n) * units**2)
        ]
        springs = [Fixed(SPRING, 10.0 ** rng.uniform(-2, 4), row_of(own * units)) for own in joints]
        assert Component(range(n), [*waves, *masses, *springs]).rigid == n - rank(exact)
