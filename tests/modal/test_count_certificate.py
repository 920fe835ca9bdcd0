"""The count behind every certificate is right: against eigenvalues of the matrix."""

from dataclasses import replace

import numpy as np
from machines import ring_of, some_cable, spread, symmetric_loop
from parts import below, chain_modes

from cabledrive.mechanics.chain import Chain, Pendant
from cabledrive.mechanics.spans import longitudinal_chains
from oracles.chain_count import modes_below

RINGS = 400


def some_ring(rng):
    """A loop's chain: a third symmetric, a fifth with a flexible joint, some on springs to the ground."""
    if rng.random() < 1 / 3:
        (labelled,) = longitudinal_chains(symmetric_loop(rng, 1e4))
        return labelled.chain
    n = int(rng.integers(2, 9))
    pendant = (spread(rng, 1e2), spread(rng, 1e2)) if rng.random() < 0.2 else None
    grounds = np.where(rng.random(n) < 0.3, [spread(rng, 1e4) for _ in range(n)], 0.0)
    lengths, masses = (np.array([spread(rng, 1e4) for _ in range(n)]) for _ in range(2))
    joint, pendants = int(rng.integers(n)), ()
    if pendant is not None:
        ground = spread(rng, 1e4) if rng.random() < 0.5 else 0.0
        pendants = (Pendant(stiffness=pendant[0], mass=pendant[1], joint=joint, ground=ground),)
    return Chain(
        rigidity=1.0,
        density=1.0,
        lengths=lengths,
        masses=masses,
        closed=True,
        pendants=pendants,
        grounds=grounds if rng.random() < 0.4 else None,
    )


def test_counts_of_a_thousand_rings_agree_with_eigenvalues_of_the_matrix(measured):
    """Wittrick and Williams by elimination and by brute force, at random frequencies far up the spectrum."""
    rng = np.random.default_rng(1)
    wrong, counts = [], 0
    for number in range(RINGS):
        chain = some_ring(rng)
        for omega in 60.0 * rng.random(5) / chain.travel_times.sum():
            counted, brute = below(chain, omega), modes_below(chain, omega)
            counts += 1
            if counted != brute:
                wrong.append(f"ring {number}, omega {omega:.17g}: {counted} counted, {brute} by brute force")
    measured(f"{len(wrong)} disagreements in {counts:,} counts")
    assert not wrong, "\n".join(wrong)


def test_counts_step_by_the_multiplicity_at_every_mode_and_nowhere_else():
    """Between the modes that the solver lists, the brute-force count is the number of those below."""
    rng = np.random.default_rng(2)
    for _ in range(60):
        chain = some_ring(rng)
        modes = chain_modes(chain, 30.0 / chain.travel_times.sum())
        omegas = np.array([2 * np.pi * mode.frequency for mode in modes])
        counts = chain.rigid_body_modes + np.cumsum([mode.multiplicity for mode in modes])
        for omega, following, expected in zip(omegas, omegas[1:], counts, strict=False):
            if following - omega > 1e-8 * omega:
                middle = 0.5 * (omega + following)
                assert modes_below(chain, middle) == expected == below(chain, middle)


def test_count_at_a_mode_of_an_even_ring_does_not_depend_on_where_it_is_cut():
    """A joint at rest must not hide the mode: the count is right however the ring is numbered."""
    chain = longitudinal_chains(ring_of([0.5] * 8, [3.0] * 8, some_cable(np.random.default_rng(6))))[0].chain
    omegas = [2 * np.pi * mode.frequency for mode in chain_modes(chain, 40.0 / chain.travel_times.sum())]
    for omega in omegas:
        for turn in range(8):
            turned = replace(chain, masses=np.roll(chain.masses, turn), lengths=np.roll(chain.lengths, turn))
            for side in (1 - 1e-11, 1 + 1e-11):
                assert below(turned, omega * side) == below(chain, omega * side)
