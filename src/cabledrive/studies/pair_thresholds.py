r"""Longitudinal modes and the transverse ones that they excite, 1:2 and sum type, with threshold torques.

With q of frequency W and amplitude Q, transverse modes a and b of one stretch grow where

.. math:: \mu^2 > \tfrac14\Gamma_a\Gamma_b\Big[1 + \frac{4\delta^2}{(\Gamma_a + \Gamma_b)^2}\Big], \qquad
          \mu = \frac{|G_{ab}| Q}{4\sqrt{m_a m_b w_a w_b}}, \quad \delta = W - w_a - w_b,
          \qquad \text{Eq. (A.33)}

and a = b is the 1:2 resonance. There the third harmonic's share is added, as in (A.22).
"""

from dataclasses import dataclass
from math import inf, isfinite, pi, sqrt

import numpy as np

from cabledrive.parameters import Drive
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


@dataclass(frozen=True, slots=True, kw_only=True)
class CoupledPair:
    """A longitudinal mode and the one or two transverse modes that it can excite parametrically.

    Attributes
    ----------
    kind : {"1:2", "sum"}
    longitudinal_hz : float
        [Hz].
    span : {"upper", "lower"}
    section : (float, float)
        Unstretched ends of the free stretch [m].
    numbers : (int, int)
        Of the transverse modes; twice the same for 1:2.
    transverse_hz : (float, float)
        Their frequencies at rest [Hz].
    detuning_hz : float
        Longitudinal frequency minus the sum of the transverse ones [Hz].
    threshold_torque : float or None
        Amplitude of the torque at the longitudinal frequency above which they grow [N m].
    reason : str
        Why there is none.
    """

    kind: str
    longitudinal_hz: float
    span: str
    section: tuple[float, float]
    numbers: tuple[int, int]
    transverse_hz: tuple[float, float]
    detuning_hz: float
    threshold_torque: float | None
    reason: str = ""


def coupled_pairs(drive: Drive, pulley_mode: float) -> tuple[CoupledPair, ...]:
    """Pairs of a drive at rest, Eq. (A.33): all 1:2 ones of the pulley mode, others near resonance.

    ``pulley_mode``: frequency of the lowest longitudinal mode in which a pulley turns [rad/s].
    Returns the lowest threshold first.
    Raises `NotComputed` if a section hangs slack at rest.
    """
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
    return tuple(sorted(found, key=_order))


def _order(pair: CoupledPair) -> tuple[float, float]:
    """The lowest threshold first, then the least detuning."""
    return inf if pair.threshold_torque is None else pair.threshold_torque, abs(pair.detuning_hz)


def _of_stretch(model: SaggingModel, k: int, r: int, *, all_of_them: bool) -> list[CoupledPair]:
    part, natural, found = model.stretches[r], float(model.natural[k]), []
    for a in range(part.omega.size):
        for b in range(a, min(a + BAND + 1, part.omega.size)):
            detuning = natural - float(part.omega[a] + part.omega[b])
            near = abs(detuning) < (NEAR if a == b else NEAR_SUM) * natural
            if not (near or (a == b and all_of_them)):
                continue
            itself = sqrt(abs(model.coupling[k, r, a, BAND] * model.coupling[k, r, b, BAND]))
            if a != b and abs(model.coupling[k, r, a, b - a + BAND]) <= WEAKEST * itself:
                continue
            torque = _threshold(model, k, r, a, b, detuning)
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
                    reason="" if isfinite(torque) else _reason(model, k),
                )
            )
    return found


def _reason(model: SaggingModel, k: int) -> str:
    if _still(model, k):
        return "the torque of the motor does not excite this longitudinal mode"
    return "no torque at the longitudinal frequency makes it grow: too far from resonance, or not stretched"


def _still(model: SaggingModel, k: int) -> bool:
    return bool(abs(model.torque_shape[k]) <= 1e-9 * np.max(np.abs(model.torque_shape)))


def _threshold(model: SaggingModel, k: int, r: int, a: int, b: int, detuning: float) -> float:
    """Threshold torque of one pair [N m]; infinite where there is none."""
    loss_a, loss_b = float(model.loss[r, a]), float(model.loss[r, b])
    natural, resistance = float(model.natural[k]), float(model.natural[k] * model.damping[k, k])
    per_amplitude = abs(float(model.coupling[k, r, a, b - a + BAND])) / 4.0
    turning = 0.25 * natural**2 if a == b else float(model.transverse[r, a] * model.transverse[r, b])
    per_amplitude /= sqrt(float(model.mass[r, a] * model.mass[r, b]) * turning)
    if _still(model, k) or per_amplitude == 0.0:
        return inf
    if resistance == 0.0:
        return 0.0
    if a == b:  # as the averaged equations count it, (nu^2 - w^2) / nu
        detuning = 0.5 * natural - 2.0 * float(model.transverse[r, a]) ** 2 / natural
    least = _least_pumping(loss_a, loss_b, detuning, natural, same=a == b)
    return least / per_amplitude * resistance / abs(float(model.torque_shape[k]))


def _least_pumping(loss_a: float, loss_b: float, detuning: float, natural: float, *, same: bool) -> float:
    total = loss_a + loss_b
    if total == 0.0:
        least = 0.25 * detuning**2
    else:
        least = 0.25 * loss_a * loss_b * (1.0 + 4.0 * detuning**2 / total**2)
    if not same:
        return sqrt(least)
    # third harmonic: mu^2 = least with the detuning shifted by mu^2 / W
    shift = 1.0 + 0.5 * detuning / natural
    inside = shift**2 - least / natural**2
    if inside < 0.0 or shift <= 0.0:
        return inf
    return sqrt(2.0 * least / (shift + sqrt(inside)))
