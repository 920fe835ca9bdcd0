r"""Models fitted to a measured response: Models 1 to 4 with the choice among them, and a current amplifier.

The chain's response from torque to motor speed is matched in the complex plane, weighted by the measured
deviation,

.. math:: \min_p \sum_k \Big|\frac{H(\omega_k) - H(\omega_k; p)}{\sigma_k}\Big|^2,

by bounded nonlinear least squares in the logarithms of the parameters. Since Models 1 to 3 are limits of
Model 4, they are compared by Akaike's criterion on the same data.

The amplifier with its current loop, section 4.4, is a gain with a first-order lag and a dead time,

.. math:: \frac{\tau}{V}(s) = \frac{g\,e^{-sD}}{1 + s/(2\pi f_b)},

seen through a command that stands from sample to sample (and, where the torque is logged as its mean over an
interval, through that mean): the responses of both are summed over all aliases of a line. "Essentially a
constant gain", (4.20), is what is left where the lag lies far above the measured band.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from math import log10, pi

import numpy as np
from scipy import optimize, stats

from cabledrive.answers.figures import figure
from cabledrive.answers.result import Result
from cabledrive.identification.estimates import FEWEST_SEGMENTS, Estimate, factor, solve
from cabledrive.identification.logs.log import Log
from cabledrive.identification.signals import FrequencyResponse, response_by_segments
from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array, Complex
from cabledrive.reduction.lumped_chain import LumpedChain, speed_response

_JOINT, _CABLE = ("joint_stiffness", "joint_damping"), ("cable_stiffness", "cable_damping")
PARAMETERS = {
    1: ("inertia", "viscous_friction"),
    2: ("motor_inertia", "load_inertia", "viscous_friction", *_JOINT),
    3: ("drive_inertia", "load_inertia", "viscous_friction", *_CABLE),
    4: ("motor_inertia", "drive_inertia", "load_inertia", "viscous_friction", *_JOINT, *_CABLE),
}
MOST_EVALUATIONS = 60
MOST_AKAIKE = 30.0
SPREAD = 1e4
"""Each parameter may move by this factor from its start, either way."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False, repr=False)
class ResponseFit(Result):
    """One model fitted to a response."""

    _heading, _table = "model {0.model}", "names: values errors"
    model: int  # {1, 2, 3, 4}
    names: tuple[str, ...]  # parameters that were fitted
    # values, errors: (p,): estimates, and standard errors, scaled by a misfit above 1
    values: Array
    errors: Array
    fixed: dict[str, float]  # parameters that were given
    misfit: float = figure("1", "misfit over the noise, root mean square", "Fit")
    criterion: float = figure("1", "Akaike's criterion, smaller is better", "Fit")
    freedom: int

    def __getitem__(self, name: str) -> float:
        return float(self.values[self.names.index(name)]) if name in self.names else self.fixed[name]

    def bounds(self, name: str, level: float = 0.95) -> tuple[float, float]:
        """Interval of one parameter, on the logarithm, so always positive."""
        k = self.names.index(name)
        width = float(stats.t.ppf(0.5 + level / 2, self.freedom) * self.errors[k] / self.values[k])
        low, high = self.values[k] * np.exp(np.clip([-width, width], -500.0, 500.0))
        return float(low), float(high)


def chain_for(model: int, values: Mapping[str, float], radius: float) -> LumpedChain:
    """The lumped chain of a model, both radii [m] alike, two spans as in (6.11), (6.13)."""
    inertias = [values[name] for name in PARAMETERS[model] if name.endswith("inertia")]
    pairs = []
    if "joint_stiffness" in PARAMETERS[model]:
        pairs.append((values["joint_stiffness"], values["joint_damping"]))
    if "cable_stiffness" in PARAMETERS[model]:
        pairs.append((2 * values["cable_stiffness"] * radius**2, 2 * values["cable_damping"] * radius))
    n = len(inertias)
    return LumpedChain(
        names=tuple(f"inertia {k}" for k in range(n)),
        inertias=tuple(inertias),
        viscous=(values["viscous_friction"], *(0.0,) * (n - 1)),
        coulomb=(0.0,) * n,
        offsets=(0.0,) * n,
        stiffness=tuple(pair[0] for pair in pairs),
        damping=tuple(pair[1] for pair in pairs),
        ratios=((1.0, 1.0),) * (n - 1),
    )


