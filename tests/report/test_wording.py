"""Texts of the pages stand in templates: each that is asked for is there, and none is left over."""

import ast
from importlib import resources
from pathlib import Path

import jinja2
import pytest

import cabledrive
from cabledrive.report.wording import in_unit, sentences, texts

SOURCES = Path(cabledrive.__file__).parent
TEMPLATES = sorted(SOURCES.glob("*/templates/texts/**/*.txt"))


def calls(tree: ast.Module, name: str):
    """Calls of a name in a module."""
    return [
        node for node in ast.walk(tree) if isinstance(node, ast.Call) and getattr(node.func, "id", "") == name
    ]


def asked_for() -> dict[Path, dict[str, set[frozenset[str]]]]:
    """Of each template the texts that modules ask for, with the names of their values."""
    found: dict[Path, dict[str, set[frozenset[str]]]] = {path: {} for path in TEMPLATES}
    for path in SOURCES.rglob("*.py"):
        source = path.read_text(encoding="utf-8")
        if "cabledrive.report.wording import" not in source:
            continue
        tree = ast.parse(source)
        (made,) = calls(tree, "texts")
        name, *package = [argument.value for argument in made.args if isinstance(argument, ast.Constant)]
        room = (package or ["cabledrive.report"])[0].rpartition(".")[2]
        texts_here = found[SOURCES / room / "templates" / "texts" / f"{name}.txt"]
        for call in calls(tree, "say"):
            assert isinstance(call.args[0], ast.Constant), f"{path}: name the text where it is asked for"
            texts_here.setdefault(call.args[0].value, set()).add(
                frozenset(k.arg or "" for k in call.keywords)
            )
    return found


@pytest.mark.parametrize("path", TEMPLATES, ids=lambda path: f"{path.parts[-4]}-{path.stem}")
def test_modules_ask_for_the_texts_that_stand_there_with_the_values_they_take(path):
    template = jinja2.Environment().parse(path.read_text(encoding="utf-8"))
    macros = [macro for macro in template.find_all(jinja2.nodes.Macro) if macro.name[0] != "_"]
    there = {macro.name: frozenset(argument.name for argument in macro.args) for macro in macros}
    asked = asked_for()[path]
    assert set(asked) == set(there)
    for name, values in asked.items():
        assert values == {there[name]}, f"{name} takes {sorted(there[name])}"


def test_a_text_is_one_line_with_its_quantities_in_units():
    said = texts("page", "cabledrive.dissertation")("chapter_headline", agree=3, items=4)
    assert said == "3 of 4 items agree."
    assert in_unit(0.00213, "mm") == "2.13 mm"
    assert in_unit(0.01, "deg", 4) == "0.573 deg"
    assert sentences(("first line", "second line.")) == "First line. Second line."


def test_a_text_refuses_values_that_it_does_not_know():
    say = texts("page", "cabledrive.dissertation")
    with pytest.raises(TypeError, match="another"):
        say("errata", another=1)
    assert resources.files("cabledrive.dissertation").joinpath("templates", "texts", "page.txt").is_file()
