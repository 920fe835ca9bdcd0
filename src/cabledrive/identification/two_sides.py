r"""Two inertias and the spring between them, both sides measured: two regressions that hold no simulation.

The sum of the equations of motion holds no spring, the load's own equation no torque,

.. math::
    \tau &= J_1\ddot\theta_1 + J_2\ddot\theta_2 + b\,\dot\theta_1 + c\,\mathrm{sgn}\,\dot\theta_1
        + b_2 (\dot\theta_2 - \dot\theta_1)
        + c_2 (\mathrm{sgn}\,\dot\theta_2 - \mathrm{sgn}\,\dot\theta_1) - d,\\
    \ddot\theta_2 &= \beta\,(\theta_1 - \theta_2) + \gamma\,(\dot\theta_1 - \dot\theta_2)
        - (b_2\,\dot\theta_2 + c_2\,\mathrm{sgn}\,\dot\theta_2) / J_2 + e,

with b, c of both sides together and all angles at the first shaft. Each is solved with low-pass filters of
several bandwidths. An interval is that of its bandwidth, and what the values differ from those of the
neighbouring bandwidths beyond chance: of two estimates, one of which uses what the other does and more, the
variance of the difference is the difference of the variances (Hausman, Econometrica 46, 1978). The bandwidth
with the narrowest interval is taken. Noise of the angles, which makes coefficients of accelerations too
small, is taken out of the normal equations by its level, that of the upper half of a channel's spectrum.

A torque that repeats with the motor's angle, of cogging or a tooth, is looked for in what the sum leaves, by
whole periods per turn, solved beside the parameters and taken off the torque of every log.
"""

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import combinations
from math import pi

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, ndimage, signal

from cabledrive.identification.estimates import Factors, Fit, factor, joined, only, solve, suited_segments
from cabledrive.identification.signals import difference, noise_spectrum, zero_phase
from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array

