"""Two methods on one log, or two logs of one axis, whose intervals exclude each other."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from cabledrive.identification.estimates import Identification
from cabledrive.identification.finding import Finding

CONTRADICTION = 5.0
"""Joint standard errors between two methods, or two logs, from which they contradict each other."""
ALIKE = 0.005
"""Share of the value within which no contradiction is stated."""


def contradicted(chosen: Identification, one: Identification, other: Identification) -> Identification:
    """The answer, with a finding where two methods exclude each other.

    ``one``, ``other``: by output error and by prediction error.
    """
    names = _excluding(one, other)
    if not names:
        return chosen
    words = "; ".join(
        f"{name.replace('_', ' ')} {one[name]:.4g} by output error, {other[name]:.4g} by prediction error"
        for name in names
    )
    finding = Finding("methods-contradict", f"two methods contradict each other on this log: {words}")
    return replace(chosen, findings=(*chosen.findings, finding))


def compared(found: Identification, each: Sequence[Identification]) -> Identification:
    """The answer, with a finding where logs of one axis exclude each other.

    ``found``: from all logs; ``each``: from each log by itself.
    """
    for k, one in enumerate(each):
        for other in each[k + 1 :]:
            names = _excluding(one, other)
            if names:
                words = ", ".join(
                    f"{name.replace('_', ' ')} {one[name]:.4g} and {other[name]:.4g}" for name in names
                )
                finding = Finding("logs-contradict", f"the logs contradict each other: {words}")
                return replace(found, findings=(*found.findings, finding))
    return found


def _excluding(one: Identification, other: Identification) -> list[str]:
    names = []
    for name, first in one.parameters.items():
        second = other.parameters[name]
        apart = abs(first.value - second.value)
        joint = float(np.hypot(first.standard_error, second.standard_error))
        if apart > CONTRADICTION * joint and apart > ALIKE * abs(first.value):
            names.append(name)
    return names
