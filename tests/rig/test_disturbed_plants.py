"""Plants with what data sheets leave out, against other integrators; the file of their ranges.

Compiled modules under test: cabledrive.rig.closed_loop.disturbed_kernels.
"""

from dataclasses import fields, replace

import numpy as np
import pytest

from cabledrive.parameters import InputRefused, load_drive
from cabledrive.rig import Motion, RigOptions
from cabledrive.rig.closed_loop.loop import close_loop, loop_at_rest, run
from cabledrive.rig.disturbed.disturbances_file import Disturbances, disturbances_of, load_disturbances
from cabledrive.rig.disturbed.disturbed_plants import disturbed_loop, disturbed_numbers
from cabledrive.rig.laws.registry import CONTROLLERS
from cabledrive.rig.trial import spec_for
from true_plants import followed, truth_of

DRIVE = load_drive("dissertation-3")
MOTION, OPTIONS = Motion(angle=20.0, rise=0.3, dwell=0.15, order=11), RigOptions(forbid_slack=False)


@pytest.fixture(scope="module")
def loop():
    made = CONTROLLERS["lqi"](spec_for(DRIVE, MOTION, bandwidth=20.0))
    found = close_loop(DRIVE, DRIVE, made, MOTION, OPTIONS, np.random.default_rng(4))
    # Without counts: a loop that rounds makes other counts out of the last digit of an integrator.
    return replace(found, rig=found.rig._replace(counts=np.zeros(3)))


def with_disturbances(loop, phases=(0.0, 0.0, 0.0), **values):
    drawn = {one.name: one.default[0] for one in fields(Disturbances)} | values
    chain = replace(
        loop.chain, coulomb=(*loop.chain.coulomb[:-1], loop.chain.coulomb[-1] + drawn["load_coulomb"])
    )
    numbers = disturbed_numbers(loop, chain, drawn, np.array(phases))
    return replace(loop, chain=chain, disturbed=numbers)


def test_without_disturbances_the_plant_is_the_exact_one(loop, measured):
    """Against the event-by-event solution: the load within a twentieth of a count."""
    exact, found = run(loop), run(with_disturbances(loop))
    gap = float(np.degrees(np.abs(exact.log[:, 2] - found.log[:, 2]).max()))
    measured(f"{gap:.1e} deg")
    assert gap < 0.036 / 20.0, f"observed {gap:.1e} deg"


@pytest.mark.kernel
def test_the_first_samples_are_those_of_the_exact_plant_with_and_without_the_compiler(loop):
    """While the motor sticks and breaks loose: 200 samples, within a sixtieth of a count."""
    exact, found = (run(one, last=200).log[:200, :3] for one in (loop, with_disturbances(loop)))
    assert np.abs(exact).max() > 1e-4
    np.testing.assert_allclose(found, exact, atol=1e-5)


@pytest.mark.parametrize(
    "ours, theirs",
    [
        ({"load_coulomb": 0.02}, {"c3": 0.02}),
        ({"stribeck_excess": 0.5}, {"stribeck": 0.5 * 0.0376}),
        ({"cogging": 0.02, "cogging_periods": 24.0}, {"cogging": 0.02, "cogging_lines": 24.0}),
        ({"torque_ripple": 0.3, "ripple_periods": 12.0}, {"ripple": 0.3, "ripple_lines": 12.0}),
        ({"encoder_eccentricity": 2e-3}, {"eccentric": 2e-3}),
        ({"backlash": 0.004}, {"gap": 0.004}),
    ],
    ids=lambda value: next(iter(value)),
)
def test_each_disturbance_is_that_of_another_integrator(loop, ours, theirs, measured):
    """Peak error of the same law on plants of `true_plants.py`, whose steps are semi-implicit."""
    found = run(with_disturbances(loop, (0.7, 0.0, 0.4), **ours), log=False).state.summary[0]
    made, rig = loop.controller, loop.rig
    other = followed(
        truth_of(DRIVE).but(**theirs).values, loop.observer, made.law, rig, made.reference, loop.target,
        loop_at_rest(loop), np.array([0, 1, 2]), 5e-6,
    )  # fmt: skip
    plain = run(with_disturbances(loop), log=False).state.summary[0]
    measured(f"{np.degrees(found):.4f} deg, the other {np.degrees(other):.4f}")
    assert abs(found - other) < 0.02 * other, f"observed {found:.3e}, {other:.3e} rad"
    assert abs(found - plain) > abs(found - other), "the disturbance changes nothing"


def test_a_load_of_three_times_the_inertia_a_shock_and_wear_change_the_run(loop):
    base = run(with_disturbances(loop), log=False).state.summary[0]
    for values in ({"load_factor": 3.0, "load_time": 0.2}, {"softening": 0.5}, {"warming": 0.9}):
        assert run(with_disturbances(loop, **values), log=False).state.summary[0] != base, values
    pushed = Disturbances(shock_torque=(0.5, 0.5), shock_time=(0.5, 0.5), shock_duration=(0.02, 0.02))
    calm = run(disturbed_loop(loop, Disturbances(), OPTIONS, np.random.default_rng(1)))
    hit = run(disturbed_loop(loop, pushed, OPTIONS, np.random.default_rng(1)))
    change = np.abs(hit.log[:, 2] - calm.log[:, 2])
    assert change[:2500].max() == 0.0
    assert np.degrees(change[2500:].max()) > 0.1


def test_the_same_seed_draws_the_same_plant_for_every_law(loop):
    ranges = Disturbances(load_coulomb=(0.0, 0.02), jitter=(1e-6, 2e-6), added_delay=(0.0, 1e-4))
    one, other = (disturbed_loop(loop, ranges, OPTIONS, np.random.default_rng([7, 3])) for _ in range(2))
    assert one.chain == other.chain
    assert 0.0 < one.chain.coulomb[-1] < 0.02
    assert 0.0 < one.rig.late_part < 1e-4
    np.testing.assert_array_equal(one.rig.jitter, other.rig.jitter)


def test_a_file_of_ranges_is_read_with_its_units(tmp_path):
    path = tmp_path / "disturbances.toml"
    path.write_text('load_coulomb = ["0 N m", "20 mN m"]\nbacklash = "1 deg"\nload_factor = [0.5, 3]\n')
    found = load_disturbances(path)
    assert found.load_coulomb == (0.0, pytest.approx(0.02))
    assert found.backlash == (pytest.approx(np.radians(1.0)),) * 2
    assert found.load_factor == (0.5, 3.0)
    assert found.cogging == (0.0, 0.0)


@pytest.mark.parametrize(
    "content, named",
    [
        ({"load_friction": 1.0}, ["load_friction", "unknown key"]),
        ({"backlash": "1 N m"}, ["backlash", "N m", "rad"]),
        ({"load_factor": [3, 0.5]}, ["load_factor", "smallest and largest"]),
        ({"load_factor": [1, 2, 3]}, ["load_factor", "3 values"]),
        ({"torque_ripple": 2.0}, ["torque_ripple", "0 to 1"]),
    ],
)
def test_ranges_that_are_none_are_refused_by_name(content, named):
    with pytest.raises(InputRefused) as refused:
        disturbances_of(content)
    assert all(word in str(refused.value) for word in named), str(refused.value)


def test_a_delay_beyond_the_next_sample_is_refused(loop):
    with pytest.raises(InputRefused, match="added_delay"):
        disturbed_loop(loop, Disturbances(added_delay=(1e-3, 1e-3)), OPTIONS, np.random.default_rng(0))
