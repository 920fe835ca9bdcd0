r"""Gain and bandwidth of a current amplifier from its response, section 4.4.

The amplifier with its current loop is a gain with a first-order lag and a dead time,

.. math:: \frac{\tau}{V}(s) = \frac{g\,e^{-sD}}{1 + s/(2\pi f_b)},

seen through a command that stands from sample to sample (and, where the torque is logged as its mean over an
interval, through that mean): the responses of both are summed over all aliases of a line. "Essentially a
constant gain", (4.20), is what is left where the lag lies far above the measured band.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import log10, pi

import numpy as np
from scipy import optimize, stats

from cabledrive.identification.estimates import Estimate
from cabledrive.identification.frequency_response import FrequencyResponse, response_by_segments
from cabledrive.identification.log_response import independent_lines
from cabledrive.identification.logs.log import Log
from cabledrive.identification.regression import FEWEST_SEGMENTS, factor, solve
from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array, Complex

ALIASES = 60
FEWEST_LINES = 6
HIGHEST_SHARE = 0.4
"""Of the sample rate: the highest line that is fitted."""
LEAST_COHERENCE = 0.5
T_SQUARED = 4.0
"""Rise of the weighted squares, per part of the response, at the end of a 95 % interval."""
GROUP = 4
"""Lines at least whose scores are summed; a line shares its noise with its neighbours alone."""
MOST_GROUPS = 30
FARTHEST = 300.0
"""Bandwidth over the highest line above which it is not identifiable."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class AmplifierFit:
    """An amplifier as its response shows it."""

    gain: Estimate  # [N m/V]
    bandwidth: Estimate  # [Hz]; without a value where the lag lies too far above the band
    delay: Estimate  # [s]
    misfit: float  # root mean square of the weighted residual; 1 where the model explains all but the noise
    findings: tuple[str, ...] = ()

    @property
    def decibels(self) -> float:
        """The gain in dB, as (4.20) states it."""
        return 20.0 * log10(self.gain.value)


def amplifier_response(
    frequency: Array,
    gain: float,
    bandwidth: float,
    delay: float,
    *,
    held: float = 0.0,
    averaged: float = 0.0,
) -> Complex:
    """Response (m,) from command to logged torque at frequencies [Hz]; a bandwidth [Hz] may be infinite.

    ``held``: time for which each command stands [s], 0: it is continuous; ``averaged``: interval, centred on
    the time stamp, over which a torque is the mean [s], 0: an instant; ``gain`` [N m/V], ``delay`` [s].
    """
    shifts = np.arange(-ALIASES, ALIASES + 1, dtype=np.float64) / held if held > 0.0 else np.zeros(1)
    f = frequency[:, None] + shifts
    lag = 1.0 / (1.0 + 1j * f / bandwidth)
    hold = np.sinc(f * held) * np.exp(-1j * pi * f * held)
    return gain * np.sum(lag * hold * np.sinc(f * averaged) * np.exp(-2j * pi * f * delay), axis=1)


