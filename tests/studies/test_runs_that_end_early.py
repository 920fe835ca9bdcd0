"""A run that ends early has no error: it counts as missed, and nothing stands in for it."""

import json
from dataclasses import replace
from types import SimpleNamespace

import pytest

from cabledrive.report.blocks import Figure
from cabledrive.report.study.controller import acceptance_chapter
from cabledrive.rig.plant_samples import Draws
from cabledrive.rig.setting import DEGREE
from cabledrive.rig.tuning import LawSetting
from cabledrive.studies.study.acceptance_stage import AcceptanceResult, TriedLaws, accept, closest
from cabledrive.studies.study.findings import Findings
from cabledrive.studies.study.goals import SPREADS
from cabledrive.studies.study.knowledge_stage import know
from cabledrive.studies.study.plants import ControllerResult, Plant
from cabledrive.studies.study.stage_cache import StageCache, as_plain
from cabledrive.studies.study.verdict_stage import judge
from study_drives import drive_of, goals

WRIST = drive_of("wrist")
ASKED = goals(60, 0.3, error=0.5 * DEGREE)
LAW = LawSetting(controller="darc-4-damped", model=4, bandwidth=55.0)
BOUND = 1.0 * DEGREE
DESIGN = ControllerResult(
    model=4,
    name=LAW.controller,
    bandwidth=LAW.bandwidth,
    sliding_rate=None,
    bound=BOUND,
    chosen=None,
    candidates=(),
    lower=(),
    upper=(),
    shares={},
    broken=(),
    reason="",
)


def accepted(pretension, *, drive=WRIST, law=LAW, draws=12):
    """A law on plants with less pretension: a span that goes slack ends the run."""
    drive = replace(drive, cable=replace(drive.cable, pretension=pretension))
    known = know(drive, [], SPREADS, backlash=0.0)
    cache = StageCache(folder=None, note=lambda line: None)
    plant = Plant(drive=drive, goals=ASKED, cache=cache, known=known)
    return accept(plant, law, "lumped", draws, bound=BOUND)


@pytest.fixture(scope="module")
def some():
    return accepted(1.5)


@pytest.fixture(scope="module")
def none():
    return accepted(1.0)


def test_errors_are_those_of_the_runs_that_lasted(some):
    """Slack comes before the largest error: an early end would pass as a small error."""
    whole = accepted(30.0)
    assert 0 < some.failed < some.draws == 12, some.failed
    assert len(some.peaks) == some.draws - some.failed
    assert set(some.peaks) <= set(whole.peaks), "a run that lasted errs as it does at more pretension"
    assert some.inside == some.share == (some.draws - some.failed) / some.draws


def test_where_no_run_lasts_there_is_no_number_and_no_picture_and_the_answer_is_unknown(none):
    assert none.failed == none.draws == 12
    assert none.peaks == ()
    assert none.worst is none.largest_torque is none.quantile(0.5) is None
    cable = replace(none, plant="cable", draws=0, peaks=(), reason="not requested")
    laws = TriedLaws(scores=(none,), cable_scores=(), chosen=LAW, runs=none, cable=cable)
    known = {"goals": ASKED, "laws": laws, "controller": DESIGN, "knowledge": know(WRIST, [], SPREADS)}
    verdict = judge(
        Findings(
            **known,
            check=SimpleNamespace(missing=(), logs=()),
            demand=SimpleNamespace(exceeded=(), demands=()),
            resonance=SimpleNamespace(refuses=False, alarm="", verdict="", slack=False),
        )
    )
    assert verdict.answer == "unknown", verdict
    assert verdict.reasons[-1] == "12 of 12 runs on lumped plants ended early: unstable or slack"
    assert "raise cable.pretension" in verdict.remedies[0], "no encoder mends a slack span"
    assert not any(margin.name.startswith("error") for margin in verdict.margins)
    blocks = acceptance_chapter(SimpleNamespace(**known, carried=False, runs=none, cable=cable)).blocks
    assert not [block for block in blocks if isinstance(block, Figure)]
    assert any("All 12 runs on lumped plants ended early" in str(getattr(b, "note", "")) for b in blocks)


def test_a_run_that_flies_apart_leaves_plain_numbers():
    """A law far too quick for its filter and a motor without limit: no infinity, nothing invented."""
    free = replace(WRIST, motor=replace(WRIST.motor, torque_limit=None))
    runs = accepted(1e9, drive=free, law=replace(LAW, bandwidth=900.0), draws=4)
    assert runs.failed == 4, runs
    assert runs.largest_torque is None, "what a diverging law asked for is no torque of the drive"
    text = json.dumps(as_plain(runs), allow_nan=False)
    assert "1e9" not in text
    assert "1000000000" not in text


def test_quantiles_count_runs_that_ended_early_as_worse_than_any_error():
    """Of ten runs with errors of 1 to 10 deg the last two ended early: the median is known, the worst not."""
    peak = tuple(n * DEGREE for n in range(1, 11))
    runs = Draws(peak=peak, later_peak=peak, failed=(False,) * 8 + (True,) * 2)
    assert runs.quantile(0.5) == pytest.approx(5.0)
    assert replace(runs, learns=True).quantile(0.99) is None
    assert runs.quantile(1.0) is None


def test_where_no_law_has_an_error_the_one_of_which_the_fewest_runs_ended_early_is_chosen():
    """The first of the list was taken: of corexy at 1010 Hz pd, 7 of 60 ended early, for pid's 3."""
    scores = [
        AcceptanceResult(plant="lumped", law=replace(LAW, controller=name), draws=60, peaks=(0.01,) * lasted)
        for name, lasted in (("pd", 53), ("pid", 57), ("lqg", 46))
    ]
    assert [one.reached.error for one in scores] == [None] * 3
    assert closest(scores) is scores[1]
    assert closest([*scores, replace(scores[2], peaks=(0.02,) * 60)]).peaks[-1] == 0.02, (
        "an error comes first"
    )


def test_a_comparison_ranks_laws_that_all_miss_the_goal_by_early_ends_before_errors():
    """Of five runs outside the goal one or four end early: both have an infinite largest error."""
    one, four, none = (
        Draws(peak=(error,) * 5, failed=(True,) * early + (False,) * (5 - early))
        for error, early in ((0.1, 1), (0.1, 4), (0.2, 0))
    )
    ranked = sorted((four, one, none, Draws()), key=lambda law: law.rank(0.05))
    assert [sum(law.failed) for law in ranked] == [0, 1, 4, 0], [law.rank(0.05) for law in ranked]
    assert ranked[-1].peak == (), "a law without runs comes last"
