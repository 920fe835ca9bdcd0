"""`cabledrive track` and `study`: the contract's objects and files, their refusals, what is kept."""

import json
import re
import time

import pytest

from cabledrive.rig import trial
from command import answer, call, object_of, refusal
from report_page import Reader
from study_drives import FOLDER

FAST = ("--angle", "10", "--rise", "0.2", "--dwell", "0.05")


@pytest.mark.parametrize(("law", "asked", "least"), [("darc-2", "4", 11.6), ("darc-4", "8", 11.2)])
def test_a_bandwidth_below_the_least_is_refused_in_one_line(law, asked, least, measured):
    line = refusal("track", "dissertation-3", "--controller", law, "--bandwidth", asked)
    named = float(re.search(r"below ([\d.]+) Hz", line)[1])
    measured(f"{law} is refused below {named:g} Hz")
    assert named == least


def test_a_slack_span_ends_with_status_3_and_what_was_found():
    push = ("--disturbance", "load:0.9:0.05")
    done = call("track", "dissertation-3", "--json", *FAST, *push)
    assert done.exit_code == 3
    assert "went slack" in done.stderr
    assert json.loads(done.stdout)["ended_at"] < 0.2
    assert answer("track", "dissertation-3", *FAST, *push, "--tension-only")["slack_samples"] > 0


def test_identify_reads_the_log_of_a_run(tmp_path, measured):
    """Quiet pulses of a rigid drive: inertia within 0.5 %, Coulomb friction within 5 %."""
    path = tmp_path / "run.csv"
    pulses = ("--controller", "pd", "--bandwidth", "2", "--pulses", "4", "--rise", "0.3", "--dwell", "0.3")
    call("track", "dissertation-3", "--plant", "model-1", *pulses, "--log", str(path))
    found = answer("identify", str(path))
    value = {name: one["value"] for name, one in found["parameters"].items()}
    inertia, coulomb = 0.0011 + 0.000642 + 0.00235, 0.0376
    off = [100 * (value["inertia"] / inertia - 1), 100 * (value["coulomb_friction"] / coulomb - 1)]
    measured(f"inertia {off[0]:+.2f} %, Coulomb friction {off[1]:+.2f} %")
    assert found["identifiable"] is True
    assert value["inertia"] == pytest.approx(inertia, rel=0.005)
    assert value["coulomb_friction"] == pytest.approx(coulomb, rel=0.05)


def test_two_winches_answer_with_position_tension_and_torque():
    found = answer("track", "camera-winches", "--move", "camera.x=0.4m", "--least-tension", "300 N")
    assert found["peak_error_mm"] < 5.0
    assert found["least_allowed"] == 300.0 < found["least_tension"]
    assert [line["name"] for line in found["lines"]] == ["left line", "right line"]
    assert found["lines"][0]["spans"] == ["left winch to left sheave", "left sheave to left clamp"]
    assert all(0.0 < motor["peak_torque"] <= 140.0 for motor in found["motors"])
    assert found["tension_kept"]
    assert found["within_bound"]


def test_a_tension_that_is_not_kept_is_status_3_with_its_reason():
    ended = call(
        *("track", "camera-winches", "--json", "--rise", "1.0", "--pulses", "1"),
        *("--disturbance", "camera.y:-1500:0.5:0.9"),
    )
    assert ended.exit_code == 3, ended.stderr
    assert not json.loads(ended.stdout)["tension_kept"]
    assert "below the least" in ended.stderr


def test_a_pair_of_motors_answers_with_its_flanks_and_what_is_left_at_rest():
    law = ("--controller", "lqg", "--bandwidth", "15")
    loose = ("track", "dissertation-3", "--set", "motor.backlash=1 deg", *law)
    found = answer(*loose, "--pair", "--preload", "0.6 N m")
    assert found["pair"]["preload"] == pytest.approx(0.6)
    assert found["pair"]["flanks_closed"] is True
    assert min(found["pair"]["least_flank_torque"]) > 0.0
    assert found["limit_cycle"] is False
    assert answer(*loose)["limit_cycle"] is True
    assert "limit cycle" in call(*loose).stdout


@pytest.mark.parametrize("axis", ["head.x", "beam.y"])
def test_an_axis_of_a_machine_whose_axes_couple_says_what_the_other_one_does(axis):
    """The example of the help of --axis: the head of `corexy` stands 40 mm off the middle."""
    said = answer("track", "corexy", "--axis", axis, "--bandwidth", "40")["axis"]
    other = said["cross_motion"]
    assert {said["load"], other["other"]} == {"head.x", "beam.y"}
    assert 0.0 < max(other["load"]) < 1e-5 < 1e-3 * said["peak_error_mm"]


