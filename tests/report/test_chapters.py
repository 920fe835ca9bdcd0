"""Chapters register themselves, in order, and say nothing of drives they are not about."""

import sys
from types import ModuleType

import pytest
from report_page import read

from cabledrive.report import chapters


def test_chapters_stand_in_the_order_of_their_places():
    entries = chapters.registry()
    assert [entry.place for entry in entries] == sorted(entry.place for entry in entries)
    names = [entry.name for entry in entries]
    assert names.index("summary") < names.index("the_drive") < names.index("natural_modes")


def test_the_page_and_its_contents_follow_the_registry():
    headings = [e.attributes["id"] for e in read().root.all("h2")]
    contents = [a.attributes["href"] for nav in read().root.all("nav")[:1] for a in nav.all("a")]
    chapters_listed = [f"{link[1:]}-title" for link in contents if f"{link[1:]}-title" in headings]
    assert chapters_listed == headings
    assert headings[0] == "in-short-title"
    assert headings[-1] == "provenance-title"


@pytest.fixture
def extra(monkeypatch, tmp_path):
    """A folder of chapters with one more file in it."""

    def add(name: str, text: str) -> None:
        (tmp_path / f"{name}.py").write_text(text)
        monkeypatch.setattr(chapters, "__path__", [*chapters.__path__, str(tmp_path)])
        monkeypatch.delitem(sys.modules, f"{chapters.__name__}.{name}", raising=False)

    return add


def test_a_new_file_is_a_new_chapter(extra):
    extra("one_more", "PLACE = 150\ndef chapter(context):\n    return None\n")
    names = [entry.name for entry in chapters.registry()]
    assert names.index("the_drive") < names.index("one_more") < names.index("natural_modes")


def test_two_chapters_cannot_have_one_place(extra):
    extra("in_the_way", "PLACE = 100\ndef chapter(context):\n    return None\n")
    with pytest.raises(
        ValueError, match=r"(the_drive and in_the_way|in_the_way and the_drive) both have PLACE = 100"
    ):
        chapters.registry()


def test_every_chapter_is_a_module_with_a_place_and_a_function():
    for entry in chapters.registry():
        module = sys.modules[f"{chapters.__name__}.{entry.name}"]
        assert isinstance(module, ModuleType)
        assert module.__doc__
        assert callable(entry.write)
