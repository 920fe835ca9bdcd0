"""Every mode of a chain: isolated by counting, refined by inverse iteration, proven by counting again."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.chain import Array, Chain, split_at_antinodes
from cabledrive.modal.counting import ModeCounter
from cabledrive.modal.refinement import inverse_iteration
from cabledrive.parameters import NotComputed

MULTIPLE = 1e-10
"""Modes closer than this, relative to their frequency, are one mode of higher multiplicity."""

ENCLOSURE = 1e-12
"""Half-width, relative, of the interval in which each mode is proven to lie by two counts."""

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
    shapes : ndarray, shape (joints of split and pendant, multiplicity)
        Displacements at the joints, normalised to unit modal mass [kg^-1/2].
    proven : bool
        Whether counts at both ends of the enclosure prove it.
    """

    omega: float
    multiplicity: int
    split: Chain
    joints: NDArray[np.intp]
    shapes: Array
    proven: bool


def chain_modes(
    chain: Chain, top: float, *, first: int | None = None, count: ModeCounter | None = None
) -> list[ChainMode]:
    """All modes of a chain below a frequency, ascending, without the rigid-body mode.

    ``top``: upper end [rad/s]; ``first``: stop after so many modes, counted with multiplicity; a multiple
    mode is not cut; ``count``: the chain's own, if there is one already.
    Raises `NotComputed` if a mode the count promises cannot be found.
    """
    count = count or ModeCounter(chain)
    rigid = chain.rigid_body_modes
    everything = Bracket(0.0, float(top), rigid, max(count(top), rigid))
    wanted = everything.below_high - rigid if first is None else min(first, everything.below_high - rigid)
    modes: list[ChainMode] = []
    found = 0
    for bracket in _isolate(everything, count, chain):
        if found >= wanted:
            break
        for mode in _refine(_narrow(bracket, count, _START), count, chain):
            modes.append(mode)
            found += mode.multiplicity
    return modes


def _isolate(bracket: Bracket, count: ModeCounter, chain: Chain) -> Iterator[Bracket]:
    """Bisect on the count until an interval holds one mode, or a cluster too close to part; lowest first."""
    longest = float(np.max(chain.travel_times))
    stack = [bracket]
    while stack:
        item = stack.pop()
        if item.modes == 0:
            continue
        narrow = (item.high - item.low) * longest <= 0.5 or item.high * longest <= 2.0
        if narrow and (item.modes == 1 or item.high - item.low <= MULTIPLE * item.high):
            yield item
        else:
            stack.extend(reversed(item.halves(count)))


def _refine(bracket: Bracket, count: ModeCounter, chain: Chain) -> list[ChainMode]:
    """Inverse iteration from the middle; where it leaves the interval or is not proven, narrow and repeat."""
    modes: list[ChainMode] = []
    while bracket.high - bracket.low > 1e-15 * bracket.high:
        middle = 0.5 * (bracket.low + bracket.high)
        split, joints = split_at_antinodes(chain, middle)
        found = inverse_iteration(split, middle, bracket.modes, bracket.low, bracket.high)
        if found is not None:
            modes = _prove(*found, bracket, count, split, joints)
            if all(mode.proven for mode in modes):
                return modes  # else it may be the neighbour's, which lies on the end of the interval
        wider, bracket = bracket, _narrow(bracket, count, 2.0**-4)
        if bracket is wider:
            break
    if modes:
        return modes
    raise NotComputed(
        f"modes: {bracket.modes} from {bracket.low:.15g} to {bracket.high:.15g} rad/s could not be refined"
    )


def _narrow(bracket: Bracket, count: ModeCounter, share: float) -> Bracket:
    """Bisect on the count to a share of the width and clear of zero, as long as the modes stay together."""
    width = share * (bracket.high - bracket.low)
    while bracket.high - bracket.low > max(min(width, 0.5 * bracket.high), 1e-15 * bracket.high):
        holding = [half for half in bracket.halves(count) if half.modes]
        if len(holding) > 1:
            break
        bracket = holding[0]
    return bracket


def _prove(
    omegas: Array, shapes: Array, bracket: Bracket, count: ModeCounter, split: Chain, joints: NDArray[np.intp]
) -> list[ChainMode]:
    """Group what is closer than round-off can part, and prove each group by counts at both sides."""
    groups = [np.arange(omegas.size)]
    if omegas.size > 1:
        groups = np.split(groups[0], np.flatnonzero(np.diff(omegas) > MULTIPLE * omegas[:-1]) + 1)
    modes = []
    for group in groups:
        low, high = omegas[group[0]] * (1 - ENCLOSURE), omegas[group[-1]] * (1 + ENCLOSURE)
        below, above = bracket.below_low + group[0], bracket.below_low + group[-1] + 1
        proven = bool(count(low) <= below and count(high) >= above)
        omega = float(omegas[group[0]] if group.size == 1 else np.mean(omegas[group]))
        modes.append(ChainMode(omega, group.size, split, joints, shapes[:, group], proven))
    return modes
