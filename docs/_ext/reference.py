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


def page(room: str) -> str:
    """Markdown of one page: the room's own docstring, then every module that is public, folders included."""
    folder = ROOT / "src" / "cabledrive" / room
    parts = [f"# {room}\n", _directive("automodule", f"cabledrive.{room}"), *_exported(room)]
    for path in sorted(folder.rglob("*.py")):
        module = ".".join(path.relative_to(folder).with_suffix("").parts)
        has_code = any(
            isinstance(node, ast.FunctionDef | ast.ClassDef) and not node.name.startswith("_")
            for node in ast.parse(path.read_text()).body
        )
        if has_code and not path.stem.startswith("_"):
            parts += [f"## {module}\n", _directive("automodule", f"cabledrive.{room}.{module}", ":members:")]
    return "\n".join(parts)


def _exported(room: str) -> list[str]:
    """What the ``__init__`` of a room exports, each name with a link and its first sentence."""
    found = importlib.import_module(f"cabledrive.{room}")
    names = sorted(getattr(found, "__all__", ()), key=str.lower)
    lines = []
    for name in names:
        value = getattr(found, name)
        home = getattr(value, "__module__", None)
        summary = (inspect.getdoc(value) or "").partition("\n\n")[0].replace("\n", " ")
        if home is not None and home.startswith("cabledrive.") and callable(value):
            lines.append(f"- {{py:obj}}`{name} <{home}.{name}>`: {summary}")
        else:
            lines.append(f"- `{name}`")
    return ["## What it exports\n", *lines, ""] if lines else []


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
    pages = {f"{room}.md": page(room) for room in rooms()} | {"examples.md": examples()}
    listing = "\n".join(["```{toctree}", *(name.removesuffix(".md") for name in pages), "```"])
    pages["index.md"] = (
        f"# Reference\n\nThe rooms of the package, in import order, and examples.\n\n{listing}\n"
    )
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