BANDS = (6.7, 10.0, 15.0, 22.0, 33.0, 50.0, 75.0, 110.0)
"""Bandwidths of the filter that are tried [Hz], as far as the sample rate allows."""
SUM = ("motor_inertia", "load_inertia", "viscous", "coulomb", "offset", "lag")
LOAD = ("beta", "gamma", "viscous", "coulomb", "zero")
SIGN_BANDS = 2.5
SLOW = 0.5
"""Speed below which friction's sign is not trusted [rad/s]."""
SEGMENTS = 120
FEWEST_ROWS = 200
NOISE_SURE = 0.25
"""Share of the correction for noise that its level may be off."""
UNMODELLED = {SUM: 7e-4, LOAD: 2e-4}
"""Share of an equation's left side that may hide in one parameter: reversals within a filter's memory."""
NOISE_ALONE = 0.2
"""Share of the weakest direction's power that must be more than noise."""
HEARD = 256
"""Samples of a part of the log by which it is found whether a feedback loop hears the encoders' noise."""
MOST_PERIODS, BINS = 240, 1024
"""Periods per turn up to which a torque that repeats with the angle is looked for; parts of a turn."""
LEAST_TURNS, SOME_PERIODS, MANY_PERIODS = 0.5, 4.0, 12.0
"""Turns that the motor must make, and periods that it must pass through in a whole turn, and in less."""
REPEATS, REPEATS_SURE = 0.8, 15.0
"""Share of the residual's power below which it has to fall by it, and its least size over its error."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Cogging:
    """A torque that repeats with the motor's angle: ``periods`` per turn, its parts and its error [N m]."""

    periods: int
    cosine: float
    sine: float
    error: float

    @property
    def size(self) -> float:
        """Amplitude [N m]."""
        return float(np.hypot(self.cosine, self.sine))

    @property
    def words(self) -> str:
        """What was taken out."""
        return f"a torque that repeats {self.periods} times per turn of the motor is taken out"

    def at(self, angle: Array) -> Array:
        """What it takes to hold it, at angles [rad]."""
        return self.cosine * np.cos(self.periods * angle) + self.sine * np.sin(self.periods * angle)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TwoSides:
    """Torque and angles, or speeds, of a log, each of shape (samples,), at the first shaft."""

    source: str
    interval: float
    torque: Array
    motor: Array
    load: Array
    rates: bool = False  # whether ``motor`` and ``load`` are speeds
    pulley: Array | None = None  # angle of the first pulley where a joint lies between it and the motor
    share: float = 1.0  # of the motor in the inertia before the spring
    twisted: bool = True  # whether the angles show the spring's twist
    saturated: NDArray[np.bool_] | None = None
    slow: float = SLOW  # below which a speed's sign is not trusted
    cogging: Cogging | None = None  # what of the torque repeats with the motor's angle
    slipped: Array | None = None  # what of the twist is a rope that has slipped on its pulley

    @property
    def near(self) -> Array:
        """The spring's first end, without what has slipped, (samples,)."""
        near = self.motor if self.pulley is None else self.pulley
        return near if self.slipped is None else near - self.slipped

    def later(self, lag: float) -> "TwoSides":
        """With the torque of the instants at which the angles were read, so late behind it [s]."""
        samples = lag / self.interval
        # held it is weaker by (pi f h)^2 / 6; a line through its samples three times as much, a spline not
        lines, spline = (ndimage.shift(self.torque, samples, order=k, mode="nearest") for k in (1, 3))
        return replace(self, torque=(lines + 2.0 * spline) / 3.0)

    def speed_and_rate(self, values: Array, band: float) -> tuple[Array, Array]:
        """Speed and acceleration below a bandwidth [Hz] of a channel, each of shape (samples,)."""
        low = zero_phase(values, self.interval, band)
        speed = low if self.rates else difference(low, self.interval)
        return speed, difference(speed, self.interval)

    def quick(self, values: Array, band: float) -> Array:
        """Speed that shows where a shaft turns round: filtered less than the equations are, (samples,)."""
        low = zero_phase(values, self.interval, min(SIGN_BANDS * band, 0.4 / self.interval))
        return low if self.rates else difference(low, self.interval)

    def noise(self, values: Array, band: float) -> Array:
        """Mean squares of a channel's noise and its first two derivatives below a bandwidth, shape (3,)."""
        level = noise_spectrum(values, self.interval)[2]
        f = np.linspace(0.0, min(4.0 * band, 0.5 / self.interval), 400)
        passed = level / (1.0 + (f / band) ** 8) ** 2
        return np.array([np.trapezoid(passed * (2.0 * pi * f) ** k, f) for k in (0, 2, 4)])

    def heard(self, values: Array) -> float:
        """1 where a feedback loop puts a channel's noise into the torque, coherent above the motion."""
        part, seen = min(HEARD, values.size // 8), np.lib.stride_tricks.sliding_window_view
        parts = (seen(np.diff(own), part)[:: part - part // 2] for own in (self.torque, values))
        window = signal.windows.hann(part, sym=False)
        a, b = (np.fft.rfft(window * (own - own.mean(axis=1, keepdims=True))) for own in parts)
        power, other = (np.mean(np.abs(own) ** 2, axis=0) for own in (a, b))
        shared = np.abs(np.mean(a.conj() * b, axis=0)) ** 2 / power / other
        mean = float(np.mean(np.nan_to_num(shared[np.fft.rfftfreq(part) > 0.25])))
        return float(mean - part / values.size > 0.01)


Equation = Callable[[TwoSides, float], tuple[tuple[Array, ...], Array, Array]]
"""Of a log at a bandwidth [Hz]: speeds by which rows are chosen, each (samples,); regressors and left side,
(samples, p + 1); what noise adds to the mean of their products, (p + 1, p + 1), in whose last row stands the
size of the noise of each that a feedback loop puts into the left side."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Solution:
    """An equation solved at one bandwidth."""

    fit: Fit
    beyond: Array  # (p,): what other bandwidths and the level of the noise may move, beside chance
    sizes: Array  # (p,): root mean square of each regressor
    kept: float  # share of the samples that is used
    band: float  # [Hz]
    equation: Equation | None = None
    heard: bool = False  # whether a feedback loop hears the noise: two bandwidths on are compared too

    @property
    def halves(self) -> Array:
        """Half widths of the 95 % intervals, shape (p,)."""
        return self.fit.half_width() + self.beyond

    def of(self, name: str) -> tuple[float, float]:
        """A coefficient and the half width of its interval."""
        place = self.fit.names.index(name)
        return float(self.fit.values[place]), float(self.halves[place])


def cogging_of(sides: Sequence[TwoSides], load: Solution | None) -> Cogging | None:
    """The torque that repeats with the motor's angle, if what the sum of torques leaves is mostly that."""
    if any(one.rates for one in sides):
        return None
    found = [_repeating(sides, load, band) for band in _bands(sides)]
    best = min((one for one in found if one is not None), key=lambda one: one[0], default=None)
    return None if best is None else best[1]


def _repeating(sides: Sequence[TwoSides], load: Solution | None, band: float) -> tuple[float, Cogging] | None:
    """The strongest repeating torque at a bandwidth [Hz], after the share of the residual that it leaves."""
    with suppress(InputRefused):
        plain = _solved(lambda one, at: _sum_columns(one, at, load), sides, SUM, band)
        if plain is None:
            return None
        turn, turns = np.zeros(BINS), 0.0
        for one in sides:
            quick, c, _ = _sum_columns(one, band, load)
            keep = _kept(one, quick, band)
            place, left = one.motor[keep] / (2.0 * pi), (c[:, -1] - c[:, :-1] @ plain.fit.values)[keep]
            turn += np.bincount(np.floor(BINS * place).astype(int) % BINS, left, BINS)
            turns = max(turns, float(np.ptp(place)))
        n = int(np.argmax(np.abs(np.fft.rfft(turn))[1 : MOST_PERIODS + 1])) + 1
        if turns < LEAST_TURNS or n * turns < (SOME_PERIODS if turns >= 1.0 else MANY_PERIODS):
            return None
        share, (cosine, sine), covariance = beside(
            sides, plain, lambda one: np.array([np.cos(n * one.motor), np.sin(n * one.motor)])
        )
        error = float(np.sqrt(np.linalg.eigvalsh(covariance)[-1]))
        made = Cogging(periods=n, cosine=float(cosine), sine=float(sine), error=error)
        return (share, made) if share < REPEATS and made.size > REPEATS_SURE * error else None
    return None


def beside(
    sides: Sequence[TwoSides], solution: Solution, more: Callable[[TwoSides], Array]
) -> tuple[float, Array, Array]:
    """Share of the residual's power that further regressors (m, samples) leave, their values, covariance."""
    parts, names, band = [], solution.fit.names, solution.band
    assert solution.equation is not None
    for one in sides:
        quick, columns, _ = solution.equation(one, band)
        added = zero_phase(more(one).T, one.interval, band)
        both = np.column_stack([columns[:, :-1], added, columns[:, -1]])
        all_names = (*names, *map(str, range(added.shape[1])))
        parts.append(_factored(both[_kept(one, quick, band)], all_names))
    whole, p = joined(parts), len(names)
    fit, plain = (solve(suited_segments(one)) for one in (whole, only(whole, names)))
    share = (fit.residual / plain.residual) ** 2 if plain.residual > 0.0 else 1.0
    return share, fit.values[p:], fit.covariance[p:, p:]


def load_equation(sides: Sequence[TwoSides]) -> Solution | None:
    """Solve the load's own equation; None where no twist is measured or the load hardly moves."""
    if not all(one.twisted for one in sides):
        return None
    try:
        return _narrowest(_load_columns, [replace(one, saturated=None) for one in sides], LOAD, LOAD[:1])
    except InputRefused:
        return None


def sum_equation(sides: Sequence[TwoSides], load: Solution | None) -> tuple[Solution, list[TwoSides], float]:
    """Solve the sum of torques; the sides at the instants of the angles, and how late these are [s]."""
    cogging, lag = cogging_of(sides, load), 0.0
    sides = [replace(one, cogging=cogging) for one in sides]
    for _ in range(2):  # the rate of the torque stands for its delay where that is small
        found = _narrowest(lambda one, band: _sum_columns(one, band, load), sides, SUM, SUM[:2])
        rest = found.of("lag")[0]
        sides, lag = [one.later(rest) for one in sides], lag + rest
    return found, sides, lag


def sum_at(sides: Sequence[TwoSides], load: Solution | None, band: float) -> Array:
    """Values of the sum of torques at one bandwidth [Hz], as for another share of the motor, shape (6,)."""
    found = _solved(lambda one, band: _sum_columns(one, band, load), sides, SUM, band)
    return np.full(len(SUM), np.nan) if found is None else found.fit.values


def _narrowest(
    equation: Equation, sides: Sequence[TwoSides], names: tuple[str, ...], wanted: Sequence[str]
) -> Solution:
    """The solution at the bandwidth that bounds the wanted parameters best."""
    found: list[Solution] = []
    refused = InputRefused(f"{sides[0].source}: noise alone is left of the motion: move the machine more")
    for band in _bands(sides):
        try:
            one = _solved(equation, sides, names, band)
        except InputRefused as refusal:
            refused = refusal
            continue
        found += [] if one is None else [one]
    if not found:
        raise refused
    for i, k in combinations(range(len(found)), 2):
        one, other = found[i], found[k]
        if k - i > (2 if one.heard else 1):
            continue
        by_chance = np.abs(one.fit.half_width() ** 2 - other.fit.half_width() ** 2)
        apart = np.sqrt(np.maximum((one.fit.values - other.fit.values) ** 2 - by_chance, 0.0))
        found[i] = replace(one, beyond=np.maximum(one.beyond, apart))
        found[k] = replace(other, beyond=np.maximum(other.beyond, apart))
    places = [names.index(name) for name in wanted]
    usual = np.median([np.abs(one.fit.values[places]) for one in found], axis=0)
    return min(found, key=lambda one: float(np.sum(one.halves[places] / np.maximum(usual, 1e-300))))


def _bands(sides: Sequence[TwoSides]) -> list[float]:
    """Bandwidths that the sample rates allow [Hz]."""
    return [band for band in BANDS if band <= max(0.1 / max(one.interval for one in sides), BANDS[0])]


def _solved(
    equation: Equation, sides: Sequence[TwoSides], names: tuple[str, ...], band: float
) -> Solution | None:
    """One bandwidth's solution without the share of the noise; None where little else is there."""
    p, parts, samples = len(names), [], []
    noise = np.zeros((p + 1, p + 1))
    for one in sides:
        quick, columns, own = equation(one, band)
        keep = _kept(one, quick, band)
        parts.append(_factored(columns[keep], names))
        samples.append(int(keep.sum()) * _step(one, band))
        noise = noise + parts[-1].rows * own
    factors = joined(parts)
    fit = solve(suited_segments(factors))
    power = np.einsum("bij,bik->jk", factors.triangles[:, :, :p], factors.triangles[:, :, :p])
    sizes = np.maximum(np.sqrt(np.diag(power) / factors.rows), 1e-300)
    # in units of the regressors, without the directions that the rows do not show
    shown = linalg.null_space(fit.unidentifiable * sizes) if len(fit.unidentifiable) else np.eye(p)
    basis = shown / sizes[:, None]
    whole = basis.T @ power @ basis
    true = whole - basis.T @ noise[:p, :p] @ basis
    if np.linalg.eigvalsh(true)[0] <= NOISE_ALONE * np.linalg.eigvalsh(whole)[0]:
        return None
    inverse = basis @ np.linalg.solve(true, basis.T)
    values = inverse @ (power @ fit.values - noise[:p, p])
    covariance = inverse @ power @ fit.covariance @ power @ inverse.T
    seconds = sum(count * one.interval for count, one in zip(samples, sides, strict=True))
    rows = max(2.0 * band * seconds - p, 1.0)
    plain = fit.residual**2 * fit.rows / rows * np.diag(inverse)
    grown = np.sqrt(np.maximum(plain / np.maximum(np.diag(covariance), 1e-300), 1.0))
    own = np.sqrt(fit.rows * np.diag(inverse))  # of what no other regressor can stand for
    beyond = UNMODELLED[names] * fit.scale * own + NOISE_SURE * np.abs(values - fit.values)
    beyond += np.abs(inverse) @ noise[p, :p] * fit.residual
    fit = replace(fit, values=values, covariance=covariance * np.outer(grown, grown))
    shares = [count / one.torque.size for count, one in zip(samples, sides, strict=True)]
    heard = bool(noise[p, :p].any())
    kept = float(np.average(shares, weights=[part.rows for part in parts]))
    return Solution(fit=fit, beyond=beyond, sizes=sizes, kept=kept, band=band, equation=equation, heard=heard)


def _sum_columns(one: TwoSides, band: float, load: Solution | None) -> tuple[tuple[Array, ...], Array, Array]:
    """The sum of torques, as an `Equation` has it."""
    h = one.interval
    viscous, coulomb = (load.of("viscous")[0], load.of("coulomb")[0]) if load is not None else (0.0, 0.0)
    speed, rate = one.speed_and_rate(one.motor, band)
    moved = one.noise(one.motor, band)
    if one.pulley is not None:
        rate = one.share * rate + (1.0 - one.share) * one.speed_and_rate(one.pulley, band)[1]
        moved = np.maximum(moved, one.noise(one.pulley, band)) * (one.share**2 + (1.0 - one.share) ** 2)
    turned, turned_rate = one.speed_and_rate(one.load, band)
    quick = one.quick(one.motor, band), one.quick(one.load, band)
    sign, own = (zero_phase(np.sign(q), h, band) for q in quick)
    behind = turned_rate + viscous * (turned - speed) + coulomb * (own - sign)
    acting = zero_phase(one.torque, h, band)
    left = acting if one.cogging is None else acting - zero_phase(one.cogging.at(one.motor), h, band)
    columns = [rate, behind, speed, sign, -np.ones(left.size), difference(acting, h), left]
    noise = np.zeros((7, 7))
    rank = 1 if one.rates else 2
    noise[0, 0], noise[1, 1] = moved[rank], one.noise(one.load, band)[rank]
    noise[2, 2] = moved[rank - 1]
    noise[-1, :3] = np.sqrt(np.diag(noise)[:3])
    noise[-1, :3] *= np.array([one.heard(values) for values in (one.motor, one.load)])[[0, 1, 0]]
    return quick, np.column_stack(columns), noise


def _load_columns(one: TwoSides, band: float) -> tuple[tuple[Array, ...], Array, Array]:
    """The load's equation in angles, or in speeds as its derivative, as an `Equation` has it."""
    h, near = one.interval, one.near
    first, load = zero_phase(near, h, band), zero_phase(one.load, h, band)
    turned = difference(load, h)
    quick = (one.quick(one.load, band),)
    sign = zero_phase(np.sign(quick[0]), h, band)
    columns = [first - load, difference(first, h) - turned, -turned]
    columns += [-(difference(sign, h) if one.rates else sign), np.ones(load.size), difference(turned, h)]
    noise, (n, m) = np.zeros((6, 6)), (one.noise(near, band), one.noise(one.load, band))
    noise[0, 0], noise[1, 1], noise[2, 2], noise[5, 5] = n[0] + m[0], n[1] + m[1], m[1], m[2]
    noise[1, 2] = noise[2, 1] = noise[0, 5] = noise[5, 0] = m[1]
    return quick, np.column_stack(columns), noise


def _factored(columns: Array, names: tuple[str, ...]) -> Factors:
    """Regressors with their left side last, in segments."""
    return factor(columns[:, :-1], columns[:, -1], names, max(12, min(SEGMENTS, len(columns) // 20)))


def _step(one: TwoSides, band: float) -> int:
    """Samples from row to row, as many as the filter leaves alike."""
    return max(1, int(0.02 / (band * one.interval)))


def _kept(one: TwoSides, quick: tuple[Array, ...], band: float) -> NDArray[np.bool_]:
    """Rows away from the ends, from standstill and from saturation, thinned; refused if they are few."""
    h, count = one.interval, quick[0].size
    reach = np.ones(max(3, int(0.5 / (band * h))))
    keep = np.convolve(np.min(np.abs(quick), axis=0) < one.slow, reach, "same") <= 0.5
    if one.saturated is not None:
        keep &= np.convolve(one.saturated, reach, "same") <= 0.5
    edge = int(2.0 / (band * h))
    keep &= np.arange(count) % _step(one, band) == 0
    keep[:edge] = keep[max(count - edge, 0) :] = False
    if (kept := int(keep.sum())) < FEWEST_ROWS:
        why = "little rotation, or saturated torque"
        raise InputRefused(f"{one.source}: {kept} samples can be used ({why}): record again, move it more")
    return np.asarray(keep)
