"""What the pages of the documentation show is what commands and Python print."""

import contextlib
import importlib
import io
import pkgutil
import re
import runpy
import shlex
import shutil
import subprocess
import sys
from math import pi, sin
from pathlib import Path

import numpy as np
import pytest
from click import Context
from click.testing import CliRunner

import cabledrive as cd
from cabledrive.app.main import main
from cabledrive.studies.study.goals import COUNTS, QUANTITIES, SPREADS
from command import call

ROOT = Path(__file__).resolve().parent.parent
DOCS = ROOT / "docs"
PAGES = {
    path.stem: path.read_text(encoding="utf-8") for path in [ROOT / "README.md", *sorted(DOCS.glob("*.md"))]
}
PICTURE = DOCS / "_static" / "elevator-modes.svg"
STEP = re.compile(
    r"^```\{code-block\} toml\n:caption: (?P<file>\S+)\n\n(?P<content>.*?)^```"
    r"|^\$ (?P<line>[^\n]+)\n(?P<said>(?:(?!\$ |```)[^\n]*\n)*)"
    r"|^```python\n(?P<code>.*?)^```\n(?:\n```text\n(?P<printed>.*?)^```\n)?",
    re.S | re.M,
)
MOVE = "time [ms],torque [mN m]\n" + "".join(f"{k},{4 * sin(2 * pi * 0.08174 * k):.6g}\n" for k in range(400))
"""A motion for the page that reads one: 4 mN m at the pulley mode of its drive."""
SHARED = "../shared/data"
LONG = re.compile(r"cd\.compare\(|run_study\(|identify\(|run_sweep\(")
"""Python that identifies, compares, studies or sweeps for seconds: run by ``make verify``."""
FEW = "\n[acceptance]\ndraws = 300\ncable_draws = 0\n"
NUMBER = re.compile(r"\d+(?:\.\d+)?")
MACHINES = ("An axis with a log", "A printer", "A lift", "An arm")


def shows(printed, shown):
    """Whether a text is the one shown; a line of three dots stands for any lines."""
    parts = [re.escape(part) for part in re.split(r"^\.\.\.\n", shown, flags=re.M)]
    return re.fullmatch("(?:.*\n)*?".join(parts), printed.replace("\u202f", " ")) is not None


def shows_nearly(printed, shown):
    """Whether the first lines are those shown; the worst of some plants within 2 %.

    A count of an encoder more or less is decided by the last bit of a processor's arithmetic.
    """
    lines = "".join(printed.splitlines(keepends=True)[: shown.count("\n")])
    values, wanted = (np.array([float(v) for v in NUMBER.findall(text)]) for text in (lines, shown))
    return NUMBER.sub("#", lines) == NUMBER.sub("#", shown) and np.allclose(values, wanted, rtol=0.02)


def run_python(code, names):
    """What a block prints."""
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(compile(code, "page", "exec"), names)
    return printed.getvalue()


def run_command(line, said):
    """Run one line; what is shown below it is its output, or the refusal."""
    if not line.startswith("cabledrive "):
        if shutil.which("cc"):
            done = subprocess.run(line, shell=True, capture_output=True, text=True, check=False)
            assert (done.returncode, done.stdout) == (0, said), done.stderr
        return
    refused = said.startswith("cabledrive: ")
    done = call(*shlex.split(line, comments=True)[1:])
    assert done.exit_code == (2 if refused else 0), f"{line}: {done.stderr}"
    if said:
        same = shows_nearly if " study " in line else shows
        assert same(done.stderr if refused else done.stdout, said), f"{line}:\n{done.stdout}{done.stderr}"


def run_page(text, whole):
    """Write the files, run the Python and the commands of a page in their order; their number.

    ``whole``: every command, and Python that takes seconds; else commands whose output is shown.
    """
    names, steps = {}, 0
    for step in STEP.finditer(text):
        if step["file"]:
            Path(step["file"]).write_text(step["content"] + (FEW if step["file"] == "study.toml" else ""))
        elif step["line"] and (whole == "commands" or step["said"]):
            run_command(step["line"], step["said"])
        elif step["code"] and (whole or not LONG.search(step["code"])):
            printed = run_python(step["code"], names)
            assert not step["printed"] or printed == step["printed"], printed
        else:
            continue
        steps += 1
    return steps


@pytest.mark.parametrize(
    ("page", "whole"),
    [(page, False) for page in PAGES if page != "tutorial"]
    + [
        pytest.param(page, True, marks=pytest.mark.verify)
        for page, text in PAGES.items()
        if any(LONG.search(step["code"] or "") for step in STEP.finditer(text))
    ],
)
def test_a_page_runs_and_prints_what_it_shows(page, whole, tmp_path, monkeypatch, measured):
    text = PAGES[page]
    project, shared = tmp_path / "project", ROOT.parent / "shared"
    project.mkdir()
    (project / "move.csv").write_text(MOVE)
    if shared.exists():
        (tmp_path / "shared").symlink_to(shared)
    monkeypatch.chdir(project)
    if whole and SHARED in text and not (project / SHARED).exists():
        pytest.skip(f"{page} needs the measured logs {SHARED}, which are not here")
    try:
        steps = run_page(text, whole)
    except cd.InputRefused as refusal:
        if "with its extra" not in str(refusal):
            raise
        pytest.skip(str(refusal))
    measured(f"{page}: {steps} blocks and commands as shown")


