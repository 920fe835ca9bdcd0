"""Elements of shallow sag against finite elements of the same equations, and their limits."""

from dataclasses import replace

import numpy as np
import pytest

from cabledrive.modal.network.component import held_element
from cabledrive.modal.network.structure import MULTIPLE, ComponentStructure
from cabledrive.modal.solver import ENCLOSURES, modes_of
from network_samples import random_hanging_network
from oracles.beam_fem import frequencies
from oracles.hanging_fem import with_hanging
from oracles.network_fem import matrices

DEGREE = 26


def held_structure(link):
    return ComponentStructure(held_element(link, ()).component)


def discretised(strings, ropes, mass, spring):
    """Mass and stiffness of all."""
    coordinates = mass.shape[0]
    mass, _, spring = matrices(strings, mass, spring, DEGREE)
    return with_hanging(mass, spring, ropes, coordinates, elements=4, degree=9)


def wrong_counts(seed, networks):
    """Counts at eight frequencies of each random network that differ from the oracle's; and how many."""
    rng, wrong, made = np.random.default_rng(seed), 0, 0
    for _ in range(networks):
        component, strings, ropes, mass, spring, others = random_hanging_network(rng)
        mass, spring = discretised(strings, ropes, mass, spring)
        speeds = [np.sqrt(min(rope.tension) / rope.density) / rope.length for rope in ropes]
        top = min([*speeds, *(string.wave_speed for string in strings)]) * DEGREE / 2.4
        truth = frequencies(mass, spring, top)
        counter = ComponentStructure(component)
        held = [(held_structure(link), link.ropes - 1) for link in component.elastic]
        for omega in rng.uniform(0.05, 1.0, 8) * top:
            if np.min(np.abs(truth - omega)) < 1e-4 * omega:  # closer than the oracle knows its frequencies
                continue
            own = counter.count(omega) + int(others @ np.floor(omega * component.time / np.pi))
            own += sum(ropes * structure.count(omega) for structure, ropes in held)
            wrong += own != int(np.sum(truth < omega))
            made += 1
    return wrong, made


def test_counts_of_random_networks_with_hanging_ropes_are_those_of_finite_elements():
    wrong, made = wrong_counts(5, 8)
    assert made > 40
    assert wrong == 0, f"{wrong} of {made} counts"


@pytest.mark.verify
def test_no_count_of_five_hundred_random_networks_with_hanging_ropes_is_wrong(measured):
    wrong, made = wrong_counts(2026, 500)
    measured(f"random networks with hanging ropes: {wrong} of {made} counts wrong")
    assert wrong == 0, f"{wrong} of {made} counts"


@pytest.mark.parametrize("seed", range(3))
def test_modes_of_random_networks_with_hanging_ropes_are_those_of_finite_elements(seed, measured):
    component, strings, ropes, mass, spring, _ = random_hanging_network(np.random.default_rng(seed))
    strings = [replace(one, density=one.density * one.ropes, ropes=1) for one in strings]
    parts = [  # ropes that move alike are one of so many times the mass and the forces
        replace(
            one,
            **{
                key: getattr(one, key) * one.ropes
                for key in ("density", "rigidity", "bending", "shear", "load")
            },
            tension=(one.tension[0] * one.ropes, one.tension[1] * one.ropes),
            ropes=1,
        )
        for one in ropes
    ]
    mass, spring = discretised(strings, parts, mass, spring)
    structure = ComponentStructure(component)
    top = 10.0 / structure.longest
    truth = frequencies(mass, spring, top)
    found = list(modes_of(structure, top, enclosures=ENCLOSURES, multiple=MULTIPLE))
    listed = np.repeat([mode.omega for mode in found], [mode.multiplicity for mode in found])
    assert all(mode.enclosure is not None for mode in found)
    expected = truth[truth > 1e-4 * top][: np.sum(listed > 1e-4 * top)]
    error = np.max(np.abs(listed[listed > 1e-4 * top] / expected - 1.0))
    measured(f"network {seed}: {listed.size} modes, largest relative difference {error:.1e}")
    assert error < 1e-6
