"""The natural frequencies agree with forty-digit roots of transfer matrices, multiplicities included."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from machines import distinct, machine, ring_of, some_cable, symmetric_loop, uneven_machine
from mpmath import mp, mpf
from transfer_roots import ExactChain, angle, discriminant, exact_chains, exact_roots, winding_number

import cabledrive as cd
from cabledrive.mechanics.chain import Chain, own_chain
from cabledrive.modal.networks import network_of_chain
from cabledrive.modal.rows import counted, lanes_at

MODES = 12
SIMPLE, MULTIPLE = 1e-12, 1e-9
APART, ONE = 5e-10, 2e-11  # relative distances: two modes from here on, one mode up to here
MACHINES = [
    pytest.param(seed, marks=() if seed % 40 == 0 else pytest.mark.verify, id=f"machine-{seed}")
    for seed in range(200)
]


def check_against(roots, modes, measured):
    """Every root is listed once, with its multiplicity, as exactly as claimed; returns the multiple ones."""
    multiplicities = [mode.multiplicity for mode in modes.longitudinal]
    spread = [
        2 * mp.pi * mpf(mode.frequency) for mode in modes.longitudinal for _ in range(mode.multiplicity)
    ]
    found = []
    for number, (omega, root) in enumerate(zip(spread[:MODES], roots, strict=False)):
        others = [abs(root - other) / root for k, other in enumerate(roots) if k != number]
        found.append((SIMPLE if min(others) > APART else MULTIPLE, float(abs(omega / root - 1))))
    measured("largest relative error " + " and ".join(largest(found)))
    assert len(spread) >= MODES
    for number, (claim, error) in enumerate(found):
        assert error <= claim, f"mode {number + 1}: relative error {error:.2e}, claimed {claim}"
    if not any(ONE < (b - a) / b < APART for a, b in pairwise(roots)):  # clearly one mode or clearly two
        sizes = [len(group) for group in distinct(roots, ONE)]
        complete = [size for size, total in zip(sizes, np.cumsum(sizes), strict=True) if total <= MODES]
        assert multiplicities[: len(complete)] == complete, f"{multiplicities} listed, {sizes} exact"
    return sum(m > 1 for m in multiplicities)


def largest(found):
    """Largest error at the simple and at the multiple roots, where there are any, in words."""
    for kind, claim in (("simple", SIMPLE), ("multiple", MULTIPLE)):
        errors = [error for claimed, error in found if claimed == claim]
        if errors:
            yield f"{max(errors):.1e} at {len(errors)} {kind} roots"


@pytest.mark.parametrize("seed", MACHINES)
def test_first_twelve_modes_agree_with_forty_digit_roots(seed, measured):
    """Loops and lines, held ends, flexible joints, contrasts up to 1e6, symmetric loops."""
    drive = machine(np.random.default_rng(seed))
    modes = cd.modes(drive, count=MODES)
    assert modes.certified
    check_against(exact_roots(drive, MODES + 1), modes, measured)


@pytest.mark.parametrize("seed", range(4))
def test_evenly_loaded_rings_have_exact_double_modes(seed, measured):
    """Equal masses at equal distances, both pulleys among them: every wave runs both ways round."""
    rng = np.random.default_rng(seed)
    parts = 2 ** rng.integers(2, 4)
    drive = ring_of([0.5] * int(parts), [10 ** rng.uniform(-3, 3)] * int(parts), some_cable(rng))
    found = check_against(exact_roots(drive, MODES + 1), cd.modes(drive, count=MODES), measured)
    assert found >= 3, f"{found} double modes among the first {MODES}"


@pytest.mark.parametrize("seed", MACHINES[:20:5] + MACHINES[1:20:5])
def test_reference_holds_as_many_roots_as_the_argument_principle_counts(seed, measured):
    """The reference itself loses no root: the discriminant winds as often round zero as it lists roots."""
    rng = np.random.default_rng(seed)
    drive = symmetric_loop(rng, 10.0) if seed % 2 else uneven_machine(rng, 10.0)
    while drive.kind != "loop" or any(p.fixed for p in drive.pulley):
        drive = uneven_machine(rng, 10.0)
    roots = exact_roots(drive, MODES + 1)
    gaps = [(b - a) / b for a, b in pairwise(roots)]
    last = max(k for k, gap in enumerate(gaps) if gap > 1e-3)
    (chain,) = exact_chains(drive)
    turns = winding_number(chain, roots[0] / 2, (roots[last] + roots[last + 1]) / 2)
    measured(f"{last + 1} roots listed, {turns} counted")
    assert turns == last + 1


# --- Strings of a thousand carriages: what round-off leaves of frequencies and counts, against sixty digits
CARRIAGES = 1000
FIRST = 12


def chain(closed, seed, carriages=CARRIAGES):
    """Lengths and masses spread over one decade and two, the carriages between two pulleys."""
    rng = np.random.default_rng(seed)
    joints = carriages + 2
    return Chain(
        rigidity=2.3,
        density=0.7,
        lengths=rng.uniform(0.2, 1.8, joints if closed else joints - 1),
        masses=rng.uniform(0.1, 10.0, joints),
        closed=closed,
    )


def first_modes(given):
    component = component_of(given)
    top = np.pi / given.travel_times.sum()
    while component.count(top) < FIRST:
        top *= 1.5
    return [own for _, own in component.modes(0.0, top)][:FIRST]


def component_of(given):
    (component,), _ = network_of_chain(own_chain(given)).components()
    return component


def condition(given, number):
    """What vanishes at a natural frequency, by transfer matrices in the digits in use."""
    lengths, masses = ([mp.mpf(float(x)) for x in array] for array in (given.lengths, given.masses))
    rigidity, density = mp.mpf(given.rigidity), mp.mpf(given.density)
    speed, impedance = mp.sqrt(rigidity / density), mp.sqrt(rigidity * density)
    exact = ExactChain([x / speed for x in lengths], [m / impedance for m in masses], given.closed)
    if given.closed:
        return lambda omega: discriminant(exact, omega)
    return lambda omega: angle(exact, omega) - (number + 0.5) * mp.pi


def refined(value, omega):
    """Secant steps from the double's value."""
    a, b = mp.mpf(omega) * (1 + mp.mpf(10) ** -11), mp.mpf(omega)
    fa, fb = value(a), value(b)
    for _ in range(4):
        a, fa, b = b, fb, b - fb * (b - a) / (fb - fa)
        if abs(b - a) < mp.mpf(10) ** -25 * b:
            break
        fb = value(b)
    return b


