"""One mode by elimination from joint to joint: as Python on a short chain, in machine code on a long one."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from math import isfinite, nan
from typing import Any

import numpy as np

from cabledrive.mechanics.chain import NO_PENDANT, Array, Chain
from cabledrive.mechanics.compiled import njit_strict
from cabledrive.modal.polish_kernels import polish

LONG_CHAIN = 300
"""Segments from which machine code pays for loading the compiler."""


def polished(split: Chain, start: float, low: float, high: float) -> tuple[Array, Array] | None:
    """One mode, the only one between two frequencies; a ring begins again at its next joint where need be.

    ``split``: no segment near a pole between `low` and `high`; ``start``: where to begin [rad/s]; ``low``,
    ``high``: interval the mode must lie in [rad/s].
    Returns ``omega``, shape (1,): natural frequency [rad/s]; ``shape``, shape (joints, 1): displacements of
    the joints (the pendant's last), of unit modal mass. Or None, where elimination without exchange of rows
    would lose digits.
    """
    omega, shape = _by_elimination(split, start, low, high)
    if split.closed and not isfinite(omega):
        omega, turned = _by_elimination(_turned(split), start, low, high)
        shape = np.concatenate((turned[-1:], turned[:-1]))
    if not isfinite(omega):
        return None
    if split.pendant is not None:
        own = split.pendant.ground - omega**2 * split.pendant.mass
        shape = np.append(shape, shape[split.pendant.joint] / (1.0 + own / split.pendant.stiffness))
    return np.array([omega]), shape[:, None]


def _turned(ring: Chain) -> Chain:
    """The same ring, numbered from its next joint."""
    lengths, masses, grounds = (
        np.concatenate((array[1:], array[:1])) for array in (ring.lengths, ring.masses, ring.ground_springs)
    )
    pendants = tuple(replace(own, joint=(own.joint - 1) % ring.masses.size) for own in ring.pendants)
    return replace(ring, lengths=lengths, masses=masses, pendants=pendants, grounds=grounds)


def _by_elimination(split: Chain, start: float, low: float, high: float) -> tuple[float, Array]:
    """As Python on a short chain, in machine code on a long one; NaN where elimination loses the digits."""
    n = split.masses.size
    first = 1 if split.closed or split.fixed[0] else 0
    last = n - 2 if split.fixed[1] else n - 1
    shape = np.cos((1.0 + np.sqrt(2.0)) * np.arange(1, n + 1))
    held = split.pendant is not None and not split.closed and not first <= split.pendant.joint <= last
    if last < first or held:  # a pendant on a held joint vibrates by itself
        return nan, shape
    long = split.lengths.size > LONG_CHAIN
    arrays = split.travel_times, split.masses, split.ground_springs, shape
    times, masses, springs, x = arrays if long else (array.tolist() for array in arrays)
    work = tuple(np.empty((7, n))) if long else tuple([0.0] * n for _ in range(7))
    hung = split.pendant or NO_PENDANT
    pendant = hung.stiffness, hung.mass, hung.ground, hung.joint
    kernel = _compiled() if long else polish
    ends = split.closed, first, last
    chain = times, masses, springs, split.impedance, pendant
    omega = kernel(start, low, high, *chain, *ends, x, work)
    return omega, np.asarray(x)


@cache
def _compiled() -> Callable[..., Any]:
    return njit_strict(polish)
