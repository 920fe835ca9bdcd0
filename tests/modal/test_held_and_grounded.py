"""Modes against finite elements that know no wave: rotor free, held or on its holding stiffness."""

from dataclasses import replace

import numpy as np
import pytest
from machines import (
    below,
    by_multiplicity,
    machine,
    ring_of,
    some_cable,
    spread,
    symmetric_loop,
    uneven_machine,
)

import cabledrive as cd
from cabledrive.mechanics.chain import Chain, Pendant
from cabledrive.mechanics.spans import longitudinal_chains
from cabledrive.parameters.route.two_pulleys import NAMES
from network_samples import as_routes
from oracles import hanging_machine
from oracles.network_fem import modes_below
from oracles.route_fem import Kinematics

AGREEMENT, MODES = 1e-8, 12
CONDITIONS = ("free", "held", "holding")
OF_EACH_WAY = {0, 1, 2, 7, 18, 24, 43, 49, 64, 68, 89, 90}
"""Machines without a motor, with a rigid joint or a flexible one, free, held and on a holding stiffness."""
QUICK = pytest.mark.parametrize(
    "seed",
    [
        pytest.param(n, marks=() if n in OF_EACH_WAY else pytest.mark.verify, id=f"machine-{n}")
        for n in range(100)
    ],
)


def drawn(rng):
    """A machine that has a motor and, half of the time, a holding stiffness; and what is held of it."""
    while True:
        drive = machine(rng, contrast=100.0)
        if not drive.drive_pulley.fixed:
            break
    if drive.motor is not None and rng.random() < 0.7:
        stiffness = drive.cable.axial_rigidity / drive.span_length * spread(rng, 1e4)
        holding = stiffness * drive.drive_pulley.radius**2
        drive = replace(drive, motor=replace(drive.motor, holding_stiffness=holding))
    sprung = drive.motor is not None and drive.motor.holding_stiffness is not None
    motor = rng.choice(CONDITIONS[: 3 if sprung else 2])
    parts = ["drive pulley", "load pulley", *(f"carriage {n}" for n in range(len(drive.carriage)))]
    hold = [part for part in parts if rng.random() < 0.6 / len(parts)]
    return drive, str(motor), hold


def elements(drive, motor, hold):
    """Frequencies along the ropes by finite elements [Hz], without a rigid-body mode."""
    rotor = drive.motor
    if rotor and motor != "holding":
        rotor = replace(rotor, holding_stiffness=None)
    drive = as_routes(replace(drive, motor=rotor))
    kin, held = Kinematics(drive), {"motor"} if motor == "held" else set()
    names = {name: kin.turns(name) for name in kin.turning}
    names |= {"motor": kin.rotors[0] if kin.rotors else kin.turns(NAMES[0])}
    names |= {f"carriage {i}": kin.size + 3 * i for i in range(len(drive.carriage))}
    at_rest = [names[name] for name in held | set(hold) if name in names]
    free = not at_rest and not (rotor and rotor.holding_stiffness) and len(kin.turning) == 2
    return straight(drive, (0,), at_rest)[1 if free else 0 :]


def straight(drive, ways, held=()):
    """Frequencies of a machine without gravity in some ways [Hz]."""
    return hanging_machine.frequencies(drive, ways=[ways], held=held, degree=46)[0]


@QUICK
def test_modes_agree_with_elements_however_the_machine_is_held(seed, measured):
    drive, motor, hold = drawn(np.random.default_rng(seed))
    found = cd.modes(drive, count=MODES, motor=motor, hold=hold)
    assert found.certified
    check_agreement(by_multiplicity(found.longitudinal), elements(drive, motor, hold), measured)


def check_agreement(listed, truth, measured):
    error = np.abs(listed[:MODES] / truth[:MODES] - 1.0)
    measured(f"relative error {error.max():.1e} in {error.size} modes")
    assert error.size == MODES
    assert error.max() <= AGREEMENT, f"relative error {error.max():.2e} of mode {np.argmax(error) + 1}"


