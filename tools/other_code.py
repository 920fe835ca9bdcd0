"""Other code for a function that is there: compiled from its module's tree, changed, at the same lines."""

import ast
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from types import CodeType, FunctionType

Place = tuple[str, int]


@cache
def text_of(file: str) -> str:
    return Path(file).read_text(encoding="utf-8")


def codes(tree: ast.Module, file: str) -> dict[Place, CodeType]:
    """Code of every function of a module, those inside others included, by name and first line."""
    return {(code.co_name, code.co_firstlineno): code for code in _inner(compile(tree, file, "exec"))}


def _inner(code: CodeType) -> Iterator[CodeType]:
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield constant
            yield from _inner(constant)


def place_of(function: FunctionType) -> Place:
    return function.__code__.co_name, function.__code__.co_firstlineno
