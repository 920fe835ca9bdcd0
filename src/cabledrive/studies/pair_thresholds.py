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

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import inf, pi

import numpy as np

from cabledrive.modal.tuning import Pair
from cabledrive.parameters import InputRefused, Machine
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.threshold import pair_threshold
from cabledrive.reduction.waves import Waves

ONE_TO_TWO, SUM = "1:2", "sum"

HIGHEST = 3.0
"""Longitudinal modes are looked at up to so many times the pulley mode's frequency."""

NEAR, NEAR_SUM, FAR = 0.1, 0.05, 0.5
"""Largest detuning, over the longitudinal frequency, at which other pairs than those with a tuning are
listed; that of 1:2 pairs of the pulley mode, beyond which averages describe none."""

WEAKEST = 1e-2
"""Least coupling of two modes, over that of each with itself, at which a sum pair is listed."""

STILL = "the first motor does not turn in this longitudinal mode"
TOO_FAR = "no torque at the longitudinal frequency makes it grow: too far from resonance, or not stretched"
SLACK = "a rope goes slack before it grows, from {:.4g} N m on"
BOTH = "both"
_SAME, _ALIKE = 1e-6, 1e-3
"""Relative differences up to which frequencies are of one mode, and pairs of both planes are alike."""
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
    def least(self) -> float:
        """Threshold torque, infinite where there is none [N m]."""
        return inf if self.threshold_torque is None else self.threshold_torque

    @property
    def second_transverse_hz(self) -> float | None:
        """Of the sum type the other transverse mode [Hz]."""
        return self.transverse_hz[1] if self.kind == SUM else None

    @property
    def second_number(self) -> int | None:
        """Of the sum type that of the other transverse mode."""
        return self.numbers[1] if self.kind == SUM else None


def pairs_of(
    waves: Waves, spans: Sequence[str], pulley_hz: float, tunings: Sequence[Pair], sought: int
) -> tuple[NearPair, ...]:
    """Pairs near resonance by Eq. (N.11), lowest threshold first; where both planes have one alike, once.

    ``spans``: their names; ``pulley_hz``: the pulley mode, whose pairs with ``tunings`` are all listed;
    ``sought``: how many modes along, the first ones, whose pairs are listed.
    """
    found: dict[tuple[object, ...], NearPair] = {}
    for pair in _pairs(waves, spans, pulley_hz, tunings, sought):
        key = pair.longitudinal_hz, pair.span, pair.section, pair.numbers
        other = found.setdefault(key, pair)
        first, last = ((*one.transverse_hz, one.coupling) for one in (pair, other))
        if other is not pair and np.allclose(first, last, rtol=_ALIKE, atol=0.0):
            found[key] = replace(other, plane=BOTH)
        elif other is not pair:
            found[*key, pair.plane] = pair

    def order(own: NearPair) -> tuple[float, ...]:
        """Of pairs that round-off alone parts, the one whose span is listed first."""
        return *(float(f"{value:.9g}") for value in (own.least, abs(own.detuning_hz))), spans.index(own.span)

    return tuple(sorted(found.values(), key=order))


def alike(first: float, second: float) -> bool:
    """Whether two frequencies are of one mode."""
    return abs(first / second - 1.0) < _SAME


def _pairs(
    waves: Waves, spans: Sequence[str], pulley_hz: float, tunings: Sequence[Pair], sought: int
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
    listed = np.diag(np.array([i in tuned or not tunings for i in range(across.size)], dtype=bool))
    turns, slack = np.abs(waves.turns[:, 0]), waves.slack_torques
    turns[turns <= _TURNING * turns.max(initial=0.0)] = 0.0
    for number, q in enumerate(waves.along[:sought]):
        natural, turn = 2 * pi * q.frequency, float(turns[number])
        detunings, strength = natural - across[:, None] - across, np.abs(coupling[number])
        own = listed & alike(q.frequency, pulley_hz) & (bool(tunings) | (np.abs(detunings) <= FAR * natural))
        # A stretch that the mode does not strain is listed as well, with the reason.
        strengths = np.maximum(strength, 1e-300 * own)
        for i, j in near_pairs(strengths, np.where(own, 0.0, np.abs(detunings) / natural)):
            amplitude = pair_threshold(natural, across[[i, j]], 0.5 * losses[[i, j]]) / float(strengths[i, j])
            grows, strain = bool(np.isfinite(amplitude)), np.abs(waves.slopes[0][number]).max()
            slopes = [waves.slopes[0][number], *waves.slopes[1][[i, j]]]
            count = 1 if waves.across[i].clamped or waves.across[j].clamped else waves.ropes
            shares = waves.rigidity * waves.length * (np.prod(slopes, axis=0) @ waves.weights) * count
            where = np.bincount([piece.span for piece in waves.network.pieces], shares)
            span = int(np.argmax(np.abs(where))) if where.any() else places[i][0]
            torque = amplitude * natural * float(damping[number]) / turn if turn and grows else None
            if turn and damping[number] == 0.0:  # it grows in time until they do
                torque = 0.0
            limit, why = float(slack[number]), TOO_FAR if turn else STILL
            if torque and torque > limit:
                torque, why = None, SLACK.format(limit)
            if torque is None and not tunings and abs(detunings[i, j]) > NEAR * natural:
                continue
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
                reason="" if torque is not None else why,
                tuning=tuned.get(i) if own[i, j] else None,
            )


def near_pairs(strength: Array, detuning: Array) -> list[list[int]]:
    """Transverse modes near resonance; both, shape (modes, modes): coupling, detuning over the frequency."""
    itself = np.sqrt(np.diag(strength))
    weakest = WEAKEST * np.outer(itself, itself)
    np.fill_diagonal(weakest, 0.0)
    near = np.where(np.eye(len(strength), dtype=bool), NEAR, NEAR_SUM)
    return np.argwhere(np.triu((detuning <= near) & (strength > weakest))).tolist()


def refuse_running(drive: Machine, what: str) -> None:
    """Refuse routes whose cable runs, for what is computed of cables at rest."""
    for route in drive.route:
        if route.speed:
            said = f'route "{route.name}" runs at {route.speed:.4g} m/s'
            raise InputRefused(f"{said}: {what} is for cables that do not; set speed to 0")