@QUICK
def test_transverse_modes_agree_with_elements(seed, measured):
    """Strings between supports, hanging carriages as point masses, guided ones as supports; both planes."""
    rng = np.random.default_rng(seed)
    drive = uneven_machine(rng, contrast=100.0)
    carriages = tuple(replace(c, guided=bool(rng.random() < 0.3)) for c in drive.carriage)
    drive = replace(drive, carriage=carriages)
    modes = cd.modes(drive, count=2 * MODES)
    planes = {p: np.array([m.frequency for m in modes.transverse if m.plane == p]) for p in "vw"}
    np.testing.assert_array_equal(planes["v"], planes["w"])
    check_agreement(planes["v"], straight(as_routes(drive), (2,)), measured)


def check_counts(chains, phases, measured):
    """Counts at frequencies drawn over each chain's travel time, against eigenvalues of its matrix."""
    wrong, counts = [], 0
    for number, chain in enumerate(chains):
        for omega in phases() / chain.travel_times.sum():
            counts += 1
            counted, brute = below(chain, omega), modes_below(chain, omega)
            if counted != brute:
                wrong.append(f"chain {number}, omega {omega:.17g}: {counted} counted, {brute} by brute force")
    measured(f"{len(wrong)} disagreements in {counts:,} counts")
    assert not wrong, "\n".join(wrong)


def test_counts_with_grounds_and_fixed_pulleys_agree_with_the_matrix(measured):
    """On the chains of 200 machines, with motors of all kinds, a quarter with a load pulley that is fixed."""
    rng, chains = np.random.default_rng(3), []
    for _ in range(200):
        drive, _, hold = drawn(rng)
        load = replace(drive.load_pulley, fixed=drive.load_pulley.fixed or "load pulley" in hold)
        drive = replace(drive, pulley=(drive.drive_pulley, load))
        chains += [labelled.chain for labelled in longitudinal_chains(drive)]
    check_counts(chains, lambda: 40.0 * rng.random(8), measured)


def test_default_is_holding_where_the_file_has_the_stiffness():
    bare = cd.load_drive("linear-axis").listed
    sprung = cd.load_drive("linear-axis", overrides=["motor.holding_stiffness=100"]).listed
    assert (cd.modes(bare, count=1).motor, cd.modes(sprung, count=1).motor) == ("free", "holding")
    free = cd.natural_frequencies(sprung, count=3, motor="free")
    assert free == pytest.approx(cd.natural_frequencies(bare, count=3), rel=1e-15)


def test_held_carriage_parts_the_transverse_motion_too():
    drive = cd.load_drive("elevator").listed
    hanging = replace(drive, carriage=tuple(replace(c, guided=False) for c in drive.carriage))
    guided = replace(drive, carriage=tuple(replace(c, guided=True) for c in drive.carriage))
    found = [m.frequency for m in cd.modes(hanging, count=6, hold=["carriage 0", "carriage 1"]).transverse]
    assert found == pytest.approx([m.frequency for m in cd.modes(guided, count=6).transverse], rel=1e-12)


# --- The count behind every certificate is right: against eigenvalues of the matrix
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
    check_counts((some_ring(rng) for _ in range(RINGS)), lambda: 60.0 * rng.random(5), measured)


def test_count_at_a_mode_of_an_even_ring_does_not_depend_on_where_it_is_cut():
    """A joint at rest must not hide the mode: the count is right however the ring is numbered."""
    chain = longitudinal_chains(ring_of([0.5] * 8, [3.0] * 8, some_cable(np.random.default_rng(6))))[0].chain
    found = cd.modes(chain, below=20.0 / np.pi / chain.travel_times.sum()).modes
    omegas = [2 * np.pi * mode.frequency for mode in found]
    for omega in omegas:
        for turn in range(8):
            turned = replace(chain, masses=np.roll(chain.masses, turn), lengths=np.roll(chain.lengths, turn))
            for side in (1 - 1e-11, 1 + 1e-11):
                assert below(turned, omega * side) == below(chain, omega * side)
