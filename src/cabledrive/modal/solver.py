"""Every mode of a structure: isolated by counting, refined by inverse iteration, proven by counting again."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.chain import Array, Chain, split_at_antinodes
from cabledrive.modal.counting import counter_of
from cabledrive.modal.refinement import inverse_iteration
from cabledrive.parameters import NotComputed

MULTIPLE = 1e-10
"""Modes closer than this, relative to their frequency, are one mode of higher multiplicity."""

ENCLOSURE = 1e-12
"""Half-width, relative, of the interval in which each mode is proven to lie by two counts."""

ENCLOSURES = (1e-12, 1e-11, 1e-10, 1e-9, 1e-8)
"""Half-widths where the count is of an assembled matrix: the first that its round-off allows."""

_START = 2.0**-2


class Bracket(NamedTuple):
    """An interval of frequency with the counts at its ends.

    Attributes
    ----------
    low, high : float
        Ends [rad/s].
    below_low, below_high : int
        Number of modes below each end.
    """

    low: float
    high: float
    below_low: int
    below_high: int

    @property
    def modes(self) -> int:
        """Number of modes inside."""
        return self.below_high - self.below_low

    def halves(self, count: Callable[[float], int]) -> tuple["Bracket", "Bracket"]:
        """Cut in the middle.

        ``count``: number of modes below a frequency.
        """
        middle = 0.5 * (self.low + self.high)
        below = min(max(count(middle), self.below_low), self.below_high)
        lower = Bracket(self.low, middle, self.below_low, below)
        return lower, Bracket(middle, self.high, below, self.below_high)


@dataclass(frozen=True, slots=True, eq=False)
class ChainMode:
    """One natural frequency of a chain with the shapes that belong to it.

    Attributes
    ----------
    omega : float
        Natural frequency [rad/s].
    multiplicity : int
    split : Chain
        The chain with massless joints added, on which the shapes are given.
    joints : ndarray of int
        Where the chain's own joints are among those of `split`.
    shapes : ndarray, shape (joints of split and pendants, multiplicity)
        Displacements at the joints, normalised to unit modal mass [kg^-1/2].
    enclosure : float or None
        Relative half-width of the interval in which two counts prove it; None: not proven.
    """

    omega: float
    multiplicity: int
    split: Chain
    joints: NDArray[np.intp]
    shapes: Array
    enclosure: float | None

    @property
    def proven(self) -> bool:
        """Whether counts at both ends of the enclosure prove it."""
        return self.enclosure is not None


class Refined(NamedTuple):
    """Modes that inverse iteration has found.

    Attributes
    ----------
    omegas : ndarray, shape (k,)
        Natural frequencies [rad/s], ascending.
    shapes : ndarray, shape (joints, k)
        Displacements, normalised to unit modal mass [kg^-1/2].
    frame : object
        What the shapes are given on.
    """

    omegas: Array
    shapes: NDArray[Any]
    frame: Any


class Structure(Protocol):
    """What the solver asks of a structure whose modes can be counted."""

    rigid_body_modes: int
    longest: float
    """Longest travel time of a wave-carrying part [s]."""

    def count(self, omega: float) -> int:
        """Number of modes below a frequency [rad/s], rigid-body modes included."""

    def refined(self, start: float, modes: int, low: float, high: float) -> Refined | None:
        """So many modes between two frequencies [rad/s], or None where iteration leaves the interval."""


class Proven(NamedTuple):
    """One natural frequency with the shapes that belong to it.

    Attributes
    ----------
    omega : float
        [rad/s].
    multiplicity : int
    shapes : ndarray, shape (joints, multiplicity)
    frame : object
        What the shapes are given on.
    enclosure : float or None
        Relative half-width of the interval in which two counts prove it; None: not proven.
    """

    omega: float
    multiplicity: int
    shapes: NDArray[Any]
    frame: Any
    enclosure: float | None


class _ChainStructure:
    """A chain as the solver sees it."""

    def __init__(self, chain: Chain, count: Callable[[float], int]) -> None:
        self._chain, self.count = chain, count
        self.rigid_body_modes = chain.rigid_body_modes
        self.longest = float(np.max(chain.travel_times))

    def refined(self, start: float, modes: int, low: float, high: float) -> Refined | None:
        """Inverse iteration on the chain, its long segments cut."""
        split, joints = split_at_antinodes(self._chain, start)
        found = inverse_iteration(split, start, modes, low, high)
        return None if found is None else Refined(*found, (split, joints))


def chain_modes(
    chain: Chain, top: float, *, first: int | None = None, count: Callable[[float], int] | None = None
) -> list[ChainMode]:
    """All modes of a chain below a frequency, ascending, without the rigid-body mode.

    ``top``: upper end [rad/s]; ``first``: stop after so many modes, counted with multiplicity; a multiple
    mode is not cut; ``count``: the chain's own, if there is one already.
    Raises `NotComputed` if a mode the count promises cannot be found.
    """
    structure = _ChainStructure(chain, count or counter_of(chain))
    widths = (ENCLOSURE,) if chain.uniform else ENCLOSURES
    return [
        ChainMode(mode.omega, mode.multiplicity, split, joints, mode.shapes, mode.enclosure)
        for mode in modes_of(structure, top, first=first, enclosures=widths)
        for split, joints in [mode.frame]
    ]


def modes_of(
    structure: Structure,
    top: float,
    *,
    low: float = 0.0,
    first: int | None = None,
    enclosures: tuple[float, ...] = (ENCLOSURE,),
    multiple: float = MULTIPLE,
) -> Iterator[Proven]:
    """All modes of a structure below a frequency, ascending, without rigid-body modes.

    ``top``, ``low``: ends [rad/s]; ``first``: stop after so many modes, counted with multiplicity; a multiple
    mode is not cut; ``enclosures``: relative half-widths to prove each in, the first that two counts confirm;
    ``multiple``: modes closer than this are one.
    Raises `NotComputed` if a mode the count promises cannot be found.
    """
    rigid = structure.rigid_body_modes
    below = max(structure.count(low), rigid) if low > 0.0 else rigid
    everything = Bracket(low, float(top), below, max(structure.count(top), below))
    wanted = everything.modes if first is None else min(first, everything.modes)
    found = 0
    for bracket in _isolate(everything, structure, multiple):
        if found >= wanted:
            break
        for mode in _refine(_narrow(bracket, structure, _START), structure, enclosures, multiple):
            found += mode.multiplicity
            yield mode


def _isolate(bracket: Bracket, structure: Structure, multiple: float) -> Iterator[Bracket]:
    """Bisect on the count until an interval holds one mode, or a cluster too close to part; lowest first."""
    longest = structure.longest
    stack = [bracket]
    while stack:
        item = stack.pop()
        if item.modes == 0:
            continue
        narrow = (item.high - item.low) * longest <= 0.5 or item.high * longest <= 2.0
        if narrow and (item.modes == 1 or item.high - item.low <= multiple * item.high):
            yield item
        else:
            stack.extend(reversed(item.halves(structure.count)))


def _refine(
    bracket: Bracket, structure: Structure, enclosures: tuple[float, ...], multiple: float
) -> list[Proven]:
    """Inverse iteration from the middle; where it leaves the interval or is not proven, narrow and repeat."""
    modes: list[Proven] = []
    while bracket.high - bracket.low > 1e-15 * bracket.high:
        middle = 0.5 * (bracket.low + bracket.high)
        found = structure.refined(middle, bracket.modes, bracket.low, bracket.high)
        if found is not None:
            modes = _prove(found, bracket, structure.count, enclosures, multiple)
            if all(mode.enclosure is not None for mode in modes):
                return modes  # else it may be the neighbour's, which lies on the end of the interval
        wider, bracket = bracket, _narrow(bracket, structure, 2.0**-4)
        if bracket is wider:
            break
    if modes:
        return modes
    raise NotComputed(
        f"modes: {bracket.modes} from {bracket.low:.15g} to {bracket.high:.15g} rad/s could not be refined"
    )


def _narrow(bracket: Bracket, structure: Structure, share: float) -> Bracket:
    """Bisect on the count to a share of the width and clear of zero, as long as the modes stay together."""
    width = share * (bracket.high - bracket.low)
    while bracket.high - bracket.low > max(min(width, 0.5 * bracket.high), 1e-15 * bracket.high):
        holding = [half for half in bracket.halves(structure.count) if half.modes]
        if len(holding) > 1:
            break
        bracket = holding[0]
    return bracket


def _prove(
    found: Refined,
    bracket: Bracket,
    count: Callable[[float], int],
    enclosures: tuple[float, ...],
    multiple: float,
) -> list[Proven]:
    """Group what is closer than round-off can part, and prove each group by counts at both sides."""
    omegas = found.omegas
    groups = [np.arange(omegas.size)]
    if omegas.size > 1:
        groups = np.split(groups[0], np.flatnonzero(np.diff(omegas) > multiple * omegas[:-1]) + 1)
    modes = []
    for group in groups:
        below, above = bracket.below_low + int(group[0]), bracket.below_low + int(group[-1]) + 1
        first, last = float(omegas[group[0]]), float(omegas[group[-1]])
        enclosure = next(
            (e for e in enclosures if count(first * (1 - e)) <= below and count(last * (1 + e)) >= above),
            None,
        )
        omega = first if group.size == 1 else float(np.mean(omegas[group]))
        modes.append(Proven(omega, group.size, found.shapes[:, group], found.frame, enclosure))
    return modes
