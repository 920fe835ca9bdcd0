"""The count behind every certificate is right: against eigenvalues of the matrix, and kernel by kernel."""

from dataclasses import replace

import numpy as np
import pytest
from machines import machine, ring_of, some_cable, spread, symmetric_loop

from cabledrive.mechanics.chain import Chain, Pendant
from cabledrive.mechanics.compiled import njit_strict
from cabledrive.mechanics.spans import longitudinal_chains
from cabledrive.modal import counting, counting_kernels, polish, refinement
from cabledrive.modal.counting import ModeCounter, modes_below_reference
from cabledrive.modal.solver import chain_modes

RINGS = 1000


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
        counter = ModeCounter(chain)
        for omega in 60.0 * rng.random(5) / chain.travel_times.sum():
            counted, brute = counter(omega), modes_below_reference(chain, omega)
            counts += 1
            if counted != brute:
                wrong.append(f"ring {number}, omega {omega:.17g}: {counted} counted, {brute} by brute force")
    measured(f"{len(wrong)} disagreements in {counts:,} counts")
    assert not wrong, "\n".join(wrong)


@pytest.mark.parametrize("cut", range(5))
def test_every_place_a_ring_can_be_cut_at_gives_the_same_count(cut):
    """With a pendant on any joint; clear of modes no cut is preferred."""
    rng = np.random.default_rng(7)
    for _ in range(100):
        chain = some_ring(rng)
        counter = ModeCounter(chain)
        for omega in 40.0 * rng.random(4) / chain.travel_times.sum():
            counter._clear_cut = cut
            assert counter(omega) == modes_below_reference(chain, omega)


def test_counts_step_by_the_multiplicity_at_every_mode_and_nowhere_else():
    """Between the modes that the solver lists, the brute-force count is the number of those below."""
    rng = np.random.default_rng(2)
    for _ in range(60):
        chain = some_ring(rng)
        modes = chain_modes(chain, 30.0 / chain.travel_times.sum())
        omegas = np.array([mode.omega for mode in modes])
        below = chain.rigid_body_modes + np.cumsum([mode.multiplicity for mode in modes])
        for omega, following, expected in zip(omegas, omegas[1:], below, strict=False):
            if following - omega > 1e-8 * omega:
                middle = 0.5 * (omega + following)
                assert modes_below_reference(chain, middle) == expected == ModeCounter(chain)(middle)


def test_count_grows_with_frequency_and_as_weyl_predicts():
    """Weyl: omega T/pi modes below omega, T a wave's time round; each mass shifts that by at most one."""
    rng = np.random.default_rng(3)
    for _ in range(200):
        chain = some_ring(rng)
        counter, total = ModeCounter(chain), chain.travel_times.sum()
        omegas = np.sort(200.0 * rng.random(20) / total)
        counts = np.array([counter(omega) for omega in omegas])
        assert np.all(np.diff(counts) >= 0)
        room = chain.masses.size + len(chain.pendants) + 1
        assert np.all(np.abs(counts - omegas * total / np.pi) <= room)


@pytest.mark.kernel
@pytest.mark.parametrize("fixed", [(False, False), (True, False), (False, True), (True, True)])
def test_kernel_of_lines_counts_alike_compiled_and_not(fixed, measured):
    """`cabledrive.modal.counting` runs count_line as Python on lists, as machine code on arrays."""
    compiled, pairs = njit_strict(counting_kernels.count_line), []
    for arguments in line_arguments(np.random.default_rng(4), fixed):
        omega, times, masses, springs, *rest = arguments
        lists = times.tolist(), masses.tolist(), springs.tolist()
        plain = counting_kernels.count_line(omega, *lists, *rest)
        pairs.append((compiled(*arguments), plain))
    measured(f"{sum(a != b for a, b in pairs)} of {len(pairs)} counts differ")
    for counted, plain in pairs:
        assert counted == plain


@pytest.mark.kernel
def test_kernel_of_rings_counts_alike_compiled_and_not(measured):
    """The same for count_ring; its margin may differ by the round-off of another tangent."""
    compiled, pairs = njit_strict(counting_kernels.count_ring), []
    for *start, _, _ in line_arguments(np.random.default_rng(5), (False, False)):
        omega, times, masses, springs, *rest = start
        masses, springs = masses[:-1], springs[:-1]
        lists = times.tolist(), masses.tolist(), springs.tolist()
        plain = counting_kernels.count_ring(omega, *lists, *rest, 2)
        pairs.append((compiled(omega, times, masses, springs, *rest, 2), plain))
    measured(f"{sum(a[0] != b[0] for a, b in pairs)} of {len(pairs)} counts differ")
    for (fast, fast_margin), (count, margin) in pairs:
        assert fast == count
        assert fast_margin == pytest.approx(margin, rel=1e-6, abs=1e-9)


