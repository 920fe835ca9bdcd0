"""What a user gives as the cable law of a run: a name, a class, a function that makes one, or a law."""

from collections.abc import Callable, Mapping
from math import isfinite
from typing import Any, TypeAlias

import numpy as np

from cabledrive.mechanics.cable_law import CableLaw
from cabledrive.mechanics.tension_only import TensionOnly
from cabledrive.parameters.cable import Cable
from cabledrive.parameters.errors import InputRefused

Model: TypeAlias = str | type[CableLaw] | CableLaw | Callable[..., CableLaw]


def made_law(model: Any, cable: Cable) -> CableLaw:
    """A law for a cable from what stands for it."""
    if isinstance(model, CableLaw):
        return model
    if not callable(model):
        raise InputRefused(
            f"model is {model!r}: give the name of a law, a subclass of CableLaw, or a function making one"
        )
    try:
        law = model(pretension=cable.pretension, axial_rigidity=cable.axial_rigidity)
    except TypeError as error:
        raise InputRefused(
            f"model = {label(model)} cannot be made from pretension and axial_rigidity ({error}): give "
            "further fields a default, or functools.partial(...)"
        ) from None
    if not isinstance(law, CableLaw):
        raise InputRefused(f"model = {label(model)} makes a {type(law).__name__}: return a CableLaw")
    return law


def check_law(law: CableLaw, cable: Cable, known: Mapping[str, type[CableLaw]]) -> None:
    """Refuse a law of another cable, one that is no function of arrays, or one without the pretension."""
    if isinstance(law, TensionOnly):
        raise InputRefused(f'model = {label(law)}: give the taut law and slack = "tension-only"')
    for name, unit in (("pretension", "N"), ("axial_rigidity", "N")):
        ours, theirs = getattr(law, name), getattr(cable, name)
        if ours != theirs:
            raise InputRefused(
                f"model = {label(law)} has {name} = {ours:.6g} {unit}, the cable {theirs:.6g} {unit}: give "
                "the class, or make it for this cable"
            )
    if law.name in known and type(law) is not known[law.name]:
        raise InputRefused(f'model = {label(law)}: "{law.name}" is the name of another law: give it its own')
    zero = np.zeros(3)
    try:
        parts = [np.asarray(part, dtype=np.float64) for part in law.components(zero, zero, zero)]
        table = np.array([np.broadcast_to(part, zero.shape) for part in parts])
    except (TypeError, ValueError) as error:
        raise InputRefused(
            f"model = {label(law)}: components fails on arrays ({error}): use numpy functions and np.where"
        ) from None
    if table.shape != (3, 3):
        raise InputRefused(f"model = {label(law)}: components gives {len(table)} parts: return Tx, Ty, Tz")
    rng = np.random.default_rng(0)
    at = rng.uniform(-1e-3, 1e-3, (3, 50))
    total, excess = (
        np.stack(np.broadcast_arrays(*part(*at))) for part in (law.components, law.excess_components)
    )
    total[0] -= law.pretension
    if not np.allclose(total, excess, rtol=1e-9, atol=1e-9 * law.pretension, equal_nan=True):
        raise InputRefused(
            f"model = {label(law)}: excess_components and components disagree: define one of the two"
        )
    off = float(np.max(np.abs(table - np.array([[cable.pretension], [0.0], [0.0]]))))
    if not (isfinite(off) and off <= 1e-9 * cable.pretension):
        raise InputRefused(
            f"model = {label(law)}: the straight cable carries {table[0, 0]:.6g}, {table[1, 0]:.6g}, "
            f"{table[2, 0]:.6g} N instead of its pretension, {cable.pretension:.6g} N: add what is missing"
        )


def label(model: Model) -> str:
    """Name of a model in messages and results."""
    if isinstance(model, str):
        return model
    kind = model if isinstance(model, type) else getattr(model, "func", model)
    return str(getattr(kind, "name", None) or getattr(kind, "__name__", type(kind).__name__))
