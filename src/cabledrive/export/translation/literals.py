"""Numbers as C writes them: shortest digits that read back to the same bits."""

from dataclasses import dataclass
from math import isinf, isnan

import numpy as np

from cabledrive.export.translation.types import C_NAMES, INT, REAL


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