def fit_amplifier(measured: FrequencyResponse, *, held: float = 0.0, averaged: float = 0.0) -> AmplifierFit:
    """Gain, bandwidth and dead time by weighted complex least squares, from a response [N m/V]."""
    count = measured.frequency.size
    if count < FEWEST_LINES:
        raise InputRefused(f"{count} lines are too few for an amplifier: give at least {FEWEST_LINES}")
    weight = 1.0 / np.maximum(measured.deviation, 1e-6 * np.abs(measured.response))
    top = float(measured.frequency[-1])

    def residual(x: Array) -> Array:
        model = amplifier_response(
            measured.frequency, np.exp(x[0]), np.exp(x[1]), x[2] / top, held=held, averaged=averaged
        )
        off = (model - measured.response) * weight
        return np.concatenate([off.real, off.imag])

    begin = np.array(
        [np.log(np.abs(measured.response[: max(3, count // 10)]).mean()), np.log(3.0 * top), 0.0]
    )
    limits = [begin[0] - 3, np.log(0.01 * top), -3.0], [begin[0] + 3, np.log(FARTHEST * top), 3.0]
    found = optimize.least_squares(residual, begin, bounds=limits, x_scale="jac", max_nfev=100)
    freedom = 2 * count - 3
    squares = 2.0 * float(found.fun @ found.fun)  # each part of the response carries half the variance
    scale = max(1.0, squares / freedom)
    errors, freedom_of_errors = _errors(found.jac, found.fun, scale)
    least = _least_bandwidth(residual, found.x, found.cost + 0.25 * T_SQUARED * scale, top)
    return _fit(found.x, errors, freedom_of_errors, (top, least), float(np.sqrt(squares / freedom)))


def _errors(slopes: Array, residual: Array, scale: float) -> tuple[Array, int]:
    """Standard errors with their degrees of freedom, from the scores of groups of neighbouring lines.

    Lines share noise through their window, and their weights are estimates: the squares alone show neither.
    With too few lines for `FEWEST_SEGMENTS` groups the errors are those that the weights claim.
    """
    count = residual.size // 2
    groups = min(MOST_GROUPS, count // GROUP)
    if groups < FEWEST_SEGMENTS:
        inverse = np.linalg.pinv(np.linalg.qr(slopes, mode="r"), rcond=1e-12)
        return np.sqrt(0.5 * scale * (inverse**2).sum(axis=1)), 2 * count - slopes.shape[1]
    by_line = np.arange(2 * count).reshape(2, count).T.ravel()
    fit = solve(factor(slopes[by_line], -residual[by_line], ("gain", "bandwidth", "delay"), groups))
    return np.sqrt(np.diag(fit.covariance)), fit.freedom


def _least_bandwidth(residual: Callable[[Array], Array], x: Array, cost: float, top: float) -> float:
    """Lowest bandwidth at which gain and delay still make up for it: where the cost passes its bound."""
    lowest = float(np.exp(x[1]))
    for trial in np.geomspace(lowest, 0.1 * top, 80)[1:]:
        start = [x[0], x[2]]

        def held(pair: Array, log_trial: float = float(np.log(trial))) -> Array:
            return residual(np.array([pair[0], log_trial, pair[1]]))

        if optimize.least_squares(held, start, x_scale="jac", max_nfev=15).cost > cost:
            break
        lowest = float(trial)
    return lowest


def identify_amplifier(
    log: Log,
    *,
    command: str = "command_voltage",
    torque: str = "torque",
    segment: float = 0.5,
    held: bool = True,
    averaged: bool = True,
) -> AmplifierFit:
    """Gain and bandwidth from a log with channels of command and torque.

    ``segment``: length of the Hann windows [s]; ``held``: whether the command stands from sample to sample;
    ``averaged``: whether the torque is logged as its mean over a sample's interval.
    """
    found = response_by_segments(
        log.channel(command), log.channel(torque), log.interval, segment=segment, overlap=0.5 * segment
    )
    kept = independent_lines(found.between(1.5 / segment, HIGHEST_SHARE * log.sample_rate), LEAST_COHERENCE)
    interval = log.interval
    return fit_amplifier(kept, held=interval if held else 0.0, averaged=interval if averaged else 0.0)


def _fit(x: Array, errors: Array, freedom: int, band: tuple[float, float], misfit: float) -> AmplifierFit:
    t = float(stats.t.ppf(0.975, freedom))
    top, least = band
    findings = []
    bandwidth = _exponential(x[1], errors[1], t, "Hz")
    if t * errors[1] > 1.0 or x[1] > np.log(0.9 * FARTHEST * top):
        reason = f"a constant gain up to {top:.4g} Hz: its bandwidth lies above {least:.4g} Hz"
        bandwidth = Estimate(
            value=float("nan"),
            unit="Hz",
            standard_error=float("inf"),
            low=least,
            high=float("inf"),
            reason=reason,
        )
        findings.append(reason)
    delay, error = float(x[2]) / top, float(errors[2]) / top
    return AmplifierFit(
        gain=_exponential(x[0], errors[0], t, "N m/V"),
        bandwidth=bandwidth,
        delay=Estimate(
            value=delay, unit="s", standard_error=error, low=delay - t * error, high=delay + t * error
        ),
        misfit=misfit,
        findings=tuple(findings),
    )


def _exponential(log_value: float, log_error: float, t: float, unit: str) -> Estimate:
    """An estimate whose logarithm was fitted."""
    value = float(np.exp(log_value))
    factor = float(np.exp(min(t * log_error, 50.0)))
    return Estimate(
        value=value,
        unit=unit,
        standard_error=value * float(log_error),
        low=value / factor,
        high=value * factor,
    )
