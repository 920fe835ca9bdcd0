"""Expressions and calls of a kernel, written in C with their types; what is known now is computed now."""

import ast
import math
import operator
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from cabledrive.export.translation.nodes import BOOL, INT, REAL, Group, Record, Scalar, Value, View
from cabledrive.export.translation.source import Scope, Source, constant

if TYPE_CHECKING:
    from cabledrive.export.translation.program import Program


ARITHMETIC: dict[type[ast.operator], tuple[str, Callable[[Any, Any], Any]]] = {
    ast.Add: ("+", operator.add),
    ast.Sub: ("-", operator.sub),
    ast.Mult: ("*", operator.mul),
    ast.Div: ("/", operator.truediv),
    ast.FloorDiv: ("//", operator.floordiv),
    ast.Mod: ("%", operator.mod),
    ast.Pow: ("**", operator.pow),
}
WHOLE: dict[type[ast.operator], str] = {ast.FloorDiv: "/", ast.Mod: "%"}
COMPARISONS: dict[type[ast.cmpop], tuple[str, Callable[[Any, Any], bool]]] = {
    ast.Lt: ("<", operator.lt),
    ast.LtE: ("<=", operator.le),
    ast.Gt: (">", operator.gt),
    ast.GtE: (">=", operator.ge),
    ast.Eq: ("==", operator.eq),
    ast.NotEq: ("!=", operator.ne),
}


