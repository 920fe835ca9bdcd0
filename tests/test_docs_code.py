"""The Python on the pages of the documentation runs, and prints what stands below it."""

import contextlib
import io
import re
from math import pi, sin
from pathlib import Path

import pytest

from cabledrive.parameters import InputRefused

ROOT = Path(__file__).resolve().parent.parent
DOCS = ROOT / "docs"
BLOCK = re.compile(r"^```python\n(.*?)^```\n(?:\n```text\n(.*?)^```\n)?", re.S | re.M)
FILES = {
    "index.md": ("belt-axis.toml", r"```toml\n(.*?)```"),
    "campaigns.md": ("campaign.toml", r"```toml\n(.*?)```"),
}
"""Files that a page's Python reads, and where on the page they stand."""
MOVE = "time [ms],torque [mN m]\n" + "".join(f"{k},{4 * sin(2 * pi * 0.08174 * k):.6g}\n" for k in range(400))
"""A motion for the page that reads one: 4 mN m at the pulley mode of its drive."""
SHARED = "../shared/data"
WITH_COMMANDS = {"tutorial_lift.md", "tutorial_printer.md"}
"""Pages whose Python reads what their commands write: `tests/test_route_tutorials.py` runs both."""


def pages():
    found = (path.name for path in DOCS.glob("*.md") if BLOCK.search(path.read_text(encoding="utf-8")))
    return sorted(set(found) - WITH_COMMANDS)


def run_blocks(text):
    """Run blocks one after another in one namespace; what each printed, and what stands below it."""
    names, outputs = {}, []
    for code, shown in BLOCK.findall(text):
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            try:
                exec(compile(code, "page", "exec"), names)
            except InputRefused as refusal:
                if "with its extra" not in str(refusal):
                    raise
                pytest.skip(str(refusal))
        outputs.append((printed.getvalue(), shown))
    return outputs


def check_outputs(outputs):
    """What stands below a block is what it must print."""
    for printed, shown in outputs:
        if shown:
            assert printed == shown


def parts(text):
    """A page as one part; its sections apart where one of them needs measured logs."""
    return re.split(r"^## ", text, flags=re.M) if SHARED in text else [text]


LONG = {"comparison.md", "identification_example.md", "multi_inertia.md", "study.md"}
"""Pages that identify, compare or study for seconds: run by ``make verify``."""


@pytest.mark.parametrize(
    "page", [pytest.param(page, marks=[pytest.mark.verify] * (page in LONG)) for page in pages()]
)
def test_python_of_a_page_runs(page, tmp_path, monkeypatch, measured):
    """Sections that read measured logs are left out where those are absent; the page is then skipped."""
    text = (DOCS / page).read_text(encoding="utf-8")
    project, shared = tmp_path / "project", ROOT.parent / "shared"
    project.mkdir()
    if shared.exists():
        (tmp_path / "shared").symlink_to(shared)
    if page in FILES:
        name, where = FILES[page]
        (project / name).write_text(re.search(where, text, re.S)[1])
    (project / "move.csv").write_text(MOVE)
    monkeypatch.chdir(project)
    absent = not (project / SHARED).exists()
    run = [part for part in parts(text) if not (absent and SHARED in part)]
    outputs = [output for part in run for output in run_blocks(part)]
    wrong = sum(printed != shown for printed, shown in outputs if shown)
    measured(
        f"blocks run: {len(outputs)}; outputs that differ: {wrong} of {sum(bool(s) for _, s in outputs)}"
    )
    check_outputs(outputs)
    if absent and SHARED in text:
        pytest.skip(f"{page}: one section needs the measured logs {SHARED}, which are not here")


def test_a_page_that_prints_something_else_is_found():
    good = "```python\nprint(1 + 1)\n```\n\n```text\n2\n```\n"
    check_outputs(run_blocks(good))
    with pytest.raises(AssertionError):
        check_outputs(run_blocks(good.replace("\n2\n", "\n3\n")))
