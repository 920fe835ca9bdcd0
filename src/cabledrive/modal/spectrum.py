"""All modes of a network: counted, listed and proven, part by part."""

from collections.abc import Hashable, Iterator
from functools import cached_property
from math import inf, pi
from typing import NamedTuple

import numpy as np

from cabledrive.modal.component import Component
from cabledrive.modal.elements import ALONG
from cabledrive.modal.mode import LONGITUDINAL, SAME, TRANSVERSE, multiplets
from cabledrive.modal.motion import HeldMode, Mode
from cabledrive.modal.networks import ModalNetwork
from cabledrive.modal.rows import TOGETHER
from cabledrive.modal.search import ENCLOSURE

ONE_WAVE = 1e-12
"""Harmonics of equal ropes along are one mode when closer than this, relative."""
MOST_DOUBLINGS = 80
"""Of the frequency, in search of the first modes of one kind."""
MANY, MOST_GRIDS = 200, 12
"""Unknowns of a part from which on grids of frequencies, so many, are laid around the one that is sought."""
MOST = 2.0**60
"""Times the slowest frequency, above which nothing is looked for: what stores no waves has few modes."""
LOOKED_THROUGH = 400
"""Modes of a part among which the first of a kind are looked for."""
FEW = 32
"""Of them, those that are looked through first: where one cannot be found, the others are not waited for."""


class _Part(NamedTuple):
    """Coordinates tied together, or a rope between ends at rest, of which so many have the same modes."""

    own: Component
    times: int
    network: ModalNetwork

    @property
    def kinds(self) -> set[str]:
        """Kinds of modes that it may have."""
        ways = self.own.ways
        found = {LONGITUDINAL} if ALONG in ways or not ways else set()
        return found | ({TRANSVERSE} if ways - {ALONG} else set())

    @property
    def closed_form(self) -> bool:
        """Whether it is one wave between ends at rest."""
        return not self.own.size and not self.own.ropes

    def count(self, omega: float) -> int:
        """Its modes below a frequency [rad/s]."""
        return self.times * self.own.count(omega)


class _Window(NamedTuple):
    """Frequencies from one edge to the next [rad/s], with the parts of the network between them."""

    low: float
    high: float
    parts: list[_Part]


