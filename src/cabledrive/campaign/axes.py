"""What is varied: each axis of a design with its keys, from a number between 0 and 1 to values in SI."""

from dataclasses import dataclass
from itertools import pairwise
from math import log
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array

EDGE = 1e-16
"""Shares are kept this far from 0 and 1 where a distribution has no ends."""


class Spread(Protocol):
    """Values of one key over the unit interval."""

    def at(self, share: Array) -> NDArray[Any]:
        """Values in SI. ``share``, shape (n,): between 0 and 1."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class Range:
    """Evenly between two values, or evenly in their logarithm."""

    low: float
    high: float
    logarithmic: bool = False

    def at(self, share: Array) -> NDArray[Any]:
        """Values at shares of the way, the ends exact."""
        if self.logarithmic:
            inside = np.exp((1.0 - share) * log(self.low) + share * log(self.high))
            return np.clip(inside, self.low, self.high)
        return np.asarray((1.0 - share) * self.low + share * self.high)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Values:
    """A list of values, each with the same share of the interval."""

    values: NDArray[Any]  # (n,): numbers in SI, words, or true and false

    def at(self, share: Array) -> NDArray[Any]:
        """The value in whose part of the interval a share lies."""
        place = np.minimum((share * self.values.size).astype(np.int64), self.values.size - 1)
        return np.asarray(self.values[place])


@dataclass(frozen=True, slots=True, kw_only=True)
class Normal:
    """A normal distribution, or one whose logarithm is normal."""

    mean: float  # of a logarithm: the median
    deviation: float  # of a logarithm: standard deviation of the natural logarithm
    logarithmic: bool = False

    def at(self, share: Array) -> NDArray[Any]:
        """Quantiles."""
        from scipy.special import ndtri

        turned = ndtri(np.clip(share, EDGE, 1.0 - EDGE))
        if self.logarithmic:
            return np.asarray(self.mean * np.exp(self.deviation * turned))
        return np.asarray(self.mean + self.deviation * turned)


@dataclass(frozen=True, slots=True, kw_only=True)
class Triangular:
    """A triangular distribution."""

    low: float
    mode: float
    high: float

    def at(self, share: Array) -> NDArray[Any]:
        """Quantiles."""
        width = self.high - self.low
        rising = (self.mode - self.low) / width
        up = self.low + np.sqrt(share * width * (self.mode - self.low))
        down = self.high - np.sqrt((1.0 - share) * width * (self.high - self.mode))
        return np.where(share < rising, up, down)


@dataclass(frozen=True, slots=True, kw_only=True)
class Multiple:
    """A key that follows another one."""

    of: Spread  # of the other key
    factor: float

    def at(self, share: Array) -> NDArray[Any]:
        """The other key's values times the factor."""
        return np.asarray(self.factor * self.of.at(share))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Axis:
    """One dimension of a design; linked keys and the columns of one table share it."""

    spreads: dict[str, Spread]  # by key
    units: dict[str, str]  # by key
    levels: int | None  # number of points on a grid; None: not stated

    @property
    def counted(self) -> bool:
        """Whether it has values one by one, and not a range."""
        return any(isinstance(spread, Values) for spread in self.spreads.values())

    def shares(self, count: int) -> Array:
        """Where the points of a grid lie: ends included on a range, the middle of each part elsewhere."""
        if all(isinstance(spread, (Range, Multiple)) for spread in self.spreads.values()) and count > 1:
            return np.arange(count) / (count - 1)
        return (np.arange(count) + 0.5) / count


def check_order(key: str, *values: float, unit: str) -> None:
    """Refuse values that do not ascend. ``unit``: in which they are."""
    for low, high in pairwise(values):
        if not low < high:
            raise InputRefused(f"{key}: {low:.9g} {unit} is not below {high:.9g} {unit}: give them ascending")
