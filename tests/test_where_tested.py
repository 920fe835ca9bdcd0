"""Every module is tested, and its tests are found by its name."""

import pytest

import where_tested


def test_every_module_has_a_test_that_names_it_or_what_uses_it():
    assert [name for name in where_tested.modules() if not where_tested.where(name)] == []


def test_no_test_loads_code_by_path_or_takes_it_out_of_another_test():
    """What tests share stands in modules of its own: oracles in ``tests/oracles``."""
    for path in (where_tested.ROOT / "tests").rglob("*.py"):
        names = where_tested.imported(where_tested.ast.parse(path.read_text(encoding="utf-8")))
        taken = {name for name in names if name.startswith(("test_", "importlib.util"))}
        assert taken == set(), f"{path.name}: {taken}"


@pytest.mark.parametrize(
    "module, test",
    [
        ("cabledrive.modal.counting", "tests/modal/test_count_certificate.py"),
        ("cabledrive.app.commands.modes", "tests/app/test_modes_command.py"),
        ("cabledrive.control.difference", "tests/rig/test_track.py"),
        ("cabledrive.report.chapters.control", "tests/report/test_chapters.py"),
    ],
    ids=["imports it", "calls it", "uses what uses it", "is found by name"],
)
def test_tests_are_found(module, test):
    assert test in where_tested.where(module)


def test_a_module_that_nothing_names_has_no_test():
    assert where_tested.where("cabledrive.modal.not_there") == set()
