r"""A piece of rope between two joints, about its rest, as the waves and ropes of a network of modes.

A rope of bending stiffness EI leaves a pulley of radius r where its curvature has grown to 1/r, and is
clamped there (`cabledrive.mechanics.network.pieces.lift_off`). A rim moves the rope along its own direction
where it leaves it, which sag turns from the chord.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from math import atan2, ceil, cos, inf, pi, sqrt
from typing import Any, NamedTuple

import numpy as np

from cabledrive.mechanics.network.pieces import Piece
from cabledrive.mechanics.network.rest_forces import RestingStretch, sag_parameter
from cabledrive.modal.elements import ACROSS, ALONG, OUT, Rope, Row, Wave
from cabledrive.modal.rows import Array

DIRECTIONS = (ALONG, ACROSS, OUT)
Rows = Sequence[Row]
EVEN = 5e-6
"""Change of the tension along a piece, relative, below which it is even."""

COUPLED = 1e-4
"""Largest relative shift of two modes along and across that meet, by sag above its edge."""

CURVED = 5e-3
"""Largest square of the ring frequency of a curved rope over that of its edge."""


class End(NamedTuple):
    """One end of a piece.

    ``straight``, ``moves``, ``itself``: rows along, across and out of plane of a straight rope, of one that
    sags, and of this along and across its own direction; ``turns``: slopes of a beam across and out of plane;
    ``lift``: rope beyond the tangent point that bending lifts off [m].
    """

    straight: Rows
    moves: Rows
    itself: Rows
    turns: Sequence[Row] = ((), ())
    lift: float = 0.0


def parts_of_piece(number: int, piece: Piece, near: End, far: End, edge: float) -> list[Wave | Rope]:
    """A piece in all its directions, by unstretched lengths.

    ``edge``: where sag moves no mode any more [rad/s], 0: nowhere any.
    """
    rest, ropes, density = piece.rest, piece.route.ropes, piece.rope.density
    bending, speed = piece.rope.bending_stiffness or 0.0, piece.speed
    length, rigidity = rest.length, rest.axial_rigidity
    first, last = (1.0 + tension / rigidity for tension in rest.tensions)
    before, after = near.lift / first, far.lift / last
    whole = before + length + after
    hold, direction = _force_of(rest, before)
    load = complex(*rest.load)
    vanishes = before + complex(*rest.force) / load if load else inf
    even, time = True, 0.0
    if rest.straight and rest.load[0] == 0.0:
        tension = rest.tensions[0]
        time = length * sqrt(density * (1.0 + tension / rigidity) / tension)
    else:
        held = hold(before + np.linspace(0.0, length, 9))
        even = bool(np.ptp(held) <= EVEN * held.min())
        time = sqrt(density) * rest.travel_time

    def string(moves: tuple[Rows, Rows], *ways: int) -> Rope:
        start, end = (
            (*(rows[i] for i in ways), *([at.turns[ways[-1] - 1]] if bending else ()))
            for at, rows in zip((near, far), moves, strict=True)
        )
        return Rope(
            start,
            end,
            length=whole,
            hold=hold,
            density=density,
            tags=tuple((number, DIRECTIONS[i]) for i in ways),
            bend=bending / (0.5 * (first + last)) ** 3,
            speed=speed,
            ropes=ropes,
            inside=(before / whole, (before + length) / whole),
            vanishes=vanishes,
        )

    def wave(moves: tuple[Rows, Rows], i: int, time: float) -> Wave:
        flow = speed * time / length  # over the speed of its waves, Eq. (N.3)
        taken, tag = time / (1.0 - flow**2), (number, DIRECTIONS[i])
        return Wave(moves[0][i], moves[1][i], density * length / time, taken, tag, flow * taken, ropes)

    def across(moves: tuple[Rows, Rows], i: int) -> Wave | Rope:
        return string(moves, i) if bending or not even else wave(moves, i, time)

    straight, own = (near.straight, far.straight), (near.itself, far.itself)
    along = wave(straight, 0, time_along := length * sqrt(density / rigidity))
    out, *taut = across(straight, 2), along, across(straight, 1)
    if not edge:
        return [out, *taut]
    turned = [atan2(*reversed(force)) for force in (rest.force, rest.end_force)]
    curved = replace(
        along,
        start=own[0][0],
        end=own[1][0],
        ring=abs(turned[1] - turned[0]) / time_along,
        cosine=(cos(turned[0]), cos(turned[1])),
    )
    hanging = replace(
        string((near.moves, far.moves), 0, 1),
        direction=direction,
        pull=rigidity - rest.flow,
        longer=whole / length,
        taut=tuple(taut),
        straight=(curved, across(own, 1)),
        edge=edge,
    )
    return [out, hanging]


def _force_of(rest: RestingStretch, before: float) -> tuple[Callable[[Array], Array], Callable[[Array], Any]]:
    """R [N], and cosine and sine of the direction, by the distance from where the rope starts.

    R is without the momentum of a rope that runs; ``before``: from there to the start of the stretch [m].
    """

    def hold(x: Array) -> Array:
        force = np.hypot(*rest.force_at(rest.start - before + np.ravel(x))).reshape(np.shape(x))
        return np.asarray(force * (rest.axial_rigidity - rest.flow) / (rest.axial_rigidity + force))

    def direction(x: Array) -> tuple[Array, Array]:
        along, across = rest.force_at(rest.start - before + np.ravel(x)).reshape(2, *np.shape(x))
        tension = np.hypot(along, across)
        return along / tension, across / tension

    return hold, direction


def straight_above(stretches: Sequence[RestingStretch], density: float) -> float:
    r"""Frequency above which sag moves no mode of a section by more than `COUPLED` [rad/s]; 0: none at all.

    The n-th wave across and a mode along that meet part by half of :math:`\sqrt 8\,\lambda/(n\pi)^2` of their
    frequency; else waves across move by half the square of this. Of the curvature, which raises modes along
    by half of :math:`(\omega_r/\omega)^2 = \lambda^2/(n\pi)^2`, what waves leave out is the square of this.
    Waves across a rope that runs, :math:`e^{i\omega\delta x/l}` times a sine, meet those along by up to
    :math:`1/(1 - v^2/c^2)` more.
    """
    if all(own.straight for own in stretches):
        return 0.0
    flow = stretches[0].flow / stretches[0].mean_tension
    irvine = sag_parameter(stretches) / (1.0 - flow) ** 2
    number = max(sqrt(sqrt(8.0 * irvine) / (2.0 * COUPLED)), sqrt(irvine / CURVED)) / pi
    if number < 1.0:
        return 0.0
    time = sqrt(density) * sum(own.travel_time for own in stretches)
    return (ceil(number) + 2 * len(stretches) - 1.5) * pi / time
