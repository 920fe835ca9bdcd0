"""Pairs of modes that come near 1:2 or sum resonance while a machine with routes moves, Eq. (N.11)."""

from dataclasses import dataclass
from math import pi

import numpy as np
from numpy.typing import NDArray

from cabledrive.studies.pair_thresholds import NEAR, NEAR_SUM, ONE_TO_TWO, SUM, WEAKEST
from cabledrive.studies.route_path import RoutePath

Array = NDArray[np.float64]
INSTANTS = 2000


@dataclass(frozen=True, slots=True, kw_only=True)
class Passage:
    """A longitudinal mode and the one or two transverse modes that it comes near to exciting.

    Attributes
    ----------
    kind : {"1:2", "sum"}
    span, plane : str
        Of the first transverse mode.
    longitudinal_hz, transverse_hz : float, (float, float)
        Where the amplitude is the largest share of the threshold [Hz].
    detuning_hz : (float, float)
        Lowest and highest longitudinal frequency minus the sum of the transverse ones [Hz].
    passes : bool
        Whether it goes through resonance.
    amplitude : float
        Amplitude of the longitudinal mode over its threshold, the largest along the motion.
    time : float
        When [s].
    """

    kind: str
    span: str
    plane: str
    longitudinal_hz: float
    transverse_hz: tuple[float, float]
    detuning_hz: tuple[float, float]
    passes: bool
    amplitude: float
    time: float


def passages_of(path: RoutePath) -> tuple[Passage, ...]:
    """Every pair that comes near resonance along a motion, the largest amplitude over its threshold first."""
    if not path.snapshots[0].keys:
        return ()
    picked = np.unique(np.linspace(0, path.time.size - 1, INSTANTS).astype(np.intp))
    here = path.here[picked]
    names = ("along", "across", "across_loss", "coupling")
    along, across, loss, coupling = (path.at(name, here) for name in names)
    amplitude = _envelope(path)[picked]
    strength = np.abs(coupling).max(axis=0)
    found = []
    for q in range(along.shape[1]):
        itself = np.sqrt(np.diag(strength[q]))
        for i in range(across.shape[1]):
            for j in range(i, across.shape[1]):
                near = NEAR if i == j else NEAR_SUM
                detuning = along[:, q] - across[:, i] - across[:, j]
                if np.all(np.abs(detuning) > near * along[:, q]) and np.ptp(np.sign(detuning)) == 0.0:
                    continue
                if strength[q, i, j] == 0.0 or (
                    i != j and strength[q, i, j] <= WEAKEST * itself[i] * itself[j]
                ):
                    continue
                least = _least(0.5 * loss[:, i], 0.5 * loss[:, j], detuning)
                threshold = 4.0 * np.sqrt(across[:, i] * across[:, j] * least)
                share = np.abs(coupling[:, q, i, j]) * amplitude[:, q] / np.maximum(threshold, 1e-300)
                when = int(np.argmax(share))
                span, plane, _ = path.snapshots[0].keys[i]
                found.append(
                    Passage(
                        kind=ONE_TO_TWO if i == j else SUM,
                        span=span,
                        plane=plane,
                        longitudinal_hz=float(along[when, q]) / (2.0 * pi),
                        transverse_hz=(
                            float(across[when, i]) / (2.0 * pi),
                            float(across[when, j]) / (2.0 * pi),
                        ),
                        detuning_hz=(float(detuning.min()) / (2.0 * pi), float(detuning.max()) / (2.0 * pi)),
                        passes=bool(detuning.min() <= 0.0 <= detuning.max()),
                        amplitude=float(share[when]),
                        time=float(path.time[picked[when]]),
                    )
                )
    return tuple(sorted(found, key=lambda one: -one.amplitude))


def _least(first: Array, second: Array, detuning: Array) -> Array:
    """Square of the growth rate that two modes with these decay rates lose [1/s^2]."""
    both = first + second
    damped = first * second * (1.0 + (detuning / np.where(both > 0.0, both, 1.0)) ** 2)
    return np.where(both > 0.0, damped, 0.25 * detuning**2)


def _envelope(path: RoutePath) -> Array:
    """Amplitude of each longitudinal mode about where the torque holds it, shape (steps + 1, q)."""
    omega, turn = path.at("along", path.here), path.at("along_turn", path.here)
    rest = np.einsum("iqm,im->iq", turn, path.torque) / omega**2
    return np.asarray(np.hypot(path.along - rest, path.along_rate / omega))
