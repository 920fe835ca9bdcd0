r"""Pairs near internal resonance of any machine: longitudinal modes and the transverse ones they can excite.

A longitudinal mode q of unit modal mass strains its spans by :math:`u_x`. It changes the tension that holds
transverse modes a and b of unit modal mass, and with amplitude Q at frequency W they grow where

.. math:: g_{ab} = \sum EA \int u_x\,\varphi_a'\,\varphi_b'\,\mathrm{d}x, \qquad
          \mu^2 > \delta_a\delta_b\Big[1 + \frac{(W - w_a - w_b)^2}{(\delta_a + \delta_b)^2}\Big], \qquad
          \mu = \frac{|g_{ab}| Q}{4\sqrt{w_a w_b}}, \qquad \text{Eq. (N.11)}

with the decay rates :math:`\delta = \Gamma/2`, as in Eq. (A.33); a = b is the 1:2 resonance. There the third
harmonic's share is added, as in (A.22). A torque of amplitude M at the motor's pulley, where the mode turns
by :math:`\theta`, gives :math:`Q = M\theta/(W c)` with modal damping c.
"""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import inf, pi, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from cabledrive.mechanics.network.assembly import Network, turns_by_torque
from cabledrive.modal import Mode
from cabledrive.modal.tuning import Pair
from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.route import RoutedDrive
from cabledrive.reduction.threshold import with_third_harmonic

ONE_TO_TWO, SUM = "1:2", "sum"

HIGHEST = 3.0
"""Longitudinal modes are looked at up to so many times the pulley mode's frequency."""

NEAR, NEAR_SUM = 0.1, 0.05
"""Largest detuning, over the longitudinal frequency, at which other pairs than those with a tuning are
listed."""

WEAKEST = 1e-2
"""Least coupling of two modes, over that of each with itself, at which a sum pair is listed."""

STILL = "the first motor does not turn in this longitudinal mode"
TOO_FAR = "no torque at the longitudinal frequency makes it grow: too far from resonance, or not stretched"
BOTH = "both"
_SAME = 1e-6
"""Relative difference up to which frequencies, and the pairs of both planes, are alike."""
_TURNING = 1e-9
"""Turn of the motor, over the largest in a longitudinal mode, from which its torque excites one."""


@dataclass(frozen=True, slots=True, kw_only=True)
class NearPair:
    """A longitudinal mode and the one or two transverse modes that it can excite parametrically."""

    kind: str  # {"1:2", "sum"}
    longitudinal_hz: float  # [Hz]
    family: str  # what mainly moves in the longitudinal mode
    span: str  # with most of the coupling; of a loop {"upper", "lower"}
    section: tuple[float, float]  # unstretched ends of what moves of it in the first transverse mode [m]
    plane: str  # {"v", "w", "both"}
    numbers: tuple[int, int]  # of the transverse modes, of those of a section; twice the same for 1:2
    transverse_hz: tuple[float, float]  # at rest [Hz]; twice the same for 1:2
    detuning_hz: float  # longitudinal frequency minus the sum of the transverse ones [Hz]
    coupling: float  # :math:`g_{ab}` [1/(m s^2 sqrt(kg))]
    # above which they grow: largest strain of the longitudinal mode [-], amplitude of the torque at the first
    # motor and the longitudinal frequency [N m]
    threshold_amplitude: float | None
    threshold_torque: float | None
    reason: str = ""  # why there is no torque
    tuning: Pair | None = None  # of 1:2 pairs of the pulley mode, where there is one pretension to choose

    @property
    def second_transverse_hz(self) -> float | None:
        """Of the sum type the other transverse mode [Hz]."""
        return self.transverse_hz[1] if self.kind == SUM else None

    @property
    def second_number(self) -> int | None:
        """Of the sum type that of the other transverse mode."""
        return self.numbers[1] if self.kind == SUM else None


def pairs_of(
    waves: "Waves", spans: Sequence[str], pulley_hz: float, tunings: Sequence[Pair] = ()
) -> tuple[NearPair, ...]:
    """Pairs near resonance by Eq. (N.11), lowest threshold first; where both planes have one alike, once.

    ``spans``: their names; ``pulley_hz``: the pulley mode, whose pairs with ``tunings`` are all listed.
    """
    found: dict[tuple[object, ...], NearPair] = {}
    for pair in _pairs(waves, spans, pulley_hz, tunings):
        key = pair.longitudinal_hz, pair.span, pair.section, pair.numbers
        other = found.setdefault(key, pair)
        first, last = ((*one.transverse_hz, one.coupling) for one in (pair, other))
        if other is not pair and np.allclose(first, last, rtol=_SAME, atol=0.0):
            found[key] = replace(other, plane=BOTH)
        elif other is not pair:
            found[*key, pair.plane] = pair
    return tuple(sorted(found.values(), key=_by_threshold))


def alike(first: float, second: float) -> bool:
    """Whether two frequencies are of one mode."""
    return abs(first / second - 1.0) < _SAME


