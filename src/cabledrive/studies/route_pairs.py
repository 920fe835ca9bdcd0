r"""Pairs near internal resonance of any machine, loop, line or routes.

A longitudinal mode q of unit modal mass strains its spans by :math:`u_x`. It changes the tension that holds
transverse modes a and b of unit modal mass, and with amplitude Q at frequency W they grow where

.. math:: g_{ab} = \sum EA \int u_x\,\varphi_a'\,\varphi_b'\,\mathrm{d}x, \qquad
          (g_{ab} Q)^2 > 16\,w_a w_b\,\delta_a\delta_b
          \Big[1 + \frac{(W - w_a - w_b)^2}{(\delta_a + \delta_b)^2}\Big], \qquad \text{Eq. (N.11)}

with the decay rates :math:`\delta = \Gamma/2`; a = b is the 1:2 resonance. A torque of amplitude M at the
motor's pulley, where the mode turns by :math:`\theta`, gives :math:`Q = M\theta/(W c)` with modal damping c.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import pi, sqrt

import numpy as np

from cabledrive.mechanics.network import network_of
from cabledrive.modal import Mode
from cabledrive.modal.natural import straight_modes
from cabledrive.parameters import InputRefused
from cabledrive.parameters.route.drive import RoutedDrive
from cabledrive.studies import pair_thresholds as near
from cabledrive.studies.resonance_detuning import ResonanceSummary, acting_torque, verdict_of

NOT_INCLUDED = "Coulomb friction of shafts and rails, motion of bodies beyond small angles"
MISSING = {
    **dict.fromkeys(
        ("tuned_pretension", "threshold_here", "growth_torque"),
        "on a machine with routes the tensions follow from statics",
    ),
    "threshold_torque": "no pair that the first motor excites is near",
    "coulomb_onset": "Coulomb friction is not included on a machine with routes",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class RoutePair(near.NearPair):
    """One of a machine with routes."""

    family: str  # what mainly moves in the longitudinal mode
    plane: str  # {"v", "w"}
    coupling: float  # :math:`g_{ab}` [1/(m s^2 sqrt(kg))]
    threshold_amplitude: float  # largest strain of the longitudinal mode above which they grow [-]


def route_resonance(
    drive: RoutedDrive, *, torque: float | None = None, motor: str | None = None
) -> ResonanceSummary:
    """Pairs near 1:2 and of sum type, Eq. (N.11), of routes whose cables do not run; ``torque`` [N m]."""
    acting = acting_torque(drive, torque)
    near.refuse_running(drive, "a pair of modes")
    network = network_of(drive, motor=motor)
    first = straight_modes(drive, count=10, motor=motor)
    names = {one.name for one in drive.pulley}
    turning = (m for m in first.longitudinal if any(m.kinetic_shares.get(name, 0.0) > 1e-6 for name in names))
    pulley = next(turning, None)
    if pulley is None:
        raise InputRefused("no pulley turns in the first longitudinal modes: there is no pulley mode to tune")
    lowest: dict[str, Mode] = {}  # of each span, across
    for mode in first.transverse:
        lowest.setdefault(mode.span or "", mode)
    nearest = min(lowest.values(), key=lambda mode: abs(mode.frequency / pulley.frequency - 0.5))
    found = straight_modes(drive, below=near.HIGHEST * pulley.frequency * 1.0001, motor=motor)
    highest = near.HIGHEST * pulley.frequency
    along = [mode for mode in found.longitudinal if not mode.clamped and mode.frequency <= highest]
    reach = 0.5 * (1.0 + near.NEAR) * (1.0 + near.NEAR_SUM) * max(mode.frequency for mode in along)
    waves = near.waves_of(network, along, [mode for mode in found.transverse if mode.frequency <= reach])
    pairs = tuple(sorted(_pairs(waves), key=near.by_threshold))
    thresholds = [(pair.longitudinal_hz, pair.threshold_torque) for pair in pairs]
    verdict, reasons = verdict_of(acting, thresholds)
    ratio = nearest.frequency / pulley.frequency
    doubt = (f"modes not certified: {found.certified_reason}",) if found.certified_reason else ()
    return ResonanceSummary(
        pairs=pairs,
        pulley_frequency=pulley.frequency,
        nearest_span=nearest.span or "",
        frequency_ratio=ratio,
        detuning=ratio - 0.5,
        motor=found.motor,
        certified=found.certified,
        left_out=(f"not included: {NOT_INCLUDED}", *doubt),
        threshold_torque=min((torque for _, torque in thresholds if torque is not None), default=None),
        torque=None if acting is None else acting.amplitude,
        verdict=verdict,
        reasons=reasons,
        missing=MISSING,
    )


def _pairs(waves: near.Waves) -> Iterator[RoutePair]:
    """Every pair near resonance."""
    coupling, (damping, losses) = waves.couplings, waves.losses
    drive, across = waves.network.drive, np.array([2 * pi * mode.frequency for mode in waves.across])
    for number, q in enumerate(waves.along):
        natural, turn = 2 * pi * q.frequency, abs(float(near.turns_of(waves.network, q)[0]))
        detunings = natural - across[:, None] - across
        for i, j in near.near_pairs(np.abs(coupling[number]), np.abs(detunings) / natural):
            detuning, strength = float(detunings[i, j]), abs(float(coupling[number, i, j]))
            least = float(near.lost_square(0.5 * losses[i], 0.5 * losses[j], detuning))
            amplitude = 4.0 * sqrt(across[i] * across[j] * least) / strength
            torque = amplitude * natural * float(damping[number]) / turn if turn else None
            slopes = [waves.slopes[0][number], *waves.slopes[1][[i, j]]]
            count = 1 if waves.across[i].clamped or waves.across[j].clamped else waves.ropes
            shares = waves.rigidity * waves.length * (np.prod(slopes, axis=0) @ waves.weights) * count
            spans = np.bincount([piece.span for piece in waves.network.pieces], shares)
            yield RoutePair(
                kind=near.ONE_TO_TWO if i == j else near.SUM,
                longitudinal_hz=q.frequency,
                family=q.family,
                span=drive.free_spans[int(np.argmax(np.abs(spans)))].name,
                plane=waves.across[i].plane or "",
                transverse_hz=(waves.across[i].frequency, waves.across[j].frequency),
                detuning_hz=detuning / (2 * pi),
                coupling=strength,
                threshold_amplitude=amplitude * float(np.abs(slopes[0]).max()),
                threshold_torque=torque,
                reason="" if turn else "the first motor does not turn in this longitudinal mode",
            )
