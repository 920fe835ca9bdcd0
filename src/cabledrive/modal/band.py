"""All modes of one kind: counted, listed and proven over the chains that carry them."""

from collections.abc import Callable, Sequence
from math import pi
from typing import Any

from cabledrive.mechanics.labelled_chain import LabelledChain
from cabledrive.modal.counting import counter_of
from cabledrive.modal.mode import SAME, TRANSVERSE, Mode, make_mode, multiplets
from cabledrive.modal.solver import ENCLOSURE, chain_modes

PLANES = ("v", "w")


class Band:
    """All modes of one kind: the chains that carry them, and how many planes each stands for.

    Parameters
    ----------
    chains : sequence of LabelledChain
    kind : {"longitudinal", "transverse"}
    """

    def __init__(self, chains: Sequence[LabelledChain], kind: str) -> None:
        self._chains, self._kind = chains, kind
        self._counters = [counter_of(chain.chain) for chain in chains]
        self._planes: tuple[str | None, ...] = PLANES if kind == TRANSVERSE else (None,)
        self.enclosure = ENCLOSURE
        self.rigid_body_modes = sum(chain.chain.rigid_body_modes for chain in chains)

    @property
    def _travel_time(self) -> float:
        return sum(float(chain.chain.travel_times.sum()) for chain in self._chains)

    def count(self, omega: float) -> int:
        """Number of modes below a frequency, without the rigid-body mode.

        ``omega`` [rad/s].
        """
        below = sum(max(counter(omega), chain.chain.rigid_body_modes) for counter, chain in self._pairs())
        return len(self._planes) * (below - self.rigid_body_modes)

    def below(self, omega: float) -> tuple[list[Mode], float]:
        """All modes below a frequency.

        ``omega`` [rad/s].
        Returns ``clear``: frequency up to which the list is certain [rad/s].
        """
        clear, step = omega, 4 * ENCLOSURE
        while self.count(clear * (1 - ENCLOSURE)) != self.count(clear * (1 + ENCLOSURE)):
            clear, step = clear * (1 - step), 2 * step
        return self._modes(clear), clear

    def first(self, count: int) -> tuple[list[Mode], float]:
        """The first few modes.

        ``count``: how many.
        Returns ``clear``: frequency up to which the list is complete [rad/s].
        """
        top = pi / self._travel_time / 8
        while self.count(top) < count:
            top *= 2
        return self._cleared(self._modes(top, first=count)[:count])

    def first_distinct(self, count: int) -> tuple[list[Mode], float]:
        """The modes of the first few distinct frequencies, the last multiplet whole.

        ``count``: how many frequencies.
        Returns ``clear``: frequency up to which the list is complete [rad/s].
        """
        top = pi / self._travel_time / 8
        while self.count(top) < count:
            top *= 2
        groups = multiplets(self._modes(top))
        while len(groups) < count or 2 * pi * groups[count - 1][-1].frequency * (1 + 2 * SAME) > top:
            top *= 2
            groups = multiplets(self._modes(top))
        return self._cleared([mode for group in groups[:count] for mode in group])

    def _cleared(self, listed: list[Mode]) -> tuple[list[Mode], float]:
        """A list of the first modes, and the frequency up to which it is complete [rad/s]."""
        last = 2 * pi * listed[-1].frequency
        held = sum(mode.multiplicity for mode in listed)
        for room in (0.1, 1e-3, 1e-6, 1e-9, 2 * ENCLOSURE):
            if self.count(last * (1 + room)) == held:
                return listed, last * (1 + room)
        return listed, last * (1 - 2 * ENCLOSURE)

    def _modes(self, top: float, first: int | None = None) -> list[Mode]:
        found = [
            (chain, solved)
            for counter, chain in self._pairs()
            for solved in chain_modes(chain.chain, top, first=first, count=counter)
        ]
        self.enclosure = max([self.enclosure, *(own.enclosure for _, own in found if own.enclosure)])
        named = [make_mode(*own, self._kind, plane) for own in found for plane in self._planes]
        return sorted(named, key=order_of)

    def _pairs(self) -> list[tuple[Callable[[float], int], LabelledChain]]:
        return list(zip(self._counters, self._chains, strict=True))


def order_of(mode: Mode) -> tuple[Any, ...]:
    """Key that sorts modes by frequency, then kind, place and plane."""
    return mode.frequency, mode.kind, mode.span != "upper", mode.section or (), mode.plane or ""
