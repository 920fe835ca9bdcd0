"""A study tries every law that a comparison offers, and chooses what the comparison's order ranks first."""

import json
from dataclasses import dataclass, replace

import numpy as np
import pytest

from cabledrive.app import finished_study
from cabledrive.parameters import load_drive
from cabledrive.parameters.files import OWN_HASH, with_own_hash
from cabledrive.rig.closed_loop.chain_kernels import SUMMARY
from cabledrive.rig.closed_loop.loop import run
from cabledrive.rig.laws.load_learning import KINDS, SCHEDULED
from cabledrive.rig.plant_samples import Disturbances, Draws
from cabledrive.rig.trial import offered
from cabledrive.studies.study import plants as law_settings
from cabledrive.studies.study import run_study
from cabledrive.studies.study.plants import FIXED, load_case, tuned_laws
from cabledrive.studies.study.sampled_plants import sampled_plant, with_values
from cabledrive.studies.study.stage_cache import StageCache
from study_drives import drive_of, goals

DRIVE = drive_of("turntable")


def test_a_study_tries_every_law_that_a_comparison_offers():
    """Of one pulse, and of a load that changes; the law of the chain is the study's own entry.

    The law that goes by an announced load has nothing to go by: the plants of a study keep theirs.
    """
    names = offered(DRIVE, Disturbances(load_factor=(0.5, 3.0)))
    assert {name for name in names if not name.startswith("darc")} <= {*FIXED, *KINDS, SCHEDULED}


def on_the_plants_of(found, setting, draws):
    """Scores of a law on the plants of a study's acceptance, by the comparison's measure."""
    known = found.knowledge
    case = load_case(found.known, found.goals, known)
    loop = case.loop(case.law(setting))
    runs = []
    for draw in range(draws):
        values, phases = sampled_plant(
            known.quantities, len(loop.rig.phases), found.goals.seed, draw, known.correlations
        )
        done = run(with_values(loop, values, phases), log=False)
        peak = done.state.summary[SUMMARY.index("peak")] / loop.gear + values.get("eccentricity", 0.0)
        runs.append((float(peak), bool(done.failed)))
    peaks, failed = zip(*runs, strict=True)
    names = ("first_peak", "later_peak", "peak_torque", "saturated", "loose")
    return Draws(peak=peaks, failed=failed, **dict.fromkeys(names, (0.0,) * draws))


def choice_and_table(drive, asked, folder):
    """What a study without an error goal chooses, and the rank of every law on the same plants."""
    found = run_study(drive, [], asked, folder=folder)
    known = replace(found.known, name="", title="", source="")
    kept = StageCache(folder=folder, note=lambda line: None)  # the settings of the study itself
    case = load_case(known, asked, found.knowledge)
    tuned = kept.staged("laws", tuned_laws, case, found.controller, every_law=False)
    table = {
        one.controller: on_the_plants_of(found, one, asked.draws).rank(np.inf)
        for one in tuned
        if one.bandwidth is not None
    }
    return found.laws.chosen.controller, table


@pytest.mark.verify
def test_the_choice_of_a_study_is_the_first_of_the_table_on_the_same_plants(tmp_path, monkeypatch, measured):
    """Of five laws."""
    monkeypatch.setattr(law_settings, "FIXED", ("pd", "lqi", "pid"))
    monkeypatch.setattr(law_settings, "KINDS", ("lqi-learning",))
    chosen, table = choice_and_table(DRIVE, goals(30, 0.3, draws=10), tmp_path)
    measured(", ".join(f"{name} {np.degrees(error):.3f}" for name, (*_, error) in table.items()))
    assert chosen == min(table, key=lambda name: table[name]), f"{chosen}, {table}"


@pytest.mark.verify
def test_the_choice_is_the_first_of_the_table_over_100_plants_with_a_flexible_joint(tmp_path, measured):
    chosen, table = choice_and_table(load_drive("dissertation-3"), goals(45, 0.5, draws=100), tmp_path)
    measured(", ".join(f"{name} {np.degrees(error):.3f}" for name, (*_, error) in table.items()))
    assert chosen == min(table, key=lambda name: table[name]), f"{chosen}, {table}"


# --- What is kept of a study or a reproduction is believed only as it was written, by the code that wrote it
@dataclass(frozen=True)
class Found:
    """A result."""

    value: float


CALLS = []


def half_more(value: float) -> Found:
    CALLS.append(value)
    return Found(1.5 * value)


def twice(value: float) -> Found:
    CALLS.append(value)
    return Found(2.0 * value)


def staged(folder, function=half_more, argument=1.0):
    return StageCache(folder=folder, note=print).staged("stage", function, argument)


DAMAGES = {
    "edited": lambda text: json.dumps(json.loads(text) | {"result": {"value": 99.0}}),
    "without a hash": lambda text: json.dumps({k: v for k, v in json.loads(text).items() if k != OWN_HASH}),
    "under another key": lambda text: json.dumps(with_own_hash(json.loads(text) | {"key": "0" * 64})),
    "cut": lambda text: text[:-3],
    "zeroed": lambda text: text[:20] + "\0" * 10 + text[30:],
    "a list": lambda text: "[1, 2]",
}


@pytest.mark.parametrize("damage", DAMAGES.values(), ids=DAMAGES)
def test_a_stage_is_served_as_it_was_written_and_else_made_again(tmp_path, damage):
    CALLS.clear()
    assert staged(tmp_path) == staged(tmp_path) == Found(1.5)
    assert len(CALLS) == 1
    (file,) = tmp_path.iterdir()
    file.write_text(damage(file.read_text()))
    assert staged(tmp_path) == staged(tmp_path) == Found(1.5)
    assert len(CALLS) == 2


def test_a_stage_is_known_by_its_function_and_by_every_argument_that_it_is_given(tmp_path):
    CALLS.clear()
    assert staged(tmp_path, argument=2.0) == Found(3.0)
    assert staged(tmp_path, argument=3.0) == Found(4.5)
    assert staged(tmp_path, twice, 2.0) == Found(4.0)
    assert CALLS == [2.0, 3.0, 2.0]


def test_results_are_a_finished_study_only_with_the_files_they_were_written_with(tmp_path):
    import hashlib

    (tmp_path / "report.html").write_text("a page")
    files = {"report.html": hashlib.sha256(b"a page").hexdigest()}
    data = with_own_hash({"verdict": "yes", "files": files})
    (tmp_path / "results.json").write_text(json.dumps(data))
    assert finished_study.finished(tmp_path) == data
    (tmp_path / "report.html").write_text("another page")
    assert finished_study.finished(tmp_path) is None
    (tmp_path / "report.html").write_text("a page")
    (tmp_path / "results.json").write_text(json.dumps(data | {"verdict": "no"}))
    assert finished_study.finished(tmp_path) is None
    (tmp_path / "results.json").write_text(json.dumps({"verdict": "yes"}))
    assert finished_study.finished(tmp_path) is None