def line_arguments(rng, fixed):
    for _ in range(50):
        n = int(rng.integers(4, 12))
        times, masses = np.array([[spread(rng, 1e3) for _ in range(n)] for _ in range(2)])
        springs = np.where(rng.random(n) < 0.3, [spread(rng, 1e3) for _ in range(n)], 0.0)
        pendant = (1.0, 1.0, float(rng.random() < 0.5), 2) if rng.random() < 0.5 else (0.0, 0.0, 0.0, 0)
        yield 40.0 * rng.random() / times.sum(), times[:-1], masses, springs, 1.0, *pendant, *fixed


@pytest.mark.kernel
@pytest.mark.parametrize("seed", range(3))
def test_long_chains_in_machine_code_have_the_modes_of_the_general_solver(seed, monkeypatch, measured):
    """`cabledrive.modal.polish` compiles inverse iteration, `cabledrive.modal.counting` the count.

    The general solver is LAPACK's elimination with exchange of rows; its counts run as Python here.
    """
    rng = np.random.default_rng(seed)
    chain = long_chain(rng, closed=seed < 2, pendant=seed > 0)
    top = 40.0 / chain.travel_times.sum()
    fast = chain_modes(chain, top)
    for module in (counting, polish):
        monkeypatch.setattr(module, "LONG_CHAIN", 10**9)
    plain = chain_modes(chain, top)
    monkeypatch.setattr(refinement, "polished", lambda *arguments: None)
    general = chain_modes(chain, top)
    pairs = [pair for other in (plain, general) for pair in zip(fast, other, strict=False)]
    apart = max(abs(a.omega / b.omega - 1.0) for a, b in pairs)
    measured(f"{len(fast)} frequencies within {apart:.1e}, relative")
    assert len(fast) > 10
    for other in (plain, general):
        check_alike(fast, other)


def check_alike(some, others):
    assert [mode.multiplicity for mode in some] == [mode.multiplicity for mode in others]
    for a, b in zip(some, others, strict=True):
        assert abs(a.omega / b.omega - 1.0) <= 1e-13, f"relative difference {a.omega / b.omega - 1.0:.1e}"
        overlap = np.sum(a.shapes * b.shapes) / np.linalg.norm(a.shapes) / np.linalg.norm(b.shapes)
        assert abs(overlap) == pytest.approx(1.0, abs=1e-9)
        assert np.linalg.norm(a.shapes) == pytest.approx(np.linalg.norm(b.shapes), rel=1e-9)


@pytest.mark.parametrize("seed", range(10))
def test_short_chains_have_the_modes_of_the_general_solver(seed, monkeypatch):
    """Elimination from joint to joint gives way to LAPACK's where it would lose digits, and changes none."""
    chain = some_ring(np.random.default_rng(seed))
    fast = chain_modes(chain, 30.0 / chain.travel_times.sum())
    monkeypatch.setattr(refinement, "polished", lambda *arguments: None)
    check_frequencies(fast, chain_modes(chain, 30.0 / chain.travel_times.sum()))


def check_frequencies(some, others):
    assert [mode.multiplicity for mode in some] == [mode.multiplicity for mode in others]
    np.testing.assert_allclose([m.omega for m in some], [m.omega for m in others], rtol=1e-12)


def long_chain(rng, closed, pendant):
    n = polish.LONG_CHAIN + 50
    return Chain(
        rigidity=1.0,
        density=1.0,
        lengths=np.array([spread(rng, 10.0) for _ in range(n if closed else n - 1)]),
        masses=np.array([spread(rng, 100.0) for _ in range(n)]),
        closed=closed,
        fixed=(False, False) if closed else (False, True),
        pendants=(Pendant(stiffness=0.05, mass=20.0),) if pendant else (),
    )


def test_count_at_a_mode_of_an_even_ring_does_not_depend_on_where_it_is_cut():
    """A joint at rest must not hide the mode: the count is right however the ring is numbered."""
    chain = longitudinal_chains(ring_of([0.5] * 8, [3.0] * 8, some_cable(np.random.default_rng(6))))[0].chain
    omegas = [mode.omega for mode in chain_modes(chain, 40.0 / chain.travel_times.sum())]
    for omega in omegas:
        for turn in range(8):
            turned = replace(chain, masses=np.roll(chain.masses, turn), lengths=np.roll(chain.lengths, turn))
            for side in (1 - 1e-11, 1 + 1e-11):
                assert ModeCounter(turned)(omega * side) == ModeCounter(chain)(omega * side)


def test_chains_of_drawn_machines_have_a_count_of_zero_at_rest():
    for seed in range(20):
        for labelled in longitudinal_chains(machine(np.random.default_rng(seed))):
            assert ModeCounter(labelled.chain)(0.0) == 0
            tiny = 1e-9 / labelled.chain.travel_times.sum()
            assert ModeCounter(labelled.chain)(tiny) <= labelled.chain.rigid_body_modes
