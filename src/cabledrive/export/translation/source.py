"""The source of a kernel: its syntax tree, its names, and refusals that name file and line."""

import ast
import builtins
import inspect
import textwrap
from collections import Counter
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import CellType, FunctionType
from typing import Any, NoReturn

from cabledrive.parameters import InputRefused

RULES = "see the subset in CONTRIBUTING.md"


@dataclass(frozen=True, slots=True, eq=False)
class Source:
    """A kernel as written; ``assigned`` counts the assignments to each name."""

    function: FunctionType
    tree: ast.FunctionDef
    assigned: Counter[str]

    @property
    def parameters(self) -> list[str]:
        """Names of the arguments."""
        return [argument.arg for argument in self.tree.args.args]

    @property
    def summary(self) -> str:
        """First line of the docstring."""
        return (ast.get_docstring(self.tree) or "").partition("\n")[0]

    def refuse(self, node: ast.AST, what: str) -> NoReturn:
        """Refuse what C is not written for, at file and line."""
        code = self.function.__code__
        line = code.co_firstlineno + getattr(node, "lineno", 1) - 1
        raise InputRefused(f"{Path(code.co_filename).name}:{line}: {what} cannot be exported: {RULES}")

    def resolve(self, node: ast.expr) -> Any:
        """The Python object that a global name or an attribute of a module stands for; else nothing."""
        if isinstance(node, ast.Attribute):
            base = self.resolve(node.value)
            return getattr(base, node.attr, None) if inspect.ismodule(base) else None
        if not isinstance(node, ast.Name):
            return None
        inner = inspect.getclosurevars(self.function).nonlocals
        known = {**self.function.__globals__, **inner}
        return known.get(node.id, getattr(builtins, node.id, None))


def plain(function: Any) -> Any:
    """The Python function of a compiled kernel; anything else is itself."""
    return getattr(function, "py_func", function)


@cache
def source_of(function: FunctionType) -> Source:
    """Parse a kernel. Raises `InputRefused` if its source is not at hand or no plain function."""
    try:
        text = textwrap.dedent(inspect.getsource(function))
        tree = ast.parse(text).body[0]
    except (OSError, TypeError, SyntaxError):
        raise InputRefused(
            f"{function.__name__}: its source is not at hand, so it cannot be exported"
        ) from None
    if not isinstance(tree, ast.FunctionDef):
        raise InputRefused(f"{function.__name__} is no function written with def: it cannot be exported")
    source = Source(function, tree, _assigned(tree))
    given = tree.args
    if given.vararg or given.kwarg or given.kwonlyargs or given.defaults or given.posonlyargs:
        source.refuse(tree, "an argument that is not a plain positional one")
    return source


def _assigned(tree: ast.FunctionDef) -> Counter[str]:
    return Counter(
        node.id for node in ast.walk(tree) if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)
    )


def interpreted(function: Any) -> Any:
    """A kernel that runs, with all that it calls, without the compiler: the reference of the translation."""
    made: dict[Any, Any] = {}

    def is_kernel(value: Any, caller: Any) -> bool:
        if not isinstance(value, FunctionType):
            return hasattr(value, "py_func")
        return value.__module__.startswith("cabledrive.") or value.__module__ == caller.__module__

    def copy(one: Any) -> Any:
        one = plain(one)
        if one not in made:
            names: dict[str, Any] = {}
            made[one] = FunctionType(one.__code__, names, one.__name__, one.__defaults__, one.__closure__)
            for name, value in one.__globals__.items():
                used = name in one.__code__.co_names and is_kernel(value, one)
                names[name] = copy(value) if used else value
            cells = [cell.cell_contents for cell in one.__closure__ or ()]
            if any(is_kernel(value, one) for value in cells):
                closed = tuple(CellType(copy(v) if is_kernel(v, one) else v) for v in cells)
                made[one] = FunctionType(one.__code__, names, one.__name__, one.__defaults__, closed)
        return made[one]

    return copy(function)
