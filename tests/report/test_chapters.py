"""Chapters register themselves, in order, and say nothing of drives they are not about."""

import sys
from types import ModuleType

import pytest

from cabledrive.report import chapters


def test_chapters_stand_in_the_order_of_their_places():
    entries = chapters.registry()
    assert [entry.place for entry in entries] == sorted(entry.place for entry in entries)
    names = [entry.name for entry in entries]
    assert names.index("what_moves_them") < names.index("the_cable") < names.index("control")


@pytest.fixture
def extra(monkeypatch, tmp_path):
    """A folder of chapters with one more file in it."""

    def add(name: str, text: str) -> None:
        (tmp_path / f"{name}.py").write_text(text)
        monkeypatch.setattr(chapters, "__path__", [*chapters.__path__, str(tmp_path)])
        monkeypatch.delitem(sys.modules, f"{chapters.__name__}.{name}", raising=False)

    return add


def test_a_new_file_is_a_new_chapter(extra):
    extra("one_more", "PLACE = 310\ndef chapter(context):\n    return None\n")
    names = [entry.name for entry in chapters.registry()]
    assert names.index("what_moves_them") < names.index("one_more") < names.index("control")


def test_two_chapters_cannot_have_one_place(extra):
    extra("in_the_way", "PLACE = 300\ndef chapter(context):\n    return None\n")
    with pytest.raises(
        ValueError,
        match=r"(what_moves_them and in_the_way|in_the_way and what_moves_them) both have PLACE = 300",
    ):
        chapters.registry()


def test_every_chapter_is_a_module_with_a_place_and_a_function():
    for entry in chapters.registry():
        module = sys.modules[f"{chapters.__name__}.{entry.name}"]
        assert isinstance(module, ModuleType)
        assert module.__doc__
        assert callable(entry.write)
