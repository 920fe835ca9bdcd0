"""Names: no public name hides a module, and what moved is still found for one version."""

import importlib
import pkgutil
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import pytest

import cabledrive
from cabledrive.old_names import MOVED


def test_no_public_name_hides_a_module():
    """``import cabledrive.modal.frequency_ratio as fr`` follows attributes: each has to be the module."""
    names = [one.name for one in pkgutil.walk_packages(cabledrive.__path__, "cabledrive.")]
    names.remove("cabledrive.__main__")
    for name in names:
        importlib.import_module(name)
    for name in names:
        found = cabledrive
        for part in name.split(".")[1:]:
            found = getattr(found, part)
        assert isinstance(found, ModuleType), f"{name} is hidden by {found!r}"


@pytest.mark.parametrize("old, new", MOVED.items())
def test_a_module_that_moved_is_found_with_a_warning(old, new):
    code = (
        "import importlib, warnings\n"
        "with warnings.catch_warnings(record=True) as told:\n"
        "    warnings.simplefilter('always')\n"
        f"    old = importlib.import_module({old!r})\n"
        f"new = importlib.import_module({new!r})\n"
        "assert all(vars(old)[name] is value for name, value in vars(new).items() if name[0] != '_')\n"
        f"assert any({new!r} in str(one.message) for one in told), told\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_a_function_keeps_its_name_where_the_module_of_that_name_moved():
    code = (
        "import warnings; warnings.simplefilter('ignore')\n"
        "import cabledrive as cd, cabledrive.modes.frequency_ratio\n"
        "print(cd.modes(cd.load_drive('dissertation-2'), count=1).modes[0].frequency > 0)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.stdout.strip() == "True", done.stderr


def test_the_page_on_migration_lists_what_moved():
    page = (Path(__file__).resolve().parent.parent / "docs" / "migration.md").read_text(encoding="utf-8")
    for old, new in MOVED.items():
        assert f"| `{old}` | `{new}` |" in page, old
