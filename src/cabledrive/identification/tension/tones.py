r"""Decaying tones fitted together.

Each tone of a recording is

.. math:: y_k(t) = e^{-a_k t}\,\mathrm{Re}\Big[c_k\,e^{2\pi i f_k(t + \kappa_k q_k(t))}\Big], \qquad
          q_k = \frac{1 - e^{-p\,a_k t}}{p\,a_k},

whose frequency is by :math:`\kappa_k` higher at its first amplitude: p = 2 where the string is recorded,
p = 1 where its stretch is. Tones of one family share a factor on their frequencies,
:math:`f_k = x\,g_k`. Least squares by variable projection in the form of Kaufman.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cabledrive.parameters.arrays import Array

OF_TONES = ("family", "tooth", "number", "decay", "rise")
PASSES = 25
SHORTEST = 0.02
"""Share of a step below which none is taken."""
SETTLED = 1e-7
"""Relative fall of the sum of squares below which a fit has settled."""
USUAL_RISE = 0.01
"""Rise of the frequency with amplitude that is expected, relative; a soft bound where noise hides it."""
LEAST_PIVOT = 1e-5
"""Smallest pivot over the largest, down to which a Gram matrix keeps the digits of its columns."""
FASTEST = 0.5
"""Decay over frequency above which there is no tone."""
DECAYED = 0.7
"""Fall of the envelope (p a T) from which the rise with amplitude can be determined."""
DECAYING = 0.35
"""Fall of the envelope (a T) from which a tone is no hum."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Tones:
    """Tones in families."""

    family: NDArray[np.intp]  # (tones,): to which family each tone belongs
    tooth: Array  # (tones,): frequency of each where its family's factor is 1 [Hz]
    number: NDArray[np.intp]  # (tones,): which mode, from 1; 0 for a tone of no span
    scale: Array  # (families,): factor x of each family
    # decay, rise: (tones,): a [1/s] and kappa [-]
    decay: Array
    rise: Array

    @property
    def frequency(self) -> Array:
        """Frequency of each tone at vanishing amplitude [Hz]."""
        return np.asarray(self.scale[self.family] * self.tooth)

    def only(self, kept: NDArray[np.bool_]) -> "Tones":
        """Some of the tones, with the same families, some perhaps without a tone."""
        return replace(self, **{name: getattr(self, name)[kept] for name in OF_TONES})

    def beside(self, other: "Tones") -> "Tones":
        """These tones and those of the same families after them."""
        rows = {name: np.concatenate([getattr(self, name), getattr(other, name)]) for name in OF_TONES}
        return replace(self, **rows)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TonesFit:
    """Tones that fit a recording best."""

    tones: Tones
    amplitude: Array  # (tones,): at the beginning of the fitted part, in the channel's unit
    amplitude_error: Array  # (tones,)
    scale_covariance: Array  # (families, families): of the factors x
    # offset, offset_error: (tones,): of each tone alone from its family, and its standard error [Hz]
    offset: Array
    offset_error: Array
    residual: float  # sum of squares
    resolved: NDArray[np.bool_]  # (tones,): whether a tone decays enough for the effect of its amplitude
    left: Array  # (samples,): what the tones do not explain
    duration: float  # [s]

    @property
    def decays(self) -> NDArray[np.bool_]:
        """Whether each tone falls enough to be no hum, shape (tones,)."""
        return np.asarray(self.tones.decay * self.duration > DECAYING)


def with_decays(values: Array, interval: float, tones: Tones, power: int) -> Tones:
    """Tones with the common decay that fits best, to begin with."""
    time = interval * np.arange(values.size, dtype=np.float64)
    tried = [
        replace(tones, decay=np.full(tones.tooth.size, share / time[-1]))
        for share in (0.3, 1.0, 2.5, 6.0, 15.0)
    ]
    return min(tried, key=lambda one: _projected(values, time, one, power).squares)


