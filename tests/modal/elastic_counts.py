"""Counts of random networks with elements beside those of finite elements."""

import numpy as np
from parts import alone

from oracles.beam_fem import frequencies
from oracles.network_fem import matrices

DEGREE = 26


def wrong_counts(seed, networks, sample, with_parts):
    """Counts at eight frequencies of each random network that differ from the oracle's; and how many.

    ``sample``: makes a network from a generator; ``with_parts``: adds its elements, given mass, stiffness,
    elements and the number of coordinates, to the matrices of its strings.
    """
    rng, wrong, made = np.random.default_rng(seed), 0, 0
    for _ in range(networks):
        component, strings, parts, mass, spring, others = sample(rng)
        coordinates = mass.shape[0]
        mass, _, spring = matrices(strings, mass, spring, DEGREE)
        mass, spring = with_parts(mass, spring, parts, coordinates)
        speeds = [np.sqrt(min(part.tension) / part.density) / part.length for part in parts]
        top = min([*speeds, *(string.wave_speed for string in strings)]) * DEGREE / 2.4
        truth = frequencies(mass, spring, top)
        held = [(alone(rope), rope.ropes - 1) for rope in component.ropes]
        for omega in rng.uniform(0.05, 1.0, 8) * top:
            if np.min(np.abs(truth - omega)) < 1e-4 * omega:  # closer than the oracle knows its frequencies
                continue
            own = (
                component.count(omega)
                + component.rigid
                + int(others @ np.floor(omega * component.time / np.pi))
            )
            own += sum(ropes * one.count(omega) for one, ropes in held)
            wrong += own != int(np.sum(truth < omega))
            made += 1
    return wrong, made
