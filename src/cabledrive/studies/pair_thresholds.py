r"""Longitudinal modes and the transverse ones they excite: thresholds, slopes, losses.

With q of frequency W and amplitude Q, transverse modes a and b of one stretch grow where

.. math:: \mu^2 > \tfrac14\Gamma_a\Gamma_b\Big[1 + \frac{4\delta^2}{(\Gamma_a + \Gamma_b)^2}\Big], \qquad
          \mu = \frac{|G_{ab}| Q}{4\sqrt{m_a m_b w_a w_b}}, \quad \delta = W - w_a - w_b,
          \qquad \text{Eq. (A.33)}

and a = b is the 1:2 resonance. There the third harmonic's share is added, as in (A.22).
"""

from dataclasses import dataclass
from math import inf, isfinite, pi, sqrt
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from cabledrive.mechanics.network.assembly import Network
from cabledrive.modal import Mode
from cabledrive.parameters import Drive, InputRefused
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.route import RoutedDrive
from cabledrive.reduction.sagging_model import BAND, SaggingModel, longitudinal_modes, sagging_model
from cabledrive.reduction.static_state import free_stretches, static_state

ONE_TO_TWO, SUM = "1:2", "sum"

HIGHEST = 3.0
"""Longitudinal modes are looked at up to so many times the pulley mode's frequency."""

NEAR, NEAR_SUM = 0.1, 0.05
"""Largest detuning, over the longitudinal frequency, at which other pairs than the pulley mode's 1:2 are
listed."""

WEAKEST = 1e-2
"""Least coupling of two modes, over that of each with itself, at which a sum pair is listed."""

FEWEST, MOST = 3, 40
_SEGMENTS = 240
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


@dataclass(frozen=True, slots=True, kw_only=True)
class CoupledPair(NearPair):
    """One of a loop or a line."""

    section: tuple[float, float]  # unstretched ends of the free stretch [m]
    numbers: tuple[int, int]  # of the transverse modes; twice the same for 1:2


def coupled_pairs(drive: Drive, pulley_mode: float) -> tuple[CoupledPair, ...]:
    """1:2 pairs of the pulley mode [rad/s] and others near, Eq. (A.33), lowest threshold first."""
    state = static_state(drive, segments=_SEGMENTS)
    modes = longitudinal_modes(drive, state, HIGHEST * pulley_mode)
    numbers = [
        range(1, min(max(FEWEST, int(0.6 * pulley_mode * part.travel_time / pi) + 1), MOST) + 1)
        for part in free_stretches(drive, state)
    ]
    model = sagging_model(drive, state, modes, numbers)
    found = []
    for k, natural in enumerate(model.natural):
        if 0.0 < natural <= HIGHEST * pulley_mode:
            own = abs(natural / pulley_mode - 1.0) < 1e-9
            for r in range(len(numbers)):  # the other plane has the same pairs
                found += _of_stretch(model, k, r, all_of_them=own)
    return tuple(sorted(found, key=by_threshold))


def by_threshold(pair: Any) -> tuple[float, float]:
    """The lowest threshold of a pair first, then the least detuning."""
    return inf if pair.threshold_torque is None else pair.threshold_torque, abs(pair.detuning_hz)


def _of_stretch(model: SaggingModel, k: int, r: int, *, all_of_them: bool) -> list[CoupledPair]:
    part, natural, found = model.stretches[r], float(model.natural[k]), []
    still = abs(model.torque_shape[k]) <= 1e-9 * np.max(np.abs(model.torque_shape))
    for a in range(part.omega.size):
        for b in range(a, min(a + BAND + 1, part.omega.size)):
            detuning = natural - float(part.omega[a] + part.omega[b])
            near = abs(detuning) < (NEAR if a == b else NEAR_SUM) * natural
            if not (near or (a == b and all_of_them)):
                continue
            itself = sqrt(abs(model.coupling[k, r, a, a] * model.coupling[k, r, b, b]))
            if a != b and abs(model.coupling[k, r, a, b]) <= WEAKEST * itself:
                continue
            torque = inf if still else _threshold(model, k, r, a, b, detuning)
            found.append(
                CoupledPair(
                    kind=ONE_TO_TWO if a == b else SUM,
                    longitudinal_hz=natural / (2 * pi),
                    span=part.span,
                    section=part.ends,
                    numbers=(a + 1, b + 1),
                    transverse_hz=(float(part.omega[a]) / (2 * pi), float(part.omega[b]) / (2 * pi)),
                    detuning_hz=detuning / (2 * pi),
                    threshold_torque=torque if isfinite(torque) else None,
                    reason="" if isfinite(torque) else STILL if still else TOO_FAR,
                )
            )
    return found


def _threshold(model: SaggingModel, k: int, r: int, a: int, b: int, detuning: float) -> float:
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
    least = float(lost_square(0.5 * loss_a, 0.5 * loss_b, detuning))
    if a == b:  # third harmonic: mu^2 = least with the detuning shifted by mu^2 / W
        shift = 1.0 + 0.5 * detuning / natural
        inside = shift**2 - least / natural**2
        if inside < 0.0 or shift <= 0.0:
            return inf
        least = 2.0 * least / (shift + sqrt(inside))
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
POINTS = 48
"""Points at which a wave is looked at on each piece of a span: enough for 20 half waves."""


