"""The identified model replayed over its own log: quiet where it is right, else a finding."""

import numpy as np
import pytest

from cabledrive.control.observers import Sampling, kalman_filter
from cabledrive.identification.logs.column_map import ColumnMap
from cabledrive.identification.logs.reading import read_log
from cabledrive.parameters import load_drive
from cabledrive.rig.closed_loop.loop import plant_chain
from cabledrive.studies.study.goals import SPREADS
from cabledrive.studies.study.knowledge_stage import know, usable_log
from cabledrive.studies.study.log_replay import TUNING, innovations
from study_drives import drive_of, log_with
from true_plants import log_text, truth_of

DRIVE = load_drive("dissertation-3")
SHEET = truth_of(DRIVE)
FRICTION = SHEET["c1"]


def known(truth, folder, seed=1):
    """What a study knows of a machine by twelve seconds of log."""
    path = folder / "log.csv"
    path.write_text(log_text(truth, 12.0, 0.8, seed))
    return know(DRIVE, [usable_log(read_log(path, ColumnMap()))], SPREADS)


@pytest.mark.kernel
def test_innovations_are_readings_less_their_predictions():
    """The compiled `cabledrive.studies.study.log_replay` against the filter's own equations."""
    chain, h, generator = plant_chain(DRIVE, 4), 1e-3, np.random.default_rng(3)
    probe = kalman_filter(
        chain,
        [0, 1, 2],
        [2e-3, 6e-4, 6e-4],
        Sampling(interval=h),
        chosen=range(3),
        tuning=TUNING,
        settled=True,
    )
    torque, readings = generator.normal(size=60), 1e-3 * generator.normal(size=(60, 3)).cumsum(axis=0)
    size = probe.model.shape[0]
    mean = np.append(0.5 * (torque[1:] + torque[:-1]), torque[-1])
    state, held, expected = np.zeros(size), 0.0, []
    for u, y in zip(mean, readings, strict=True):
        expected.append(y - probe.output @ state)
        state = state + probe.gains[-1] @ expected[-1]
        rub = probe.scalars[7] - probe.scalars[5] * np.tanh(probe.scalars[6] * state[probe.places[0]])
        state = probe.model @ [*state, held, u, u, rub]
        held = probe.scalars[2] * held + (probe.scalars[3] + probe.scalars[4]) * u
    np.testing.assert_allclose(innovations(probe, torque, readings), np.array(expected)[6:], rtol=1e-9)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_machine_as_the_sheet_has_it_gives_no_finding(seed, tmp_path, measured):
    found = known(SHEET, tmp_path, seed)
    measured(f"power {found.replays[0].ratio:.2f} times the model's, {found.replays[0].limit:.2f} allowed")
    assert found.findings == ()
    for name, key in (("near_inertia", None), ("load_inertia", "j3"), ("joint_stiffness", "km")):
        true = SHEET["j1"] + SHEET["j2"] if key is None else SHEET[key]
        assert found.quantities[name].low <= true <= found.quantities[name].high, name


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"eccentric": 2e-3}, "load angle"),
        ({"cogging": 0.4 * FRICTION, "cogging_lines": 12.0}, "times the power"),
        ({"hardening": 30.0}, "times the power"),
        ({"km": 48.0}, "joint: 4"),
        ({"c1": 1.6 * FRICTION}, "Coulomb friction: 0.06"),
        ({"c3": 0.5 * FRICTION}, "load pulley: 0.018"),
    ],
)
def test_what_the_sheet_lacks_is_a_finding(changes, words, tmp_path, measured):
    found = known(SHEET.but(**changes), tmp_path)
    measured(f"{changes}: {found.findings}")
    assert any(words in finding.words for finding in found.findings), found.findings


def test_friction_of_the_load_and_backlash_are_identified(tmp_path, measured):
    """A load that rubs with 5 mN m; a tenth of a degree of backlash, within a quarter of it."""
    truth = SHEET.but(c3=0.005, gap=np.radians(0.2))
    found = known(truth, tmp_path).quantities
    load, play = found["load_coulomb_friction"], found["backlash"]
    measured(f"load {load.value:.5f} N m, backlash {np.degrees(play.value):.3f} deg")
    assert load.source == play.source == "log"
    assert load.low <= 0.005 <= load.high, load
    assert load.high - load.low < 0.001
    assert play.low <= np.radians(0.2) <= play.high, play


def test_the_angle_of_a_load_behind_a_gear_is_compared_at_the_motor():
    """A turntable of 1 to 3: its own log is replayed without a finding."""
    drive = drive_of("turntable")
    found = know(drive, [log_with(("torque", "angle", "load_angle"))], SPREADS)
    assert found.replays[0].ratio < found.replays[0].limit
