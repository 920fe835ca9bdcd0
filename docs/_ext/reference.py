"""Writes one reference page per room of the package, and one with the scripts of examples/."""

import ast
import importlib
import inspect
import tomllib
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]


def rooms() -> list[str]:
    """Rooms of the import contract that exist, in the order in which they may be imported."""
    contract = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]["contracts"][0]
    order = [layer.strip("()") for layer in reversed(contract["layers"])]
    return [room for room in order if (ROOT / "src" / "cabledrive" / room / "__init__.py").exists()]


def page(room: str, known: set[str]) -> str:
    """Markdown of one page: a module's own docstring, then every name that it exports.

    ``room``: "" is the package; ``known``: names of the pages before; those here are added.
    """
    module = f"cabledrive.{room}".rstrip(".")
    found = importlib.import_module(module)
    linked, parts = [f"# {room or 'cabledrive'}\n", _directive("automodule", module)], []
    for name in sorted(getattr(found, "__all__", ()), key=str.lower):
        value = getattr(found, name)
        home = f"{getattr(value, '__module__', None) or module}.{name}"
        summary = (inspect.getdoc(value) or "").partition("\n\n")[0].replace("\n", " ")
        if home in known:
            linked.append(f"- {{py:obj}}`{name} <{home}>`: {summary}")
        elif callable(value):
            kind = ("autoclass", ":members:") if inspect.isclass(value) else ("autofunction",)
            parts.append(f"## {name}\n\n{_directive(kind[0], home, *kind[1:])}")
        known.add(home)
    return "\n".join([*linked, "", *parts])


def _directive(name: str, argument: str, *options: str) -> str:
    lines = [f".. {name}:: {argument}", *(f"   {option}" for option in options)]
    return "\n".join(["```{eval-rst}", *lines, "```", ""])


def examples() -> str:
    """The scripts as MyST, each under the question that its docstring begins with."""
    parts = ["# Examples\n\nEach script runs as it stands and asserts a number that can be looked up.\n"]
    for path in sorted((ROOT / "examples").glob("*.py")):
        text = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or ""
        question, _, answer = text.partition("\n\n")
        code = f"```{{literalinclude}} ../../examples/{path.name}\n:language: python\n```"
        parts.append(f"## {' '.join(question.split())}\n\n{answer}\n\n`examples/{path.name}`\n\n{code}\n")
    return "\n".join(parts)


def write(app: Any) -> None:
    """Write what has changed, and remove the page of a room that is gone."""
    folder = Path(app.srcdir) / "reference"
    folder.mkdir(exist_ok=True)
    known: set[str] = set()
    pages = {f"{room}.md": page(room, known) for room in rooms()}
    pages = {"cabledrive.md": page("", known), **pages, "examples.md": examples()}
    listing = "\n".join(["```{toctree}", *(name.removesuffix(".md") for name in pages), "```"])
    words = "The names at the door, the rooms of the package in import order, and examples."
    pages["index.md"] = f"# Reference\n\n{words}\n\n{listing}\n"
    for old in folder.glob("*.md"):
        if old.name not in pages:
            old.unlink()
    for name, text in pages.items():
        path = folder / name
        if not path.exists() or path.read_text() != text:
            path.write_text(text)


def setup(app: Any) -> dict[str, bool]:
    app.connect("builder-inited", write)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
