"""The variables of an FMU."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Variable:
    """A variable of an FMU: causality "input", "output" or "parameter"; ``unit`` may be empty."""

    name: str
    causality: str
    unit: str
    about: str
    start: float = 0.0
