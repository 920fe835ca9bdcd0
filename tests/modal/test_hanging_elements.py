"""Ropes that sag against finite elements of the same equations, and their limits."""

from dataclasses import replace

import numpy as np
import pytest
from elastic_counts import DEGREE, wrong_counts
from parts import listed

from network_samples import random_hanging_network
from oracles.beam_fem import frequencies
from oracles.hanging_fem import with_hanging
from oracles.network_fem import matrices


def with_all(mass, spring, ropes, coordinates):
    return with_hanging(mass, spring, ropes, coordinates, elements=4, degree=9)


def test_counts_of_random_networks_with_hanging_ropes_are_those_of_finite_elements():
    wrong, made = wrong_counts(5, 8, random_hanging_network, with_all)
    assert made > 40
    assert wrong == 0, f"{wrong} of {made} counts"


@pytest.mark.verify
def test_no_count_of_five_hundred_random_networks_with_hanging_ropes_is_wrong(measured):
    wrong, made = wrong_counts(2026, 500, random_hanging_network, with_all)
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
    coordinates = mass.shape[0]
    mass, _, spring = matrices(strings, mass, spring, DEGREE)
    mass, spring = with_all(mass, spring, parts, coordinates)
    top = 10.0 / component.longest
    truth = frequencies(mass, spring, top)
    own = listed(component.modes(0.0, top))
    expected = truth[truth > 1e-4 * top][: np.sum(own > 1e-4 * top)]
    error = np.max(np.abs(own[own > 1e-4 * top] / expected - 1.0))
    measured(f"network {seed}: {own.size} modes, largest relative difference {error:.1e}")
    assert error < 1e-6