class Expressions:
    """Translates the expressions of one kernel."""

    def __init__(self, program: "Program", source: Source, scope: Scope) -> None:
        self.program, self.source, self.scope = program, source, scope

    def value(self, node: ast.expr, kind: str | None = None, *, alone: bool = False) -> Value:
        """Translate an expression, to a ``kind`` of number where one is wanted.

        Only one that stands ``alone`` may change something.
        """
        method = getattr(self, "_" + type(node).__name__.lower(), None)
        if method is None:
            self.source.refuse(node, f"{type(node).__name__} in an expression")
        found: Value = method(node)
        if not (found.pure or alone):
            self.source.refuse(node, "a call that changes something inside a larger expression")
        return found if kind is None else self.converted(node, found, kind)

    def converted(self, node: ast.AST, value: Value, kind: str) -> Value:
        """A scalar as another kind; only an integer becomes a real number without being asked."""
        if not isinstance(value.type, Scalar):
            self.source.refuse(node, f"an array or several values where one {kind} number is wanted,")
        if value.type.kind == kind:
            return value
        if (value.type.kind, kind) != (INT, REAL):
            self.source.refuse(node, f"{value.type.kind} where {kind} is wanted,")
        if value.known is not None:
            return Value(self.program.precision.literal(float(value.known)), Scalar(REAL))
        return Value(f"(real){value.text}", Scalar(REAL), pure=value.pure)

    def _constant(self, node: ast.Constant) -> Value:
        return self.number(node, node.value)

    def number(self, node: ast.AST, value: Any) -> Value:
        """A number of Python as a constant."""
        if isinstance(value, bool | int):
            return constant(value)
        if isinstance(value, float):
            return Value(self.program.precision.literal(value), Scalar(REAL))
        self.source.refuse(node, f"{type(value).__name__} as a value")

    def _name(self, node: ast.Name) -> Value:
        found = self.scope.lookup(node.id)
        if found is not None:
            return found
        if self.source.assigned[node.id] or node.id in self.source.parameters:
            self.source.refuse(node, f"{node.id}, used before it is set or after its loop,")
        return self.number(node, self.source.resolve(node))

    def _attribute(self, node: ast.Attribute) -> Value:
        if (known := self.source.resolve(node)) is not None and not self._is_inside(node):
            return self.number(node, known)
        base = self.value(node.value)
        if isinstance(base.type, View) and node.attr == "size":
            return constant(base.type.size)
        if isinstance(base.type, View) and node.attr == "shape":
            return Value("", Group(tuple(Scalar(INT, length) for length in base.type.shape)))
        if not isinstance(base.type, Record) or node.attr not in dict(base.type.fields):
            self.source.refuse(node, f"attribute {node.attr}")
        return self.program.part(base, node.attr)

    def _is_inside(self, node: ast.expr) -> bool:
        while isinstance(node, ast.Attribute):
            node = node.value
        return isinstance(node, ast.Name) and self.scope.lookup(node.id) is not None

    def _subscript(self, node: ast.Subscript) -> Value:
        base = self.value(node.value)
        places = list(node.slice.elts) if isinstance(node.slice, ast.Tuple) else [node.slice]
        if isinstance(base.type, Group) and not base.text:  # of a shape
            place = self.value(places[0], INT).known
            if place is None or len(places) > 1:
                self.source.refuse(node, "a length that is not known beforehand")
            return constant(int(Value("", base.type.items[int(place)]).known or 0))
        if not isinstance(base.type, View) or len(places) > len(base.type.shape):
            self.source.refuse(node, "this subscript")
        return self._part(node, base, base.type, places)

    def _part(self, node: ast.Subscript, base: Value, view: View, places: list[ast.expr]) -> Value:
        """An element, or a contiguous part: rows by number, at the end perhaps a slice."""
        strides = [int(np.prod(view.shape[i + 1 :], dtype=int)) for i in range(len(view.shape))]
        fixed, moving, shape = 0, [], view.shape[len(places) :]
        for i, place in enumerate(places):
            if isinstance(place, ast.Slice):
                if i < len(places) - 1 or place.step is not None:
                    self.source.refuse(node, "a slice that is not contiguous")
                low, high = self._bound(place.lower, 0), self._bound(place.upper, view.shape[i])
                if not 0 <= low <= high <= view.shape[i]:
                    self.source.refuse(node, f"a slice beyond {view.shape[i]} elements")
                fixed, shape = fixed + low * strides[i], (high - low, *shape)
                continue
            index = self.value(place, INT)
            if index.known is None:
                moving.append(index.text if strides[i] == 1 else f"({index.text} * {strides[i]})")
            elif -view.shape[i] <= index.known < view.shape[i]:  # from the end as in Python
                fixed += int(index.known) % view.shape[i] * strides[i]
            else:
                self.source.refuse(node, f"element {index.known} of {view.shape[i]}")
        if view.size == 0 and moving:
            self.source.refuse(node, "an element of an empty array")
        offset = " + ".join([*moving, *([str(fixed)] if fixed or not moving else [])])
        if shape == () and not any(isinstance(place, ast.Slice) for place in places):
            return Value(f"{base.text}[{offset}]", Scalar(view.kind), base.roots)
        text = base.text if offset == "0" else f"({base.text} + {f'({offset})' if moving else offset})"
        return Value(text, View(view.kind, shape), base.roots)

    def _bound(self, node: ast.expr | None, default: int) -> int:
        if node is None:
            return default
        known = self.value(node, INT).known
        if known is None:
            self.source.refuse(node, "a slice whose ends are not known beforehand")
        return int(known)

    def _binop(self, node: ast.BinOp) -> Value:
        left, right = node.left, self.value(node.right)
        natural = isinstance(left, ast.Name) and left.id in self.scope.natural
        counted = isinstance(right.type, Scalar) and right.type.kind == INT and (right.known or 0) > 0
        if type(node.op) in WHOLE and natural and counted:
            # of a counter that is never negative C rounds as Python does
            return Value(f"({self.value(left).text} {WHOLE[type(node.op)]} {right.text})", Scalar(INT))
        return self.arithmetic(node, self.value(left), node.op, right)

    def arithmetic(self, node: ast.AST, left: Value, op: ast.operator, right: Value) -> Value:
        """Sum, difference, product or quotient of two numbers, in the order in which it is written."""
        if type(op) not in ARITHMETIC:
            self.source.refuse(node, f"the operator {type(op).__name__}")
        sign, compute = ARITHMETIC[type(op)]
        a, b = left.type, right.type
        if not (isinstance(a, Scalar) and isinstance(b, Scalar)) or BOOL in (a.kind, b.kind):
            self.source.refuse(node, "arithmetic on something else than numbers")
        whole = a.kind == b.kind == INT
        if whole and left.known is not None and right.known is not None:
            return self.number(node, compute(left.known, right.known))
        if sign in ("//", "%", "**"):
            self.source.refuse(node, f"{sign} of numbers that are not known beforehand")
        if not whole or sign == "/":
            left, right = self.converted(node, left, REAL), self.converted(node, right, REAL)
            whole = False
        return Value(f"({left.text} {sign} {right.text})", Scalar(INT if whole else REAL))

    def _unaryop(self, node: ast.UnaryOp) -> Value:
        if isinstance(node.op, ast.Not):
            one = self.value(node.operand, BOOL)
            return constant(not one.known) if one.known is not None else Value(f"(!{one.text})", Scalar(BOOL))
        one = self.value(node.operand)
        if not isinstance(node.op, ast.USub) or not isinstance(one.type, Scalar) or one.type.kind == BOOL:
            self.source.refuse(node, f"the operator {type(node.op).__name__}")
        return (
            constant(-one.known) if one.known is not None else Value(f"(-{one.text})", Scalar(one.type.kind))
        )

    def _boolop(self, node: ast.BoolOp) -> Value:
        both = isinstance(node.op, ast.And)
        parts = []
        for each in node.values:
            one = self.value(each, BOOL)
            if one.known is None:
                parts.append(one.text)
            elif one.known != both:  # decides: the rest is not looked at
                if not parts:
                    return constant(not both)
                parts.append(one.text)
                break
        if not parts:
            return constant(both)
        return Value(
            parts[0] if len(parts) == 1 else f"({(' && ' if both else ' || ').join(parts)})", Scalar(BOOL)
        )

    def _compare(self, node: ast.Compare) -> Value:
        operands = [node.left, *node.comparators]
        if any(isinstance(part, ast.Call) for part in operands[1:-1]):
            self.source.refuse(node, "a call in the middle of a comparison")
        pairs = zip(operands[:-1], node.ops, operands[1:], strict=True)
        found = [self._pair(node, a, op, b) for a, op, b in pairs]
        if len(found) == 1:
            return found[0]
        return Value(f"({' && '.join(one.text for one in found)})", Scalar(BOOL))

    def _pair(self, node: ast.AST, a: ast.expr, op: ast.cmpop, b: ast.expr) -> Value:
        left, right = self.value(a), self.value(b)
        x, y = left.type, right.type
        if type(op) not in COMPARISONS or not (isinstance(x, Scalar) and isinstance(y, Scalar)):
            self.source.refuse(node, "a comparison of something else than numbers")
        sign, compute = COMPARISONS[type(op)]
        if left.known is not None and right.known is not None:
            return constant(bool(compute(left.known, right.known)))
        if x.kind != y.kind:
            left, right = self.converted(node, left, REAL), self.converted(node, right, REAL)
        return Value(f"({left.text} {sign} {right.text})", Scalar(BOOL))

    def _ifexp(self, node: ast.IfExp) -> Value:
        test = self.value(node.test, BOOL)
        if test.known is not None:
            return self.value(node.body if test.known else node.orelse)
        left, right = self.value(node.body), self.value(node.orelse)
        x, y = left.type, right.type
        if not (isinstance(x, Scalar) and isinstance(y, Scalar)):
            self.source.refuse(node, "a choice between something else than numbers")
        kind = x.kind if x.kind == y.kind else REAL
        left, right = self.converted(node, left, kind), self.converted(node, right, kind)
        return Value(f"({test.text} ? {left.text} : {right.text})", Scalar(kind))


