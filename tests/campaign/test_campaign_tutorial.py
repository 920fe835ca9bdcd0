"""The tutorial of the page on campaigns runs as it is printed, and says what the drive says."""

import json
import re
import shlex
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import cabledrive as cd
from cabledrive.studies.study import Goals, run_study
from cabledrive.studies.study.results_file import results_of
from command import run

ROOT = Path(__file__).parents[2]
PAGE, EXAMPLE = ROOT / "docs" / "campaigns.md", ROOT / "examples" / "tolerance_campaign.toml"


@pytest.mark.verify
def test_from_one_drive_to_a_tolerance_study(tmp_path, monkeypatch):
    tutorial = PAGE.read_text().split("## From one drive to a tolerance study")[1].split("\n## ")[0]
    spec = re.search(r"```toml\n(.*?)```", tutorial, re.S)[1]
    assert EXAMPLE.read_text() == spec
    commands = re.findall(r"^\$ cabledrive (.*)$", tutorial, re.M)
    assert [line.split()[0] for line in commands] == ["sweep", "sensitivity", "tolerance", "report"]
    (tmp_path / "campaign.toml").write_text(spec)
    monkeypatch.chdir(tmp_path)
    answers = {}
    for line in commands:
        words = shlex.split(line)
        done = run(*words, "--json")
        assert done.returncode == 0, (line, done.stderr)
        answers[words[0]] = json.loads(done.stdout)
    data = xr.open_zarr("campaign.zarr").load()
    first = data.longitudinal_hz[:, 0]
    assert (answers["sweep"]["done"], answers["sweep"]["failed"]) == (1280, 0)
    # the share of rows that keep the goal, counted here
    kept = float(np.mean(first.values[data.code.values == 0] > 5.9))
    assert 0.0 < kept < 1.0, "the goal of the tutorial asks nothing"
    assert answers["tolerance"]["yield"] == pytest.approx(kept, abs=1e-12)
    assert set(answers["sensitivity"]["total"]) == {key for key in data if "." in key}
    page = (tmp_path / "campaign.html").read_text()
    assert f"{1280}" in page
    assert "longitudinal_hz" in page


STUDY = """
drive = "dissertation-3"
[vary]
"pulley.1.inertia" = { values = ["23 kg cm^2"] }
[goals]
draws = 40
cable_draws = 0
[design]
kind = "list"
[compute]
what = "study"
"""


@pytest.mark.verify
def test_a_row_of_a_study_is_the_study_with_its_seed(tmp_path):
    (tmp_path / "spec.toml").write_text(STUDY)
    sweep = cd.run_sweep(tmp_path / "spec.toml", tmp_path / "study.zarr", progress=False)
    data = sweep.open().load()
    assert (sweep.done, sweep.refused, sweep.failed) == (1, 0, 0), data.reason.values
    drive = cd.load_drive("dissertation-3", overrides=["pulley.1.inertia=23 kg cm^2"])
    goals = Goals(draws=40, cable_draws=0, carriage_draws=400, seed=int(data.seed[0]))
    alone = run_study(drive, (), goals)
    assert float(data.time[0]) > 0.0
    said = results_of(alone)
    assert data.verdict.values[0] == said["verdict"]
    assert float(data.reached_error_deg[0]) == pytest.approx(said["reached_error_deg"], rel=1e-9)
    assert data.headline.values[0] == said["headline"]
