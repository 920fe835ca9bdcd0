"""`cabledrive compare`: its files and keys, its refusals, a second run from what is kept."""

import json
import time

import pytest

from cabledrive.rig import trial
from cabledrive.rig.laws.registry import CONTROLLERS
from command import answer, refusal

ASKED = "compare dissertation-3 --controllers lqg,lqi-learning --draws 3 --rise 0.4 --dwell {}"
FEW = ASKED.format("0.1").split()


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    out = tmp_path_factory.mktemp("compare") / "out"
    return out, answer(*FEW, "-o", out)


def test_json_and_files_have_what_the_contract_promises(finished):
    out, found = finished
    assert {one["name"] for one in found["controllers"]} == {"lqg", "lqi-learning"} <= set(CONTROLLERS)
    for one in found["controllers"]:
        assert 0.0 < one["median_deg"] <= one["worst_deg"]
        assert 0.0 <= one["share_low"] <= one["share_within"] <= 1.0
        assert 0.0 < one["torque_ripple"] <= found["limits"]["torque_ripple"]
        assert one["disk_margin"] >= found["limits"]["disk_margin"]
        assert one["peak_torque"] > 0.0
        assert one["gain_margin"] > 1.0
        assert one["phase_margin_deg"] > 0.0
        assert one["tuning_seconds"] > 0.0
        assert one["runs"] == 3
    assert found["best"] == found["controllers"][0]["name"]
    written = json.loads((out / "results.json").read_text())
    assert written["controllers"] == found["controllers"]
    assert written["provenance"]["drive_hash"]
    page = (out / "report.html").read_text()
    assert "lqi-learning" in page
    assert "http" not in page.replace("http://www.w3.org", "")


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
