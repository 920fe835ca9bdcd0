"""Indices, yields and tolerances agree with functions whose answers are known."""

import json
import re
import shlex
from base64 import b64decode
from itertools import chain
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import cabledrive as cd
from cabledrive.campaign.results import indices
from campaign_computations import Dangerous, Ishigami, swept
from command import answer, refusal, run

A, B = 7.0, 0.1
VARIANCE = A**2 / 8 + B * np.pi**4 / 5 + B**2 * np.pi**8 / 18 + 0.5
FIRST = np.array([0.5 * (1 + B * np.pi**4 / 5) ** 2, A**2 / 8, 0.0]) / VARIANCE
TOTAL = FIRST + np.array([1.0, 0.0, 1.0]) * B**2 * np.pi**8 * (1 / 18 - 1 / 50) / VARIANCE

KEYS = "".join(f'"own.x{i}" = {{ from = {-np.pi}, to = {np.pi} }}\n' for i in (1, 2, 3))
ISHIGAMI = f'drive = "dissertation-3"\n[vary]\n{KEYS}[design]\nkind = "saltelli"\nbase = 512\nseed = 2\n'


@pytest.fixture(scope="module")
def ishigami(tmp_path_factory):
    return swept(tmp_path_factory.mktemp("ishigami"), ISHIGAMI, computation=Ishigami()).store


def test_the_indices_of_ishigami_s_function_lie_in_their_intervals(ishigami):
    found = answer("sensitivity", str(ishigami), "--output", "y")
    assert (found["output"], found["rows"], found["groups_left_out"]) == ("y", 512 * 5, 0)
    assert found["standard_deviation"] == pytest.approx(np.sqrt(VARIANCE), rel=0.03)
    for i, key in enumerate(f"own.x{n}" for n in (1, 2, 3)):
        for kind, truth in (("first", FIRST[i]), ("total", TOTAL[i])):
            index = found[kind][key]
            assert index["low"] <= truth <= index["high"], (key, kind, index, truth)
            assert index["high"] - index["low"] < 0.35
            assert index["low"] <= index["value"] <= index["high"]


def test_bootstrap_intervals_hold_the_truth_as_often_as_they_say():
    """Of y = x1 + 2 x2, x normal: indices 0.2 and 0.8. 95 % intervals, 30 repetitions of 64 groups."""
    generator, held, asked = np.random.default_rng(4), 0, 0
    for _ in range(30):
        a, b = generator.normal(size=(2, 64, 2))
        mixed = [
            a[:, 0] * (i != 0) + b[:, 0] * (i == 0) + 2 * (a[:, 1] * (i != 1) + b[:, 1] * (i == 1))
            for i in (0, 1)
        ]
        groups = np.column_stack((a @ [1.0, 2.0], b @ [1.0, 2.0], *mixed))
        for truth, one in zip((0.2, 0.8, 0.2, 0.8), chain(*indices(groups, generator)), strict=True):
            held, asked = held + (one["low"] <= truth <= one["high"]), asked + 1
    assert 0.86 <= held / asked <= 0.99, f"{held} of {asked}"


def test_screening_finds_the_effects_of_a_product_and_a_line(tmp_path):
    """y = x1 x2 - 3 x3 over [0, 2]: effects of x1 are 2 x2: mean 2, deviation 1.118."""
    keys = "".join(f'"own.x{i}" = {{ from = 0, to = 2 }}\n' for i in (1, 2, 3, 4))
    text = f'drive = "dissertation-3"\n[vary]\n{keys}[design]\nkind = "morris"\nbase = 400\nseed = 5\n'

    class Product(Ishigami):
        def one(self, row):
            return {"y": row.own["x1"] * row.own["x2"] - 3.0 * row.own["x3"]}

    store = swept(tmp_path, text, computation=Product()).store
    found = answer("sensitivity", str(store), "--output", "y")
    assert (found["rows"], found["groups"], found["groups_left_out"]) == (2000, 400, 0)
    assert next(iter(found["effects"])) == "own.x3"
    line, idle = found["effects"]["own.x3"], found["effects"]["own.x4"]
    assert line["mean"] == pytest.approx(-6.0)
    assert line["mean_size"]["value"] == pytest.approx(6.0)
    assert line["deviation"] == pytest.approx(0.0, abs=1e-12)
    assert idle["mean_size"]["value"] == idle["deviation"] == 0.0
    for key in ("own.x1", "own.x2"):
        bent = found["effects"][key]
        assert bent["mean_size"]["low"] <= 2.0 <= bent["mean_size"]["high"], bent
        assert bent["deviation"] == pytest.approx(np.sqrt(1.25), rel=0.05)


