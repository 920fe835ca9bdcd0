"""Put every script of examples/ onto the page "Gallery", under the question that it answers."""

import ast
from pathlib import Path
from typing import Any

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
MARK = "<!-- examples -->"


def gallery() -> str:
    """The scripts as MyST: question, answer, code."""
    return "\n\n".join(_entry(path) for path in sorted(EXAMPLES.glob("*.py")))


def _entry(path: Path) -> str:
    question, _, answer = (ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or "").partition(
        "\n\n"
    )
    heading = " ".join(question.split())
    code = f"```{{literalinclude}} ../examples/{path.name}\n:language: python\n```"
    return f"## {heading}\n\n{answer}\n\n`examples/{path.name}`\n\n{code}"


def _fill(app: Any, page: str, source: list[str]) -> None:
    source[0] = source[0].replace(MARK, gallery())


def setup(app: Any) -> dict[str, bool]:
    app.connect("source-read", _fill)
    return {"parallel_read_safe": True}