class Waves(NamedTuple):
    """Longitudinal and transverse modes of unit modal mass, and their slopes at the points of all pieces."""

    network: Network
    along: list[Mode]
    across: list[Mode]
    # slopes: of along and across, shape (modes, pieces, POINTS); weights: of the points
    slopes: tuple[Array, Array]
    weights: Array


def waves_of(network: Network, along: list[Mode], across: list[Mode]) -> Waves:
    """Modes of a network with their slopes at Gauss points of its pieces."""
    x, weights = np.polynomial.legendre.leggauss(POINTS)
    gaps = x[:, None] - x + np.eye(POINTS)
    scale = np.array([np.prod(row) for row in 2.0 * gaps])
    slope = scale[:, None] / scale / gaps  # differentiates at the points
    np.fill_diagonal(slope, 0.0)
    np.fill_diagonal(slope, -slope.sum(axis=1))
    names = [network.drive.free_spans[piece.span].name for piece in network.pieces]

    def slopes(modes: list[Mode], ways: list[str]) -> Array:
        found = np.zeros((len(modes), len(names), POINTS))
        for row, mode, way in zip(found, modes, ways, strict=True):
            for number, (name, piece) in enumerate(zip(names, network.pieces, strict=True)):
                place = piece.start + 0.5 * (x + 1.0) * piece.length
                values = mode.displacement(name, way, place)[0].real
                row[number] = 2.0 * slope @ values / piece.length
        return found

    both = slopes(along, ["along"] * len(along)), slopes(across, [WAYS[one.plane or "w"] for one in across])
    return Waves(network, along, across, both, 0.5 * weights)


def of_pieces(network: Network) -> tuple[Array, Array, Array]:
    """Length [m], rigidity of one rope [N] and number of ropes of every piece, shape (pieces,) each."""
    both = np.array([(piece.length, piece.rope.axial_rigidity) for piece in network.pieces])
    return both[:, 0], both[:, 1], network.ropes[::3].astype(np.float64)


def couplings(waves: Waves) -> Array:
    """Coupling of two transverse modes by a longitudinal one, by piece, shape (along, across, across)."""
    length, rigidity, ropes = of_pieces(waves.network)
    along, across = waves.slopes
    planes, clamped = (np.array([getattr(one, of) for one in waves.across]) for of in ("plane", "clamped"))
    # Of ropes side by side a mode between held ends moves one; a mode with a body moves all alike.
    alone = np.logical_or.outer(clamped, clamped)
    found = np.zeros((len(along), len(across), len(across)))
    for number, one in enumerate(along):
        weight = (rigidity * length)[:, None] * waves.weights * one
        single, every = (
            np.tensordot(across * weight * count, across, axes=((1, 2), (1, 2)))
            for count in (1.0, ropes[:, None])
        )
        found[number] = np.where(alone, single, every) * np.equal.outer(planes, planes)
    return found


def transverse_losses(waves: Waves) -> Array:
    """Damping rates of the transverse modes [1/s]: those of the ropes that move, by their strain energy."""
    length, rates = of_pieces(waves.network)[0], [one.rope.transverse_damping for one in waves.network.pieces]
    shares = np.sum(waves.slopes[1] ** 2, axis=2) * length
    return np.asarray(shares @ rates / shares.sum(axis=1))


def refuse_running(drive: RoutedDrive, what: str) -> None:
    """Refuse routes whose cable runs, for what is computed of cables at rest."""
    for route in drive.route:
        if route.speed:
            raise InputRefused(
                f'route "{route.name}" runs at {route.speed:.4g} m/s: {what} is for cables that do not; set '
                "speed to 0"
            )


def turns_of(network: Network, mode: Mode) -> Array:
    """Turn of each motor in a mode of unit modal mass, shape (motors,) [rad/sqrt(kg)]; 0 below round-off."""
    joints, driven = mode.joints, network.drive.turned
    if not joints:
        return np.zeros(len(driven))
    largest, found = max(float(np.abs(value[0])) for value in joints.values()), []
    for number in driven:
        name = network.drive.pulley[number].name
        value = joints.get(f"rotor of {name}", joints.get(name))
        turn = 0.0 if value is None else float(np.real(value[0]))
        found.append(turn if abs(turn) > 1e-9 * largest else 0.0)
    return np.array(found)


def longitudinal_losses(waves: Waves) -> Array:
    """Damping of the longitudinal modes [1/s]: viscous parts of the file alone."""
    drive, (length, _, ropes) = waves.network.drive, of_pieces(waves.network)
    damping = ropes * length * [piece.rope.axial_damping for piece in waves.network.pieces]
    strained = waves.slopes[0] ** 2 @ waves.weights @ damping
    return strained + [_rubbed(drive, mode.joints) for mode in waves.along]


def _rubbed(drive: RoutedDrive, joints: Any) -> float:
    """Damping of a mode by bearings, motors, their joints and bodies [1/s]."""

    def moved(name: str) -> float:
        return float(np.abs(joints[name][0])) if name in joints else 0.0

    total = sum(pulley.viscous_friction * moved(pulley.name) ** 2 for pulley in drive.pulley)
    for motor, own in zip(drive.motor, drive.driven, strict=True):
        name = drive.pulley[own].name
        rotor = f"rotor of {name}"
        total += motor.viscous_friction * moved(rotor if rotor in joints else name) ** 2
        if rotor in joints:
            total += (motor.joint_damping or 0.0) * float(np.abs(joints[rotor][0] - joints[name][0])) ** 2
    for body in drive.body:
        total += body.damping * sum(moved(f"{body.name}.{move}") ** 2 for move in body.moves)
    return total