def test_yield_and_tolerance_of_a_limit_on_one_key(tmp_path):
    """y = x^2 + noise below 7, x uniform from 0 to 8: y < 23 below sqrt(17) always, above sqrt(23) never."""
    text = 'drive = "dissertation-3"\n[vary]\n"own.x" = { from = 0, to = 8 }\n'
    text += '"own.idle" = { from = 0, to = 1 }\n[design]\nkind = "sobol"\nrows = 2048\n'
    store = swept(tmp_path, text, computation=Dangerous(folder=str(tmp_path))).store
    found = answer("tolerance", str(store), "--goal", "square < 23", "--target", "0.999")
    assert np.sqrt(17.0) / 8.0 < found["yield"] < np.sqrt(23.0) / 8.0
    assert found["yield_low"] < found["yield"] < found["yield_high"]
    first = next(iter(found["keys"]))
    assert first == "own.x"
    tight = found["keys"]["own.x"]["tightened"]
    assert tight["low"] < 0.01
    assert 3.6 <= tight["high"] <= np.sqrt(17.0) + 0.05
    assert found["keys"]["own.idle"]["tightened"] is None
    slope = found["keys"]["own.x"]["gain_per_high"]
    assert slope == pytest.approx(found["yield"] / 8.0, rel=0.1), "(Y - 0) times the density 1/8"


def test_the_page_of_a_campaign_needs_nothing_else_and_gives_the_worst_machines_with_their_files(tmp_path):
    text = 'drive = "dissertation-3"\n[vary]\n"cable.pretension" = { from = "-0.2 N", to = "7 N" }\n'
    text += '"pulley.1.inertia" = { normal = ["23.5 kg cm^2", "1 kg cm^2"] }\n'
    text += '[design]\nkind = "sobol"\nrows = 128\n[compute]\nwhat = "modes"\ncount = 2\n'
    store, page = swept(tmp_path, text).store, tmp_path / "page.html"
    answer("report", str(store), "--goal", "longitudinal_hz[0] < 5.9 Hz", "-o", str(page))
    html = page.read_text()
    assert not re.findall(r'(?:src|href)="(?!data:|#)', html)
    assert "must be above 0" in html
    data = xr.open_zarr(store).load()
    held = float(np.mean((data.code == 0) & (data.longitudinal_hz[:, 0] < 5.9)))
    assert f"{100 * held:.2f}" in html
    files = [b64decode(text) for text in re.findall(r"data:application/toml;base64,([\w+/=]+)", html)]
    assert len(files) == 10
    worst = int(np.nanargmax(data.longitudinal_hz[:, 0]))
    (tmp_path / "worst.toml").write_bytes(files[0])
    drive = cd.load_drive(tmp_path / "worst.toml")
    assert drive.cable.pretension == float(data["cable.pretension"][worst])
    assert drive.load_pulley.inertia == float(data["pulley.1.inertia"][worst])
    assert "--goal" in refusal("report", "elevator", "--goal", "y < 3", "-o", str(tmp_path / "b.html"))


# --- The tolerance study of the page on campaigns runs as it is printed
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
