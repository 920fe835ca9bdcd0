"""Calls in a kernel: of Python's own functions, of the math library, of other kernels."""

import ast
import math
from typing import Any

import numpy as np

from cabledrive.export.translation.expressions import Expressions, bare
from cabledrive.export.translation.scope import constant
from cabledrive.export.translation.types import BOOL, INT, REAL, Scalar, Value, View

MATH: dict[Any, str] = {
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
        single = {abs: self._absolute, float: self._float, int: self._int, len: self._len}
        if any(called is one for one in single):
            return single[called](node.args[0])
        if called is math.isfinite:
            return Value(f"cd_isfinite({bare(self.real(node.args[0]).text)})", Scalar(BOOL))
        if getattr(called, "__hash__", None) and called in MATH:
            name = MATH[called] + self.program.precision.suffix
            return Value(f"{name}({bare(self.real(node.args[0]).text)})", Scalar(REAL))
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

    def _absolute(self, node: ast.expr) -> Value:
        return Value(f"fabs{self.program.precision.suffix}({bare(self.real(node).text)})", Scalar(REAL))

    def _float(self, node: ast.expr) -> Value:
        return self.real(node)

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