def _by_threshold(pair: NearPair) -> tuple[float, float]:
    """The lowest threshold of a pair first, then the least detuning."""
    return inf if pair.threshold_torque is None else pair.threshold_torque, abs(pair.detuning_hz)


def _pairs(
    waves: "Waves", spans: Sequence[str], pulley_hz: float, tunings: Sequence[Pair]
) -> Iterator[NearPair]:
    """Every pair near resonance, plane by plane."""
    coupling, (damping, losses) = waves.couplings, waves.losses
    across, places = np.array([2 * pi * mode.frequency for mode in waves.across]), waves.places
    tuned = {
        i: own
        for i, (where, section, _, number) in enumerate(places)
        for own in tunings
        if (own.span, own.number) == (spans[where], number) and np.allclose(own.section, section)
    }
    listed = np.diag(np.array([i in tuned for i in range(across.size)], dtype=bool))
    turns = np.abs([turns_of(waves.network, mode)[0] for mode in waves.along])
    turns[turns <= _TURNING * turns.max(initial=0.0)] = 0.0
    for number, q in enumerate(waves.along):
        natural, turn = 2 * pi * q.frequency, float(turns[number])
        detunings, strength = natural - across[:, None] - across, np.abs(coupling[number])
        own = listed & alike(q.frequency, pulley_hz)
        # A stretch that the mode does not strain is listed as well, with the reason.
        strengths = np.maximum(strength, 1e-300 * own)
        for i, j in near_pairs(strengths, np.where(own, 0.0, np.abs(detunings) / natural)):
            amplitude = _threshold(natural, across[[i, j]], 0.5 * losses[[i, j]]) / float(strengths[i, j])
            grows, strain = bool(np.isfinite(amplitude)), np.abs(waves.slopes[0][number]).max()
            slopes = [waves.slopes[0][number], *waves.slopes[1][[i, j]]]
            count = 1 if waves.across[i].clamped or waves.across[j].clamped else waves.ropes
            shares = waves.rigidity * waves.length * (np.prod(slopes, axis=0) @ waves.weights) * count
            where = np.bincount([piece.span for piece in waves.network.pieces], shares)
            span = int(np.argmax(np.abs(where))) if where.any() else places[i][0]
            torque = amplitude * natural * float(damping[number]) / turn if turn and grows else None
            if turn and damping[number] == 0.0:  # it grows in time until they do
                torque = 0.0
            yield NearPair(
                kind=ONE_TO_TWO if i == j else SUM,
                longitudinal_hz=q.frequency,
                family=q.family,
                span=spans[span],
                section=places[i][1],
                plane=places[i][2],
                numbers=(places[i][3], places[j][3]),
                transverse_hz=(waves.across[i].frequency, waves.across[j].frequency),
                detuning_hz=float(detunings[i, j]) / (2 * pi),
                coupling=float(strength[i, j]),
                threshold_amplitude=float(amplitude * strain) if grows else None,
                threshold_torque=torque,
                reason="" if torque is not None else TOO_FAR if turn else STILL,
                tuning=tuned.get(i) if own[i, j] else None,
            )


def _threshold(natural: float, across: Array, loss: Array) -> float:
    """Amplitude times coupling above which two modes of decay rates ``loss`` grow, Eq. (A.33) [1/s^2]."""
    (a, b), turning = across.tolist(), float(across.prod())
    if a != b:
        least = lost_square(loss[0], loss[1], natural - a - b)
    else:  # as the averaged equations count it
        detuning, turning = 0.5 * natural - 2.0 * a**2 / natural, 0.25 * natural**2
        least = lost_square(loss[0], loss[1], detuning)
        least = with_third_harmonic(least, np.array(-0.5 * detuning), np.array(0.5 * natural))
    return 4.0 * sqrt(turning) * float(np.sqrt(least))


def lost_square(first: ArrayLike, second: ArrayLike, detuning: ArrayLike) -> Array:
    """Square of the growth rate that two modes with these decay rates lose [1/s^2]."""
    a, b, off = np.asarray(first), np.asarray(second), np.asarray(detuning)
    both = a + b
    damped = a * b * (1.0 + (off / np.where(both > 0.0, both, 1.0)) ** 2)
    return np.where(both > 0.0, damped, 0.25 * off**2)


def near_pairs(strength: Array, detuning: Array) -> list[list[int]]:
    """Transverse modes near resonance; both, shape (modes, modes): coupling, detuning over the frequency."""
    itself = np.sqrt(np.diag(strength))
    weakest = WEAKEST * np.outer(itself, itself)
    np.fill_diagonal(weakest, 0.0)
    near = np.where(np.eye(len(strength), dtype=bool), NEAR, NEAR_SUM)
    return np.argwhere(np.triu((detuning <= near) & (strength > weakest))).tolist()


WAYS = {"w": "across", "v": "out of plane"}
"""Direction of a transverse plane."""
_STILL = 1e-9
"""Share of the largest part of its energy up to which a mode leaves a piece at rest."""
POINTS = 16
"""Points at which a wave is looked at on each piece of a span, beyond those that its half waves need."""


