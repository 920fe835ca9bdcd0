"""Regressors of friction: constant, smooth, different in both directions, falling with speed."""

from dataclasses import dataclass
from math import pi, sqrt

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from cabledrive.identification.filters import butterworth
from cabledrive.parameters import InputRefused

Array = NDArray[np.float64]

FRICTIONS = ("coulomb", "tanh", "asymmetric", "asymmetric-offset", "stribeck", "viscous")
PRINTED_SLOPE = 0.5
"""K of (4.8) [s/rad]: wide; b and c mean something only together with it."""
DEAD_ZONE_DEVIATIONS = 2.0


@dataclass(frozen=True, slots=True, kw_only=True)
class FrictionModel:
    """Which friction is fitted.

    Attributes
    ----------
    kind : str
        One of `FRICTIONS`.
    slope : float
        K of c tanh(K w) [s/rad].
    fading : float
        Speed at which the excess of Stribeck friction has fallen to 1/e [rad/s].
    """

    kind: str = "coulomb"
    slope: float = PRINTED_SLOPE
    fading: float = 0.0

    def __post_init__(self) -> None:
        if self.kind not in FRICTIONS:
            raise InputRefused(f'friction "{self.kind}" is unknown: take one of {", ".join(FRICTIONS)}')


def dead_zone(quantum: float, interval: float, cutoff: float) -> float:
    """Speed below which its sign is not known: the deviation that the encoder's rounding makes, times 2.

    ``quantum``: step of the encoder [rad]; ``interval`` [s]; ``cutoff``: bandwidth of the speed [Hz].
    Returns [rad/s].
    """
    frequency, response = signal.freqz_sos(butterworth(interval, cutoff), worN=2048, fs=1 / interval)
    gain = np.abs(response) ** 2 * 2 * pi * frequency
    return DEAD_ZONE_DEVIATIONS * quantum / sqrt(12) * float(np.sqrt(np.mean(gain**2)))


def direction_of(speed: Array, zone: float, shortest: int = 1) -> Array:
    """Sign of the speed, zero while it rests inside the dead zone.

    ``speed`` [rad/s]; ``zone`` [rad/s]; ``shortest``: samples that a rest lasts at least; a turn that passes
    through the zone sooner is no rest.
    """
    inside = np.abs(speed) <= zone
    edges = np.flatnonzero(np.diff(np.concatenate(([0], inside.astype(np.int8), [0]))))
    for start, end in zip(edges[::2], edges[1::2], strict=True):
        if end - start < shortest:
            inside[start:end] = False
    return np.where(inside, 0.0, np.sign(speed))


def friction_columns(model: FrictionModel, speed: Array, sign: Array, offset: str) -> dict[str, Array]:
    r"""Regressors beside the acceleration, by the parameter that multiplies them, Eqs. (4.8), (4.11), (4.12).

    .. math:: \tau = J\ddot\theta + b\dot\theta + c\,S(\dot\theta) - d

    ``speed``, shape (samples,) [rad/s]; ``sign``, shape (samples,): its direction, see `direction_of`;
    ``offset``: name of the offset: "offset_torque" or "offset_force".
    Returns the regressor of the offset is -1, as in (4.9).
    """
    plain = {"viscous_friction": speed, "coulomb_friction": sign, offset: np.full_like(speed, -1.0)}
    if model.kind == "coulomb":
        return plain
    if model.kind == "viscous":
        return {"viscous_friction": speed, offset: plain[offset]}
    if model.kind == "tanh":
        return plain | {"coulomb_friction": np.tanh(model.slope * speed)}
    if model.kind == "stribeck":
        return plain | {"stribeck_friction": sign * np.exp(-((speed / model.fading) ** 2))}
    forth, back = speed > 0.0, speed < 0.0
    sides = {
        "viscous_friction_positive": np.where(forth, speed, 0.0),
        "coulomb_friction_positive": np.maximum(sign, 0.0),
        "viscous_friction_negative": np.where(back, speed, 0.0),
        "coulomb_friction_negative": np.minimum(sign, 0.0),
    }
    return sides | {offset: plain[offset]} if model.kind == "asymmetric-offset" else sides