@pytest.mark.parametrize("closed", [False, True], ids=["line", "ring"])
@pytest.mark.parametrize("carriages", [CARRIAGES, pytest.param(10 * CARRIAGES, marks=pytest.mark.verify)])
def test_frequencies_of_thousands_of_carriages_are_right_to_the_last_digits(carriages, closed, measured):
    """Low modes of a long chain lose nothing: nothing large cancels in the form of links and grounds."""
    given = chain(closed, 0, carriages)
    modes = first_modes(given)
    with mp.workdps(60):
        ends = [(1, modes[0].omega), (len(modes), modes[-1].omega)]
        errors = [float(abs(omega / refined(condition(given, n), omega) - 1)) for n, omega in ends]
    measured(f"relative error {errors[0]:.1e} of the first mode, {errors[1]:.1e} of mode {len(modes)}")
    for error in errors:
        assert error < 2e-14, f"relative error {error:.1e}"


@pytest.mark.parametrize(("closed", "clear"), [(False, 1e-12), (True, 2e-12)])
def test_count_of_a_thousand_carriages_is_right_so_close_to_a_mode(closed, clear, measured):
    """On either side of each mode, as close as the enclosure; a band holds sums of links and grounds."""
    wrong, counts = [], 0
    given = chain(closed, 0)
    component, below = component_of(given), 1
    for mode in first_modes(given):
        assert mode.enclosure is not None
        for distance in np.geomspace(clear, 1e-9, 9):
            at = lanes_at([mode.omega * (1 - distance), mode.omega * (1 + distance)])
            sides = tuple(counted(component.cut(2 * mode.omega).table, at))
            counts += 2
            if sides != (below, below + mode.multiplicity):
                wrong.append(f"{sides} at {distance:.1e} of {mode.omega}")
        below += mode.multiplicity
    measured(f"{len(wrong)} wrong of {counts} counts as close as {clear:.0e}")
    assert not wrong, "\n".join(wrong)