class Waves(NamedTuple):
    """Longitudinal and transverse modes of unit modal mass, and their slopes at the points of all pieces."""

    network: Network
    along: list[Mode]
    across: list[Mode]
    # slopes: of along and across, shape (modes, pieces, points); weights: of the points
    slopes: tuple[Array, Array]
    weights: Array
    # of every piece: length [m], rigidity of one rope [N], number of ropes, shape (pieces,) each
    length: Array
    rigidity: Array
    ropes: Array
    moved: Array  # share of the kinetic energy of each mode across in each piece, shape (across, pieces)

    @property
    def places(self) -> list[tuple[int, tuple[float, float], str, int]]:
        """Of each mode across: span, unstretched ends of what moves of it [m], plane, number among these."""
        pieces, counted, found = self.network.pieces, Counter[tuple[object, ...]](), []
        spans = np.array([piece.span for piece in pieces])
        for mode, moved in zip(self.across, self.moved, strict=True):
            span = self.network.drive.spans.index(mode.span or "")
            moving = np.flatnonzero((spans == span) & (moved > _STILL * moved.max()))
            ends = pieces[moving[0]].rest.start, pieces[moving[-1]].rest.end
            place = span, ends, mode.plane or "w"
            counted[place] += 1
            found.append((*place, counted[place]))
        return found

    @property
    def couplings(self) -> Array:
        """Of two transverse modes by a longitudinal one, shape (along, across, across)."""
        along, across = self.slopes
        planes, clamped = (np.array([getattr(one, of) for one in self.across]) for of in ("plane", "clamped"))
        # Of ropes side by side a mode between held ends moves one; a mode with a body moves all alike.
        alone = np.logical_or.outer(clamped, clamped)
        found = np.zeros((len(along), len(across), len(across)))
        for number, one in enumerate(along):
            weight = (self.rigidity * self.length)[:, None] * self.weights * one
            single, every = (
                np.tensordot(across * weight * count, across, axes=((1, 2), (1, 2)))
                for count in (1.0, self.ropes[:, None])
            )
            found[number] = np.where(alone, single, every) * np.equal.outer(planes, planes)
        return found

    @property
    def losses(self) -> tuple[Array, Array]:
        """Damping rates of longitudinal and transverse modes by the file's viscous parts alone [1/s].

        Across, those of the ropes by their share of what moves: no carriage and no body is damped there.
        """
        network = self.network
        along, across = np.array(
            [(piece.rope.axial_damping, piece.rope.transverse_damping) for piece in network.pieces]
        ).T
        strained = self.slopes[0] ** 2 @ self.weights @ (self.ropes * self.length * along)
        moved = np.array([moved_in(network, mode) for mode in self.along])
        rubbed = (moved @ network.dampers.dense.T) ** 2 @ network.dampers.values
        return strained + rubbed, np.asarray(self.moved @ across)


def waves_of(network: Network, along: list[Mode], across: list[Mode]) -> Waves:
    """Modes of a network with their slopes at Gauss points of its pieces."""
    highest = max((mode.frequency for mode in across), default=0.0)
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

    def values(modes: list[Mode], ways: list[str]) -> Array:
        found = np.zeros((len(modes), *places.shape))
        for row, mode, way in zip(found, modes, ways, strict=True):
            for number, name in enumerate(network.drive.spans):
                own = mode.displacement(name, way, places[spans == number].ravel())[0].real
                row[spans == number] = own.reshape(-1, size)
        return found

    both = values(along, ["along"] * len(along)), values(across, [WAYS[one.plane or "w"] for one in across])
    slopes = [2.0 * own @ slope.T / length[:, None] for own in both]
    ropes, weights = network.ropes[::3].astype(np.float64), 0.5 * weights
    mass = ropes * [piece.rope.density * piece.rest.length for piece in network.pieces]
    moved = both[1] ** 2 @ weights * mass
    moved[[one.clamped for one in across]] /= ropes  # of ropes side by side one
    return Waves(network, along, across, (slopes[0], slopes[1]), weights, length, rigidity, ropes, moved)


def refuse_running(drive: RoutedDrive, what: str) -> None:
    """Refuse routes whose cable runs, for what is computed of cables at rest."""
    for route in drive.route:
        if route.speed:
            said = f'route "{route.name}" runs at {route.speed:.4g} m/s'
            raise InputRefused(f"{said}: {what} is for cables that do not; set speed to 0")


def moved_in(network: Network, mode: Mode) -> Array:
    """Motion of every coordinate in a mode of unit modal mass, shape (n,)."""
    joints = mode.joints
    return np.array(
        [float(np.real(joints[name][0])) if name in joints else 0.0 for name in network.motion.names]
    )


def turns_of(network: Network, mode: Mode) -> Array:
    """Turn of each motor in a mode of unit modal mass, shape (motors,) [rad/sqrt(kg)]; 0 below round-off."""
    moved = moved_in(network, mode)
    turns = turns_by_torque(network) @ moved
    return np.where(np.abs(turns) > 1e-9 * np.abs(moved).max(initial=0.0), turns, 0.0)
