"""What the documentation says about the package is so."""

import importlib
import re
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
DOCS = ROOT / "docs"
PACKAGE = ROOT / "src" / "cabledrive"


def test_architecture_lists_the_rooms_in_import_order_and_each_is_there():
    listed = re.findall(r"^\| `(\w+)` \|", (DOCS / "architecture.md").read_text(), re.M)
    contract = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]["contracts"][0]
    order = [layer.strip("()") for layer in reversed(contract["layers"])]
    assert listed == order
    assert [room for room in order if not any((PACKAGE / room).glob("*.py"))] == []


def test_the_drawing_of_the_rooms_stacks_them_in_import_order():
    drawn = re.findall(r'<text x="110" y="\d+">(\w+)</text>', (DOCS / "_static" / "rooms.svg").read_text())
    listed = re.findall(r"^\| `(\w+)` \|", (DOCS / "architecture.md").read_text(), re.M)
    assert [*reversed(drawn), "dissertation", "export", "campaign", "studio", "app"] == listed


def test_every_name_in_the_table_of_symbols_is_in_the_code():
    parameters = importlib.import_module("cabledrive.parameters")
    named = re.findall(r"`([A-Z]\w+)\.(\w+)`", (DOCS / "conventions.md").read_text())
    assert len(named) > 20, f"only {len(named)} names found"
    absent = [
        f"{owner}.{name}" for owner, name in named if not hasattr(getattr(parameters, owner, None), name)
    ]
    assert absent == []


def test_the_drive_on_the_front_page_loads(tmp_path):
    page = (DOCS / "index.md").read_text()
    path = tmp_path / "belt-axis.toml"
    path.write_text(re.search(r"```toml\n(.*?)```", page, re.S)[1])
    drive = importlib.import_module("cabledrive.parameters").load_drive(str(path))
    assert (drive.kind, drive.cable.pretension, drive.load_pulley.radius) == ("loop", 5.0, 0.03)


def test_the_gallery_shows_every_example_under_its_question():
    sys.path.insert(0, str(DOCS / "_ext"))
    shown = importlib.import_module("gallery").gallery()
    scripts = sorted(path.name for path in (ROOT / "examples").glob("*.py"))
    assert re.findall(r"literalinclude\} ../examples/(\S+)", shown) == scripts
    headings = re.findall(r"^## (.+)$", shown, re.M)
    assert len(set(headings)) == len(scripts), headings
    assert "<!-- examples -->" in (DOCS / "gallery.md").read_text()
