"""A moved body keeps every rope as long as it is: others follow, or the pose is refused with its strain."""

from math import acos, atan2, hypot, pi, sqrt

import numpy as np
import pytest

import cabledrive as cd
from cabledrive.parameters import InputRefused
from cabledrive.parameters.drive_file import drive_from_text
from cabledrive.parameters.route import followers, moved

CRANE = """
schema = 1
kind = "route"
name = "trolley and weight"
[cable]
axial_rigidity = "1 MN"
mass_per_length = "0.1 kg/m"
[layout]
gravity = 9.81
[[body]]
name = "trolley"
at = ["{x} m", "0 m"]
moves = "x"
mass = 50
stiffness = 1
{travel}
[[body]]
name = "weight"
at = ["{radius} m", "{y} m"]
moves = "y"
mass = 20
[[pulley]]
name = "sheave"
at = ["0 m", "{height} m"]
radius = "{radius} m"
inertia = 0.01
[[anchor]]
name = "hook"
on = "trolley"
at = ["{x} m", "0 m"]
[[anchor]]
name = "shackle"
on = "weight"
at = ["{radius} m", "{y} m"]
[[route]]
name = "rope"
path = ["hook", "-sheave", "shackle"]
"""
LIFT = "lift-2-to-1"


def crane(x, y, radius, height, travel=""):
    return drive_from_text(CRANE.format(x=x, y=y, radius=radius, height=height, travel=travel))


def rope_of(x, radius, height):
    """Length from a hook at (x, 0), x < 0, to the level of the axle on the other side of the sheave.

    By the angles of hook and contact seen from the axle.
    """
    distance = hypot(x, height)
    to_hook = atan2(-height, x) % (2.0 * pi)
    contact = to_hook - acos(radius / distance)
    return sqrt(distance**2 - radius**2) + radius * contact


@pytest.mark.parametrize("seed", range(20))
def test_a_weight_rises_by_what_its_trolley_takes(seed):
    """Lengths by trigonometry of one point and one circle, not by the tangents of the package."""
    rng = np.random.default_rng(seed)
    x, height, radius = -rng.uniform(1.0, 4.0), rng.uniform(4.0, 9.0), rng.uniform(0.05, 0.4)
    y, there = rng.uniform(0.0, 1.0), -rng.uniform(0.5, 6.0)
    expected = y + rope_of(there, radius, height) - rope_of(x, radius, height)
    found = followers(crane(x, y, radius, height), {"trolley.x": there})
    assert set(found) == {"weight.y"}
    assert found["weight.y"] == pytest.approx(expected, abs=1e-10)


def test_a_car_takes_its_counterweight_along_and_its_modes_are_those_of_both_places():
    drive = cd.load_drive(LIFT, overrides=["car.y=35 m"])
    both = cd.load_drive(LIFT, overrides=["car.y=35 m", "counterweight.y=5 m"])
    assert followers(cd.load_drive(LIFT), {"car.y": 35.0}) == {"counterweight.y": pytest.approx(5.0)}
    found, expected = (cd.modes(one, count=2).longitudinal for one in (drive, both))
    assert [m.frequency for m in found] == pytest.approx([m.frequency for m in expected], rel=1e-9)
    assert found[0].frequency == pytest.approx(3.161, abs=5e-4), "by finite elements of the ropes"


def test_what_no_motion_allows_is_refused_with_its_strain():
    """The frame lifted by 0.1 m leaves 0.2 m of the compensating ropes over."""
    drive = cd.load_drive(LIFT)
    rope = 2.0 * (18.5 + 2.0) + 0.9 * pi
    with pytest.raises(InputRefused, match="compensation") as refused:
        moved(drive, {"tension frame.y": -1.9})
    strain = float(str(refused.value).split("strained by ")[1].split(" %")[0])
    assert strain == pytest.approx(100.0 * 0.2 / rope, rel=2e-3)
    with pytest.raises(InputRefused, match="strained by"):
        moved(drive, {"car.y": 35.0, "counterweight.y": 6.0})


@pytest.mark.parametrize(
    "key, name", [("head.x", "corexy"), ("head.x", "printer-idlers"), ("camera.x", "camera-winches")]
)
def test_belts_fixed_to_a_head_and_drums_that_wind_need_nobody_to_follow(key, name):
    drive = cd.load_drive(name)
    body = next(body for body in drive.body if body.name == key.partition(".")[0])
    assert followers(drive, {key: body.at[0] + 0.05}) == {}


def test_a_body_keeps_to_its_travel():
    limited = crane(-2.0, 0.5, 0.2, 6.0, travel='travel = "-4 m : -1 m"')
    assert limited.body[0].travel == (-4.0, -1.0)
    assert drive_from_text(cd.parameters.drive_text(limited)) == limited
    with pytest.raises(InputRefused, match=r"trolley\.x = -5 m lies outside its travel, -4 : -1 m"):
        moved(limited, {"trolley.x": -5.0})
    for x, travel in ((-2.0, "-1 m : -4 m"), (-5.0, "-4 m : -1 m"), (-2.0, "-4 m")):
        with pytest.raises(InputRefused, match="travel"):
            crane(x, 0.5, 0.2, 6.0, travel=f'travel = "{travel}"')
    free = crane(-2.0, 0.5, 0.2, 6.0)
    assert cd.content_hash(limited) == cd.content_hash(free), "where it may go does not change its modes"
