r"""Ropes at rest: elastic catenaries between joints, found from few forces by Newton's method.

With the force :math:`\mathbf F(s)` along and across a span at the unstretched place s and the weight
:math:`\mathbf g` per metre, a rope of Hooke's law that runs with the unstretched speed v reaches

.. math:: \mathbf F' = -\rho_0\,\mathbf g, \qquad
          \mathbf r' = \frac{EA + |\mathbf F|}{EA - m}\,\frac{\mathbf F}{|\mathbf F|}, \qquad
          m = \rho_0 v^2. \qquad \text{Eq. (N.10)}

Its tension is :math:`|\mathbf F| + m\,|\mathbf r'|`; wheels and bodies feel F alone. Forces are linear in
that at the start of each section, along which it is passed on, and in the force across at the start of each
run between places that are held across. That the ends of a run lie where they should and the rope of a
section has the length that its pretension gave it are conditions of the least complementary energy; a balance
of bodies is a side condition, its multipliers their moves along the ropes. Steps halved until the slope of
the energy along them falls reach the one solution. A rope that forces turn leaves its wheel farther on, which
passes on their size: both follow the forces from step to step. So does rope that a span has too much of.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from math import hypot
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cabledrive.parameters.arrays import Array
from cabledrive.parameters.errors import NotComputed
from cabledrive.parameters.fields import described, meaning

MOST_STEPS = 200
SINGULAR = 1e-10
NEAR = 0.1
"""Change of the forces by a step below which ropes leave their wheels where they turn them."""
_SETTLED, _ROUND_OFF, _TINY = 1e-13, 4e-16, 1e-300
_PANELS = 4
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(16)
PLACES: Array = ((np.arange(_PANELS)[:, None] + (_NODES + 1.0) / 2.0) / _PANELS).ravel()
"""Places of the quadrature on a stretch of length 1, panel after panel."""
SHARES: Array = np.tile(_WEIGHTS, _PANELS) / (2.0 * _PANELS)
"""Their weights, 1 together."""


@described
@dataclass(frozen=True, slots=True, kw_only=True)
class RestingStretch:
    """One piece of cable between neighbouring joints, at rest."""

    span: str = meaning('name of its span: "upper" or "lower" of a loop')
    start: float = meaning("unstretched position from where the span starts [m]")
    end: float = meaning("the same of its end [m]")
    force: tuple[float, float] = meaning(
        "force at the start, along and across the span; across a loop is downwards [N]"
    )
    load: tuple[float, float] = meaning("weight per unstretched length, along and across [N/m]")
    axial_rigidity: float = meaning("EA [N]")
    flow: float = meaning("density times the square of the unstretched speed of a rope that runs [N]", 0.0)

    def force_at(self, positions: Array) -> Array:
        """Force along and across, by the part ahead on the part behind.

        Parameters
        ----------
        positions : ndarray, shape (p,)
            Unstretched positions [m].

        Returns
        -------
        ndarray, shape (2, p)
            [N].
        """
        below = np.asarray(positions, dtype=float) - self.start
        return np.array(self.force)[:, None] - np.outer(self.load, below)

    def tension_at(self, positions: Array) -> Array:
        """Tension of the cable; negative where a cable without load across would have to push.

        Parameters
        ----------
        positions : ndarray, shape (p,)
            Unstretched positions [m].

        Returns
        -------
        ndarray, shape (p,)
            [N].
        """
        along, across = self.force_at(positions)
        return np.asarray(self._tension(along if self.straight else np.hypot(along, across)))

    def _tension(self, force: Any) -> Any:
        """Of a rope that bears a force [N]: what turns one that runs is more."""
        return (force + self.flow) * (self.axial_rigidity / (self.axial_rigidity - self.flow))

    @property
    def length(self) -> float:
        """Unstretched length [m]."""
        return self.end - self.start

    @property
    def straight(self) -> bool:
        """Whether nothing acts across it: what hangs cannot push, a straight rope could by the balance."""
        return self.force[1] == 0.0 == self.load[1]

    @property
    def end_force(self) -> tuple[float, float]:
        """Force along and across at the end [N]."""
        return self.force[0] - self.load[0] * self.length, self.force[1] - self.load[1] * self.length

    @property
    def tensions(self) -> tuple[float, float]:
        """Tension at start and end [N]."""
        first, last = (own[0] if self.straight else hypot(*own) for own in (self.force, self.end_force))
        return self._tension(first), self._tension(last)

    @property
    def lowest_tension(self) -> float:
        """Lowest tension on the stretch [N]."""
        if self.straight:
            return min(self.tensions)
        load = np.array(self.load)
        weight = float(load @ load)
        turn = float(load @ np.array(self.force)) / weight if weight else 0.0
        return float(self.tension_at(self.start + np.clip([0.0, turn, self.length], 0.0, self.length)).min())

    @property
    def mean_tension(self) -> float:
        """Mean tension over the unstretched length [N]."""
        return float(self.tension_at(self.start + self.length * PLACES) @ SHARES)

    @property
    def pull(self) -> float:
        """Force along at the middle, of a straight rope the lowest tension: without it a rope pushes [N]."""
        if self.straight:
            return min(self.tensions)
        return self.force[0] - 0.5 * self.load[0] * self.length

    @property
    def gradient(self) -> float:
        """Mean rise of the tension per unstretched metre [N/m]."""
        first, last = self.tensions
        return (last - first) / self.length

    @property
    def travel_time(self) -> float:
        """Time that a transverse wave takes from end to end [s]; infinite where the stretch is slack."""
        tension = self.tension_at(self.start + self.length * PLACES)
        if tension.min() <= 0.0:
            return float("inf")
        return self.length * float(np.sqrt(1.0 / tension + 1.0 / self.axial_rigidity) @ SHARES)


def sag_parameter(stretches: Sequence[RestingStretch]) -> float:
    r"""Irvine's parameter of rope between held places, with any weights: 12 EA/T times the mean of sin^2.

    .. math:: \lambda^2 = \frac{12\,EA}{\bar T}\,\overline{\sin^2\theta}

    A level cable without weights has the usual :math:`(\rho_0 g l/T)^2\,EA/T`, T without its momentum.
    """
    square = tension = 0.0
    for stretch in stretches:
        along, across = stretch.force_at(stretch.start + stretch.length * PLACES)
        share = stretch.length / (stretches[-1].end - stretches[0].start)
        square += share * float(SHARES @ (across**2 / (along**2 + across**2)))
        tension += share * float(SHARES @ np.hypot(along, across))
    return 12.0 * stretches[0].axial_rigidity / tension * square if square else 0.0


@dataclass(frozen=True, eq=False, kw_only=True)
class Ropes:
    """Pieces of rope in order of their sections: p pieces, s sections, r runs.

    Sag moves the points where ropes leave their wheels; ``distance`` and ``cut`` are of straight ropes.
    """

    span: NDArray[np.intp]  # (p,)
    section: NDArray[np.intp]  # (p,)
    run: NDArray[np.intp]  # (p,)
    distance: Array  # (p,): between the joints [m]
    cut: Array  # (p,): unstretched; a guess where a rope is as long as it reaches [m]
    rigidity: Array  # (p,): EA [N]
    load: Array  # (p, 2): weight along and across per unstretched metre [N/m]
    jump: Array  # (p, 2): weight of the joint at the end, across where the rope bears it [N]
    ropes: Array  # (p,): parallel ones
    running: Array  # (p,): density times the square of the speed of a rope that runs, in the mean [N]
    flow: Array  # (p,): the same of its unstretched speed, the same all along [N]
    pretension: Array  # (p,): of the straight weightless machine; NaN: open, the balance makes it [N]
    standing: Array  # (s,): tension at a drum that keeps a torque, NaN: none [N]
    far: NDArray[np.bool_]  # (s,): whether that drum is at the end of its section
    rim: Array  # (p, 2): sense times radius of the wheel at each end, 0: none [m]
    wound: Array  # (p, 2): rope that left at the start, that came at the end, unstretched [m]
    bow: Array  # (p, 2): by what the ends are farther apart, along and across [m]
    over: Array  # (p, 2): tension where a straight rope leaves its wheels beyond the force along [N]

    @cached_property
    def hangs(self) -> NDArray[np.bool_]:
        """Whether a weight acts across each run, (r,)."""
        borne = np.abs(self.load[:, 1]) * self.length + np.abs(self.jump[:, 1])
        return np.asarray(np.bincount(self.run, borne) > 0.0)

    @cached_property
    def length(self) -> Array:
        """Unstretched length of each piece, (p,) [m]."""
        return np.asarray(self.cut + np.diff(self.wound)[:, 0])

    @cached_property
    def weight(self) -> Array:
        """Weight along and across of each piece, (p, 2) [N]."""
        return self.load * self.length[:, None]

    @cached_property
    def drop(self) -> Array:
        """By how much the force falls along each piece and at its end, (p, 2) [N]."""
        found = self.weight + self.jump
        passed = np.flatnonzero((np.diff(self.span) != 0) & (np.diff(self.section) == 0))
        found[passed, 0] += self.over[passed + 1, 0] - self.over[passed, 1]
        return found

    @cached_property
    def strained(self) -> Array:
        """By how much the pretension of the straight machine lengthens each piece, (p,) [m]."""
        return np.asarray(self.cut * np.nan_to_num(self.pretension) / self.rigidity)

    @cached_property
    def longer(self) -> Array:
        """By how much each piece reaches beyond its length, along and across, (p, 2) [m]."""
        return self.bow + np.column_stack((self.strained - np.diff(self.wound)[:, 0], 0.0 * self.cut))

    @cached_property
    def kept(self) -> Array:
        """Tension at the start of each section with a drum that keeps its torque, NaN: none, (s,) [N]."""
        marks = np.arange(self.standing.size)
        first, last = (np.searchsorted(self.section, marks, side) for side in ("left", "right"))
        fallen = np.bincount(self.section, self.drop[:, 0]) - self.over[last - 1, 1]
        return np.asarray(self.standing + np.where(self.far, fallen, -self.over[first, 0]))

    def sums(self, values: Array, group: NDArray[np.intp]) -> Array:
        """Sums of values of all parallel ropes over sections or runs."""
        return np.asarray(np.bincount(group, self.ropes * values), dtype=float)

    @cached_property
    def fallen(self) -> Array:
        """Force at the start of each piece less that of its section and its run, (p, 2) [N]."""
        found = np.empty_like(self.drop)
        for column, group in enumerate((self.section, self.run)):
            edges = [0, *(np.flatnonzero(np.diff(group)) + 1).tolist(), group.size]
            for first, last in pairwise(edges):
                own = self.drop[first:last, column]
                found[first:last, column] = own - own.cumsum()
        return found

    def forces(self, tension: Array, shear: Array) -> Array:
        """Force at the start of each piece, (p, 2), by those of the sections (s,) and runs (r,) [N]."""
        return self.fallen + np.column_stack((tension[self.section], shear[self.run]))

    def reach(self, force: Array) -> tuple[Array, Array]:
        """How far pieces reach beyond their lengths, (p, 2) [m]; what they give, (3, p): aa, ab, bb [m/N]."""
        places, weight = self.length[:, None] * PLACES, self.length[:, None] * SHARES
        along, across = (force[:, i, None] - self.load[:, i, None] * places for i in (0, 1))
        soft = 1.0 / (self.rigidity - self.flow)[:, None]
        runs = self.flow[:, None] * soft
        bar = ~self.hangs[self.run][:, None]  # may push, which is refused afterwards
        size = np.where(bar, 1.0, np.maximum(np.hypot(along, across), _TINY))
        cosine, sine = np.where(bar, 1.0, along / size), np.where(bar, 0.0, across / size)
        less = np.where(cosine > 0.0, -(sine**2) / (1.0 + np.abs(cosine)), cosine - 1.0)
        turning = np.where(bar, 0.0, (1.0 + runs) / size)
        excess = along * soft + runs * cosine + less, across * soft + (1.0 + runs) * sine
        give = soft + turning * sine**2, -turning * sine * cosine, soft + turning * cosine**2
        left, gives = (np.stack([(weight * own).sum(axis=1) for own in both]) for both in (excess, give))
        return left.T, gives

    def settled(self, tension: Array, shear: Array, share: float) -> "Ropes":
        """Ropes that leave their wheels as these forces turn them, and pass on what a span has too much.

        ``share``: of the way there that is gone.
        """
        force = self.forces(tension, shear)
        longer = (self.rigidity + np.hypot(*(force - 0.5 * self.weight).T)) / (self.rigidity - self.flow)
        excess = self.reach(force)[0]
        along, across = np.stack((force, force - self.weight), axis=-1).swapaxes(0, 1)
        turned = (self.rim != 0.0) & self.hangs[self.run][:, None]
        size = np.where(turned, np.hypot(along, across), 1.0)
        over = np.where(turned, np.where(along > 0.0, across**2 / (size + np.abs(along)), size - along), 0.0)
        moved = np.stack((across * turned, over), axis=-1) * (self.rim / size)[..., None]
        bow = moved[:, 1] - moved[:, 0]
        stretch = (self.rigidity[:, None] + size) / (self.rigidity - self.flow)[:, None]
        over += np.einsum("pc,pec->pe", self.load, moved) / stretch
        wound = self.rim * np.where(turned, np.arctan2(across, along), 0.0) / stretch
        starts = np.append(True, np.diff(self.span) != 0)
        first, last = np.flatnonzero(starts), np.flatnonzero(np.append(starts[1:], True))
        more = self.length - self.cut
        short = np.add.reduceat(self.strained + bow[:, 0] - more - excess[:, 0], first)
        missing = short / longer[first]
        missing += np.add.reduceat(more - np.diff(wound)[:, 0], first)
        group = self.section[first]
        for a, b in pairwise([*np.flatnonzero(np.diff(group, prepend=-1)).tolist(), group.size]):
            went = np.append(0.0, missing[a:b].cumsum())  # rope, by the ends of spans
            if np.isnan(self.standing[group[a]]):
                went[-1] = 0.0
            elif not self.far[group[a]]:
                went -= went[-1]
            wound[first[a:b], 0] += went[:-1]
            wound[last[a:b], 1] += went[1:]
        opened = np.isnan(self.pretension)
        wound[opened] = 0.0
        bow, over, wound = (
            before + share * (now - before)
            for before, now in ((self.bow, bow), (self.over, over), (self.wound, wound))
        )
        reached = np.add.reduceat(self.length + excess[:, 0], first)
        scale = np.add.reduceat(self.distance + bow[:, 0], first) / reached
        cut = np.where(opened, self.cut * np.repeat(scale, last - first + 1), self.cut)
        passes = self.sums(self.length, self.section) / self.sums(self.length * longer, self.section)
        flow = self.running * passes[self.section] ** 2
        return replace(self, cut=cut, wound=wound, bow=bow, over=over, flow=flow)


def solved(
    ropes: Ropes, along: Array, across: Array, rest: Callable[[Ropes], Array]
) -> tuple[Ropes, Array, Array]:
    """Tension of each section, (s,), and force across at the start of each run, (r,) [N]; `NotComputed`.

    ``along``, shape (n, s), and ``across``, (n, r): what they add to each of n balances, which must come to
    ``rest``, (n,); where none meets them the nearest is returned. The ropes have the lengths found.
    """
    count, of_run = along.shape[1], ropes.section[np.unique(ropes.run, return_index=True)[1]]
    held, hangs = ~np.isnan(ropes.standing), ropes.hangs
    opened = np.bincount(ropes.section, np.isnan(ropes.pretension)) > 0.0
    given = np.nan_to_num(ropes.pretension)
    soft = ropes.sums(ropes.length / ropes.rigidity, ropes.section)
    scale = np.abs(along).max(axis=1, initial=0.0)
    scale = np.where(scale > 0.0, scale, 1.0)[:, None]
    shear = np.where(hangs, 0.5 * np.bincount(ropes.run, ropes.drop[:, 1]), 0.0)
    tension = np.zeros(count)
    tension[ropes.section] = given
    if opened.any():  # of straight ropes in balance
        left = rest(ropes) - along @ tension - across @ shear
        tension += np.linalg.pinv(along / scale, rcond=SINGULAR) @ (left / scale[:, 0])
        least = np.bincount(ropes.section, np.abs(ropes.drop).sum(axis=1))
        tension = np.where(opened, np.maximum(tension, 1e-3 * least), tension)
    lags, before = bool(opened.any() or held.any() or ropes.flow.any() or ropes.drop.any()), np.inf
    share = 0.0  # of what moves the points where ropes leave their wheels that a step takes along

    def slopes(tension: Array, shear: Array, base: Array) -> tuple[Array, Array, Array]:
        """Slope of the energy by tensions and shears, and what the pieces give."""
        excess, give = ropes.reach(ropes.forces(tension, shear))
        excess -= ropes.longer
        by_tension = ropes.sums(excess[:, 0], ropes.section)
        by_tension = np.where(held, soft * (tension - np.nan_to_num(ropes.kept)), by_tension)
        by_tension = np.where(opened, soft * (tension - base), by_tension)
        by_shear = ropes.sums(excess[:, 1], ropes.run)  # of a slack rope round-off would move it far
        by_shear[~hangs | (np.abs(by_shear) <= _ROUND_OFF * ropes.sums(ropes.length, ropes.run))] = 0.0
        return by_tension, by_shear, give

    for number in range(MOST_STEPS):
        if lags:
            ropes = ropes.settled(tension, shear, share)
        by_tension, by_shear, give = slopes(tension, shear, tension)
        across_give = ropes.sums(give[2], ropes.run)
        follows = np.where(hangs, ropes.sums(give[1], ropes.run) / across_give, 0.0)
        shift = by_shear / across_give  # of the shear, that ends lie on the chord
        sagging = ~(opened | held)
        bend = np.where(sagging, ropes.sums(give[0], ropes.section), soft)
        curvature = bend - sagging * np.bincount(of_run, follows**2 * across_give, count)
        slope = by_tension - sagging * np.bincount(of_run, follows * by_shear, count)
        balance = along.copy()
        np.subtract.at(balance.T, of_run, (across * follows).T)
        even = np.sqrt(curvature.max(initial=0.0) / curvature)
        missing = rest(ropes) - along @ tension - across @ (shear - shift) + balance @ (slope / curvature)
        gain = balance / scale * even
        if not np.isfinite([*missing, *shift, *slope, *even, *gain.flat]).all():
            break
        pull = even * (np.linalg.pinv(gain, rcond=SINGULAR) @ (missing / scale[:, 0]))
        step = pull - slope / curvature
        turn = -shift - follows * step[of_run]
        first, part = (by_tension - curvature * pull) @ step + by_shear @ turn, 1.0
        size = np.abs(tension).max(initial=0.0) + np.abs(shear).max(initial=0.0) + _TINY
        change = max(np.abs(step).max(initial=0.0), np.abs(turn).max(initial=0.0)) / size
        while change > 1e-11 and part > 2.0**-30:
            there = slopes(tension + part * step, shear + part * turn, tension)
            if abs((there[0] - curvature * pull) @ step + there[1] @ turn) <= (1.0 - 0.1 * part) * abs(first):
                break
            part /= 2.0
        part = part if part > 2.0**-30 else 1.0  # round-off: the last digits do not fall any more
        tension, shear = tension + part * step, shear + part * turn
        if bool(share) == lags and (change <= _SETTLED or (change < 1e-10 and change >= 0.5 * before)):
            return ropes, tension, shear
        if lags and not share and change < NEAR:
            share, left = 1.0, rest(ropes) - along @ tension - across @ shear
            if np.any(np.abs(left) > NEAR * size * scale[:, 0]):  # refused by it
                return ropes, tension, shear
        elif share and number > MOST_STEPS // 4:  # it goes round the solution, or away from it
            share = 0.3
        before = change
    if np.any(tension[ropes.section] + ropes.fallen[:, 0] <= 0.0):  # refused by it
        return ropes, tension, shear
    raise NotComputed(f"no state of rest found in {number + 1} steps: raise the pretension")
