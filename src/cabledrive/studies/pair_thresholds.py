r"""Longitudinal modes and the transverse ones they excite: thresholds, slopes, losses.

With q of frequency W and amplitude Q, transverse modes a and b of one stretch grow where

.. math:: \mu^2 > \tfrac14\Gamma_a\Gamma_b\Big[1 + \frac{4\delta^2}{(\Gamma_a + \Gamma_b)^2}\Big], \qquad
          \mu = \frac{|G_{ab}| Q}{4\sqrt{m_a m_b w_a w_b}}, \quad \delta = W - w_a - w_b,
          \qquad \text{Eq. (A.33)}

and a = b is the 1:2 resonance. There the third harmonic's share is added, as in (A.22).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf, isfinite, pi, sqrt
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from cabledrive.mechanics.network.assembly import Network, turns_by_torque
from cabledrive.modal import Mode
from cabledrive.modal.tuning import Pair, resonant_pairs
from cabledrive.parameters import Drive, InputRefused
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.route import RoutedDrive
from cabledrive.reduction.sagging_model import longitudinal_modes, sagging_model
from cabledrive.reduction.static_state import FreeStretch, TransverseShapes, free_stretches, static_state
from cabledrive.reduction.stretches import StretchModel
from cabledrive.reduction.threshold import with_third_harmonic

ONE_TO_TWO, SUM = "1:2", "sum"

HIGHEST = 3.0
"""Longitudinal modes are looked at up to so many times the pulley mode's frequency."""

NEAR, NEAR_SUM = 0.1, 0.05
"""Largest detuning, over the longitudinal frequency, at which other pairs than the pulley mode's 1:2 are
listed."""

WEAKEST = 1e-2
"""Least coupling of two modes, over that of each with itself, at which a sum pair is listed."""

FEWEST, MOST, LISTED = 3, 40, 0.6
"""Transverse modes of a stretch; share of the pulley mode up to which all its 1:2 pairs are listed."""
_SEGMENTS, FINER = 240, 15
"""Segments of a span at least, and of each of its transverse modes: frequencies err by less than 1e-5."""
STILL = "the torque of the motor does not excite this longitudinal mode"
TOO_FAR = "no torque at the longitudinal frequency makes it grow: too far from resonance, or not stretched"


@dataclass(frozen=True, slots=True, kw_only=True)
class NearPair:
    """A longitudinal mode and the one or two transverse modes that it can excite parametrically."""

    kind: str  # {"1:2", "sum"}
    longitudinal_hz: float  # [Hz]
    span: str  # with most of the coupling; of a loop {"upper", "lower"}
    transverse_hz: tuple[float, float]  # at rest [Hz]; twice the same for 1:2
    detuning_hz: float  # longitudinal frequency minus the sum of the transverse ones [Hz]
    # amplitude of the torque at the (first) motor and the longitudinal frequency above which they grow [N m]
    threshold_torque: float | None
    reason: str = ""  # why there is none
    tuning: Pair | None = None  # of the 1:2 pairs of a loop's pulley mode

    @property
    def second_transverse_hz(self) -> float | None:
        """Of the sum type the other transverse mode [Hz]."""
        return self.transverse_hz[1] if self.kind == SUM else None


@dataclass(frozen=True, slots=True, kw_only=True)
class CoupledPair(NearPair):
    """One of a loop or a line."""

    section: tuple[float, float]  # unstretched ends of the free stretch [m]
    numbers: tuple[int, int]  # of the transverse modes; twice the same for 1:2

    @property
    def second_number(self) -> int | None:
        """Of the sum type that of the other transverse mode."""
        return self.numbers[1] if self.kind == SUM else None


def coupled_pairs(drive: Drive, pulley_mode: float) -> tuple[tuple[CoupledPair, ...], bool]:
    """1:2 pairs of the pulley mode [rad/s] and others near, Eq. (A.33), lowest threshold first.

    The others are of every longitudinal mode up to `HIGHEST` times the pulley mode. Returns also whether
    `MOST` transverse modes of each stretch are enough for them.
    """
    own, state = resonant_pairs(drive), static_state(drive, segments=_SEGMENTS)
    modes = longitudinal_modes(drive, state, HIGHEST * pulley_mode)
    top = max((w for w in modes.natural if w <= HIGHEST * pulley_mode), default=pulley_mode)
    reach = max(LISTED * pulley_mode, 0.5 * (1.0 + NEAR) * (1.0 + NEAR_SUM) * top)
    mass = state.mesh.carriage_mass

    def up_to(highest: float, part: FreeStretch) -> int:
        """Transverse modes of a stretch; each carriage adds one to those of a string."""
        more = 1 + int(np.count_nonzero(mass[part.segments.start + 1 : part.segments.stop]))
        return min(max(FEWEST, int(highest * part.travel_time / pi) + more), MOST)

    numbers = [range(1, up_to(reach, part) + 1) for part in free_stretches(drive, state)]
    if (finer := FINER * max(map(len, numbers))) > _SEGMENTS:
        state = static_state(drive, segments=finer)
        modes, mass = longitudinal_modes(drive, state, HIGHEST * pulley_mode), state.mesh.carriage_mass
    model, stretches = sagging_model(drive, state, modes, numbers)
    found = []
    for k, natural in enumerate(model.natural):
        if 0.0 < natural <= HIGHEST * pulley_mode:
            tuned = own if abs(natural / pulley_mode - 1.0) < 1e-9 else None
            for r, part in enumerate(stretches):  # the other plane has the same pairs
                found += _of_stretch(model, k, r, part, tuned, up_to(LISTED * pulley_mode, part))
    return tuple(sorted(found, key=by_threshold)), max(map(len, numbers)) < MOST


