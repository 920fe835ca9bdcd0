"""A rope that creeps or slides on its pulley, in logs of machines that share no code with the package."""

import numpy as np
import pytest

from cabledrive.identification.rope_friction import without_slip
from cabledrive.identification.two_sides import TwoSides
from cabledrive.parameters import load_drive
from study_drives import drive_of
from true_plants import shaken_log, truth_of

DRIVES = {"geared": load_drive("dissertation-3"), "rigid": drive_of("turntable")}
SHAKES, MOST = {"geared": 0.8, "rigid": 0.6}, {"geared": 0.92, "rigid": 0.53}
"""Torque of the multisine, and the largest pull of the rope that it makes [N m]."""


def slip_in(name, seed, **slips):
    """What is found in the log of a machine with other inertias, springs and frictions than its sheet."""
    g, truth = np.random.default_rng(seed), truth_of(DRIVES[name])
    parts = {"j1": 0.1, "j3": 0.1, "kc": 0.2, "km": 0.2, "bc": 0.4, "c1": 0.5}
    truth = truth.but(**{key: truth[key] * g.uniform(1.0 - part, 1.0 + part) for key, part in parts.items()})
    truth = truth.but(c3=truth["c1"] * g.uniform(0.0, 0.2)).but(**slips)
    torque, angles = shaken_log(truth, 12.0, SHAKES[name], seed)
    motor, *pulley, load = (angles[k] for k, count in enumerate(truth.counts) if count > 0.0)
    share = truth["j1"] / (truth["j1"] + truth["j2"]) if pulley else 1.0
    joint = {"pulley": pulley[0], "share": share} if pulley else {}
    one = TwoSides(source="log", interval=1e-3, torque=torque, motor=motor, load=load, **joint)
    return without_slip([one])[1], truth["j3"]


@pytest.mark.parametrize("name", DRIVES)
def test_a_creep_is_found_with_its_size(name, measured):
    """From 0.2 to 1.5 % of the way per N m: within a tenth, in seven of eight logs at least."""
    found = []
    for seed in range(8):
        creep = float(np.random.default_rng([seed, 1]).uniform(0.002, 0.015))
        slip, inertia = slip_in(name, seed, creep=creep)
        found.append(np.nan if slip is None or not slip.creep else slip.creep / inertia / creep)
    measured(
        f"over the true one {np.nanmin(found):.3f} to {np.nanmax(found):.3f}, missed {np.isnan(found).sum()}"
    )
    assert np.isnan(found).sum() <= 1
    assert np.nanmax(np.abs(np.array(found) - 1.0)) < 0.1


def test_the_torque_at_which_a_rope_slides_is_found(measured):
    found = []
    for seed in range(8):
        holds = float(np.random.default_rng([seed, 2]).uniform(0.4, 0.85)) * MOST["rigid"]
        slip, inertia = slip_in("rigid", seed, holds=holds)
        assert slip is not None
        found.append(slip.limit * inertia / holds)
    measured(f"over the true one {min(found):.3f} to {max(found):.3f}")
    assert max(abs(one - 1.0) for one in found) < 0.1


FAULTS = {
    "none": {},
    "backlash": {"gap": 0.017},
    "load friction": {"b3": 0.006, "c3": 0.02},
    "eccentric encoder": {"eccentric": 2e-3},
    "stiffening": {"hardening": 30.0},
    "Stribeck": {"stribeck": 0.02},
    "cogging": {"cogging": 0.015, "cogging_lines": 12.0},
}


@pytest.mark.parametrize("what", FAULTS)
def test_a_rope_that_holds_is_not_blamed(what):
    assert all(slip_in(name, 20 + k, **FAULTS[what])[0] is None for k in range(2) for name in DRIVES)