def fit_tones(values: Array, interval: float, start: Tones, power: int) -> TonesFit:
    """Fit tones to a recording (samples,) that begins after the pluck; ``power``: p of the module."""
    time = interval * np.arange(values.size, dtype=np.float64)
    tones, state = start, _projected(values, time, start, power)
    for _ in range(PASSES):
        steps = _step(time, tones, state, power)
        share, before = 1.0, _judged(tones, state)
        while share > SHORTEST:
            tried = _moved(tones, share * steps, time[-1], power)
            following = _projected(values, time, tried, power)
            if _judged(tried, following) < before:
                tones, state = tried, following
                break
            share *= 0.4
        if share <= SHORTEST or _judged(tones, state) > before * (1.0 - SETTLED):
            break
    return _conclude(time, tones, state, power)


class _Projection(NamedTuple):
    basis: Array
    linear: Array
    residual: Array
    squares: float
    triangle: Array
    directions: Array


def _projected(values: Array, time: Array, tones: Tones, power: int) -> _Projection:
    """Best amplitudes for given frequencies, decays and rises; a constant beside them."""
    envelope, angle, _ = _angles(time, tones, power)
    columns = np.column_stack([envelope * np.cos(angle), envelope * np.sin(angle), np.ones(time.size)])
    directions, triangle = _factored(columns)
    linear = np.asarray(np.linalg.lstsq(triangle, directions.T @ values, rcond=1e-10)[0], dtype=float)
    residual = values - columns @ linear
    return _Projection(columns, linear, residual, float(residual @ residual), triangle, directions)


def _factored(columns: Array) -> tuple[Array, Array]:
    """QR factors of a tall matrix by two Cholesky factorizations; Householder's where that loses digits."""
    upper = np.eye(columns.shape[1])
    directions = columns
    for _ in range(2):
        try:
            factor = np.linalg.cholesky(directions.T @ directions).T
        except np.linalg.LinAlgError:
            return np.linalg.qr(columns)
        size = np.diag(factor)
        if size.min() < LEAST_PIVOT * size.max():
            return np.linalg.qr(columns)
        directions, upper = directions @ np.linalg.inv(factor), factor @ upper
    return directions, upper


def _judged(tones: Tones, state: _Projection) -> float:
    """Sum of squares, with the soft bound on the rises."""
    softly = float(np.sum((tones.rise / USUAL_RISE) ** 2)) / state.residual.size
    return state.squares * (1.0 + softly)


def _angles(time: Array, tones: Tones, power: int) -> tuple[Array, Array, Array]:
    """Envelope, angle and q of each tone, shape (samples, tones)."""
    envelope = np.exp(-np.outer(time, tones.decay))
    rate = power * np.maximum(tones.decay, 1e-9 / time[-1])
    q = -np.expm1(-np.outer(time, rate)) / rate
    return envelope, 2 * np.pi * tones.frequency * (time[:, None] + tones.rise * q), q


def _resolved(tones: Tones, duration: float, power: int) -> NDArray[np.bool_]:
    return np.asarray((power * tones.decay * duration > DECAYED) & (tones.number > 0))


def _sensitivities(time: Array, tones: Tones, state: _Projection, power: int) -> tuple[Array, Array, Array]:
    """Derivatives of each tone with its frequency, its decay and its rise."""
    _, _, q = _angles(time, tones, power)
    count = tones.tooth.size
    cosine, sine = state.basis[:, :count], state.basis[:, count : 2 * count]
    c, s = state.linear[:count], state.linear[count : 2 * count]
    turned = 2 * np.pi * (s * cosine - c * sine)
    by_frequency = turned * (time[:, None] + tones.rise * q)
    by_decay = -time[:, None] * (c * cosine + s * sine)
    return by_frequency, by_decay, turned * tones.frequency * q


def _families(tones: Tones) -> Array:
    """By how much each tone moves with each family's factor, shape (tones, families)."""
    return np.asarray(tones.tooth[:, None] * (tones.family[:, None] == np.arange(tones.scale.size)))


