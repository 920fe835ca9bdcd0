"""The tolerance study of the page on campaigns runs as it is printed, and says what the drive says."""

import json
import re
import shlex
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from command import run

ROOT = Path(__file__).parents[2]
PAGE, EXAMPLE = ROOT / "docs" / "campaigns_export.md", ROOT / "examples" / "tolerance_campaign.toml"


@pytest.mark.verify
def test_from_one_drive_to_a_tolerance_study(tmp_path, monkeypatch):
    tutorial = PAGE.read_text().split("### From one drive to a tolerance study")[1].split("\n### ")[0]
    spec = re.search(r":caption: campaign.toml\n\n(.*?)```", tutorial, re.S)[1]
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