# --- Double modes, pairs split by little, and modes where a span is infinitely stiff
SPLITS = [1e-3, 1e-6, 1e-8]


def even_ring(detuning):
    """Equal masses at equal distances on a loop; one carriage heavier by a share."""
    cable = some_cable(np.random.default_rng(0))
    mass = 0.7 * cable.mass_per_length
    masses = [mass] * 4
    masses[1] *= 1.0 + detuning
    return ring_of([0.5] * 4, masses, cable)


def longitudinal(drive, count):
    modes = cd.modes(drive, count=count)
    assert modes.certified
    return modes.longitudinal


@pytest.mark.parametrize("split", SPLITS)
def test_pairs_split_by_a_small_share_are_two_modes(split, measured):
    """A detuned mass parts each pair; both are listed, each as exactly as any simple mode."""
    drive = even_ring(detuning=8.0 * split)
    listed = longitudinal(drive, 9)
    roots = [float(root) / (2 * np.pi) for root in exact_roots(drive, 9)]
    error = max(abs(mode.frequency / root - 1.0) for mode, root in zip(listed, roots, strict=False))
    measured(f"{len(listed)} modes in {len(roots)}, relative error {error:.1e}")
    assert [mode.multiplicity for mode in listed] == [1] * 9
    parted = (roots[1] - roots[0]) / roots[0]
    assert 0.1 * split < parted < 10 * split, f"split by {parted:.1e}"
    np.testing.assert_allclose([mode.frequency for mode in listed], roots, rtol=1e-12)


def test_pair_closer_than_its_claim_is_one_mode_of_multiplicity_two(measured):
    """Below 1e-10, relative, round-off may look like a split."""
    listed = longitudinal(even_ring(detuning=1e-13), 3)
    measured(f"multiplicity {listed[0].multiplicity}")
    assert listed[0].multiplicity == 2


def test_modes_at_the_poles_of_the_span_stiffness_are_found(measured):
    """sin(omega L/c) = 0 for both spans at once: the stiffness of a span is infinite, the mode is not."""
    errors = []
    for seed in range(20):
        rng = np.random.default_rng(seed)
        cable = some_cable(rng)
        drive = ring_of([1.0, 1.0], (10 ** rng.uniform(-3, 3, 2)).tolist(), cable)
        half_wave = np.sqrt(cable.axial_rigidity / cable.mass_per_length) / 2
        listed = np.array([mode.frequency for mode in longitudinal(drive, 12)])
        errors.append(max(np.min(np.abs(listed / (n * half_wave) - 1)) for n in range(1, 5)))
    measured(f"relative error {max(errors):.1e}")
    assert max(errors) < 1e-14


def test_pendant_tuned_to_the_mode_of_resting_pulleys_leaves_it_where_it_was(measured):
    """Motor and joint ring at the same frequency: a pole of the span meets the pole of the pendant."""
    drive = cd.load_drive("dissertation-1").listed
    half_wave = 2 * np.pi * cd.natural_frequencies(drive, count=2, taut=True)[1]
    motor = cd.Motor(inertia=1e-6, joint_stiffness=float(1e-6 * half_wave**2))
    tuned = replace(drive, motor=motor)
    listed = cd.natural_frequencies(tuned, count=5, taut=True)
    layout = replace(drive.layout, span_length=drive.span_length, pulley_distance=None)  # for the reference
    roots = [float(root) / (2 * np.pi) for root in exact_roots(replace(tuned, layout=layout), 5)]
    measured(f"relative error {np.max(np.abs(listed / roots - 1.0)):.1e}")
    np.testing.assert_allclose(listed, roots, rtol=1e-12)
    assert np.min(np.abs(2 * np.pi * listed / half_wave - 1)) < 1e-14
