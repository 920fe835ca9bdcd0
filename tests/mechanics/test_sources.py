"""A cached kernel is one of its sources: its own module's and those of all it imports, in whatever room."""

import ast
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from cabledrive.mechanics.sources import PACKAGE, digest_with_imports, imported_names

FILES = {
    "__init__.py": "",
    "control/__init__.py": "from cabledrive.control.other import gain\n",
    "control/law.py": "from cabledrive.control.numbers import GAIN\n",
    "control/numbers.py": "GAIN = 2.0\n",
    "control/other.py": "gain = 1.0\n",
    "rig/loop.py": "from cabledrive.control import (\n    law,  # the law\n)\n",
    "rig/by_name.py": "from cabledrive.control import gain\n",
    "rig/whole.py": "def f():\n    import cabledrive.control.law\n",
}


@pytest.fixture
def package(tmp_path) -> Path:
    for name, text in FILES.items():
        (tmp_path / "cabledrive" / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "cabledrive" / name).write_text(text)
    return tmp_path / "cabledrive"


@pytest.mark.parametrize(
    ("module", "edited", "changes"),
    [
        ("rig/loop.py", "rig/loop.py", True),
        ("rig/loop.py", "control/law.py", True),
        ("rig/loop.py", "control/numbers.py", True),
        ("rig/whole.py", "control/numbers.py", True),
        ("rig/by_name.py", "control/other.py", True),
        ("rig/loop.py", "control/other.py", False),
        ("rig/loop.py", "rig/whole.py", False),
    ],
)
def test_an_edit_counts_for_all_who_import_it_and_for_nobody_else(package, module, edited, changes, measured):
    before = digest_afresh(package, module)
    (package / edited).write_text((package / edited).read_text() + "# edited\n")
    changed = digest_afresh(package, module) != before
    measured(f"{module} after an edit in {edited}: {'compiled anew' if changed else 'kept'}")
    assert changed == changes


def test_the_digest_does_not_depend_on_the_place(package, tmp_path):
    moved = tmp_path / "elsewhere" / "cabledrive"
    shutil.copytree(package, moved)
    assert digest_afresh(moved, "rig/loop.py") == digest_afresh(package, "rig/loop.py")


def digest_afresh(package: Path, module: str) -> str:
    """As a new process would, which has read no file yet."""
    from cabledrive.mechanics import sources

    sources._source.cache_clear()
    sources._file_of.cache_clear()
    return digest_with_imports(package / module, package)


def test_no_import_of_the_package_is_overlooked():
    """Python's own grammar finds none that is missing; one in a template for code may be found besides."""
    for path in sorted(PACKAGE.rglob("*.py")):
        text = path.read_text()
        assert set(by_grammar(ast.parse(text))) <= set(imported_names(text)), path


def by_grammar(tree: ast.Module):
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom):
            assert node.level == 0, "relative imports are not looked for"
            if node.module.split(".")[0] == "cabledrive":
                yield from ((node.module, alias.name) for alias in node.names)
        elif isinstance(node, ast.Import):
            yield from ((a.name, "") for a in node.names if a.name.split(".")[0] == "cabledrive")


CALLED = "from cabledrive.mechanics.compiled import njit\n\n@njit\ndef part(x):\n    return {} * x\n"
CALLS = (
    "from cabledrive.mechanics.part_for_test import part\nfrom cabledrive.mechanics.compiled import njit\n\n"
    "@njit\ndef whole(x):\n    return 1.0 + part(x)\n"
)


def test_a_compiled_kernel_is_compiled_anew_when_one_of_another_room_is_edited(tmp_path, measured):
    pytest.importorskip("numba")
    copy = tmp_path / "cabledrive"
    shutil.copytree(PACKAGE, copy, ignore=shutil.ignore_patterns("__pycache__"))
    (copy / "trajectories" / "whole_for_test.py").write_text(CALLS)
    found = []
    for factor in (2.0, 2.0, 3.0):
        (copy / "mechanics" / "part_for_test.py").write_text(CALLED.format(factor))
        found.append(whole_of_one(tmp_path))
    measured(f"value and loads from the cache: {', '.join(found)}; edited before the last")
    assert found == ["3.0 0", "3.0 1", "4.0 0"]


def whole_of_one(folder: Path) -> str:
    """The kernel's value, and how often it was loaded from the cache."""
    script = (
        f"import sys; sys.path.insert(0, {str(folder)!r})\n"
        "from cabledrive.trajectories.whole_for_test import whole\n"
        "print(whole(1.0), sum(whole.stats.cache_hits.values()))\n"
    )
    environment = {k: v for k, v in os.environ.items() if not k.startswith("NUMBA")}
    done = subprocess.run(
        [sys.executable, "-c", script],
        env=environment | {"XDG_CACHE_HOME": str(folder / "cache"), "PYTHONDONTWRITEBYTECODE": "1"},
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    return done.stdout.strip()