def _step(time: Array, tones: Tones, state: _Projection, power: int) -> Array:
    by_frequency, by_decay, by_rise = _sensitivities(time, tones, state, power)
    resolved = _resolved(tones, time[-1], power)
    columns = np.column_stack([by_frequency @ _families(tones), by_decay, by_rise * resolved])
    columns -= state.directions @ (state.directions.T @ columns)
    families, count = tones.scale.size, tones.tooth.size
    deviation = np.sqrt(state.squares / time.size)
    soft = np.hstack([np.zeros((count, families + count)), np.eye(count) * deviation / USUAL_RISE])
    rows = np.vstack([columns, soft])
    left = np.concatenate([state.residual, -tones.rise * deviation / USUAL_RISE])
    size = np.maximum(np.linalg.norm(rows, axis=0), 1e-300)
    directions, triangle = _factored(rows / size)
    return np.asarray(np.linalg.lstsq(triangle, directions.T @ left, rcond=1e-9)[0] / size)


def _moved(tones: Tones, step: Array, duration: float, power: int) -> Tones:
    families, count = tones.scale.size, tones.tooth.size
    narrow = 0.5 / (duration * np.median(tones.tooth))
    scale = tones.scale + np.clip(step[:families], -narrow, narrow)
    change = step[families : families + count]
    decay = np.clip(tones.decay + change, 0.3 * tones.decay, 3.0 * tones.decay + 0.1 / duration)
    decay = np.clip(decay, 0.01 / duration, np.maximum(FASTEST * tones.frequency, 0.01 / duration))
    moved = replace(tones, scale=scale, decay=decay)
    resolved = _resolved(moved, duration, power)
    return replace(moved, rise=np.where(resolved, tones.rise + step[families + count :], 0.0))


def _conclude(time: Array, tones: Tones, state: _Projection, power: int) -> TonesFit:
    by_frequency, by_decay, by_rise = _sensitivities(time, tones, state, power)
    resolved = _resolved(tones, time[-1], power)
    families, count = tones.scale.size, tones.tooth.size
    others = np.column_stack([by_decay, by_rise[:, resolved]])
    freedom = max(1, time.size - 2 * count - 1 - families - others.shape[1])
    variance = state.squares / freedom
    soft = np.concatenate([np.zeros(count), np.full(int(resolved.sum()), np.sqrt(variance) / USUAL_RISE)])
    clear = _clear(by_frequency, others, soft, state)
    shared = _clear(by_frequency @ _families(tones), others, soft, state)
    alone, common = (np.linalg.pinv(c.T @ c, hermitian=True, rcond=1e-14) for c in (clear, shared))
    pulled = -tones.rise[resolved] * np.sqrt(variance) / USUAL_RISE
    left = np.concatenate([state.residual, np.zeros(count), pulled])
    linear = np.linalg.pinv(state.triangle.T @ state.triangle, hermitian=True)
    spread = np.sqrt(variance * np.diag(linear))
    return TonesFit(
        tones=tones,
        amplitude=np.hypot(state.linear[:count], state.linear[count : 2 * count]),
        amplitude_error=np.hypot(spread[:count], spread[count : 2 * count]) / np.sqrt(2.0),
        scale_covariance=variance * common,
        offset=alone @ (clear.T @ left),
        offset_error=np.sqrt(variance * np.diag(alone)),
        residual=state.squares,
        resolved=resolved,
        left=state.residual,
        duration=float(time[-1]),
    )


def _clear(wanted: Array, others: Array, soft: Array, state: _Projection) -> Array:
    """Columns without what amplitudes, decays and rises could do instead."""
    both = np.column_stack([wanted, others])
    both = both - state.directions @ (state.directions.T @ both)
    both = np.vstack([both, np.hstack([np.zeros((soft.size, wanted.shape[1])), np.diag(soft)])])
    kept = both[:, wanted.shape[1] :]
    size = np.maximum(np.linalg.norm(kept, axis=0), 1e-300)
    wanted = both[:, : wanted.shape[1]]
    directions, triangle = _factored(kept / size)
    linear = np.linalg.lstsq(triangle, directions.T @ wanted, rcond=1e-9)[0]
    return np.asarray(wanted - (kept / size) @ linear)
