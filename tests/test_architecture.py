"""The rooms import one way only, and the contract that says so notices when they do not."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
LINT = """
import sys
from importlinter.cli import lint_imports
sys.exit(lint_imports(no_cache=True, no_logo=True))
"""


def lint_imports(folder: Path) -> subprocess.CompletedProcess[str]:
    """Check the contracts in a process of its own: an imported package would hide the copy."""
    return subprocess.run([sys.executable, "-c", LINT], cwd=folder, capture_output=True, text=True)


@pytest.fixture
def copy_with(tmp_path: Path):
    """A copy of the package in which one more module of a room imports something."""

    def build(importer: str, imported: str) -> Path:
        shutil.copy(ROOT / "pyproject.toml", tmp_path)
        shutil.copytree(ROOT / "src" / "cabledrive", tmp_path / "cabledrive")
        for room in (importer, imported):
            package = tmp_path / "cabledrive" / room
            package.mkdir(exist_ok=True)
            (package / "__init__.py").touch()
        module = tmp_path / "cabledrive" / importer / "one_more.py"
        module.write_text(f"import cabledrive.{imported}\n")
        return tmp_path

    return build


def test_the_package_keeps_its_import_contracts():
    checked = lint_imports(ROOT)
    assert checked.returncode == 0, checked.stdout + checked.stderr
    assert "2 kept, 0 broken" in checked.stdout


@pytest.mark.parametrize(
    "importer, imported", [("modal", "parameters"), ("control", "reduction"), ("app", "report")]
)
def test_a_room_may_import_the_rooms_before_it(copy_with, importer, imported):
    checked = lint_imports(copy_with(importer, imported))
    assert checked.returncode == 0, checked.stdout + checked.stderr


@pytest.mark.parametrize(
    "importer, imported", [("parameters", "modal"), ("modal", "app"), ("trajectories", "rig")]
)
def test_a_room_must_not_import_a_room_after_it(copy_with, importer, imported):
    checked = lint_imports(copy_with(importer, imported))
    assert checked.returncode == 1, checked.stdout + checked.stderr
    assert f"cabledrive.{importer} is not allowed to import cabledrive.{imported}" in checked.stdout


def test_control_must_not_import_the_simulation(copy_with):
    checked = lint_imports(copy_with("control", "simulation"))
    assert checked.returncode == 1, checked.stdout + checked.stderr
    assert "Control laws do not see the simulation BROKEN" in checked.stdout


def test_a_room_outside_the_contract_breaks_it(copy_with):
    checked = lint_imports(copy_with("utils", "parameters"))
    assert checked.returncode == 1, checked.stdout + checked.stderr
    assert "not listed as layers:\n\n- cabledrive.utils" in checked.stdout
