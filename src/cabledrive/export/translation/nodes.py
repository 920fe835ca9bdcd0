"""Statements of C as a tree, the types of its expressions, and numbers as C writes them."""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from math import isinf, isnan
from typing import Any, TypeAlias

import numpy as np

REAL, INT, BOOL = "real", "int", "bool"
C_NAMES = {REAL: "real", INT: "int32_t", BOOL: "bool"}


@dataclass(frozen=True, slots=True)
class Scalar:
    """A number or truth value; ``value`` where an integer or truth value is known before the program runs."""

    kind: str
    value: int | bool | None = None


@dataclass(frozen=True, slots=True)
class View:
    """Contiguous part of an array, whose shape is known."""

    kind: str
    shape: tuple[int, ...]

    @property
    def size(self) -> int:
        """Number of elements."""
        return int(np.prod(self.shape, dtype=int))


@dataclass(frozen=True, slots=True)
class Record:
    """A NamedTuple: frozen tables of a design, or a struct of state behind a pointer."""

    name: str
    fields: tuple[tuple[str, "Kind"], ...]
    frozen: bool


@dataclass(frozen=True, slots=True)
class Group:
    """Several values, as a kernel returns them; none of them: nothing."""

    items: tuple["Kind", ...] = ()


Kind: TypeAlias = Scalar | View | Record | Group
NOTHING = Group()


@dataclass(frozen=True, slots=True)
class Value:
    """An expression in C with its type.

    ``roots``: the names that a view may be a part of; ``pure``: whether evaluating it changes nothing.
    """

    text: str
    type: Kind
    roots: frozenset[str] = frozenset()
    pure: bool = True

    @property
    def known(self) -> int | bool | None:
        """The integer or truth value that it is known to be before the program runs."""
        return self.type.value if isinstance(self.type, Scalar) else None


def unknown(kind: Kind) -> Kind:
    """The type without what is known of its value."""
    return replace(kind, value=None) if isinstance(kind, Scalar) else kind


def kind_of(value: Any, name: str, frozen: bool) -> Kind:
    """Type of a Python value; a NamedTuple becomes a record called ``name``."""
    if isinstance(value, bool | np.bool_):
        return Scalar(BOOL, bool(value) if frozen else None)
    if isinstance(value, int | np.integer):
        return Scalar(INT, int(value) if frozen else None)
    if isinstance(value, float):
        return Scalar(REAL)
    if isinstance(value, np.ndarray):
        return View(INT if value.dtype.kind in "iu" else REAL, value.shape)
    fields = tuple(
        (field, kind_of(part, f"{name}_{field}", frozen)) for field, part in value._asdict().items()
    )
    return Record(name, fields, frozen)


def c_type(kind: Kind, constant: bool = False) -> str:
    """How C declares it; ``constant``: a view that nothing is written through."""
    if isinstance(kind, Scalar):
        return C_NAMES[kind.kind] + " "
    if isinstance(kind, View):
        return ("const " if constant else "") + C_NAMES[kind.kind] + " *"
    assert isinstance(kind, Record)
    return kind.name + " *"


Block = list["Node"]


@dataclass(eq=False)
class Node:
    """A statement: ``text``, or the head of the blocks inside it.

    ``target``: the local that it sets; ``value``: to what; ``pure``: whether the value changes nothing;
    ``loop``: whether its block is run many times.
    """

    text: str = ""
    target: str = ""
    value: str = ""
    pure: bool = True
    loop: bool = False
    blocks: list[Block] = field(default_factory=list)
    declared: str = ""

    def reads(self, name: str) -> bool:
        """Whether the statement itself, without its blocks, mentions a name other than to set it."""
        return mentions(self.text, name) or mentions(self.value, name)


def mentions(text: str, name: str) -> bool:
    """Whether a text holds an identifier."""
    return re.search(rf"\b{re.escape(name)}\b", text) is not None


def walk(block: Block) -> Iterator[Node]:
    """Every statement, in order."""
    for node in block:
        yield node
        for inner in node.blocks:
            yield from walk(inner)


