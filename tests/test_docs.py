"""What the documentation says about the package is so."""

import importlib
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
DOCS = ROOT / "docs"


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
