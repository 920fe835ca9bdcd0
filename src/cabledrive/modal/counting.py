r"""How many modes lie below a frequency: the count that certifies every list of modes.

Wittrick and Williams: the number of natural frequencies below :math:`\omega` is the number of negative
eigenvalues of the dynamic stiffness, plus the modes each segment has between held ends,

.. math:: J(\omega) = s\{K(\omega)\} + \sum_i \lfloor \omega l_i/(\pi c) \rfloor. \qquad \text{Eq. (M.5)}

No mode is missed and none counted twice, whatever its multiplicity. See W. H. Wittrick and F. W. Williams, "A
general algorithm for computing natural frequencies of elastic structures", Quarterly Journal of Mechanics and
Applied Mathematics 24(3), 263-284, 1971.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache, partial
from typing import Any

import numpy as np

from cabledrive.mechanics.chain import NO_PENDANT, Chain, split_at_antinodes
from cabledrive.mechanics.compiled import njit_strict
from cabledrive.mechanics.stiffness_matrix import dynamic_stiffness, free_joints
from cabledrive.modal import counting_kernels
from cabledrive.modal.mixed_counting import mixed_count
from cabledrive.modal.polish import LONG_CHAIN

CUT_SHARES = ((0.382, 0.146), (0.236, 0.71), (0.618, 0.31), (0.09, 0.854))
_CLEAR = 1e-13


def counter_of(chain: Chain) -> Callable[[float], int]:
    """What counts the modes of a chain below a frequency [rad/s]."""
    return ModeCounter(chain) if chain.uniform else partial(mixed_count, chain)


class ModeCounter:
    """Counts the modes of one uniform chain; make it once, call it with many frequencies.

    Parameters
    ----------
    chain : Chain
        The chain whose modes are counted.
    """

    def __init__(self, chain: Chain) -> None:
        self._chain, self._long = chain, chain.lengths.size > LONG_CHAIN
        self._kernel = _kernel("count_ring" if chain.closed else "count_line", self._long)
        self._cuts = _cut_rings(chain) if chain.closed else iter([(chain, chain.fixed)])
        self._arguments: list[tuple[Any, ...]] = []
        self._clear_cut = 0

    def __call__(self, omega: float) -> int:
        """Number of natural frequencies below omega, rigid-body mode included.

        ``omega``: angular frequency [rad/s].
        """
        if omega <= 0.0:
            return 0
        if self._chain.closed:
            return self._ring(float(omega))
        return int(self._kernel(float(omega), *self._cut(0)))

    def _ring(self, omega: float) -> int:
        """Cut the ring at two places; where round-off clouds the count, cut elsewhere, keep the clearest.

        The cut that was clear last comes first: neighbouring modes are alike.
        """
        best, clearest = self._kernel(omega, *self._cut(self._clear_cut))
        if clearest > _CLEAR:
            return int(best)
        for number in range(1 + len(CUT_SHARES)):
            count, margin = self._kernel(omega, *self._cut(number))
            if margin > clearest:
                best, clearest = count, margin
            if margin > _CLEAR:
                self._clear_cut = number
                break
        return int(best)

    def _cut(self, number: int) -> tuple[Any, ...]:
        while len(self._arguments) <= number:
            chain, ends = next(self._cuts)
            self._arguments.append(_arguments(chain, self._long, *ends))
        return self._arguments[number]


def _arguments(chain: Chain, long: bool, *ends: int) -> tuple[Any, ...]:
    """What the kernels take after omega: lists for Python, arrays for machine code."""
    pendant = chain.pendant or NO_PENDANT
    arrays = chain.travel_times, np.ascontiguousarray(chain.masses), chain.ground_springs
    times, masses, springs = arrays if long else (array.tolist() for array in arrays)
    hung = pendant.stiffness, pendant.mass, pendant.ground, pendant.joint
    return times, masses, springs, chain.impedance, *hung, *ends


def _cut_rings(chain: Chain) -> Iterator[tuple[Chain, tuple[int]]]:
    """The ring cut at joint 0 and half way; then inside two segments, at one pair of shares after another."""
    n = chain.masses.size
    yield chain, ((n + 1) // 2,)
    other = max(1, round(0.38 * n))
    for share, other_share in CUT_SHARES:
        pieces = ([(1 - share) * chain.lengths[0]], chain.lengths[1:other])
        cut = chain.lengths[other] * np.array([other_share, 1 - other_share])
        lengths = np.concatenate((*pieces, cut, chain.lengths[other + 1 :], [share * chain.lengths[0]]))
        masses, grounds = (
            np.insert(np.roll(each, -1), (0, other), 0.0) for each in (chain.masses, chain.ground_springs)
        )
        pendants = tuple(
            replace(own, joint=own.joint + int(own.joint > other) if own.joint else n + 1)
            for own in chain.pendants
        )
        cut_ring = replace(chain, lengths=lengths, masses=masses, pendants=pendants, grounds=grounds)
        yield cut_ring, (other + 1,)


@cache
def _compiled(name: str) -> Callable[..., Any]:
    kernel: Callable[..., Any] = njit_strict(getattr(counting_kernels, name))
    return kernel


def _kernel(name: str, long: bool) -> Callable[..., Any]:
    """Python for a short chain, machine code for a long one, where it pays for loading the compiler."""
    return _compiled(name) if long else getattr(counting_kernels, name)


def modes_below_reference(chain: Chain, omega: float) -> int:
    """Count by the formula itself, Eq. (M.5): eigenvalues of the assembled matrix; for short chains.

    ``omega``: angular frequency [rad/s].
    Returns number of natural frequencies below omega, rigid-body mode included.
    """
    split, _ = split_at_antinodes(chain, omega)
    joints = free_joints(split)
    matrix = dynamic_stiffness(split, omega).matrix()[np.ix_(joints, joints)]
    inside = np.floor(omega * split.travel_times / np.pi).sum()
    return int(np.sum(np.linalg.eigvalsh(matrix) < 0.0) + inside)
