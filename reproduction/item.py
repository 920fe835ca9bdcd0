"""What is known of one statement of the print, and of the tables and figures that belong together."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from reproduction.panel import Panel

AGREES, ERRATUM, DIFFERS, NOT_COMPUTABLE = "agrees", "erratum", "differs", "not computable"
VERDICTS = (AGREES, ERRATUM, DIFFERS, NOT_COMPUTABLE)
UNEXPLAINED = "not explained"
NOT_COMPARABLE = "not comparable"
Otherwise = tuple[str, str]


@dataclass(frozen=True, slots=True, kw_only=True)
class Item:
    """One printed number or claim.

    Attributes
    ----------
    id : str
        Unique, lower case, such as "table-3-2-1-fundamental".
    source : str
        Where it stands in the print, and what it is.
    printed, computed : float, str or None
        As printed, and as found; words for a claim.
    unit : str
    deviation : float or None
        Computed over printed, minus one; None for words, or where one of them is missing.
    verdict : {"agrees", "erratum", "differs", "not computable"}
    note : str
        The reason: the place in the errata, the cause found, or why nothing can be computed.
    tested : bool, default True
        Whether the verdict tests a figure that this package computes. Else it cannot fail: an input held as
        printed, arithmetic among printed values, a judgement on the print alone, nothing to compute.
    """

    id: str
    source: str
    printed: float | str | None
    computed: float | str | None
    unit: str
    deviation: float | None
    verdict: str
    note: str
    tested: bool = True

    def plain(self) -> dict[str, Any]:
        """The item as JSON gives it.

        Returns
        -------
        dict
        """
        return {name: getattr(self, name) for name in self.__slots__}


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """What an entry has found.

    Attributes
    ----------
    items : tuple of Item
    panels : tuple of Panel
        Data of the figure.
    """

    items: tuple[Item, ...]
    panels: tuple[Panel, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Entry:
    """Numbered tables or figures, or the numbers in the prose of a section, that belong together.

    Attributes
    ----------
    name : str
        Unique, fit for a file name.
    chapter : str
        Chapter of the print, "A" for the appendix.
    covers : tuple of str
        Such as "Table 3.2", "Fig. 3.1", "Section 4.1".
    compute : callable
        Takes whether the quick version is wanted, returns an `Outcome`.
    """

    name: str
    chapter: str
    covers: tuple[str, ...]
    compute: Callable[[bool], Outcome]


def place(anchor: str) -> str:
    """Words that point to an item of the errata."""
    return f"reproduction/errata.md#{anchor}"


def rms(values: ArrayLike) -> float:
    """Root of the mean square."""
    return float(np.sqrt(np.mean(np.asarray(values, dtype=float) ** 2)))


def outcome(items: Sequence[Item], panels: Sequence[Panel] = ()) -> Outcome:
    """Put an outcome together."""
    return Outcome(items=tuple(items), panels=tuple(panels))