# --- cabledrive compare: a second run from what is kept; the law that it ranks first
ASKED = "compare dissertation-3 --controllers lqg,lqi-learning --draws 3 --rise 0.4 --dwell {}"
FEW = ASKED.format("0.1").split()


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    out = tmp_path_factory.mktemp("compare") / "out"
    return out, answer(*FEW, "-o", out)


def test_the_same_command_goes_on_from_what_is_kept_and_another_does_not_replace_it(finished):
    out, found = finished
    begun = time.perf_counter()
    assert answer(*FEW, "-o", out)["controllers"] == found["controllers"]
    assert time.perf_counter() - begun < 10.0
    assert "holds other results" in refusal(*ASKED.format("0.2").split(), "-o", out)


@pytest.fixture
def two_laws_on_three_plants(monkeypatch):
    """What `track --controller best` compares, cut down to what `finished` compares."""
    monkeypatch.setattr(trial, "offered", lambda *machine: ("lqg", "lqi-learning"))
    monkeypatch.setattr(trial, "BEST_DRAWS", 3)
    trial.best_law.cache_clear()
    yield
    trial.best_law.cache_clear()


def test_track_best_runs_the_law_that_the_comparison_ranks_first(finished, two_laws_on_three_plants):
    """The same winner with the same errors; the run says which it is, at the bandwidth that was tuned."""
    _, found = finished
    motion = ("--rise", "0.4", "--dwell", "0.1", "--pulses", "2")
    said = answer("track", "dissertation-3", "--controller", "best", *motion)
    assert said["controller"] == said["best"]["controller"] == found["best"]
    assert said["best"]["draws"] == 3
    for one in said["best"]["candidates"]:
        (same,) = (law for law in found["controllers"] if law["name"] == one["name"])
        assert one["worst_deg"] == pytest.approx(same["worst_deg"], rel=1e-9)
        assert one["median_deg"] == pytest.approx(same["median_deg"], rel=1e-9)


# --- cabledrive study: the contract's files and keys, its refusals, a second run from the cache
WINCH = str(FOLDER / "winch.toml")
GOALS = '[goals]\nerror = "0.5 deg"\n[motion]\nangle = "30 deg"\nduration = "0.3 s"\ndwell = "0.1 s"\n'
DRAWS = "[acceptance]\ndraws = 300\ncable_draws = 0\n"


@pytest.fixture(scope="module")
def studied(tmp_path_factory):
    """A finished study of the turntable by its data sheet, with its answer."""
    folder = tmp_path_factory.mktemp("turntable")
    (folder / "study.toml").write_text(GOALS + DRAWS)
    arguments = ["study", str(FOLDER / "turntable.toml"), "--goals", str(folder / "study.toml")]
    return [*arguments, "-o", str(folder / "out")], folder / "out", answer(*arguments, "-o", folder / "out")


def test_the_report_needs_nothing_else_and_starts_with_the_verdict(studied, measured):
    _, out, found = studied
    text = (out / "report.html").read_text()
    page = Reader(text).root
    loaded = [e.attributes for tag in ("link", "img", "iframe", "script") for e in page.all(tag)]
    others = [one for one in loaded if one.get("src", one.get("href", "data:,")) != "data:,"]
    pictures = [e.attributes for e in page.all("div") if e.attributes.get("role") == "img"]
    measured(f"{len(text) / 1e6:.2f} MB, {len(pictures)} pictures, {len(others)} other files loaded")
    assert others == []
    assert not re.search(r"url\((?!#)", text)
    headings = [e.attributes["id"] for e in page.all("h2")]
    assert (headings[0], headings[-1]) == ("verdict-title", "provenance-title")
    assert len(pictures) >= 5
    assert all(one.get("aria-label") for one in pictures)
    assert len(text) < 15e6
    assert found["provenance"]["drive_hash"] in text


def test_a_second_run_is_served_and_changes_no_file(studied):
    arguments, out, found = studied
    before = {path: path.stat().st_mtime_ns for path in out.rglob("*")}
    result = call(*arguments, "--json")
    assert "finished study" in result.stderr
    assert {**object_of(result.stdout), "provenance": 0} == {**found, "provenance": 0}
    assert {path: path.stat().st_mtime_ns for path in out.rglob("*")} == before


def test_a_no_is_an_answer_and_not_a_failure(tmp_path, monkeypatch):
    monkeypatch.setattr("cabledrive.report.study.results.study_html", lambda result: "drawn elsewhere")
    (tmp_path / "hasty.toml").write_text(GOALS.replace("30 deg", "90 deg"))
    asked = ["--goals", tmp_path / "hasty.toml", "--quick", "--json"]
    result = call("study", WINCH, *asked, "-o", tmp_path / "out")
    found = object_of(result.stdout)
    assert (result.exit_code, found["verdict"]) == (0, "no")
    assert found["reasons"][0].startswith("torque")
    assert not (tmp_path / "out" / "controller.json").exists()