class Spectrum:
    """Modes of a network, in windows of frequency: above its edge a rope that sags is straight."""

    def __init__(self, network: ModalNetwork) -> None:
        self.network = network
        self.enclosure = ENCLOSURE
        self._windows = [_Window(0.0, inf, _parts(network))]
        self._edges = network.edges
        self._kept: dict[int, tuple[float, list[Mode]]] = {}
        self._straight: list[_Part] | None = None

    @cached_property
    def rigid_body_modes(self) -> int:
        """Motions that strain nothing."""
        return sum(part.own.rigid for part in self._windows[0].parts)

    @property
    def slowest(self) -> float:
        """A frequency below which few modes lie [rad/s]."""
        return pi / max((part.own.longest for part in self._windows[0].parts), default=1.0) / 8.0

    def _reach(self, omega: float) -> None:
        """Windows up to a frequency: each begins where the count is that of the one before it."""
        while self._edges and self._edges[0] < omega:
            edge, last = self._edges.pop(0), self._windows[-1]
            above = _parts(self.network.straight_above(edge))
            for step in range(40):
                at = max(edge, last.low) * (1.0 + 2e-3 * step)
                if _counted(last.parts, at) == _counted(above, at) == _counted(above, at * (1.0 + 1e-5)):
                    self._windows[-1] = last._replace(high=at)
                    self._windows.append(_Window(at, inf, above))
                    break

    def count(self, omega: float, kinds: set[str] | None = None) -> int:
        """Modes below a frequency [rad/s], without rigid-body modes; of parts that may have some kinds."""
        self._reach(omega)
        window = next(own for own in self._windows if omega <= own.high)
        return _counted(window.parts, omega, kinds)

    def below(self, omega: float) -> list[Mode]:
        """All modes below a frequency [rad/s], ascending."""
        self._reach(omega)
        found = [
            mode
            for window in self._windows
            if window.low < omega
            for part in window.parts
            for mode in self._listed(part, window.low, min(omega, window.high))
        ]
        return self._in_order(found)

    def first(self, kinds: dict[str, int], *, distinct: bool) -> dict[str, tuple[list[Mode], float]]:
        """The first modes of each kind, so many or so many frequencies, the last multiplet whole.

        Returns the modes of each kind, and up to where these are all [rad/s]: infinite where there are none.
        """
        found: dict[str, tuple[list[Mode], float]] = {}
        tops = {kind: self._about(kind, count + distinct) for kind, count in kinds.items()}
        for kind, top in sorted(tops.items(), key=lambda own: -own[1]):
            count = kinds[kind]
            listed, reach = self._first_of(kind, count + distinct, top, distinct)
            groups = multiplets(listed) if distinct else [[mode] for mode in listed]
            kept: list[list[Mode]] = []
            for group in groups:
                number = len(kept) if distinct else sum(own[0].multiplicity for own in kept)
                if number >= count or 2 * pi * group[0].frequency > reach:
                    break
                kept.append(group)
            if not kept:
                found[kind] = [], reach
                continue
            last = 2 * pi * kept[-1][-1].frequency
            more = len(groups) > len(kept)
            beyond = 2 * pi * groups[len(kept)][0].frequency if more else min(reach, 1.2 * last)
            found[kind] = [m for group in kept for m in group], min(1.1 * last, 0.5 * (last + beyond))
        return found

    def _first_of(self, kind: str, count: int, top: float, distinct: bool) -> tuple[list[Mode], float]:
        """Modes of one kind, ascending, the first ones, and up to where these are all [rad/s]."""
        low, found, seen, reach = 0.0, list[Mode](), 0, inf
        for _ in range(MOST_DOUBLINGS):
            window = next(own for own in self._windows if low < own.high)
            mixed = [part.own.whole for part in window.parts if len(part.kinds) > 1]
            most = low + (LOOKED_THROUGH if low else FEW) * pi / max(mixed) if mixed else inf
            self._reach(min(top, most))
            window = next(own for own in self._windows if low < own.high)
            end = min(top, most, window.high)
            parts = [part for part in window.parts if kind in part.kinds]
            here = [mode for part in parts for mode in self._listed(part, low, end)]
            seen += sum(mode.multiplicity for mode in here)
            found = self._in_order([*found, *(mode for mode in here if mode.kind == kind)])
            number = len(multiplets(found)) if distinct else sum(mode.multiplicity for mode in found)
            if number >= count or seen >= LOOKED_THROUGH * max(1, len(parts)):
                reach = end
                break
            if end >= MOST * self.slowest:
                break
            low, top = end, top if end < top else 1.5 * top
        return found, reach

    def _about(self, kind: str, count: int) -> float:
        """A frequency with about so many modes of one kind below it [rad/s], by straight ropes."""
        if self._straight is None:
            edges = self.network.edges
            straight = _parts(self.network.straight_above(edges[-1])) if edges else self._windows[0].parts
            self._straight = straight
        pure = [part for part in self._straight if part.kinds == {kind}]
        parts = pure or [part for part in self._straight if kind in part.kinds]
        long = [part.own for part in parts if part.own.whole]
        if not long:
            return self.slowest
        many = any(own.size > MANY for own in long)
        high = min((count + 2 + own.size * (not many)) * pi / own.whole for own in long)
        low, most = high / 64.0, min((count + own.size + 2) * pi / own.whole for own in long)
        for _ in range(MOST_GRIDS):
            grid = np.geomspace(low, high, 16)
            counts = sum((part.times * part.own.counts(grid) for part in parts), np.zeros(grid.size))
            place = int(np.searchsorted(counts, count))
            if place < grid.size:
                high = float(grid[place])
                if not many or counts[place] <= 1.25 * count:
                    break
                low = float(grid[place - 1]) if place else low / 64.0
            elif high < most:
                low, high = high, min(4.0 * high, most)
            else:
                break
        return high

    def _in_order(self, modes: list[Mode]) -> list[Mode]:
        """Ascending, with waves of one frequency along ropes between ends at rest as one mode."""
        found: list[Mode] = []
        for mode in sorted(modes, key=order_of):
            last = found[-1] if found else None
            # the same harmonic of equal ropes along
            if (
                isinstance(last, HeldMode)
                and isinstance(mode, HeldMode)
                and last.kind == mode.kind == LONGITUDINAL
                and last.number == mode.number
                and mode.frequency <= last.frequency * (1.0 + ONE_WAVE)
            ):
                waves = last.waves + mode.waves
                found[-1] = HeldMode(last.network, waves, last.number, last.frequency)
            else:
                found.append(mode)
        return found

    def _listed(self, part: _Part, low: float, top: float) -> list[Mode]:
        """Modes of a part of a window between two frequencies; what lies between is solved once."""
        window = next(own for own in self._windows if part in own.parts)
        reach, modes = self._kept.get(id(part.own), (window.low, []))
        if reach < top:
            modes = [*modes, *self._modes(part, reach, top)]
            self._kept[id(part.own)] = top, modes
        return [mode for mode in modes if low <= 2 * pi * mode.frequency < top]

    def _modes(self, part: _Part, low: float, top: float) -> Iterator[Mode]:
        if part.closed_form:
            wave = part.own.waves[0]
            first = int(low * wave.time_at(low) / pi) if low > 0.0 else 0
            for number in range(first + 1, int(top * wave.time_at(top) / pi) + 1):
                yield HeldMode(part.network, ((wave, part.times),), number, wave.held(number) / (2.0 * pi))
            return
        alike: dict[int, list[Mode]] = {}
        for cut, solved in part.own.modes(low, top):
            if solved.enclosure:
                self.enclosure = max(self.enclosure, solved.enclosure)
            if part.times > 1:
                shapes = np.repeat(solved.shapes, part.times, axis=1)
                solved = solved._replace(shapes=shapes, multiplicity=part.times * solved.multiplicity)
            alike.setdefault(solved.multiplicity, []).append(Mode(part.network, cut, solved))
        for modes in alike.values():
            if len(part.kinds) > 1:
                most = max(1, TOGETHER // modes[0].cut.table.first.size)
                for some in (modes[i : i + most] for i in range(0, len(modes), most)):
                    cut, solutions = modes[0].cut, [mode.solved for mode in some]
                    both = zip(some, cut.energies(solutions), cut.across(solutions), strict=True)
                    for mode, energies, across in both:
                        mode.row_energies, mode.across = energies, across
                        mode.places  # noqa: B018 (from which its kind will be asked)
                        del mode.row_energies
            yield from modes


def _parts(network: ModalNetwork) -> list[_Part]:
    tied, held = network.components()
    parts = [*(_Part(own, 1, network) for own in tied), *(_Part(own, times, network) for own, times in held)]
    first: dict[Hashable, Component] = {}
    for part in parts:
        if not part.closed_form:
            part.own.twin = first.setdefault(part.own.alike, part.own)
    return parts


def _counted(parts: list[_Part], omega: float, kinds: set[str] | None = None) -> int:
    return sum(part.count(omega) for part in parts if kinds is None or part.kinds & kinds)


def order_of(mode: Mode) -> tuple[float, str, bool, tuple[float, ...], str, str]:
    """Key that sorts modes by frequency, to twelve digits, then kind, place and plane."""
    return (
        float(f"{mode.frequency:.12g}"),
        mode.kind,
        mode.span != "upper",
        mode.section or (),
        mode.span or "",
        mode.plane or "",
    )


__all__ = ["LOOKED_THROUGH", "SAME", "Spectrum", "order_of"]
