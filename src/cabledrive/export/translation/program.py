"""A program in C: kernels, each translated once for every shape of its arguments, with their tables."""

import ast
from dataclasses import dataclass
from types import FunctionType
from typing import Any

import numpy as np

from cabledrive.export.translation.expressions import Expressions, bare
from cabledrive.export.translation.nodes import (
    C_NAMES,
    NOTHING,
    Block,
    Group,
    Kind,
    Precision,
    Record,
    Scalar,
    Value,
    View,
    c_type,
    declare,
    drop_unread,
    kind_of,
    mentions,
    printed,
    unknown,
    walk,
)
from cabledrive.export.translation.source import (
    FROZEN,
    Promoted,
    Scope,
    Source,
    c_name,
    constant,
    plain,
    source_of,
)
from cabledrive.export.translation.statements import Statements
from cabledrive.parameters import InputRefused

KERNELS = "cabledrive."


@dataclass(frozen=True, slots=True, eq=False)
class Translated:
    """A kernel in C: its name, result, places of the arguments it takes and of those it writes, text."""

    name: str
    result: Kind
    taken: tuple[int, ...]
    written: tuple[int, ...]
    text: str


class Program:
    """Translated kernels, ``done`` in the order in which C wants them, and the frozen tables they use."""

    def __init__(self, precision: Precision | None = None) -> None:
        self.precision = precision or Precision()
        self.done: dict[Any, Translated] = {}
        self.tables: dict[str, tuple[np.ndarray, str]] = {}
        self.numbers: dict[str, float] = {}
        self.records: dict[str, Any] = {}
        self.taken: set[str] = set()
        self.open: list[Any] = []

    def frozen(self, name: str, numbers: Any) -> Value:
        """A number, an array or a NamedTuple of them as constant tables, named after it."""
        if isinstance(numbers, bool | int):
            return constant(numbers)
        self._freeze(name, numbers, name)
        return Value(name, kind_of(numbers, name, frozen=True), frozenset([FROZEN]))

    def _freeze(self, name: str, part: Any, about: str) -> None:
        if hasattr(part, "_asdict"):
            for field, inner in part._asdict().items():
                self._freeze(f"{name}_{field}", inner, f"{name}.{field}")
        elif isinstance(part, np.ndarray) and part.size:
            self.tables[name] = (part, f"{about}, shape {part.shape}")
        elif isinstance(part, float):
            self.numbers[name] = part

    def state(self, name: str, pointer: str, state: Any) -> Value:
        """A NamedTuple of arrays that change, as a struct called ``name`` behind a pointer."""
        self._register(name, state)
        return Value(pointer, kind_of(state, name, frozen=False), frozenset([pointer]))

    def _register(self, name: str, state: Any) -> None:
        for field, part in state._asdict().items():
            if hasattr(part, "_asdict"):
                self._register(f"{name}_{field}", part)
        self.records[name] = state

    def part(self, base: Value, name: str) -> Value:
        """A field of a record, by its name; an array without elements is nowhere."""
        assert isinstance(base.type, Record)
        kind = dict(base.type.fields)[name]
        if isinstance(kind, View) and kind.size == 0:
            return Value("NULL", kind, base.roots)
        if base.type.frozen:
            if isinstance(kind, Scalar) and kind.value is not None:
                return constant(kind.value)
            return Value(f"{base.type.name}_{name}", kind, base.roots)
        text = f"{base.text[1:]}.{name}" if base.text.startswith("&") else f"{base.text}->{name}"
        return Value("&" + text if isinstance(kind, Record) else text, kind, base.roots)

    def structs(self) -> str:
        """Definitions of the structs of state."""
        held = {name: state for name, state in self.records.items() if _holds(state)}
        return "\n".join(self._struct(name, state) for name, state in held.items())

    def _struct(self, name: str, state: Any) -> str:
        lines = []
        for field, part in state._asdict().items():
            kind = kind_of(part, f"{name}_{field}", frozen=False)
            if isinstance(kind, View) and kind.size:
                shape = " x ".join(map(str, kind.shape))
                lines.append(f"    {C_NAMES[kind.kind]} {field}[{kind.size}]; /* {shape} */")
            elif isinstance(kind, Record) and _holds(part):
                lines.append(f"    {kind.name} {field};")
            elif isinstance(kind, Scalar):
                lines.append(f"    {C_NAMES[kind.kind]} {field};")
        return "typedef struct {\n" + "\n".join(lines) + f"\n}} {name};\n"

    def call(self, caller: Expressions, node: ast.Call, called: Any, values: list[Value]) -> Value:
        """A call of another kernel."""
        function = plain(called)
        if not isinstance(function, FunctionType):
            caller.source.refuse(node, f"a call of {ast.unparse(node.func)}")
        source = source_of(function)
        if len(values) != len(source.parameters):
            caller.source.refuse(node, f"{len(values)} arguments of {function.__name__}")
        made = self.translate(function, [value.type for value in values])
        for i in made.written:
            if FROZEN in values[i].roots:
                caller.source.refuse(node, f"writing to frozen numbers in {function.__name__}")
            caller.scope.mark(values[i])
        texts = [bare(values[i].text) for i in made.taken]
        roots = frozenset().union(*(value.roots for value in values if isinstance(value.type, View)))
        pure = not made.written and all(value.pure for value in values)
        return Value(f"{made.name}({', '.join(texts)})", made.result, roots, pure)

    def translate(self, function: Any, kinds: list[Kind]) -> Translated:
        """A kernel for arguments of these types. Raises `InputRefused` if it leaves the subset."""
        source = source_of(plain(function))
        given = [
            unknown(kind) if source.assigned[name] else kind
            for name, kind in zip(source.parameters, kinds, strict=True)
        ]
        key = (source, tuple(given))
        if key in self.done:
            return self.done[key]
        if key in self.open:
            raise InputRefused(f"{source.function.__name__} calls itself: a recursion cannot be exported")
        self.open.append(key)
        made = self._translated(source, given)
        self.open.remove(key)
        self.done[key] = made
        return made

    def root(self, function: Any, values: list[Value]) -> tuple[Translated, str]:
        """A kernel that a shell calls, and its call with these arguments."""
        made = self.translate(plain(function), [value.type for value in values])
        return made, f"{made.name}({', '.join(values[i].text for i in made.taken)})"

    def _translated(self, source: Source, given: list[Kind]) -> Translated:
        name = "k_" + source.function.__name__.strip("_")
        free = next(one for one in [name, *(f"{name}_{i}" for i in range(2, 99))] if one not in self.taken)
        self.taken.add(free)
        real: set[str] = set()
        returned: Kind | None = None
        while True:
            scope = Scope(source, dict(zip(source.parameters, given, strict=True)), real)
            for parameter, kind in scope.given.items():
                if parameter in real and kind == Scalar("int"):
                    scope.given[parameter] = Scalar("real")
            body = Statements(self, source, scope)
            body.name, body.returned = free, returned
            try:
                block, left = body.block(source.tree.body)
            except Promoted:
                continue
            if not body.widened:
                break
            returned = body.returned
        result = body.returned or NOTHING
        if result != NOTHING and not left:
            source.refuse(source.tree, f"{source.function.__name__}, which may end without a result,")
        return self._finished(free, source, scope, block, result)

    def _finished(self, name: str, source: Source, scope: Scope, block: Block, result: Kind) -> Translated:
        locals_ = {
            c_name(one) if not one.startswith("held") else one: kind for one, kind in scope.local.items()
        }
        drop_unread(block, set(locals_))
        written = scope.close()
        if FROZEN in written:
            source.refuse(source.tree, f"{source.function.__name__}, which writes to frozen numbers,")

        for local, kind in locals_.items():
            if isinstance(kind, Group):
                value = next(node.value for node in walk(block) if node.target == local)
                declare(block, local, f"{value.partition('(')[0]}_result ")
            else:
                declare(block, local, c_type(kind, local not in written))
        text = "\n".join(printed(block))
        parameters = []
        taken, writes = [], []
        for i, (parameter, kind) in enumerate(scope.given.items()):
            c = c_name(parameter)
            frozen = isinstance(kind, Record) and kind.frozen
            if c in written:
                writes.append(i)
            if frozen or not mentions(text, c):
                continue
            taken.append(i)
            parameters.append(f"{c_type(kind, c not in written)}{c}")
        head = ""
        if isinstance(result, Group) and result.items:
            fields = " ".join(f"{c_type(kind)}v{i};" for i, kind in enumerate(result.items))
            head = f"typedef struct {{ {fields} }} {name}_result;\n"
        gives = f"{name}_result " if head else "void " if result == NOTHING else c_type(result)
        about = f"/* {source.function.__module__.removeprefix(KERNELS)}.{source.function.__name__}: "
        summary = (ast.get_docstring(source.tree) or "").partition("\n")[0]
        about += summary.replace("*/", "* /") + " */\n"
        signature = f"static {gives}{name}({', '.join(parameters) or 'void'})"
        return Translated(
            name=name,
            result=result,
            taken=tuple(taken),
            written=tuple(writes),
            text=f"{about}{head}{signature}\n{{\n{text}\n}}\n",
        )

    def functions(self) -> str:
        """All kernels, callees first."""
        return "\n".join(made.text for made in self.done.values())

    def used_tables(self, text: str) -> str:
        """Definitions of the tables that a text mentions."""
        numbers = "".join(
            f"static const real {name} = {self.precision.literal(value)};\n"
            for name, value in self.numbers.items()
            if mentions(text, name)
        )
        return numbers + "\n".join(
            self.precision.table(name, array, about)
            for name, (array, about) in self.tables.items()
            if mentions(text, name)
        )


def _holds(state: Any) -> bool:
    """Whether a NamedTuple has anything that C can hold: it knows neither empty arrays nor empty structs."""
    return any(_holds(part) if hasattr(part, "_asdict") else np.size(part) > 0 for part in state)
