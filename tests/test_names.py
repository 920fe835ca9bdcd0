"""What moved is still found by its old name, for one version."""

import importlib
import subprocess
import sys
from pathlib import Path

import pytest

from cabledrive.old_names import MOVED, RENAMED

IMPORT_ALL = """
import importlib, warnings
from cabledrive.old_names import MOVED
for old, new in MOVED.items():
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        found = importlib.import_module(old)
    meant = importlib.import_module(new)
    assert all(vars(found)[name] is value for name, value in vars(meant).items() if name[0] != "_"), old
    assert any(f"{old} is now {new}" in str(one.message) for one in caught), old
"""


def test_every_module_that_moved_is_found_with_a_warning():
    done = subprocess.run([sys.executable, "-c", IMPORT_ALL], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_a_function_or_class_is_found_by_its_old_name_with_a_warning():
    """In the module's present place; the test before this one joins the former place to it."""
    for home, names in RENAMED.items():
        module = importlib.import_module(home)
        for old, new in names.items():
            assert old not in vars(module)
            with pytest.warns(DeprecationWarning, match=f"{old} is now .*{new}"):
                assert getattr(module, old) is getattr(module, new)
        with pytest.raises(AttributeError, match="no attribute 'never_there'"):
            module.never_there  # noqa: B018


def test_an_import_of_0_1_still_runs():
    code = (
        "import warnings; warnings.simplefilter('ignore')\n"
        "from cabledrive.rig.draws import run_draws\n"
        "from cabledrive.rig.plant_samples import run_samples\n"
        "assert run_draws is run_samples"
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
    for home, names in RENAMED.items():
        for old, new in names.items():
            assert f"| `{home}.{old}` | `{home}.{new}` |" in page, old
