r"""Modes of a network as waves: slopes at the points of all pieces, couplings, losses.

With slopes of unit modal mass a longitudinal mode q couples transverse modes a and b by

.. math:: g_{qab} = \sum EA \int u_q'\,\varphi_a'\,\varphi_b'\,\mathrm{d}x .

About a rope that hangs a mode stretches it by :math:`\varepsilon = c u' + s w'` and turns it by
:math:`\nu = c w' - s u'` in its plane and by :math:`v'` out of it; (c, s) is its direction at rest. The third
order of the elastic energy is :math:`\tfrac12 EA\int\varepsilon(\nu^2 + v'^2)\,\mathrm{d}x`: g is the sum of
three such integrals, in each of which one of the modes stretches the rope and both others turn it.
"""

from collections import Counter
from dataclasses import dataclass, replace
from functools import cached_property
from math import pi

import numpy as np

from cabledrive.mechanics.network.assembly import Network, turns_by_torque
from cabledrive.modal import Mode
from cabledrive.parameters.arrays import Array

WAYS = {"w": "across", "v": "out of plane"}
"""Direction of a transverse plane."""
_STILL = 1e-9
"""Share of the largest part of its energy up to which a mode leaves a piece at rest."""
POINTS = 16
"""Points at which a wave is looked at on each piece of a span, beyond those that its half waves need."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Waves:
    """Longitudinal and transverse modes of unit modal mass, and their slopes at the points of all pieces."""

    network: Network
    along: list[Mode]
    across: list[Mode]
    # slopes: of along and across, shape (modes, pieces, points); weights: of the points
    slopes: tuple[Array, Array]
    weights: Array
    inside: Array  # share of each point on the way along its piece, shape (points,)
    # of every piece: length [m], rigidity of one rope [N], number of ropes, shape (pieces,) each
    length: Array
    rigidity: Array
    ropes: Array
    moved: Array  # share of the kinetic energy of each mode across in each piece, shape (across, pieces)
    shapes: Array  # displacement of each mode across, shape (across, pieces, points)
    # motion of every coordinate in the modes along and across, shape (modes, n)
    coordinates: tuple[Array, Array]
    # About ropes that hang: turns of those along in and out of the plane, (along, 2, pieces, points), and
    # stretch of those across, (across, pieces, points); damping that follows from both [1/s]
    beside: tuple[Array, Array] | None = None
    more: tuple[Array | float, Array | float] = (0.0, 0.0)
    measure: Array | float = 1.0  # square of the length per stretched length at the points, (pieces, points)

    @property
    def places(self) -> list[tuple[int, tuple[float, float], str, int]]:
        """Of each mode across: span, unstretched ends of what moves of it [m], plane, number among these."""
        pieces, counted, found = self.network.pieces, Counter[tuple[object, ...]](), []
        spans = np.array([piece.span for piece in pieces])
        for mode, moved in zip(self.across, self.moved, strict=True):
            span = self.network.drive.spans.index(mode.span or "")
            moving = np.flatnonzero((spans == span) & (moved > _STILL * moved.max()))
            ends = pieces[moving[0]].unstretched[0], pieces[moving[-1]].unstretched[1]
            place = span, ends, mode.plane or "w"
            counted[place] += 1
            found.append((*place, counted[place]))
        return found

    @property
    def turns(self) -> Array:
        """Turn of each motor in the longitudinal modes, shape (along, motors) [rad/sqrt(kg)]."""
        return self.coordinates[0] @ turns_by_torque(self.network).T

    def forced(self, number: int) -> Array:
        """Motion of the modes along per torque of the first motor at the frequency of one, (along,)."""
        along = 2.0 * pi * np.array([mode.frequency for mode in self.along])
        stiffness = along**2 - along[number] ** 2
        found = np.linalg.solve(np.diag(stiffness) + 1j * along[number] * self.damping, self.turns[:, 0])
        return np.asarray(found)

    @cached_property
    def slack_torques(self) -> Array:
        """Torque of the first motor at each longitudinal frequency that slackens a rope, (along,) [N m]."""
        forces = [
            own.rest.tension_at(own.rest.start + self.inside * own.rest.length) for own in self.network.pieces
        ]
        stiffness = (self.network.impedance / self.network.time)[::3] * self.length  # EA + T
        share = stiffness[:, None] * self.slopes[0] / np.maximum(np.array(forces), 1e-300)
        swings = [
            np.abs(np.tensordot(self.forced(k), share, axes=1)).max() if lost > 0.0 else np.inf
            for k, lost in enumerate(self.losses[0])
        ]
        return 1.0 / np.maximum(swings, 1e-300)

    @cached_property
    def couplings(self) -> Array:
        """Of two transverse modes by a longitudinal one, shape (along, across, across)."""
        force = (self.rigidity * self.length)[:, None] * self.weights * self.measure
        found = self.products(force * self.slopes[0])
        if self.beside is not None:
            planes = np.array([int(one.plane == "v") for one in self.across], dtype=int)
            for own, turned in zip(found, self.beside[0], strict=True):
                once = self._summed(self.beside[1] * force, self.slopes[1] * turned[planes])
                own += once + once.T
        return found

    def products(self, weights: Array) -> Array:
        """Products of slopes of two modes across in one plane, summed with weights (n, pieces, points)."""
        across, planes = self.slopes[1], np.array([one.plane for one in self.across])
        found = [self._summed(across * own, across) * np.equal.outer(planes, planes) for own in weights]
        return np.array(found).reshape(len(weights), len(across), len(across))

    def _summed(self, first: Array, second: Array) -> Array:
        """Products of values of modes across, (across, pieces, points), summed over all ropes."""
        clamped = np.array([one.clamped for one in self.across], dtype=bool)
        # Of ropes side by side a mode between held ends moves one; a mode with a body moves all alike.
        single, every = (
            np.tensordot(first * count, second, axes=((1, 2), (1, 2))) for count in (1.0, self.ropes[:, None])
        )
        return np.where(np.logical_or.outer(clamped, clamped), single, every)

    def turned(self, along: Array, across: Array) -> "Waves":
        """These modes along and across, turned round where a sign is -1."""
        one, other = along[:, None], across[:, None]
        return replace(
            self,
            slopes=(one[:, :, None] * self.slopes[0], other[:, :, None] * self.slopes[1]),
            shapes=other[:, :, None] * self.shapes,
            coordinates=(one * self.coordinates[0], other * self.coordinates[1]),
        )

    @cached_property
    def damping(self) -> Array:
        """Of the modes along, by the file's viscous parts, which tie near ones, (along, along) [1/s]."""
        network = self.network
        axial = np.array([piece.rope.axial_damping for piece in network.pieces])
        force = (self.ropes * self.length * axial)[:, None] * self.weights
        strained = np.tensordot(self.slopes[0] * force, self.slopes[0], axes=((1, 2), (1, 2)))
        rubbed = self.coordinates[0] @ network.dampers.dense.T
        return np.asarray(strained + (rubbed * network.dampers.values) @ rubbed.T + self.more[0])

    @cached_property
    def losses(self) -> tuple[Array, Array]:
        """Damping rates of longitudinal and transverse modes by the file's viscous parts alone [1/s].

        Across, those of the ropes by their share of what moves: no carriage and no body is damped there.
        """
        across = np.array([piece.rope.transverse_damping for piece in self.network.pieces])
        return np.diag(self.damping), np.asarray(self.moved @ across) + self.more[1]


