"""The source of a kernel, and what its names stand for while it is translated."""

import ast
import builtins
import inspect
import re
import textwrap
from collections import Counter
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from types import CellType, FunctionType
from typing import Any, NoReturn

from cabledrive.export.translation.nodes import BOOL, INT, REAL, Kind, Scalar, Value, unknown
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
    names = (node for node in ast.walk(tree) if isinstance(node, ast.Name))
    source = Source(function, tree, Counter(node.id for node in names if isinstance(node.ctx, ast.Store)))
    given = tree.args
    if given.vararg or given.kwarg or given.kwonlyargs or given.defaults or given.posonlyargs:
        source.refuse(tree, "an argument that is not a plain positional one")
    return source


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


WORDS = """auto break case char const continue default do double else enum extern float for goto if
inline int long register restrict return short signed sizeof static struct switch typedef union unsigned
void volatile while bool true false real"""
C_WORDS = frozenset(WORDS.split())
FROZEN = "<frozen>"


class Promoted(Exception):
    """An integer name turned out to hold a real number: translate again with it as one."""


@dataclass(eq=False)
class Scope:
    """Names of one kernel.

    ``given``: arguments; ``known``: names set once, to a value known now; ``local``: the others with their
    types; ``counters``: of the loops around; ``natural``: those of them that are never negative; ``real``:
    names that hold real numbers although an integer is assigned first; ``roots``: of each view, the names it
    may be a part of; ``written``: names whose elements are set.
    """

    source: Source
    given: dict[str, Kind]
    real: set[str]
    known: dict[str, Value] = field(default_factory=dict)
    local: dict[str, Kind] = field(default_factory=dict)
    counters: set[str] = field(default_factory=set)
    natural: set[str] = field(default_factory=set)
    roots: dict[str, set[str]] = field(default_factory=dict)
    written: set[str] = field(default_factory=set)
    held: int = 0

    def lookup(self, name: str) -> Value | None:
        """What a name stands for inside the kernel; none where it is a global one."""
        if name in self.counters:
            return Value(c_name(name), Scalar(INT))
        if name in self.known:
            return self.known[name]
        kind = self.local.get(name) or self.given.get(name)
        if kind is None:
            return None
        found = Value(c_name(name), kind, frozenset([c_name(name)]))
        return found if found.known is None else Value(literal_of(found.known), kind)

    def fresh(self, kind: Kind) -> str:
        """A new local of the translation's own."""
        self.held += 1
        name = f"held{self.held}"
        self.local[name] = kind
        return name

    def settle(self, name: str, kind: Kind) -> Kind:
        """Type of a local, from what is assigned to it now and what was before."""
        before = self.local.get(name) or self.given.get(name)
        kind = unknown(kind)
        if name in self.real and kind == Scalar(INT):
            kind = Scalar(REAL)
        if before is None or name in self.given:
            self.local.setdefault(name, kind) if before is None else None
            before = before or kind
        if before == kind or (before == Scalar(REAL) and kind == Scalar(INT)):
            return before
        if before == Scalar(INT) and kind == Scalar(REAL):
            self.real.add(name)
            raise Promoted
        raise TypeError(f"{name} with two types")

    def mark(self, value: Value) -> None:
        """Note that elements of a view are set."""
        self.written |= value.roots

    def close(self) -> set[str]:
        """Names through which something is written, also by a view of them."""
        while more := set().union(*(self.roots.get(name, set()) for name in self.written)) - self.written:
            self.written |= more
        return self.written


def c_name(name: str) -> str:
    """A Python name as C takes it."""
    if name == "_":
        return "turn"
    return name + "_" if name in C_WORDS or re.fullmatch(r"held\d+", name) else name.lstrip("_") or name


def literal_of(value: int | bool) -> str:
    """An integer or truth value in C."""
    if isinstance(value, bool):
        return "true" if value else "false"
    return str(value) if value >= 0 else f"({value})"


def constant(value: int | bool) -> Value:
    """A value that is known now."""
    kind = BOOL if isinstance(value, bool) else INT
    return Value(literal_of(value), Scalar(kind, value))
