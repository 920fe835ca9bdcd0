"""`cabledrive compare`: its files and keys, its refusals, a second run from what is kept."""

import time

import pytest

from cabledrive.rig import trial
from command import answer, refusal

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
