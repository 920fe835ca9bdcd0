"""A controller.json runs again on the rig: the law and the filter of the file, the reference anew."""

import json
from dataclasses import replace

import numpy as np
import pytest

import cabledrive as cd
from cabledrive.control.load_torque import load_regressors
from cabledrive.control.reference_kernels import reference_table
from cabledrive.parameters import content_hash
from cabledrive.rig import Motion, RigOptions, track
from cabledrive.rig.closed_loop.loop import close_loop, run
from cabledrive.rig.laws.controller_file import controller_numbers, is_controller_path, read_controller
from cabledrive.rig.laws.controllers import motion_numbers
from cabledrive.rig.laws.load_learning import TURNING, load_blocks, load_learning
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


def learning_loop(name: str, motion: Motion):
    """Law and settled filter made for the short motion along another one; tables from whole-motion arrays."""
    first = spec_for(DRIVE, SHORT, bandwidth=22.0)
    designed = close_loop(
        DRIVE, DRIVE, load_learning(first, name), SHORT, RigOptions(), np.random.default_rng(0)
    )
    settled = designed.observer._replace(gains=designed.observer.gains[-1:])
    spec, turning = spec_for(DRIVE, motion, bandwidth=22.0), TURNING * SHORT.rise
    made = replace(load_learning(spec, name, turning), law=designed.controller.law)
    loop = close_loop(DRIVE, DRIVE, made, motion, RigOptions(), np.random.default_rng(0))
    chain = spec.model(4)
    torques = load_regressors(spec.wanted(2 * chain.size), turning, spec.interval)
    blocks, _ = load_blocks(chain, settled, made.law.rows[1:, : len(settled.output)], torques, spec.interval)
    table = np.ascontiguousarray(np.hstack((made.reference[:, : 2 * chain.size + 1], blocks)))
    generator = designed.controller.generator
    controller = replace(made, reference=table, generator=generator)
    return replace(loop, observer=settled, controller=controller)


@pytest.mark.parametrize("name", ["lqi-learning", "lqg-learning"])
def test_the_file_of_a_law_that_learns_makes_its_columns_sample_by_sample(name, tmp_path, measured):
    """The generator looks ahead; the rig's tables come from whole-motion arrays with another rounding."""
    path = tmp_path / "controller.json"
    path.write_text(json.dumps(controller_numbers(learning_loop(name, SHORT), DRIVE, "motor")))
    found, loop = track(DRIVE, controller=path, motion=OTHER), learning_loop(name, OTHER)
    generator = read_controller(path).reference
    table = reference_table(generator, motion_numbers(DRIVE, OTHER), loop.rig.interval, len(loop.target))
    scale = np.abs(loop.controller.reference).max(axis=0)
    gap = float((np.abs(table - loop.controller.reference).max(axis=0) / scale).max())
    moved = np.abs(found.load_angle * loop.gear - run(loop).log[:, loop.chain.size - 1]).max()
    measured(f"columns {gap:.1e}, load {moved:.1e} rad")
    assert table.shape[1] == len(read_controller(path).columns)
    assert gap < 1e-9
    assert moved < 1e-9
    assert found.summary["gains"]["file"] == str(path)


def test_the_file_of_a_law_that_learns_without_its_generator_is_refused(tmp_path):
    data = controller_numbers(learning_loop("lqi-learning", SHORT), DRIVE, "motor") | {"reference": None}
    (tmp_path / "controller.json").write_text(json.dumps(data))
    with pytest.raises(cd.InputRefused, match="run the study again"):
        track(DRIVE, controller=tmp_path, motion=OTHER)


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