def _matched(
    model: Callable[[Array], Complex],
    measured: FrequencyResponse,
    least: Array | float,
    begin: Array,
    reach: Array | tuple[Array, Array],
    most: int,
) -> tuple[optimize.OptimizeResult, Callable[[Array], Array]]:
    """Weighted least squares in the complex plane, and the residual (2 m,); ``reach``: or bounds."""
    weight = 1.0 / np.maximum(measured.deviation, least)

    def residual(x: Array) -> Array:
        off = (model(x) - measured.response) * weight
        return np.concatenate([off.real, off.imag])

    limits = reach if isinstance(reach, tuple) else (begin - reach, begin + reach)
    found = optimize.least_squares(residual, begin, bounds=limits, x_scale="jac", max_nfev=most)
    return found, residual


def _claimed(slopes: Array, scale: float) -> Array:
    """Standard errors (p,) that the weights claim; each part of a response carries half the variance."""
    inverse = np.linalg.pinv(np.linalg.qr(slopes, mode="r"), rcond=1e-12)
    return np.sqrt(0.5 * scale * (inverse**2).sum(axis=1))


def fit_response(
    measured: FrequencyResponse,
    model: int,
    start: Mapping[str, float],
    *,
    radius: float = 1.0,
    fixed: Mapping[str, float] | None = None,
) -> ResponseFit:
    """Fit a Model to a response [rad/(N m s)]; ``start``: rough values; ``radius``: of both pulleys [m]."""
    fixed = dict(fixed or {})
    names = tuple(name for name in PARAMETERS[model] if name not in fixed)
    if 2 * measured.frequency.size <= len(names) + 2:
        raise InputRefused(f"{measured.frequency.size} lines are few for {len(names)} parameters: add some")
    omega = 2 * np.pi * measured.frequency

    def response_at(logs: Array) -> Complex:
        values = fixed | dict(zip(names, np.exp(logs), strict=True))
        return speed_response(chain_for(model, values, radius), omega)

    begin, least = np.log([start[name] for name in names]), 1e-3 * float(np.abs(measured.response).min())
    found, _ = _matched(response_at, measured, least, begin, np.log(SPREAD), MOST_EVALUATIONS)
    rows, p = found.jac.shape
    freedom = max(1, rows - p)
    squares, values = 2.0 * float(found.fun @ found.fun), np.exp(found.x)
    return ResponseFit(
        model=model,
        names=names,
        values=values,
        errors=values * _claimed(found.jac, max(1.0, squares / freedom)),
        fixed=fixed,
        misfit=float(np.sqrt(squares / freedom)),
        criterion=float(rows * np.log(squares / rows) + 2 * p),
        freedom=freedom,
    )


def choose_model(
    measured: FrequencyResponse,
    start: Mapping[str, float],
    *,
    radius: float = 1.0,
    inertias_known: bool = False,
) -> ResponseFit:
    """Fit of the Model, 1 to 4, that a response calls for.

    From the motor's side Models 2 and 3 are one and the same two inertias; only known inertias distinguish
    them.

    Parameters
    ----------
    measured : FrequencyResponse
    start : mapping of str to float
        Rough values for Model 4; the others lump them.
    radius : float, default 1.0
        [m].
    inertias_known : bool, default False
        Whether the inertias of ``start`` are known, from bench tests, and held.

    Returns
    -------
    ResponseFit
        Of the simplest model whose criterion is at most 30 above the least.
    """
    motor, drive, load = (start[f"{name}_inertia"] for name in ("motor", "drive", "load"))
    lumps: dict[int, dict[str, float]] = {
        1: {"inertia": motor + drive + load},
        2: {"load_inertia": drive + load},
        3: {"drive_inertia": motor + drive},
        4: {},
    }
    fits = []
    for model, lumped in lumps.items():
        rough = {name: (dict(start) | lumped)[name] for name in PARAMETERS[model]}
        fixed = {name: rough[name] for name in rough if inertias_known and name.endswith("inertia")}
        fits.append(fit_response(measured, model, rough, radius=radius, fixed=fixed))
    least = min(fit.criterion for fit in fits)
    return min((fit for fit in fits if fit.criterion <= least + MOST_AKAIKE), key=lambda fit: len(fit.names))