def drop_unread(block: Block, names: set[str]) -> None:
    """Take out what is set and never read; a call that changes something stays."""
    changed = True
    while changed:
        changed = False
        for name in sorted(names):
            if any(node.reads(name) for node in walk(block)):
                continue
            for inner in _all_blocks(block):
                for node in [one for one in inner if one.target == name]:
                    changed = True
                    if node.pure:
                        inner.remove(node)
                    else:
                        node.text, node.target, node.value = f"(void){node.value};", "", ""


def _all_blocks(block: Block) -> Iterator[Block]:
    yield block
    for node in block:
        for inner in node.blocks:
            yield from _all_blocks(inner)


def declare(block: Block, name: str, kind: str) -> None:
    """Give a local its declaration, in the innermost block that holds it; ``kind``: its type in C."""
    used = [node for node in block if _inside(node, name)]
    if not used:
        return
    first = used[0]
    if len(used) == 1 and first.blocks and not first.reads(name):
        inner = [one for one in first.blocks if any(_inside(node, name) for node in one)]
        if len(inner) == 1 and (not first.loop or _begins_by_setting(inner[0], name)):
            declare(inner[0], name, kind)
            return
    if first.target == name and not mentions(first.value, name):
        first.declared = kind
    else:  # set in branches: C wants it above them
        start = "NULL" if kind.endswith("*") else "false" if kind == "bool " else "0"
        block.insert(block.index(first), Node(text=f"{kind}{name} = {start};"))


def _inside(node: Node, name: str) -> bool:
    return any(one.target == name or one.reads(name) for one in walk([node]))


def _begins_by_setting(block: Block, name: str) -> bool:
    first = next(node for node in block if _inside(node, name))
    return first.target == name and not mentions(first.value, name)


def printed(block: Block, depth: int = 1) -> list[str]:
    """Lines of C."""
    lines, pad = [], "    " * depth
    for node in block:
        if node.target:
            lines.append(f"{pad}{node.declared}{node.target} = {node.value};")
        elif not node.blocks:
            lines.append(pad + node.text)
        else:
            lines.append(f"{pad}{node.text} {{")
            lines += printed(node.blocks[0], depth + 1)
            for other in node.blocks[1:]:
                if other:
                    lines.append(f"{pad}}} else {{")
                    lines += printed(other, depth + 1)
            lines.append(pad + "}")
    return lines


@dataclass(frozen=True, slots=True)
class Precision:
    """The floating-point type of a program: ``single`` or double."""

    single: bool = False

    @property
    def suffix(self) -> str:
        """What follows literals and the names of math functions."""
        return "f" if self.single else ""

    def literal(self, value: float) -> str:
        """A floating-point constant."""
        if isnan(value):
            return "(real)NAN"
        if isinf(value):
            return "(real)INFINITY" if value > 0.0 else "(-(real)INFINITY)"
        rounded = np.float32(value) if self.single else value
        text = repr(float(value)) if not self.single else np.format_float_scientific(rounded, unique=True)
        text = text if any(mark in text for mark in ".en") else text + ".0"
        text = f"{text}{self.suffix}"
        return f"({text})" if text.startswith("-") else text

    def _entry(self, value: float, kind: str) -> str:
        if kind == INT:
            return str(int(value))
        text = self.literal(float(value))
        return text.strip("()") if np.isfinite(value) else text

    def table(self, name: str, array: np.ndarray, about: str = "") -> str:
        """Definition of a constant table, a row of the last dimension a line."""
        kind = INT if array.dtype.kind in "iu" else REAL
        rows = array.reshape(-1, array.shape[-1]) if array.ndim > 1 else [array]
        lines = ",\n".join("    " + ", ".join(self._entry(value, kind) for value in row) for row in rows)
        comment = f"/* {about} */\n" if about else ""
        return f"{comment}static const {C_NAMES[kind]} {name}[{array.size}] = {{\n{lines}\n}};\n"