def by_threshold(pair: Any) -> tuple[float, float]:
    """The lowest threshold of a pair first, then the least detuning."""
    return inf if pair.threshold_torque is None else pair.threshold_torque, abs(pair.detuning_hz)


def _of_stretch(
    model: StretchModel, k: int, r: int, part: TransverseShapes, tuned: Sequence[Pair] | None, listed: int
) -> list[CoupledPair]:
    """Pairs of a longitudinal mode on a stretch; of the pulley mode, whose are ``tuned``, all first 1:2."""
    natural, found = float(model.natural[k]), []
    still = abs(model.torque_shape[k]) <= 1e-9 * np.max(np.abs(model.torque_shape))
    detunings, count = natural - np.add.outer(part.omega, part.omega), part.omega.size
    off = np.abs(detunings) / natural
    if tuned is not None:
        np.fill_diagonal(off[:listed, :listed], 0.0)
    # A stretch that the mode does not strain is listed as well, with the reason.
    strength = np.maximum(np.abs(model.coupling[k, r, :count, :count]), 1e-300 * np.eye(count))
    for a, b in near_pairs(strength, off):
        torque = inf if still else _threshold(model, k, r, a, b, float(detunings[a, b]))
        own = (
            pair
            for pair in (tuned if tuned and a == b else ())
            if (pair.span, pair.number) == (part.span, a + 1)
            and np.allclose(pair.section, part.ends, rtol=0.0, atol=1e-9 * part.ends[1])
        )
        found.append(
            CoupledPair(
                kind=ONE_TO_TWO if a == b else SUM,
                longitudinal_hz=natural / (2 * pi),
                span=part.span,
                section=part.ends,
                numbers=(a + 1, b + 1),
                transverse_hz=(float(part.omega[a]) / (2 * pi), float(part.omega[b]) / (2 * pi)),
                detuning_hz=float(detunings[a, b]) / (2 * pi),
                threshold_torque=torque if isfinite(torque) else None,
                reason="" if isfinite(torque) else STILL if still else TOO_FAR,
                tuning=next(own, None),
            )
        )
    return found


def _threshold(model: StretchModel, k: int, r: int, a: int, b: int, detuning: float) -> float:
    """Threshold torque of one pair [N m]; infinite where there is none."""
    loss_a, loss_b = float(model.loss[r, a]), float(model.loss[r, b])
    natural, resistance = float(model.natural[k]), float(model.natural[k] * model.damping[k, k])
    per_amplitude = abs(float(model.coupling[k, r, a, b])) / 4.0
    turning = 0.25 * natural**2 if a == b else float(model.transverse[r, a] * model.transverse[r, b])
    per_amplitude /= sqrt(float(model.mass[r, a] * model.mass[r, b]) * turning)
    if per_amplitude == 0.0:
        return inf
    if resistance == 0.0:
        return 0.0
    if a == b:  # as the averaged equations count it, (nu^2 - w^2) / nu
        detuning = 0.5 * natural - 2.0 * float(model.transverse[r, a]) ** 2 / natural
    least = lost_square(0.5 * loss_a, 0.5 * loss_b, detuning)
    if a == b:
        least = with_third_harmonic(least, np.array(-0.5 * detuning), np.array(0.5 * natural))
    return sqrt(least) / per_amplitude * resistance / abs(float(model.torque_shape[k]))


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
        rubbed = (moved @ network.dampers.rows.T) ** 2 @ network.dampers.values
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
    names = [network.drive.free_spans[piece.span].name for piece in network.pieces]

    def values(modes: list[Mode], ways: list[str]) -> Array:
        found = np.zeros((len(modes), len(names), size))
        for row, mode, way in zip(found, modes, ways, strict=True):
            for number, (name, piece) in enumerate(zip(names, network.pieces, strict=True)):
                place = piece.start + 0.5 * (x + 1.0) * piece.length
                row[number] = mode.displacement(name, way, place)[0].real
        return found

    both = values(along, ["along"] * len(along)), values(across, [WAYS[one.plane or "w"] for one in across])
    length, rigidity = np.array([(one.length, one.rope.axial_rigidity) for one in network.pieces]).T
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
