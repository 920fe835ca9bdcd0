"""Chains that are built in Python have certified modes as drives have: one cable or several, any pendants."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

import cabledrive as cd
from cabledrive.mechanics import Chain, Pendant, longitudinal_chains
from cabledrive.modal import longitudinal_modes
from oracles.network_fem import String, natural_frequencies

DEGREE = 24


def finite_elements(chain: Chain) -> np.ndarray:
    """Natural frequencies [Hz] by the p-version of finite elements, ascending: no wave formula."""
    n = chain.masses.size
    total = n + len(chain.pendants)
    held = {joint for joint, fixed in zip((0, n - 1), chain.fixed, strict=True) if fixed}
    kept = [joint for joint in range(total) if joint not in held]
    rows, stiffness = np.eye(total), np.zeros((total, total))
    mass = np.diag([*chain.masses, *(pendant.mass for pendant in chain.pendants)])
    stiffness[range(n), range(n)] = 0.0 if chain.grounds is None else chain.grounds
    for number, pendant in enumerate(chain.pendants):
        twist = rows[n + number] - rows[pendant.joint]
        stiffness += pendant.stiffness * np.outer(twist, twist)
        stiffness[n + number, n + number] += pendant.ground
    rigidity, density = (
        np.broadcast_to(value, chain.lengths.shape) for value in (chain.rigidity, chain.density)
    )
    strings = [
        String(rows[i, kept], rows[(i + 1) % n, kept], rho * length, np.sqrt(force / rho) / length)
        for i, (length, force, rho) in enumerate(zip(chain.lengths, rigidity, density, strict=True))
    ]
    square = np.ix_(kept, kept)
    return natural_frequencies(strings, mass[square], stiffness[square], DEGREE) / (2.0 * np.pi)


def round_off(everything: np.ndarray, truth: np.ndarray) -> np.ndarray:
    """What the eigenvalue solver's round-off, relative to the largest square, is of each frequency."""
    return 2e-16 * (everything[-1] / truth) ** 2


def listed(found: cd.Modes) -> np.ndarray:
    """Frequencies [Hz], each by its multiplicity."""
    return np.repeat([mode.frequency for mode in found.modes], [mode.multiplicity for mode in found.modes])


MOTOR = Pendant(stiffness=2500.0, mass=0.4, joint=2)
LINE = Chain(
    rigidity=438.0,
    density=2.1e-4,
    lengths=np.array([0.6, 0.37, 0.47]),
    masses=np.array([0.8, 0.05, 0.2, 1.5]),
)
RING = replace(LINE, lengths=np.array([0.6, 0.37, 0.47, 0.4]), closed=True)
CABLES = {
    "rigidity": np.array([438.0, 9e4, 1.2e3]),
    "density": np.array([2.1e-4, 0.041, 6e-4]),
}
CHAINS = {
    "line": LINE,
    "between walls": replace(LINE, fixed=(True, True)),
    "springs to the ground": replace(LINE, grounds=np.array([0.0, 900.0, 0.0, 40.0])),
    "ring with a motor on a joint": replace(RING, pendants=(MOTOR,)),
    "motor on a holding spring": replace(LINE, pendants=(replace(MOTOR, joint=0, ground=300.0),)),
    "three cables": replace(LINE, **CABLES),
    "three cables, a pendant at each end": replace(
        LINE, **CABLES, pendants=(replace(MOTOR, joint=0), replace(MOTOR, joint=3, stiffness=90.0))
    ),
    "three pendants on one joint of a ring": replace(
        RING, pendants=tuple(replace(MOTOR, stiffness=k) for k in (10.0, 700.0, 2500.0))
    ),
    "pendant on a held end": replace(
        LINE, **CABLES, fixed=(True, False), pendants=(replace(MOTOR, joint=0, ground=7.0), MOTOR)
    ),
    "one string beside another between walls": replace(
        LINE,
        rigidity=np.array([7.0, 5.0]),
        density=np.array([1e-3, 2e-2]),
        lengths=np.array([0.6, 0.37]),
        masses=np.zeros(3),
        fixed=(True, True),
    ),
    "ring of two cables": replace(
        LINE,
        rigidity=np.array([400.0, 900.0]),
        lengths=np.array([0.6, 0.8]),
        masses=np.array([0.8, 0.0]),
        closed=True,
    ),
}
FREE = {
    "line",
    "ring with a motor on a joint",
    "three cables",
    "three cables, a pendant at each end",
    "three pendants on one joint of a ring",
    "ring of two cables",
}


