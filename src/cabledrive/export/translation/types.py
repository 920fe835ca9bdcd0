"""What an expression of a kernel is: a scalar, a view of an array, a record of them, or several at once."""

from dataclasses import dataclass, replace
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

    def field(self, name: str) -> "Kind | None":
        """Type of a field; none where there is no such field."""
        return dict(self.fields).get(name)


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
