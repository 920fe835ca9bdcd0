"""All modes of a network, merged from its independent parts and its waves between held ends, in order."""

from collections.abc import Iterator
from math import pi

import numpy as np

from cabledrive.mechanics.network.assembly import DIRECTIONS, Network
from cabledrive.mechanics.network.hanging import hanging_elements
from cabledrive.mechanics.network.motion import ALONG
from cabledrive.modal.mode import LONGITUDINAL, STRING, TRANSVERSE, Mode, multiplets
from cabledrive.modal.mode import SAME as ONE_FREQUENCY
from cabledrive.modal.network.component import HeldWaves, components_of
from cabledrive.modal.network.elastic_links import elastic_links
from cabledrive.modal.network.motion import PLANES, HeldMotion, NetworkMotion
from cabledrive.modal.network.resting import RestingElement, models_of
from cabledrive.modal.network.structure import MULTIPLE, ComponentStructure
from cabledrive.modal.solver import ENCLOSURE, ENCLOSURES, Proven, modes_of

SAME = 1e-12
"""Harmonics of equal spans are one longitudinal mode when closer than this, relative."""


MOST_DOUBLINGS = 60
"""Of the frequency, in search of so many modes of a part; one that stores no waves has only a few."""


class NetworkSpectrum:
    """Modes of a network: counted, listed and proven.

    Parameters
    ----------
    network : Network
    even : bool, default False
        Take all ropes for straight strings of even tension without bending stiffness, as the frequency
        response does.
    hanging : bool, default True
        Ropes hang in shallow sag; else all are straight.
    """

    def __init__(self, network: Network, *, even: bool = False, hanging: bool = True) -> None:
        self.network = network
        self.hung = hanging_elements(network) if hanging and not even else {}
        elastic = {} if even else elastic_links(network, self.hung)
        components, self._held, resting = components_of(network, elastic)
        self._structures = [ComponentStructure(component) for component in components]
        self._resting = [RestingElement(network, own) for own in resting]
        self._models = models_of(network, elastic)
        self.rigid_body_modes = sum(structure.rigid_body_modes for structure in self._structures)
        self.enclosure = ENCLOSURE
        self._lazy: dict[int, tuple[list[list[Mode]], Iterator[list[Mode]]]] = {}

    @property
    def straight(self) -> list[int]:
        """Numbers of the spans whose sag is left out."""
        hanging = {self.network.pieces[piece].span for piece in self.hung}
        return [span for span in range(len(self.network.drive.free_spans)) if span not in hanging]

    def count(self, omega: float) -> int:
        """Number of modes below a frequency [rad/s], without rigid-body modes."""
        coupled = sum(max(own.count(omega), own.rigid_body_modes) for own in self._structures)
        held = sum(wave.below(omega) for wave in self._held) + sum(own.below(omega) for own in self._resting)
        return coupled - self.rigid_body_modes + held

    @property
    def slowest(self) -> float:
        """A frequency below which few modes lie [rad/s]."""
        times = [own.longest for own in (*self._structures, *(own.structure for own in self._resting))]
        return pi / max([*times, *(wave.time for wave in self._held)]) / 8.0

    def below(self, omega: float) -> list[Mode]:
        """All modes below a frequency [rad/s], ascending."""
        found = [self._mode(own) for structure in self._structures for own in self._solved(structure, omega)]
        return sorted([*found, *self._waves(omega), *self._of_resting(omega)], key=order_of)

    def _of_resting(self, omega: float) -> Iterator[Mode]:
        """Modes of elements between ends at rest below a frequency [rad/s]."""
        for own in self._resting:
            for solved in self._solved(own.structure, omega):
                yield from self._of_links(own, solved)

    def _of_links(self, own: RestingElement, solved: Proven) -> Iterator[Mode]:
        """A mode of one rope between ends at rest as those of all its links."""
        yield from (self._mode(part, clamped=True) for part in own.each(solved))

    def first(self, kind: str, count: int, limit: int) -> list[Mode]:
        """The first modes of one kind, ascending, a multiple one at the end whole.

        ``count``: how many; ``limit``: modes of each independent part that are looked through for them. Fewer
        are returned where more are not certain to be the first.
        """
        found, reach = self._found(kind, count, limit, distinct=False)
        kept: list[Mode] = []
        for mode in found:
            if sum(own.multiplicity for own in kept) >= count or 2 * pi * mode.frequency > reach:
                break
            kept.append(mode)
        return kept

    def first_distinct(self, kind: str, count: int, limit: int) -> tuple[list[Mode], float]:
        """The modes of the first distinct frequencies of one kind, ascending, the last multiplet whole.

        ``count``, ``limit``: as of `first`.
        Returns ``clear``: frequency up to which the list is complete [rad/s].
        """
        # One frequency more than is wanted: that the last multiplet is whole shows where the next one begins.
        found, reach = self._found(kind, count + 1, limit, distinct=True)
        groups = multiplets(mode for mode in found if 2 * pi * mode.frequency < reach)
        listed = [mode for group in groups[:count] for mode in group]
        if not listed:
            return [], reach
        last = 2 * pi * listed[-1].frequency
        beyond = 2 * pi * groups[count][0].frequency if len(groups) > count else reach
        return listed, min(1.1 * last, 0.5 * (last + beyond))

    def _found(self, kind: str, count: int, limit: int, *, distinct: bool) -> tuple[list[Mode], float]:
        """Modes of one kind, ascending, among them the first, and up to where these are all [rad/s]."""
        found = self._first_waves(kind, count, distinct)
        reach = np.inf
        parts: list[ComponentStructure | RestingElement] = [*self._structures, *self._resting]
        for part in parts:
            highest = _highest_of(found, count, distinct)
            own, end = self._first_of(part, kind, count, limit, highest, distinct)
            found += own
            reach = min(reach, end)
        return sorted(found, key=order_of), reach

    def _first_waves(self, kind: str, count: int, distinct: bool) -> list[Mode]:
        """As many waves between held ends, at least, as are asked for of one kind."""
        own = [wave for wave in self._held if self._held_kind(wave) == kind]
        if not own:
            return []
        every = np.concatenate(
            [np.repeat(np.arange(1, count + 1), wave.count) * pi / wave.time for wave in own]
        )
        if distinct:
            every = np.sort(every)
            every = every[np.diff(every, prepend=0.0) > ONE_FREQUENCY * every]
        top = float(np.partition(every, count - 1)[count - 1]) * (1.0 + ONE_FREQUENCY)
        return [mode for mode in self._waves(top) if mode.kind == kind]

    def _held_kind(self, wave: HeldWaves) -> str:
        return LONGITUDINAL if DIRECTIONS[self.network.direction[wave.link]] == ALONG else TRANSVERSE

    def _first_of(
        self,
        part: ComponentStructure | RestingElement,
        kind: str,
        count: int,
        limit: int,
        highest: float,
        distinct: bool,
    ) -> tuple[list[Mode], float]:
        """First modes of one kind of an independent part, and up to where these are all [rad/s].

        ``highest``: frequency beyond which none is wanted [Hz].
        """
        if kind not in self._kinds(part):
            return [], np.inf
        found: list[Mode] = []
        seen = 0
        for modes in self._in_order(part):
            seen += sum(mode.multiplicity for mode in modes)
            found += [mode for mode in modes if mode.kind == kind]
            if _number(found, distinct) >= count or modes[0].frequency > highest:
                break
            if seen >= limit:
                return found, 2 * pi * modes[0].frequency
        return found, np.inf

    def _kinds(self, part: ComponentStructure | RestingElement) -> set[str]:
        """Kinds of modes that an independent part may have."""
        if isinstance(part, RestingElement):
            return {LONGITUDINAL, TRANSVERSE} if part.hangs else {TRANSVERSE}
        own = part.component
        along = self.network.direction[own.links] == DIRECTIONS.index(ALONG)
        kinds = {LONGITUDINAL} if np.any(along) or any(link.hangs for link in own.elastic) else set()
        return kinds | {TRANSVERSE} if own.elastic or not np.all(along) else kinds

    def _in_order(self, part: ComponentStructure | RestingElement) -> Iterator[list[Mode]]:
        """The modes of a part, ascending, solved as they are asked for and kept."""
        kept, more = self._lazy.setdefault(id(part), ([], self._ascending(part)))
        yield from list(kept)
        for modes in more:
            kept.append(modes)
            yield modes

    def _ascending(self, part: ComponentStructure | RestingElement) -> Iterator[list[Mode]]:
        """The modes of a part octave by octave, those of one frequency together."""
        structure = part.structure if isinstance(part, RestingElement) else part
        low, top = 0.0, self.slowest
        for _ in range(MOST_DOUBLINGS):
            for solved in self._solved(structure, top, low):
                if isinstance(part, RestingElement):
                    yield list(self._of_links(part, solved))
                else:
                    yield [self._mode(solved)]
            low, top = top, 2.0 * top

    def _solved(self, structure: ComponentStructure, omega: float, low: float = 0.0) -> Iterator[Proven]:
        if structure.component.columns.size or structure.component.elastic:
            yield from modes_of(structure, omega, low=low, enclosures=ENCLOSURES, multiple=MULTIPLE)

    def _mode(self, solved: Proven, *, clamped: bool = False) -> Mode:
        """A solved mode in the terms of the machine."""
        if solved.enclosure is not None:
            self.enclosure = max(self.enclosure, solved.enclosure)
        motion = NetworkMotion(self.network, solved)
        span, way = motion.place if motion.strain_by_span else ("", ALONG)
        across = motion.kind == TRANSVERSE
        if across and way == ALONG:
            ways = {key: share for key, share in motion.strain_by_span.items() if key[1] != ALONG}
            span, way = max(ways, key=lambda key: ways[key])
        return Mode(
            frequency=solved.omega / (2 * pi),
            kind=motion.kind,
            multiplicity=solved.multiplicity,
            span=span if across else None,
            plane=PLANES[way] if across else None,
            section=(0.0, self._length(span)) if across else None,
            model=self._models.get((span, way), STRING) if across else None,
            clamped=clamped,
            proven=solved.enclosure is not None,
            _motion=motion,
        )

    def _length(self, span: str) -> float:
        return next(own.length for own in self.network.drive.free_spans if own.name == span)

    def _waves(self, omega: float) -> Iterator[Mode]:
        """Waves between held ends below a frequency; longitudinal ones of one frequency together."""
        along: list[tuple[float, int, HeldWaves]] = []
        for wave in self._held:
            way = DIRECTIONS[self.network.direction[wave.link]]
            for number in range(1, int(np.floor(omega * wave.time / pi)) + 1):
                frequency = number / (2.0 * wave.time)
                if way == ALONG:
                    along.append((frequency, number, wave))
                else:
                    yield self._held_mode(frequency, number, (wave,), PLANES[way])
        along.sort(key=lambda item: item[0])
        group: list[tuple[float, int, HeldWaves]] = []
        for item in along:
            if group and (item[1] != group[0][1] or item[0] > group[0][0] * (1.0 + SAME)):
                yield self._held_mode(group[0][0], group[0][1], tuple(own for _, _, own in group), None)
                group = []
            group.append(item)
        if group:
            yield self._held_mode(group[0][0], group[0][1], tuple(own for _, _, own in group), None)

    def _held_mode(
        self, frequency: float, number: int, waves: tuple[HeldWaves, ...], plane: str | None
    ) -> Mode:
        motion = HeldMotion(self.network, waves, number)
        piece = self.network.pieces[self.network.piece[waves[0].link]]
        return Mode(
            frequency=frequency,
            kind=LONGITUDINAL if plane is None else TRANSVERSE,
            multiplicity=sum(wave.count for wave in waves),
            span=None if plane is None else motion.place[0],
            plane=plane,
            section=None if plane is None else (piece.start, piece.end),
            model=None if plane is None else STRING,
            clamped=True,
            proven=True,
            _motion=motion,
        )


def _number(modes: list[Mode], distinct: bool) -> int:
    """Number of distinct frequencies, or of modes with their multiplicities; ``modes`` ascending."""
    return len(multiplets(modes)) if distinct else sum(mode.multiplicity for mode in modes)


def _highest_of(found: list[Mode], count: int, distinct: bool) -> float:
    """Frequency of the last of so many modes, the lowest that are found [Hz]; infinite if there are fewer."""
    if distinct:
        groups = multiplets(sorted(found, key=order_of))
        return groups[count - 1][-1].frequency if len(groups) >= count else np.inf
    seen = 0
    for mode in sorted(found, key=order_of):
        seen += mode.multiplicity
        if seen >= count:
            return mode.frequency
    return np.inf


def order_of(mode: Mode) -> tuple[float, str, str, str]:
    """Key that sorts modes by frequency, then kind, span and plane."""
    return mode.frequency, mode.kind, mode.span or "", mode.plane or ""
