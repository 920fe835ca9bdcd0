"""Statements of a kernel, as statements of C."""

import ast
import re
from typing import Any, TypeVar

from cabledrive.export.translation.expressions import Calls, bare
from cabledrive.export.translation.nodes import (
    BOOL,
    INT,
    NOTHING,
    REAL,
    Block,
    Group,
    Kind,
    Node,
    Record,
    Scalar,
    Value,
    View,
    mentions,
    unknown,
)
from cabledrive.export.translation.source import c_name, constant

Returned = TypeVar("Returned", bound=Kind)


class Statements(Calls):
    """Translates the body of one kernel, ``name`` in C; ``returned`` is the type that it returns."""

    name = ""
    returned: Kind | None = None
    widened = False

    def block(self, statements: list[ast.stmt]) -> tuple[Block, bool]:
        """Statements in order, and whether the last one leaves; what follows it is unreachable.

        Of those that may leave, the method gives whether it does.
        """
        block: Block = []
        for statement in statements:
            method = getattr(self, "_" + type(statement).__name__.lower(), None)
            if method is None:
                self.source.refuse(statement, f"the statement {type(statement).__name__}")
            if method(statement, block):
                return block, True
        return block, False

    def _pass(self, _: ast.Pass, block: Block) -> None:
        """Nothing is written."""

    def _expr(self, node: ast.Expr, block: Block) -> None:
        if isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
            return
        if not isinstance(node.value, ast.Call):
            self.source.refuse(node, "an expression that does nothing")
        block.append(Node(text=f"{self.value(node.value, alone=True).text};"))

    def _annassign(self, node: ast.AnnAssign, block: Block) -> None:
        if node.value is None:
            self.source.refuse(node, "a declaration without a value")
        self.assign(node.target, self.value(node.value, alone=True), block)

    def _assign(self, node: ast.Assign, block: Block) -> None:
        if len(node.targets) > 1:
            self.source.refuse(node, "several targets of one value")
        target = node.targets[0]
        if not isinstance(target, ast.Tuple):
            self.assign(target, self.value(node.value, alone=True), block)
        elif isinstance(node.value, ast.Tuple):
            self._assign_many(target, [self.value(part) for part in node.value.elts], block)
        else:
            self._unpack(node, target, block)

    def _unpack(self, node: ast.Assign, target: ast.Tuple, block: Block) -> None:
        """Several values of a call, or the lengths of an array."""
        value = self.value(node.value, alone=True)
        parts: list[Value] = []
        if isinstance(value.type, Group):
            parts = [Value("", kind) for kind in value.type.items]
            if value.text:
                text = self.scope.fresh(value.type)
                block.append(Node(target=text, value=value.text, pure=value.pure))
                parts = [Value(f"{text}.v{i}", one.type, value.roots) for i, one in enumerate(parts)]
        elif isinstance(value.type, View) and all(isinstance(one, ast.Name) for one in target.elts):
            kind, length = Scalar(value.type.kind), value.type.size if len(value.type.shape) == 1 else 0
            parts = [Value(f"{value.text}[{i}]", kind, value.roots) for i in range(length)]
        if len(parts) != len(target.elts):
            self.source.refuse(node, "this unpacking")
        for one, part in zip(target.elts, parts, strict=True):
            self.assign(one, part if part.known is None else constant(part.known), block)

    def _assign_many(self, target: ast.Tuple, values: list[Value], block: Block) -> None:
        """Python computes every value before it sets the first target."""
        if len(values) != len(target.elts):
            self.source.refuse(target, "this unpacking")
        names = [one.id if isinstance(one, ast.Name) else "" for one in target.elts]
        apart = all(names) and not any(
            mentions(value.text, c_name(name)) for i, value in enumerate(values) for name in names[:i]
        )
        if not apart:
            values = [self._held(value, block) for value in values]
        for one, value in zip(target.elts, values, strict=True):
            self.assign(one, value, block)

    def _held(self, value: Value, block: Block) -> Value:
        literal = re.fullmatch(r"[()-]*\d[\w.]*[()-]*", value.text)
        if value.known is not None or literal or not isinstance(value.type, Scalar):
            return value
        name = self.scope.fresh(Scalar(value.type.kind))
        block.append(Node(target=name, value=bare(value.text)))
        return Value(name, value.type)

    def assign(self, target: ast.expr, value: Value, block: Block) -> None:
        """Set a local name or an element of an array."""
        if isinstance(target, ast.Name):
            self._assign_name(target, value, block)
            return
        if not isinstance(target, ast.Subscript):
            self.source.refuse(target, f"setting {ast.unparse(target)}")
        place = self.value(target)
        if not isinstance(place.type, Scalar):
            self.source.refuse(target, "setting a whole array")
        self.scope.mark(place)
        text = bare(self.converted(target, value, place.type.kind).text)
        block.append(Node(text=f"{place.text} = {text};"))

    def _assign_name(self, target: ast.Name, value: Value, block: Block) -> None:
        name, kind = target.id, value.type
        if name in self.scope.counters:
            self.source.refuse(target, f"setting {name}, which counts a loop,")
        if isinstance(kind, Record | Group):
            self.source.refuse(target, f"{name} as a name for several values")
        once = self.source.assigned[name] == 1 and name not in self.scope.given
        if once and value.known is not None and name not in self.scope.real:
            self.scope.known[name] = value
            return
        try:
            settled = self.scope.settle(name, kind)
        except TypeError:
            self.source.refuse(target, f"{name} with two types")
        if isinstance(settled, Scalar):
            value = self.converted(target, value, settled.kind)
        elif name in self.scope.given:
            self.source.refuse(target, f"another array under the name of the argument {name}")
        else:
            self.scope.roots.setdefault(c_name(name), set()).update(value.roots)
        block.append(Node(target=c_name(name), value=bare(value.text), pure=value.pure))

    def _augassign(self, node: ast.AugAssign, block: Block) -> None:
        value = self.arithmetic(node, self.value(node.target), node.op, self.value(node.value))
        self.assign(node.target, value, block)

    def _if(self, node: ast.If, block: Block) -> bool:
        test = self.value(node.test, BOOL)
        if test.known is not None:
            inner, left = self.block(node.body if test.known else node.orelse)
            block += inner
            return left
        (then, first), (other, second) = self.block(node.body), self.block(node.orelse)
        if then or other:
            block.append(Node(text=f"if ({bare(test.text)})", blocks=[then, other]))
        return first and second

    def _for(self, node: ast.For, block: Block) -> None:
        call = node.iter
        if (
            node.orelse
            or not isinstance(node.target, ast.Name)
            or not isinstance(call, ast.Call)
            or self.source.resolve(call.func) is not range
        ):
            self.source.refuse(node, "a loop over something else than range")
        name, given = node.target.id, [self.value(argument, INT) for argument in call.args]
        if (self.source.assigned[name] > 1 and name in self.scope.local) or name in self.scope.counters:
            self.source.refuse(node, f"{name}, which counts a loop and is set elsewhere,")
        if not 1 <= len(given) <= 3:
            self.source.refuse(node, "this range")
        start = given[0] if len(given) > 1 else constant(0)
        stop, step = given[min(1, len(given) - 1)], given[2] if len(given) > 2 else constant(1)
        if not step.known:
            self.source.refuse(node, "a loop whose step is not known beforehand")
        if start.known is not None and stop.known is not None:
            if not range(start.known, stop.known, step.known):
                return
        elif stop.known is None:
            held = self.scope.fresh(Scalar(INT))  # Python asks for the end once
            block.append(Node(target=held, value=bare(stop.text)))
            stop = Value(held, Scalar(INT))
        self.scope.counters.add(name)
        lowest = start if step.known > 0 else stop
        if lowest.known is not None and lowest.known >= (0 if lowest is start else -1):
            self.scope.natural.add(name)
        inner, _ = self.block(node.body)
        self.scope.counters.remove(name)
        self.scope.natural.discard(name)
        up, count, size = step.known > 0, c_name(name), abs(step.known)
        change = f"{'++' if up else '--'}{count}" if size == 1 else f"{count} {'+' if up else '-'}= {size}"
        head = f"int32_t {count} = {start.text}; {count} {'<' if up else '>'} {stop.text}; {change}"
        block.append(Node(text=f"for ({head})", blocks=[inner], loop=True))

    def _while(self, node: ast.While, block: Block) -> None:
        if node.orelse:
            self.source.refuse(node, "else of a loop")
        test = self.value(node.test, BOOL)
        inner, _ = self.block(node.body)
        block.append(Node(text=f"while ({bare(test.text)})", blocks=[inner], loop=True))

    def _break(self, _: ast.Break, block: Block) -> bool:
        block.append(Node(text="break;"))
        return True

    def _continue(self, _: ast.Continue, block: Block) -> bool:
        block.append(Node(text="continue;"))
        return True

    def _return(self, node: ast.Return, block: Block) -> bool:
        if node.value is None:
            self._returns(node, NOTHING)
            block.append(Node(text="return;"))
            return True
        if isinstance(node.value, ast.Tuple):
            parts = [self.value(part) for part in node.value.elts]
            kinds = self._returns(node, Group(tuple(unknown(one.type) for one in parts))).items
            for one in parts:
                self.scope.mark(one) if isinstance(one.type, View) else None
            texts = [
                bare(self.converted(node, one, kind.kind).text if isinstance(kind, Scalar) else one.text)
                for one, kind in zip(parts, kinds, strict=True)
            ]
            block.append(Node(text=f"return ({self.name}_result){{{', '.join(texts)}}};"))
            return True
        value = self.value(node.value, alone=True)
        if isinstance(value.type, View | Record):
            self.source.refuse(node, "an array as the only result")
        kind = self._returns(node, unknown(value.type))
        if isinstance(kind, Scalar):
            value = self.converted(node, value, kind.kind)
        elif isinstance(kind, Group):
            value = self._same_group(value, block)
        block.append(Node(text=f"return {bare(value.text)};"))
        return True

    def _same_group(self, value: Value, block: Block) -> Value:
        """Several values of another kernel, in this kernel's own type."""
        assert isinstance(value.type, Group)
        name = self.scope.fresh(value.type)
        block.append(Node(target=name, value=value.text, pure=False))
        parts = ", ".join(f"{name}.v{i}" for i in range(len(value.type.items)))
        return Value(f"({self.name}_result){{{parts}}}", value.type)

    def _returns(self, node: ast.Return, kind: Returned) -> Returned:
        """The type of the result that holds this one and those before."""
        found = kind if self.returned is None else _wider(self.returned, kind)
        if found is None:
            self.source.refuse(node, "a result of another type than before")
        self.widened |= self.returned not in (None, found)
        self.returned = found
        return found


def _wider(a: Any, b: Any) -> Any:
    """One type for two results: a real number where the other is an integer; None: there is none."""
    if isinstance(a, Group) and isinstance(b, Group) and len(a.items) == len(b.items):
        items = tuple(map(_wider, a.items, b.items))
        return None if None in items else Group(items)
    return a if a == b else Scalar(REAL) if {a, b} == {Scalar(REAL), Scalar(INT)} else None
