"""A controller.json runs again on the rig: the law and the filter of the file, the reference anew."""

import json
from dataclasses import replace

import numpy as np
import pytest

import cabledrive as cd
from cabledrive.parameters import content_hash
from cabledrive.rig import Motion, RigOptions, track
from cabledrive.rig.closed_loop.loop import close_loop, run
from cabledrive.rig.laws.controller_file import controller_numbers, is_controller_path
from cabledrive.rig.laws.registry import design
from cabledrive.rig.trial import spec_for

DRIVE = cd.load_drive("dissertation-3")
SHORT, OTHER = (
    Motion(angle=5.0, rise=0.15, dwell=0.05, order=11),
    Motion(angle=8.0, rise=0.2, dwell=0.05, order=13),
)

HERTZ = {"pd": 6.0, "dob": 4.0, "shaper": 6.0, "darc-3-damped": 9.0, "darc-4-damped": 27.0}


def loop_of(name: str, motion: Motion):
    made = design(name, spec_for(DRIVE, motion, bandwidth=HERTZ.get(name)))
    return close_loop(DRIVE, DRIVE, made, motion, RigOptions(), np.random.default_rng(0))


def written(folder, law: str, **changes):
    data = controller_numbers(loop_of(law, SHORT), DRIVE, "motor") | changes
    (folder / "controller.json").write_text(json.dumps(data, allow_nan=False))
    return folder / "controller.json"


@pytest.mark.parametrize(
    "name", ["pd", "pid", "lqg", "lqi", "dob", "shaper", "darc-3-damped", "darc-4-damped"]
)
def test_the_file_runs_the_law_and_the_settled_filter_along_another_motion(name, tmp_path, measured):
    path = written(tmp_path, name)
    found = track(DRIVE, controller=str(path), motion=OTHER)
    loop, first = loop_of(name, OTHER), loop_of(name, SHORT)  # adaptation and filter are tuned to a motion
    settled = first.observer._replace(gains=first.observer.gains[-1:])
    made = replace(loop.controller, law=first.controller.law)
    same = run(replace(loop, observer=settled, controller=made)).log
    gap = float(np.abs(found.load_angle * loop.gear - same[:, loop.chain.size - 1]).max())
    measured(f"{gap:.1e} rad")
    assert gap < 1e-11, f"observed {gap:.1e} rad"  # the file makes its reference by its own generator
    assert found.summary["controller"] == name
    assert found.summary["gains"]["file"] == str(path)


def test_tables_along_the_motion_are_made_anew(tmp_path):
    """The file holds law, filter and drive; the same bandwidth by name gives the same run."""
    name = "lqi-learning"
    made = design(name, spec_for(DRIVE, SHORT, bandwidth=22.0))
    loop = close_loop(DRIVE, DRIVE, made, SHORT, RigOptions(), np.random.default_rng(0))
    data = controller_numbers(loop, DRIVE, "motor")
    assert data["columns"] == []
    path = tmp_path / "controller.json"
    path.write_text(json.dumps(data, allow_nan=False))
    found = track(DRIVE, controller=path, motion=OTHER)
    named = track(DRIVE, controller=name, bandwidth=22.0, motion=OTHER)
    np.testing.assert_array_equal(found.load_angle, named.load_angle)
    assert found.summary["gains"]["file"] == str(path)
    data["law"]["rows"][0][0] *= 1.001
    path.write_text(json.dumps(data))
    with pytest.raises(cd.InputRefused, match="run the study again"):
        track(DRIVE, controller=path, motion=OTHER)


def test_a_folder_and_a_path_object_are_taken_too(tmp_path):
    path = written(tmp_path, "pd")
    runs = [track(DRIVE, controller=one, motion=SHORT).torque for one in (path, tmp_path, str(tmp_path))]
    np.testing.assert_array_equal(runs[0], runs[1])
    np.testing.assert_array_equal(runs[0], runs[2])


def test_the_torque_limit_of_the_file_holds(tmp_path):
    path = written(tmp_path, "pd", torque_limit=0.1)
    assert track(DRIVE, controller=path, motion=SHORT).summary["circumstances"]["torque_limit"] == 0.1


def test_a_name_is_no_path():
    assert not is_controller_path("darc-4-damped")
    assert not is_controller_path(None)
    assert is_controller_path("darc.json")


@pytest.mark.parametrize(
    "changes, choices, named",
    [
        ({"drive_hash": "0" * 64}, {}, ["another drive", "000000000000", "drive.toml"]),
        ({"name": "no-such-law"}, {}, ["no-such-law", "pd"]),
        ({"sample_time": 1e-3}, {}, ["0.001 s", "0.0002 s"]),
        ({"encoders": ["motor", "load", "drive"]}, {}, ["encoders"]),
        ({"shafts": ["load"]}, {}, ["do not fit"]),
        ({"filter": {}}, {}, ["no controller", "kind"]),
        ({"radius": 1.0}, {}, ["carriage"]),
        ({}, {"bandwidth": 5.0}, ["bandwidth"]),
        ({}, {"gains": "dissertation"}, ["gains"]),
        ({}, {"options": RigOptions(ideal_sensors=True)}, ["filter"]),
        ({}, {"feedforward": "rigid"}, ["feedforward"]),
    ],
)
def test_a_file_that_does_not_fit_is_one_line(changes, choices, named, tmp_path):
    path = written(tmp_path, "pd", **changes)
    with pytest.raises(cd.InputRefused) as refusal:
        track(DRIVE, controller=path, motion=SHORT, **choices)
    words = str(refusal.value)
    assert "\n" not in words
    assert all(part in words for part in named), words


@pytest.mark.parametrize("text", ["", "[1, 2]", "{}", '{"drive_hash": 1}', "\x00", "3"])
def test_what_is_no_controller_file_is_one_line(text, tmp_path):
    (tmp_path / "controller.json").write_text(text)
    with pytest.raises(cd.InputRefused, match=r"controller\.json") as refusal:
        track(DRIVE, controller=tmp_path / "controller.json", motion=SHORT)
    assert "\n" not in str(refusal.value)


def test_a_missing_file_is_named():
    with pytest.raises(cd.InputRefused, match=r"nowhere\.json"):
        track(DRIVE, controller="nowhere.json", motion=SHORT)


def test_the_hash_is_that_of_the_drive_it_was_made_for(tmp_path):
    assert json.loads(written(tmp_path, "pd").read_text())["drive_hash"] == content_hash(DRIVE)
