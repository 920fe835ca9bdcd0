"""What a kernel's names stand for while it is translated."""

import re
from dataclasses import dataclass, field

from cabledrive.export.translation.source import Source
from cabledrive.export.translation.types import BOOL, INT, REAL, Kind, Scalar, Value, View

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
        if isinstance(kind, Scalar) and kind.value is not None:
            return Value(literal_of(kind.value), kind)
        return Value(c_name(name), kind, frozenset([c_name(name)]))

    def fresh(self, kind: Kind) -> str:
        """A new local of the translation's own."""
        self.held += 1
        name = f"held{self.held}"
        self.local[name] = kind
        return name

    def settle(self, name: str, kind: Kind) -> Kind:
        """Type of a local, from what is assigned to it now and what was before."""
        before = self.local.get(name) or self.given.get(name)
        kind = Scalar(kind.kind) if isinstance(kind, Scalar) else kind
        if isinstance(kind, Scalar) and name in self.real and kind.kind == INT:
            kind = Scalar(REAL)
        if before is None or name in self.given:
            self.local.setdefault(name, kind) if before is None else None
            before = before or kind
        if before == kind or (before == Scalar(REAL) and kind == Scalar(INT)):
            return before
        if before == Scalar(INT) and kind == Scalar(REAL):
            self.real.add(name)
            raise Promoted
        if isinstance(before, View) and isinstance(kind, View) and before.kind == kind.kind:
            return before if before.shape == kind.shape else _none(name)
        return _none(name)

    def mark(self, value: Value) -> None:
        """Note that elements of a view are set."""
        self.written |= value.roots

    def close(self) -> set[str]:
        """Names through which something is written, also by a view of them."""
        changed = True
        while changed:
            more = set().union(*(self.roots.get(name, set()) for name in self.written)) - self.written
            self.written |= more
            changed = bool(more)
        return self.written


def _none(name: str) -> Kind:
    raise TypeError(f"{name} with two types")


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
