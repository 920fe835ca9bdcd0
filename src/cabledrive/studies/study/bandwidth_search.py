"""Bandwidths from the lowest on, until the encoders' counts make too much torque."""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import Any, Protocol, TypeVar

SAMPLES_PER_PERIOD = 40.0
RIPPLE = 1.5
"""Largest torque from quantisation, over that of the bandwidth with the least."""
LOUD = "quantisation raises the torque by half and more"


class Costed(Protocol):
    """A bandwidth that was tried."""

    @property
    def torque(self) -> float | None:
        """Largest torque [N m]; None: it was not run."""

    @property
    def refused(self) -> str:
        """Why it cannot be used; empty where it can."""


One = TypeVar("One", bound=Costed)


def while_quiet(tried: Iterable[tuple[One, dict[str, float]]]) -> Iterator[tuple[One, dict[str, float]]]:
    """Those up to the first that is too loud, which is refused.

    ``tried``: each made when it is asked for, with the share of every quantity.
    """
    least = float("inf")
    for found, shares in tried:
        least = min(least, found.torque if found.torque is not None else least)
        loud = found.torque is not None and found.torque > RIPPLE * least
        refused: Any = replace(found, refused=LOUD) if loud and not found.refused else found  # type: ignore[type-var]
        yield refused, shares
        if loud:
            return
