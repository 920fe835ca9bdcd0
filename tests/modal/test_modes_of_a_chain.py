"""Chains that are built in Python have certified modes as drives have."""

from itertools import pairwise

import numpy as np
import pytest

import cabledrive as cd
from cabledrive.mechanics import Chain, longitudinal_chains


def finite_elements(chain: Chain, parts: int, count: int) -> np.ndarray:
    """Lowest frequencies [Hz] by linear elements with consistent masses: too high, by order two."""
    n = chain.masses.size
    total = n + sum(parts - 1 for _ in chain.lengths)
    pendant = chain.pendant is not None
    stiffness, mass = np.zeros((2, total + pendant, total + pendant))
    fresh = n
    for i, length in enumerate(chain.lengths):
        nodes = [i, *range(fresh, fresh + parts - 1), (i + 1) % n]
        fresh += parts - 1
        h = length / parts
        for a, b in pairwise(nodes):
            place = np.ix_([a, b], [a, b])
            stiffness[place] += chain.rigidity / h * np.array([[1.0, -1.0], [-1.0, 1.0]])
            mass[place] += chain.density * h / 6.0 * np.array([[2.0, 1.0], [1.0, 2.0]])
    mass[np.arange(n), np.arange(n)] += chain.masses
    stiffness[np.arange(n), np.arange(n)] += chain.ground_springs
    if pendant:
        k, m = chain.pendant
        place = np.ix_([chain.pendant_joint, total], [chain.pendant_joint, total])
        stiffness[place] += k * np.array([[1.0, -1.0], [-1.0, 1.0]])
        stiffness[total, total] += chain.pendant_ground
        mass[total, total] += m
    held = [j for j, fixed in zip((0, n - 1), chain.fixed, strict=True) if fixed]
    kept = np.setdiff1d(np.arange(total + pendant), held)
    root = np.linalg.inv(np.linalg.cholesky(mass[np.ix_(kept, kept)]))
    squares = np.linalg.eigvalsh(root @ stiffness[np.ix_(kept, kept)] @ root.T)
    rigid = 0 if held or chain.ground_springs.any() or chain.pendant_ground > 0.0 else 1
    return np.sqrt(squares[rigid : rigid + count]) / (2.0 * np.pi)


LINE = {
    "rigidity": 438.0,
    "density": 2.1e-4,
    "lengths": np.array([0.6, 0.37, 0.47]),
    "masses": np.array([0.8, 0.05, 0.2, 1.5]),
}
CHAINS = {
    "line": Chain(**LINE),
    "between walls": Chain(**LINE, fixed=(True, True)),
    "springs to the ground": Chain(**LINE, grounds=np.array([0.0, 900.0, 0.0, 40.0])),
    "ring with a motor on a joint": Chain(
        **(LINE | {"lengths": np.array([0.6, 0.37, 0.47, 0.4])}),
        closed=True,
        pendant=(2500.0, 0.4),
        pendant_joint=2,
    ),
    "motor on a holding spring": Chain(**LINE, pendant=(2500.0, 0.4), pendant_ground=300.0),
}


@pytest.mark.parametrize("name", CHAINS)
def test_a_chain_has_the_frequencies_of_finite_elements(name, measured):
    found = cd.modes(CHAINS[name], count=6)
    coarse, fine = (finite_elements(CHAINS[name], parts, 6) for parts in (20, 40))
    truth = fine + (fine - coarse) / 3.0  # Richardson: their error is of order two
    frequencies = [mode.frequency for mode in found.modes for _ in range(mode.multiplicity)][:6]
    gap = float(np.abs(np.array(frequencies) / truth - 1.0).max())
    measured(f"{gap:.1e}")
    assert gap < 3e-6, f"observed {gap:.1e}"
    assert found.certified
    assert found.certificate.count == found.certificate.longitudinal == 6
    assert found.rigid_body_modes == (1 if name in ("line", "ring with a motor on a joint") else 0)


@pytest.mark.parametrize("name", ["dissertation-2", "dissertation-3"])
def test_the_chain_of_a_drive_has_its_longitudinal_modes(name):
    drive = cd.load_drive(name)
    (chain,) = longitudinal_chains(drive)
    of_drive = [(mode.frequency, mode.multiplicity) for mode in cd.modes(drive, below=2000.0).longitudinal]
    of_chain = [(mode.frequency, mode.multiplicity) for mode in cd.modes(chain.chain, below=2000.0).modes]
    assert of_chain == of_drive


def test_shapes_are_told_by_joint_and_segment():
    mode = cd.modes(CHAINS["springs to the ground"], count=1).modes[0]
    assert mode.joint_names == ("joint 0", "joint 1", "joint 2", "joint 3")
    ends = mode.shape("segment 1", [0.0, 0.37])
    np.testing.assert_allclose(ends[0], [mode.joints["joint 1"][0], mode.joints["joint 2"][0]], rtol=1e-9)
    assert mode.family in ("spring to the ground", "chain")


@pytest.mark.parametrize("choice", [{"motor": "held"}, {"hold": ["joint 0"]}, {"at_torque": 1.0}])
def test_what_is_about_drives_is_refused(choice):
    with pytest.raises(cd.InputRefused, match="about drives"):
        cd.modes(CHAINS["line"], count=1, **choice)