ALIASES, FEWEST_LINES = 60, 6
"""Of a line, either way; lines of an amplifier's response at least."""
HIGHEST_SHARE = 0.4
"""Of the sample rate: the highest line that is fitted."""
LEAST_COHERENCE = 0.5
T_SQUARED = 4.0
"""Rise of the weighted squares, per part of the response, at the end of a 95 % interval."""
GROUP, MOST_GROUPS = 4, 30
"""Lines at least whose scores are summed, as a line shares its noise with its neighbours; groups at most."""
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
    frequency: Array, gain: float, bandwidth: float, delay: float, interval: float = 0.0
) -> Complex:
    """Response (m,) of a torque, the mean over ``interval`` [s], to a command held for it; 0: neither."""
    shifts = np.arange(-ALIASES, ALIASES + 1, dtype=np.float64) / interval if interval > 0.0 else np.zeros(1)
    f = frequency[:, None] + shifts
    lag = 1.0 / (1.0 + 1j * f / bandwidth)
    hold = np.sinc(f * interval) * np.exp(-1j * pi * f * interval)
    return gain * np.sum(lag * hold * np.sinc(f * interval) * np.exp(-2j * pi * f * delay), axis=1)


def fit_amplifier(measured: FrequencyResponse, interval: float = 0.0) -> AmplifierFit:
    """Gain, bandwidth and dead time by weighted complex least squares, from a response [N m/V]."""
    count = measured.frequency.size
    if count < FEWEST_LINES:
        raise InputRefused(f"{count} lines are too few for an amplifier: give at least {FEWEST_LINES}")
    top, least = float(measured.frequency[-1]), 1e-6 * np.abs(measured.response)

    def response_at(x: Array) -> Complex:
        return amplifier_response(measured.frequency, np.exp(x[0]), np.exp(x[1]), x[2] / top, interval)

    size = np.log(np.abs(measured.response[: max(3, count // 10)]).mean())
    limits = np.array([size - 3, np.log(0.01 * top), -3.0]), np.array([size + 3, np.log(FARTHEST * top), 3.0])
    begin = np.array([size, np.log(3.0 * top), 0.0])
    found, residual = _matched(response_at, measured, least, begin, limits, 100)
    squares, freedom = 2.0 * float(found.fun @ found.fun), 2 * count - 3
    misfit, scale = float(np.sqrt(squares / freedom)), max(1.0, squares / freedom)
    # Lines share noise through their window, and their weights are estimates: the squares alone show neither.
    groups = min(MOST_GROUPS, count // GROUP)
    if groups < FEWEST_SEGMENTS:
        errors = _claimed(found.jac, scale)
    else:
        by_line = np.arange(2 * count).reshape(2, count).T.ravel()
        fit = solve(factor(found.jac[by_line], -found.fun[by_line], ("gain", "bandwidth", "delay"), groups))
        errors, freedom = np.sqrt(np.diag(fit.covariance)), fit.freedom
    t, x, findings = float(stats.t.ppf(0.975, freedom)), found.x, []
    bandwidth = _exponential(x[1], errors[1], t, "Hz")
    if t * errors[1] > 1.0 or x[1] > np.log(0.9 * FARTHEST * top):
        lowest = _least_bandwidth(residual, x, found.cost + 0.25 * T_SQUARED * scale, top)
        findings = [f"a constant gain up to {top:.4g} Hz: its bandwidth lies above {lowest:.4g} Hz"]
        bandwidth = replace(Estimate.unknown("Hz", findings[0]), low=lowest)
    return AmplifierFit(
        gain=_exponential(x[0], errors[0], t, "N m/V"),
        bandwidth=bandwidth,
        delay=Estimate.of(x[2] / top, "s", errors[2] / top, t * float(errors[2]) / top),
        misfit=misfit,
        findings=tuple(findings),
    )


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
    log: Log, *, command: str = "command_voltage", torque: str = "torque", segment: float = 0.5
) -> AmplifierFit:
    """Gain and bandwidth from channels of a held command and a mean torque; ``segment``: of windows [s]."""
    found = response_by_segments(
        log.channel(command), log.channel(torque), log.interval, (segment, 0.5 * segment)
    )
    kept = found.between(1.5 / segment, HIGHEST_SHARE * log.sample_rate).independent(LEAST_COHERENCE)
    return fit_amplifier(replace(kept, deviation=kept.noise), log.interval)  # it has no peaks


def _exponential(log_value: float, log_error: float, t: float, unit: str) -> Estimate:
    """An estimate whose logarithm was fitted."""
    value, factor = float(np.exp(log_value)), float(np.exp(min(t * log_error, 50.0)))
    error = value * float(log_error)
    return Estimate(value=value, unit=unit, standard_error=error, low=value / factor, high=value * factor)