@pytest.mark.parametrize("name", CHAINS)
def test_a_chain_has_the_frequencies_of_finite_elements(name, measured):
    found = cd.modes(CHAINS[name], count=6)
    rigid = int(name in FREE)
    frequencies = listed(found)
    everything = finite_elements(CHAINS[name])
    truth = everything[rigid : rigid + frequencies.size]
    gap = np.abs(frequencies / truth - 1.0)
    measured(f"{gap.max():.1e}")
    allowed = 1e-10 + round_off(everything, truth)
    assert np.all(gap < allowed), f"observed {gap}, allowed {allowed}"
    assert found.certified
    assert found.certificate.count == found.certificate.longitudinal == frequencies.size
    assert found.certificate.enclosure <= 1e-10
    assert found.rigid_body_modes == rigid


def random_chain(rng: np.random.Generator) -> Chain:
    """Up to six cables, their rigidities and densities a factor 30 apart; pendants and springs by chance."""
    n, closed = int(rng.integers(2, 7)), bool(rng.random() < 0.4)
    m = n if closed else n - 1
    pendants = tuple(
        Pendant(
            stiffness=spread(rng, 50.0),
            mass=spread(rng, 1.0),
            joint=int(rng.integers(n)),
            ground=spread(rng, 5.0) if rng.random() < 0.3 else 0.0,
        )
        for _ in range(int(rng.integers(0, 5)))
    )
    return Chain(
        rigidity=spread(rng, 10.0, m),
        density=spread(rng, 0.1, m),
        lengths=spread(rng, 0.5, m),
        masses=np.where(rng.random(n) < 0.3, 0.0, spread(rng, 0.2, n)),
        closed=closed,
        fixed=(False, False) if closed else (bool(rng.random() < 0.3), bool(rng.random() < 0.3)),
        pendants=pendants,
        grounds=np.where(rng.random(n) < 0.2, 3.0, 0.0),
    )


def spread(rng: np.random.Generator, middle: float, size: int | None = None):
    """Numbers about a middle, a factor of 30 from the least to the largest."""
    return middle * np.exp(rng.uniform(-1.7, 1.7, size))


def wrong_chains(seed: int, chains: int) -> tuple[list[str], int]:
    """Chains whose list differs from finite elements or is not certified, and the modes compared."""
    rng, wrong, compared = np.random.default_rng(seed), [], 0
    for number in range(chains):
        chain = random_chain(rng)
        slowest = 0.5 / np.max(chain.lengths / np.sqrt(chain.rigidity / chain.density))
        top = slowest * rng.uniform(0.5, 8.0)  # Hz: up to four waves in the slowest segment
        found, everything = cd.modes(chain, below=top), finite_elements(chain)
        truth = everything[found.rigid_body_modes :]
        expected = truth[truth < found.certificate.below]
        frequencies = listed(found)
        compared += expected.size
        if frequencies.size != expected.size or not found.certified:
            wrong.append(f"chain {number}: {frequencies.size} listed, {expected.size} expected")
        elif np.any(np.abs(frequencies / expected - 1.0) > 1e-9 + round_off(everything, expected)):
            wrong.append(f"chain {number}: off by {np.abs(frequencies / expected - 1.0).max():.1e}")
    return wrong, compared


def test_random_chains_have_the_frequencies_of_finite_elements():
    wrong, compared = wrong_chains(17, 12)
    assert compared > 60
    assert not wrong, "\n".join(wrong)


@pytest.mark.verify
def test_none_of_a_thousand_random_chains_misses_a_mode(measured):
    wrong, compared = wrong_chains(2026, 1000)
    measured(f"chains of up to six cables and four pendants: {len(wrong)} of 1,000 wrong, {compared:,} modes")
    assert not wrong, "\n".join(wrong)