def bare(text: str) -> str:
    """Without the brackets around the whole."""
    if not (text.startswith("(") and text.endswith(")")):
        return text
    depth = 0
    for i, sign in enumerate(text):
        depth += (sign == "(") - (sign == ")")
        if depth == 0 and i < len(text) - 1:
            return text
    return text[1:-1]


MATH: dict[Any, str] = {
    abs: "fabs",
    math.tanh: "tanh",
    math.exp: "exp",
    math.sqrt: "sqrt",
    math.sin: "sin",
    math.cos: "cos",
    math.floor: "floor",
    np.rint: "rint",
}


class Calls(Expressions):
    """Translates expressions with calls."""

    def _call(self, node: ast.Call) -> Value:
        called = self.source.resolve(node.func)
        if node.keywords or any(isinstance(argument, ast.Starred) for argument in node.args):
            self.source.refuse(node, "a call with keywords or a star")
        if called in (min, max):
            return self._extreme(node, called)
        number = partial(self.value, kind=REAL)
        single: dict[Any, Callable[[ast.expr], Value]] = {float: number, int: self._int, len: self._len}
        if any(called is one for one in single):
            return single[called](node.args[0])
        if called is math.isfinite:
            return Value(f"cd_isfinite({bare(self.value(node.args[0], REAL).text)})", Scalar(BOOL))
        if getattr(called, "__hash__", None) and called in MATH:
            name = MATH[called] + self.program.precision.suffix
            return Value(f"{name}({bare(self.value(node.args[0], REAL).text)})", Scalar(REAL))
        return self.program.call(self, node, called, [self.value(argument) for argument in node.args])

    def _extreme(self, node: ast.Call, which: Any) -> Value:
        values = [self.value(argument) for argument in node.args]
        kinds = [one.type for one in values]
        if len(values) < 2 or not all(isinstance(kind, Scalar) and kind.kind != BOOL for kind in kinds):
            self.source.refuse(node, "min or max of something else than numbers")
        known = [kind.value for kind in kinds if isinstance(kind, Scalar)]
        if None not in known:
            return constant(which(known))
        whole = all(isinstance(kind, Scalar) and kind.kind == INT for kind in kinds)
        name = f"cd_{'i' if whole else ''}{which.__name__}"
        values = [self.converted(node, one, INT if whole else REAL) for one in values]
        text = bare(values[0].text)
        for one in values[1:]:
            text = f"{name}({text}, {bare(one.text)})"
        return Value(text, Scalar(INT if whole else REAL))

    def _int(self, node: ast.expr) -> Value:
        one = self.value(node)
        if isinstance(one.type, Scalar) and one.type.kind == INT:
            return one
        return Value(f"(int32_t){self.converted(node, one, REAL).text}", Scalar(INT))

    def _len(self, node: ast.expr) -> Value:
        one = self.value(node)
        if not isinstance(one.type, View):
            self.source.refuse(node, "the length of something else than an array")
        return constant(one.type.shape[0])
