r"""Following a branch of steady states through its folds: pseudo-arclength continuation.

From a point the next one is searched along the tangent and corrected on the plane across it,

.. math:: F(x, p) = 0, \qquad t\cdot(x - x_0,\ p - p_0) = s, \qquad \text{Eq. (A.29)}

which is regular at folds. Folds are where the tangent has no part along p, Hopf points where a pair of
eigenvalues crosses the imaginary axis; both are refined on the branch itself.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cabledrive.parameters.arrays import Array

Function = Callable[[Array, float], Array]

MOST_POINTS = 1500
_NEWTON_STEPS = 25
_CONVERGED = 1e-13
_SMALLEST = 1e-7


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SpecialPoint:
    """A fold or a Hopf point."""

    kind: str  # "fold" or "hopf"
    state: Array  # (n,)
    parameter: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Branch:
    """A branch of steady states."""

    states: Array  # (points, n)
    parameters: Array  # (points,)
    special: tuple[SpecialPoint, ...]
    ended: str  # why it ends: "limit", "points", "closed", or "cannot go on" with where

    @property
    def complete(self) -> bool:
        """Whether it was followed as far as asked."""
        return not self.ended.startswith("cannot")


def follow_branch(
    residual: Function,
    jacobian: Function,
    start: Array,
    *,
    limits: tuple[float, float],
    step: float,
    scale: Array,
) -> Branch:
    """Follow a branch of steady states from a point near it, Eq. (A.29).

    ``residual``, ``jacobian``: F(x, p), shape (n,), and its derivative by x, shape (n, n); ``start``, shape
    (n + 1,): near a steady state, the parameter last; ``limits``: of the parameter; ``step``: largest step,
    in scaled arclength, below 0 where the parameter falls at first; ``scale``, shape (n + 1,): typical sizes.
    Returns what was found, also where it cannot go on.
    """
    curve, upwards, step = _Curve(residual, jacobian, np.asarray(scale, dtype=float)), step > 0.0, abs(step)
    across = np.append(np.zeros(len(start) - 1), 1.0)
    point = curve.correct(start / curve.scale, across, 0.0)
    if point is None:
        none = np.zeros((0, len(start)))
        ended = f"cannot go on: no steady state near the start, parameter {start[-1]:.6g}"
        return Branch(states=none[:, :-1], parameters=none[:, -1], special=(), ended=ended)
    tangent = curve.tangent(point, None)
    tangent = tangent if (tangent[-1] > 0) == upwards else -tangent
    points, special, length, ended = [point], [], step, "points"
    while len(points) < MOST_POINTS:
        new = curve.correct(point, tangent, length)
        if new is None or (turned := curve.tangent(new, tangent)) @ tangent < 0.9:
            length *= 0.5
            if length < _SMALLEST * step:
                where = point[-1] * curve.scale[-1]
                ended = f"cannot go on: no step leads away from parameter {where:.6g}"
                break
            continue
        special += curve.special_points(point, tangent, length, new, turned)
        point, tangent, length = new, turned, min(1.3 * length, step)
        points.append(point)
        if not limits[0] <= point[-1] * curve.scale[-1] <= limits[1]:
            ended = "limit"
            break
        if len(points) > 10 and np.linalg.norm(point - points[0]) < 0.5 * length:
            ended = "closed"
            break
    scaled = np.array(points) * curve.scale
    return Branch(states=scaled[:, :-1], parameters=scaled[:, -1], special=tuple(special), ended=ended)


class _Curve:
    """The steady states as a curve in scaled state and parameter."""

    def __init__(self, residual: Function, jacobian: Function, scale: Array) -> None:
        self._residual, self._jacobian, self.scale = residual, jacobian, scale

    def _value(self, y: Array) -> Array:
        x = y * self.scale
        return self._residual(x[:-1], float(x[-1])) / self.scale[:-1]

    def _slope(self, y: Array) -> Array:
        """Derivative by state and parameter; the parameter's by a central difference."""
        x = y * self.scale
        by_state = self._jacobian(x[:-1], float(x[-1])) * self.scale[:-1] / self.scale[:-1, None]
        h = 1e-6 * max(1.0, abs(y[-1]))
        ahead, behind = y.copy(), y.copy()
        ahead[-1] += h
        behind[-1] -= h
        return np.column_stack((by_state, (self._value(ahead) - self._value(behind)) / (2 * h)))

    def eigenvalues(self, y: Array) -> NDArray[np.complex128]:
        x = y * self.scale
        return np.asarray(np.linalg.eigvals(self._jacobian(x[:-1], float(x[-1]))), dtype=complex)

    def correct(self, origin: Array, tangent: Array, length: float) -> Array | None:
        y = origin + length * tangent
        for _ in range(_NEWTON_STEPS):
            system = np.vstack((self._slope(y), tangent))
            gap = np.append(self._value(y), tangent @ (y - origin) - length)
            try:
                change = np.linalg.solve(system, gap)
            except np.linalg.LinAlgError:
                return None
            y = y - change
            if not np.all(np.isfinite(y)):
                return None
            if np.linalg.norm(change) < _CONVERGED * (1.0 + np.linalg.norm(y)):
                return y
        return None

    def tangent(self, y: Array, along: Array | None) -> Array:
        _, _, rows = np.linalg.svd(self._slope(y))
        direction = rows[-1]
        return -direction if along is not None and direction @ along < 0.0 else direction

    def special_points(
        self, point: Array, tangent: Array, length: float, new: Array, turned: Array
    ) -> list[SpecialPoint]:
        found = []
        if tangent[-1] * turned[-1] < 0.0:
            found.append(
                self._refined("fold", point, tangent, length, lambda y: self.tangent(y, tangent)[-1])
            )
        if self._pair(point) * self._pair(new) < 0.0:
            found.append(self._refined("hopf", point, tangent, length, self._pair))
        return [special for special in found if special is not None]

    def _pair(self, y: Array) -> float:
        """Real part of the complex pair nearest to the imaginary axis; 1 where there is none."""
        values = self.eigenvalues(y)
        pairs = values[np.abs(values.imag) > 1e-6 * np.max(np.abs(values))]
        return float(pairs.real[np.argmin(np.abs(pairs.real))]) if pairs.size else 1.0

    def _refined(
        self, kind: str, point: Array, tangent: Array, length: float, test: Callable[[Array], float]
    ) -> SpecialPoint | None:
        from scipy.optimize import brentq

        def value(s: float) -> float:
            y = self.correct(point, tangent, s)
            return test(point if y is None else y)

        if value(0.0) * value(length) > 0.0:
            return None
        y = self.correct(point, tangent, brentq(value, 0.0, length, xtol=1e-15, rtol=1e-14))
        if y is None or abs(test(y)) > 1e-3:
            return None
        x = y * self.scale
        return SpecialPoint(kind=kind, state=x[:-1], parameter=float(x[-1]))