def waves_of(network: Network, along: list[Mode], across: list[Mode], *, hanging: bool = False) -> Waves:
    """Modes of a network with their slopes at Gauss points of its pieces; ``hanging``: about its sag."""
    highest = max((mode.frequency for mode in ([*along, *across] if hanging else across)), default=0.0)
    # as many as a polynomial through its half waves on the longest piece; a product of three needs no more
    size = POINTS + int(pi * highest * float(network.time.max()))
    x, weights = np.polynomial.legendre.leggauss(size)
    gaps = x[:, None] - x + np.eye(size)
    scale = np.array([np.prod(row) for row in 2.0 * gaps])
    slope = scale[:, None] / scale / gaps  # differentiates at the points
    np.fill_diagonal(slope, 0.0)
    np.fill_diagonal(slope, -slope.sum(axis=1))
    spans = np.array([piece.span for piece in network.pieces])
    middle = np.array([0.5 * (piece.start + piece.end) for piece in network.pieces])
    length, rigidity = np.array([(one.length, one.rope.axial_rigidity) for one in network.pieces]).T
    places = middle[:, None] + 0.5 * length[:, None] * x

    def values(modes: list[Mode], ways: list[str]) -> tuple[Array, Array]:
        """Displacements and their slopes, (modes, pieces, points)."""
        found = np.zeros((len(modes), *places.shape))
        for row, mode, way in zip(found, modes, ways, strict=True):
            for number, name in enumerate(network.drive.spans):
                own = mode.displacement(name, way, places[spans == number].ravel())[0].real
                row[spans == number] = own.reshape(-1, size)
        return found, 2.0 * found @ slope.T / length[:, None]

    own_ways = [WAYS[one.plane or "w"] for one in across]
    (_, first), (shown, second) = values(along, ["along"] * len(along)), values(across, own_ways)
    ropes, weights = network.ropes[::3].astype(np.float64), 0.5 * weights
    mass = ropes * [piece.rope.density * piece.rest.length for piece in network.pieces]
    moved = shown**2 @ weights * mass
    alone = [one.clamped for one in across]
    moved[alone] /= ropes  # of ropes side by side one
    names = network.motion.names
    coordinates = tuple(
        np.array(
            [[np.real(mode.joints.get(name, (0.0,))[0]) for name in names] for mode in modes], float
        ).reshape(len(modes), len(names))
        for modes in (along, across)
    )
    beside, measure = None, 1.0
    more: tuple[Array | float, Array | float] = (0.0, 0.0)
    if hanging:
        rests, inside = [piece.rest for piece in network.pieces], 0.5 * (x + 1.0)
        forces = np.array([own.force_at(own.start + inside * own.length) for own in rests])
        pull = np.hypot(forces[:, 0], forces[:, 1])
        cosine, sine = forces[:, 0] / pull, forces[:, 1] / pull
        unstretched = np.array([own.length for own in rests])
        measure = ((length / unstretched)[:, None] / (1.0 + pull / rigidity[:, None])) ** 2
        out = np.array([one.plane == "v" for one in across], dtype=bool)[:, None, None]
        beyond, w = values(along, ["across"] * len(along))
        u = values(across, ["along"] * len(across))[1]
        turned = np.stack([cosine * w - sine * first, 0.0 * w], axis=1)
        first, stretched = cosine * first + sine * w, np.where(out, 0.0, cosine * u + sine * second)
        second, beside = np.where(out, second, cosine * second - sine * u), (turned, stretched)
        axial, lateral = np.array(
            [(own.rope.axial_damping, own.rope.transverse_damping) for own in network.pieces]
        ).T
        lost = stretched**2 @ weights * (ropes * length * axial)
        lost[alone] /= ropes
        rubbed = (coordinates[1] @ network.dampers.dense.T) ** 2 @ network.dampers.values
        dragged = beyond * ((mass * lateral)[:, None] * weights)
        more = np.tensordot(dragged, beyond, axes=((1, 2), (1, 2))), lost.sum(axis=1) + rubbed
    return Waves(
        network=network,
        along=along,
        across=across,
        slopes=(first, second),
        beside=beside,
        more=more,
        measure=measure,
        weights=weights,
        inside=0.5 * (x + 1.0),
        length=length,
        rigidity=rigidity,
        ropes=ropes,
        moved=moved,
        shapes=shown,
        coordinates=(coordinates[0], coordinates[1]),
    )
