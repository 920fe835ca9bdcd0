"""A study as a row of a campaign is the study of the command."""

import tomllib

import pytest

from cabledrive.campaign.rows import compute_rows
from cabledrive.campaign.spec import spec_of
from command import answer

SPEC = """
drive = "dissertation-3"
[vary]
"pulley.1.inertia" = { values = ["24 kg cm^2"] }
[goals]
error = "0.2 deg"
[design]
kind = "list"
seed = 7
[compute]
what = "study"
"""


@pytest.mark.verify
def test_a_row_has_the_verdict_error_and_law_of_the_command(tmp_path, measured):
    campaign = spec_of(tomllib.loads(SPEC), tmp_path)
    chunk = compute_rows(campaign, 0, 1)
    row = chunk.variables
    (tmp_path / "goals.toml").write_text(f'error = "0.2 deg"\nseed = {chunk.seed[0]}\n')
    machine = ["dissertation-3", "--set", "pulley.1.inertia=24 kg cm^2"]
    asked = ["--goals", str(tmp_path / "goals.toml"), "--quick", "-o", str(tmp_path / "study")]
    said = answer("study", *machine, *asked)
    measured(f"{row['verdict'][0]}: {row['chosen_controller'][0]}, {row['reached_error_deg'][0]:.4g} deg")
    assert chunk.code[0] == 0
    assert row["verdict"][0] == said["verdict"]
    assert row["headline"][0] == said["headline"]
    assert row["reached_error_deg"][0] == said["reached_error_deg"]
    assert chunk.time[0] > 0.0