def test_two_strings_of_different_impedance_meet_at_a_mass():
    """Fixed ends: Z1 cot(w t1) + Z2 cot(w t2) = w m."""
    strings = Chain(
        rigidity=np.array([40.0, 10.0]),
        density=np.array([1e-3, 4e-3]),
        lengths=np.array([0.7, 0.45]),
        masses=np.array([0.0, 2e-3, 0.0]),
        fixed=(True, True),
    )
    times, impedances = np.array([0.7 / 200.0, 0.45 / 50.0]), np.array([0.2, 0.2])

    def residual(omega: float) -> float:
        phase = omega * times
        (s, t), (c, d) = np.sin(phase), np.cos(phase)
        return float(impedances @ [c * t, d * s] - omega * 2e-3 * s * t)

    grid = np.linspace(1.0, 4000.0, 20_001)
    signs = np.sign([residual(omega) for omega in grid])
    roots = [
        brentq(residual, *grid[i : i + 2], xtol=1e-12, rtol=1e-14)
        for i in np.flatnonzero(signs[:-1] * signs[1:] < 0)
    ]
    found = cd.modes(strings, below=4000.0 / (2.0 * np.pi))
    np.testing.assert_allclose(listed(found), np.array(roots) / (2.0 * np.pi), rtol=1e-11)
    assert found.certified


def test_equal_pendants_at_both_ends_vibrate_in_and_against_phase():
    """Halves of a symmetric chain: one with its middle at rest, one with its middle free."""
    end = Pendant(stiffness=300.0, mass=0.4)
    whole = Chain(
        rigidity=438.0,
        density=2.1e-4,
        lengths=np.array([0.5, 0.5]),
        masses=np.array([0.1, 0.6, 0.1]),
        pendants=(end, replace(end, joint=2)),
    )
    half = Chain(
        rigidity=438.0, density=2.1e-4, lengths=np.array([0.5]), masses=np.array([0.1, 0.3]), pendants=(end,)
    )
    parts = [cd.modes(own, below=9000.0) for own in (half, replace(half, fixed=(False, True)))]
    expected = np.sort(np.concatenate([listed(part) for part in parts]))
    found = cd.modes(whole, below=9000.0)
    np.testing.assert_allclose(listed(found), expected, rtol=1e-11)
    assert found.certificate.count == expected.size > 8
    for mode in found.modes:
        left, right = mode.joints["pendant 0"], mode.joints["pendant 1"]
        np.testing.assert_allclose(np.abs(left), np.abs(right), rtol=1e-7, atol=1e-9)


def test_equal_pendants_on_one_joint_have_a_multiple_mode():
    """Two of three equal absorbers move against the third and leave the joint at rest: sqrt(k/m), twice."""
    own = Pendant(stiffness=90.0, mass=0.4, joint=1)
    found = cd.modes(replace(LINE, **CABLES, pendants=(own, own, own)), count=5)
    (double,) = [mode for mode in found.modes if mode.multiplicity == 2]
    assert double.frequency == pytest.approx(np.sqrt(90.0 / 0.4) / (2.0 * np.pi), rel=1e-12)
    assert np.abs(double.joints["joint 1"]).max() < 1e-9
    assert found.certified


def test_one_cable_given_for_each_segment_is_the_uniform_chain():
    uniform = CHAINS["ring with a motor on a joint"]
    given = replace(uniform, rigidity=np.full(4, 438.0), density=np.full(4, 2.1e-4))
    one, other = (cd.modes(chain, below=5000.0) for chain in (uniform, given))
    np.testing.assert_allclose(listed(other), listed(one), rtol=1e-11)
    assert one.certificate.count == other.certificate.count
    assert [mode.family for mode in one.modes] == [mode.family for mode in other.modes]
    for a, b in zip(one.modes, other.modes, strict=True):
        assert a.kinetic_shares == pytest.approx(b.kinetic_shares, abs=1e-8)


def test_numbers_may_come_as_lists():
    given = Chain(rigidity=[438.0, 9e4], density=[2.1e-4, 0.041], lengths=[0.6, 0.4], masses=[0.8, 0, 1])
    arrays = replace(
        given,
        **{name: np.array(getattr(given, name)) for name in ("rigidity", "density", "lengths", "masses")},
    )
    assert list(listed(cd.modes(given, count=4))) == list(listed(cd.modes(arrays, count=4)))


