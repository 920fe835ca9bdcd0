"""The tutorial and the how-tos run as they are written."""

import re
import shlex
import shutil
import subprocess
import tomllib
from pathlib import Path

import numpy as np
import pytest

from cabledrive.identification.logs.reading import read_log
from cabledrive.studies.study.goals import Goals, goals_of
from command import call

DOCS = Path(__file__).resolve().parent.parent / "docs"
TUTORIAL, HOWTO, STUDY = ((DOCS / name).read_text() for name in ("tutorial.md", "guide_howto.md", "study.md"))
FILES = re.findall(r"```\{code-block\} toml\n:caption: (\S+)\n\n(.*?)```", TUTORIAL, re.S)
COMMANDS = re.findall(r"^\$ cabledrive (.+)\n((?:(?!\$|```).*\n)*)", TUTORIAL, re.M)
FEW = "\n[acceptance]\ndraws = 300\ncable_draws = 0\n"
NUMBER = re.compile(r"\d+(?:\.\d+)?")


def says_the_same(printed, shown):
    """Whether the first lines are those shown; the worst of some plants within 2 %.

    A count of an encoder more or less is decided by the last bit of a processor's arithmetic.
    """
    lines = "".join(printed.splitlines(keepends=True)[: shown.count("\n")])
    values, wanted = (np.array([float(v) for v in NUMBER.findall(text)]) for text in (lines, shown))
    return NUMBER.sub("#", lines) == NUMBER.sub("#", shown) and np.allclose(values, wanted, rtol=0.02)


@pytest.mark.verify
def test_the_tutorial_runs_from_an_empty_folder_and_prints_what_it_shows(tmp_path, monkeypatch):
    """Fewer plants than a reader's and no drawing; of a study the line with the verdict is compared."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("cabledrive.report.study_page.study_html", lambda result: result.drive.name)
    assert [name for name, _ in FILES] == ["my-axis.toml", "shake.toml", "study.toml"]
    for name, content in FILES:
        Path(name).write_text(content + (FEW if name == "study.toml" else ""))
    for line, shown in COMMANDS:
        done = call(*shlex.split(line))
        assert done.exit_code == 0, f"{line}: {done.stderr}"
        if line.startswith("study"):
            assert says_the_same(done.stdout, shown), f"{line}: {done.stdout}"
        elif shown:
            assert done.stdout == shown, line
    listed = re.findall(r"^\| `([\w.]+)/?` \|", TUTORIAL, re.M)
    assert sorted(path.name for path in Path("study").iterdir()) == sorted(listed)
    line, shown = re.search(r"^\$ (cd firmware .+)\n((?:(?!```).*\n)*)", TUTORIAL, re.M).groups()
    if shutil.which("cc"):
        done = subprocess.run(line, shell=True, capture_output=True, text=True, check=False)
        assert (done.returncode, done.stdout) == (0, shown), done.stderr


@pytest.mark.parametrize("line", re.findall(r"^\$ cabledrive (.+)", HOWTO, re.M))
def test_commands_of_the_howtos_run(line):
    assert call(*shlex.split(line)).exit_code == 0


@pytest.mark.parametrize("block", re.findall(r"```toml\n(.*?)```", HOWTO, re.S))
def test_goals_of_the_howtos_are_understood(block):
    assert goals_of(tomllib.loads(block)) != Goals()


def test_the_log_of_the_howto_is_read_with_its_names_and_units(tmp_path):
    """1 N mm and 360 deg in the file are 1e-3 N m and 2 pi in the log."""
    block = next(block for block in re.findall(r"```toml\n(.*?)```", HOWTO, re.S) if "[log.columns]" in block)
    rows = "".join(f"{k / 1000},{k % 7},{k},{2 * k}\n" for k in range(181))
    (tmp_path / "log.csv").write_text(f"t,tau,theta_m,theta_l\n{rows}")
    log = read_log(tmp_path / "log.csv", goals_of(tomllib.loads(block)).columns)
    assert sorted(log.channels) == ["angle", "load_angle", "torque"]
    assert log.channel("torque")[1] == pytest.approx(1e-3)
    assert log.channel("load_angle")[-1] == pytest.approx(2.0 * np.pi)


def test_the_page_on_the_study_names_every_key_of_its_file():
    from cabledrive.studies.study.goals import COUNTS, QUANTITIES, SPREADS

    named = set(re.findall(r"`(\w+)`", STUDY.split("## `study.toml`")[1]))
    assert {*COUNTS, *QUANTITIES, *SPREADS, "load_inertia"} <= named