@pytest.mark.verify
@pytest.mark.parametrize("machine", MACHINES)
def test_the_tutorial_runs_from_an_empty_folder_and_prints_what_it_shows(machine, tmp_path, monkeypatch):
    """Fewer plants than a reader's, no drawing of the study, of whose lines the verdict is compared."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("cabledrive.report.study.results.study_html", lambda result: result.drive.name)
    text = PAGES["tutorial"].split(f"\n## {machine}\n")[1].split("\n## ")[0]
    assert run_page(text, "commands") >= 6
    if "study" in text and machine == MACHINES[0]:
        listed = re.findall(r"^\| `([\w.]+)/?` \|", text, re.M)
        assert sorted(path.name for path in Path("study").iterdir()) == sorted(listed)


def test_the_front_page_lists_every_command():
    listed = re.findall(r"^\| `cabledrive (\w+)", PAGES["index"], re.M)
    assert sorted(listed) == main.list_commands(Context(main))


def test_the_page_on_the_study_names_every_key_of_its_file():
    named = set(re.findall(r"`(\w+)`", PAGES["study"].split("## `study.toml`")[1].split("\n## ")[0]))
    assert {*COUNTS, *QUANTITIES, *SPREADS, "load_inertia"} <= named


def test_the_reference_shows_every_example_under_its_question(monkeypatch):
    monkeypatch.syspath_prepend(DOCS / "_ext")
    from reference import examples

    shown = examples()
    scripts = sorted(path.name for path in (ROOT / "examples").glob("*.py"))
    assert re.findall(r"literalinclude\} ../../examples/(\S+)", shown) == scripts
    headings = re.findall(r"^## (.+)$", shown, re.M)
    assert len(set(headings)) == len(scripts), headings


def words_of(picture):
    """The texts of a drawing; matplotlib writes each as a comment above its outlines."""
    return re.findall(r"<!-- (.*?) -->", picture.read_text(encoding="utf-8"))


def test_the_picture_of_modes_is_what_the_code_draws(tmp_path):
    again = tmp_path / "again.svg"
    script = [sys.executable, DOCS / "readme_picture.py", again]
    drawn = subprocess.run(script, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert drawn.returncode == 0, drawn.stderr
    assert words_of(again) == words_of(PICTURE), f"draw it again: docs/readme_picture.py {PICTURE.name}"
    assert any(words.startswith("3.5145 Hz") for words in words_of(PICTURE))


def test_every_file_that_a_page_names_is_there():
    named = re.compile(r"`((?:src|tests|docs|tools|benchmarks|examples|reproduction)/[\w./-]+)")
    texts = {**PAGES, "CONTRIBUTING": (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")}
    found = {(page, path) for page, text in texts.items() for path in named.findall(text)}
    assert found
    assert {(page, path) for page, path in found if not (ROOT / path).exists()} == set()


def test_a_law_a_format_and_a_command_enter_where_contributing_says(tmp_path, monkeypatch):
    """Its snippets run, with the names of the modules that they are written for."""
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    names = {"np": np}
    for module in ("rig.laws.baselines", "rig.laws.registry", "identification.logs.log"):
        names |= vars(importlib.import_module(f"cabledrive.{module}"))
    for module in ("identification.logs.log", "identification.logs.reading", "app.commands.track"):
        names |= vars(importlib.import_module(f"cabledrive.{module}"))
    names |= vars(importlib.import_module("cabledrive.app.options"))
    monkeypatch.setitem(names["CONTROLLERS"], "stiff-pd", None)
    monkeypatch.setitem(names["FORMATS"], ".num", lambda path, reading: names["open_numbers"](path, reading))
    for word in ("def stiff_pd", "def open_numbers", "def command"):
        (code,) = (one for one in re.findall(r"^```python\n(.*?)^```", text, re.S | re.M) if word in one)
        exec(code, names)
    run = cd.track(cd.load_drive("dissertation-3").listed, controller="stiff-pd", bandwidth=10.0)
    assert run.summary["peak_error_deg"] < 0.2
    rows = "".join(f"{k / 100} {sin(k / 9)} {k / 50}\n" for k in range(100))
    (tmp_path / "log.num").write_text(f"time[s] torque[N*m] angle[rad]\n{rows}")
    assert cd.read_log(tmp_path / "log.num").channel("angle")[-1] == pytest.approx(1.98)
    assert CliRunner().invoke(names["command"], ["elevator"]).output == "1.003e+04 N m\n"


def test_every_name_that_a_room_exports_is_there():
    """Many are loaded when they are first asked for, from a module that a string names."""
    names = [one.name for one in pkgutil.walk_packages(cd.__path__, "cabledrive.") if one.ispkg]
    for room in [cd, *map(importlib.import_module, names)]:
        lost = [name for name in getattr(room, "__all__", ()) if not hasattr(room, name)]
        assert not lost, f"{room.__name__}: {lost}"


# --- Every script in examples/ runs as it stands and asserts a number that a reader can look up
SCRIPTS = sorted((Path(__file__).resolve().parent.parent / "examples").glob("*.py"))


@pytest.mark.parametrize(
    "script",
    [
        pytest.param(one, id=one.name, marks=[pytest.mark.verify] * (one.name == "study_of_a_drive.py"))
        for one in SCRIPTS
    ],
)
def test_example_runs_in_an_empty_folder(script, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(script.parent)
    monkeypatch.setattr(sys, "argv", [str(script)])
    runpy.run_path(str(script), run_name="__main__")
