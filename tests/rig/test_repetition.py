"""A motion repeated with a torque learnt between repetitions: contraction, projection, its own end."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cabledrive.control.iterative_learning import lifted, repetition_learning, torque_along
from cabledrive.parameters import InputRefused, load_drive
from cabledrive.rig import Motion, track
from command import answer

DRIVE = load_drive("dissertation-3")
RUBBING = load_drive(
    "dissertation-3", overrides=["pulley.1.coulomb_friction=0.015", "lumped.cable_stiffness=830"]
)
SPRING = 1.0 - np.cos(0.05 * np.arange(2000)) * np.exp(-0.01 * np.arange(2000))
IMPULSE = np.diff(SPRING, prepend=0.0)


def test_the_lifted_map_is_the_response_to_straight_lines_between_nodes():
    """Against the sum over samples, with other torque at every node."""
    width, nodes = 20, 60
    values = np.random.default_rng(1).normal(size=nodes)
    torque = torque_along(values, width, nodes * width)
    error = np.convolve(torque, IMPULSE)[: nodes * width].reshape(nodes, width).mean(axis=1)
    np.testing.assert_allclose(lifted(IMPULSE, nodes, width) @ values, error, atol=1e-9)


def learning():
    nominal = lifted(IMPULSE, 60, 20)
    other = lifted(1.2 * IMPULSE, 60, 20)
    found = repetition_learning(nominal, [other], np.zeros_like(nominal), 1e-4, 1.0)
    assert found is not None
    return nominal, other, found


@given(st.integers(0, 2**32 - 1), st.floats(0.1, 10.0))
def test_two_torques_come_nearer_by_the_contraction_on_every_plant_that_was_looked_at(seed, radius):
    """With the projection, and whatever repeats: the claim of the proof, at any pair of torques."""
    nominal, other, found = learning()
    rng = np.random.default_rng(seed)
    lasting = rng.normal(size=60)
    for plant in (nominal, other):
        one, two = (rng.normal(size=found.directions.shape[1]) for _ in range(2))
        images = [found.corrected(a, plant @ found.directions @ a + lasting, radius) for a in (one, two)]
        assert np.linalg.norm(images[0] - images[1]) <= (found.contraction * np.linalg.norm(one - two) + 1e-9)


def test_the_fixed_point_lies_inside_the_ball():
    """The projection does not act in the loop of the proof: the error in its directions goes to nothing."""
    nominal, other, found = learning()
    lasting = np.sin(0.2 * np.arange(60))
    for plant in (nominal, other):
        place, radius = np.zeros(found.directions.shape[1]), found.radius(lasting)
        for _ in range(200):
            place = found.corrected(place, plant @ found.directions @ place + lasting, radius)
        assert np.linalg.norm(place) < radius
        left = found.correction @ (plant @ found.directions @ place + lasting)
        assert np.linalg.norm(left) < 1e-9


def test_repetitions_take_two_thirds_of_the_error_of_lqg_and_stop_by_themselves(measured):
    """0.015 N m at the load and a softer cable, of which law and proof know nothing."""
    said = track(
        DRIVE,
        controller="lqg",
        bandwidth=35.0,
        plant_drive=RUBBING,
        motion=Motion(order=11),
        seed=3,
        repeat=12,
    ).summary
    found = said["repeated"]
    peaks = [one["peak_error_deg"] for one in found["repetitions"]]
    measured(f"{peaks[0]:.3f} to {said['peak_error_deg']:.3f} deg, contraction {found['contraction']:.2f}")
    assert said["peak_error_deg"] == peaks[found["best"] - 1]
    assert said["peak_error_deg"] < peaks[0] / 2.0
    assert found["contraction"] < 1.0
    assert len(peaks) < 12, "learning stops before it is told to"
    assert "fell by less than" in found["stopped"]


def test_a_law_that_has_no_torque_along_its_motion_is_refused():
    for choices in (
        {"controller": "darc-4-damped", "bandwidth": 23.0},
        {"controller": "darc-indirect", "bandwidth": 23.0},
        {"controller": "lqg", "bandwidth": 23.0, "draws": 2},
    ):
        with pytest.raises(InputRefused, match="repeat"):
            track(DRIVE, motion=Motion(order=11), repeat=3, **choices)
    with pytest.raises(InputRefused, match="from 2 to"):
        track(DRIVE, motion=Motion(order=11), repeat=1, controller="lqg", bandwidth=23.0)


def test_the_command_shows_the_error_of_each_repetition():
    said = answer("track", "dissertation-3", "--controller", "lqg", "--bandwidth", "30", "--repeat", "3")
    assert 2 <= len(said["repeated"]["repetitions"]) <= 3
    assert said["repeated"]["assumed"]