def test_a_wall_to_wall_string_and_a_ring_of_one_segment_have_their_harmonics():
    """No coordinate moves, or one that some modes leave at rest: n c / (2 l)."""
    wall = Chain(rigidity=[4.0], density=[1.0], lengths=[0.5], masses=[0.0, 0.0], fixed=(True, True))
    np.testing.assert_allclose(listed(cd.modes(wall, count=5)), 2.0 * np.arange(1, 6), rtol=1e-12)
    ring = Chain(rigidity=[4.0], density=[1.0], lengths=[0.5], masses=[0.0], closed=True)
    found = cd.modes(ring, below=13.0)
    assert [mode.multiplicity for mode in found.modes] == [2, 2, 2]
    np.testing.assert_allclose([mode.frequency for mode in found.modes], [4.0, 8.0, 12.0], rtol=1e-12)
    assert found.rigid_body_modes == 1


@pytest.mark.parametrize("name", ["dissertation-2", "dissertation-3"])
def test_the_chain_of_a_drive_has_its_longitudinal_modes(name):
    drive = cd.load_drive(name)
    (chain,) = longitudinal_chains(drive)
    of_drive = [(mode.frequency, mode.multiplicity) for mode in longitudinal_modes(drive, below=2000.0)]
    of_chain = [(mode.frequency, mode.multiplicity) for mode in cd.modes(chain.chain, below=2000.0).modes]
    np.testing.assert_allclose(of_chain, of_drive, rtol=1e-13)


def test_shapes_are_named_by_joint_pendant_and_segment():
    chain = CHAINS["three cables, a pendant at each end"]
    names = ("joint 0", "joint 1", "joint 2", "joint 3", "pendant 0", "pendant 1")
    for mode in cd.modes(chain, count=12).modes:
        assert mode.joint_names == names
        for number, length in enumerate(chain.lengths):
            ends = mode.shape(f"segment {number}", [0.0, length])[0]
            joints = [mode.joints[f"joint {own}"][0] for own in (number, number + 1)]
            np.testing.assert_allclose(ends, joints, rtol=1e-9, atol=1e-9)
        assert sum(mode.kinetic_shares.values()) == pytest.approx(1.0)


def test_forces_of_two_cables_balance_at_their_joint():
    """R u' jumps by -omega^2 m u: the slopes of each side come from its own wave number."""
    chain = CHAINS["three cables"]
    for mode in cd.modes(chain, count=12).modes:
        before, after = (float(slope[0]) for slope in mode.slopes_at("joint 1"))
        pull = CABLES["rigidity"][1] * after - CABLES["rigidity"][0] * before
        omega = 2.0 * np.pi * mode.frequency
        inertia = -(omega**2) * 0.05 * float(mode.joints["joint 1"][0])
        assert pull == pytest.approx(inertia, rel=1e-6, abs=1e-6 * abs(CABLES["rigidity"][1] * after))


def test_a_soft_spring_names_the_mode_that_it_holds():
    found = cd.modes(CHAINS["springs to the ground"], count=1).modes[0]
    assert found.family == "spring to the ground"
    soft = replace(LINE, **CABLES, pendants=(Pendant(stiffness=1e-3, mass=0.4), MOTOR))
    assert cd.modes(soft, count=1).modes[0].family == "spring of pendant 0"


@pytest.mark.parametrize("choice", [{"motor": "held"}, {"hold": ["joint 0"]}, {"at_torque": 1.0}])
def test_what_is_about_drives_is_refused(choice):
    with pytest.raises(cd.InputRefused, match="about drives"):
        cd.modes(LINE, count=1, **choice)


@pytest.mark.parametrize(
    ("change", "parts"),
    [
        ({"rigidity": np.array([1.0, -3.0, 1.0])}, ("segment 1", "rigidity", "-3 N", "positive")),
        ({"density": np.array([1.0, 2.0])}, ("density", "2 values", "3 segments")),
        ({"lengths": np.array([0.1, np.nan, 0.1])}, ("segment 1", "length", "nan m", "finite")),
        ({"grounds": np.array([0.0, 0.0, -1.0, 0.0])}, ("joint 2", "grounds", "-1 N/m")),
        ({"pendants": (replace(MOTOR, joint=4),)}, ("pendant 0", "joint = 4", "0 to 3")),
        ({"pendants": (MOTOR, replace(MOTOR, mass=0.0))}, ("pendant 1", "mass", "0 kg", "positive")),
    ],
)
def test_what_no_chain_can_have_is_refused(change, parts):
    with pytest.raises(cd.InputRefused) as refusal:
        cd.modes(replace(LINE, **change), count=1)
    assert all(part in str(refusal.value) for part in parts), refusal.value
