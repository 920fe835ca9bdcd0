r"""Output error of a lumped chain, from many starts, and what a reader of a fit has to doubt.

The chain moves by itself under the measured input; the parameters make the sum of squared differences between
measured and simulated outputs least,

.. math:: \min_p \sum_{\text{records}} \sum_k |y_k - h(x_k(p))|^2,

by bounded nonlinear least squares with the exact sensitivities of the integration. Positive parameters are
searched in the logarithm, and have the intervals of their logarithm,

.. math:: [\hat p\,e^{-t s/\hat p},\; \hat p\,e^{+t s/\hat p}],

which never reach below zero; others are symmetric.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy import optimize, stats

from cabledrive.identification.chain_model import ChainModel, Record
from cabledrive.identification.estimates import Finding
from cabledrive.identification.regression import factor, joined, solve, suited_segments
from cabledrive.identification.signals import difference, zero_phase
from cabledrive.parameters import InputRefused, NotComputed
from cabledrive.parameters.arrays import Array

MOST_EVALUATIONS, SCOUT_EVALUATIONS = 200, 12
"""Of a fit, and of a start that is only compared with others."""
SEGMENTS = 240
FAR, RUN_AWAY = 1e3, 1e6
"""Residual of parameters under which the motion diverges: of a fit in sizes of the output, of a start."""
SCOUTED, SETTLED = 1000, 4000
"""Samples of each record by which starts, and the fits of the best of them, are compared, in twice as long
steps as the whole, to which the best is then fitted."""
FULL = 2
"""Starts that are fitted to more than the first samples."""
ENOUGH = 1e-6
"""Relative change of the squares at which the fit of all rows ends: far below what chance moves."""
ALIKE = 1e-3
"""Relative distance of residuals at which two fits count as one minimum."""
STARTS = 12
LOW_SHARE, HIGH_SHARE = 0.1, 0.9
"""Shares of the total inertia that the motor may have at the start."""
FASTEST = 0.2
"""Highest resonance of a start, in samples."""
NEAR = 0.01
"""Distance to a bound, in the logarithm or in the range, that counts as having reached it."""
SIGNIFICANT, LARGE, LAGS = 1e-4, 0.1, 20
"""Chance of a correlation as large as that of the residual, if it were white; correlation that matters
whatever the number of samples; lags that are looked at."""
EXCITED = 0.99
"""Share of the input's power below the frequency to which a log is said to excite."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ChainFit:
    """Parameters of a lumped chain from its records."""

    model: ChainModel
    values: dict[str, float]
    covariance: Array  # (p, p): from scores of segments of time, so that coloured residuals count
    freedom: int  # degrees of freedom of intervals
    residual: float  # root mean square

    @property
    def errors(self) -> dict[str, float]:
        """Standard errors."""
        return dict(zip(self.values, np.sqrt(np.diag(self.covariance)).tolist(), strict=True))

    def simulated(self, record: Record) -> Array:
        """Outputs of the model under the input of a record, shape (samples, channels)."""
        return self.model.outputs(self.values, record)

    def interval_of(self, name: str) -> tuple[float, float]:
        """95 % interval of one parameter."""
        half = float(stats.t.ppf(0.975, max(1, self.freedom))) * self.errors[name]
        value = self.values[name]
        if not self.model.positive[self.model.names.index(name)]:
            return value - half, value + half
        share = min(half / value, 700.0)
        return value * float(np.exp(-share)), value * float(np.exp(share))

    def at_bounds(self) -> dict[str, float]:
        """Parameters that the search left at a bound, with that bound."""
        found: dict[str, float] = {}
        for s, positive in zip(self.model.free, self.model.positive, strict=True):
            for bound in (s.low, s.high):
                reach = NEAR * bound if positive else NEAR * (s.high - s.low)
                if abs(self.values[s.name] - bound) <= abs(reach):
                    found[s.name] = bound
        return found

    def undetermined(self) -> list[str]:
        """Parameters whose standard error is above their value; offsets may be zero."""
        names = (name for name, positive in zip(self.values, self.model.positive, strict=True) if positive)
        return [name for name in names if not self.errors[name] <= abs(self.values[name])]

    def doubts(self, records: Sequence[Record], first_lag: int = 1) -> list[Finding]:
        """Findings "at-bound", "undetermined", "residual-not-white".

        ``first_lag``: from which on the residual must be white; what a sensor or a difference correlates lies
        below it. Its correlation is judged by the portmanteau statistic of Ljung and Box.
        """
        found = []
        for name, bound in self.at_bounds().items():
            words = f"{name} ends at the bound {bound:.4g} of its search: no interval"
            found.append(Finding("at-bound", words))
        for name in self.undetermined():
            words = f"its standard error {self.errors[name]:.3g} is above its value {self.values[name]:.3g}"
            found.append(Finding("undetermined", f"{name} is not determined: {words}"))
        largest, chance, lags = 0.0, 1.0, np.arange(first_lag, first_lag + LAGS)
        for record in records:
            off = self.simulated(record) - record.output
            for residual in (off - off.mean(axis=0)).T:
                n, power = residual.size, float(residual @ residual)
                if power > 0.0 and n >= 4 * (first_lag + LAGS):
                    r = np.array([float(residual[k:] @ residual[:-k]) / power for k in lags])
                    q = n * (n + 2) * float(np.sum(r**2 / (n - lags)))
                    largest = max(largest, float(np.abs(r).max()))
                    chance = min(chance, float(stats.chi2.sf(q, LAGS)))
        if chance < SIGNIFICANT and largest > LARGE:
            words = (
                f"the residual is correlated with its past (up to {largest:.2f}): an effect that the model "
                "lacks acts on the machine, and the intervals are valid only for the model as given"
            )
            found.append(Finding("residual-not-white", words))
        return found


def _searched(
    records: Sequence[Record], model: ChainModel, start: Mapping[str, float], far: float, **ending: Any
) -> optimize.OptimizeResult:
    """Least squares from a start; ``far``: residual of parameters under which the motion diverges."""
    place, *bounds = model.search_bounds(model.inside(start))
    known: dict[bytes, tuple[Array, Array]] = {}

    def compared(at: Array) -> tuple[Array, Array]:
        key = at.tobytes()
        if key not in known:
            known.clear()
            residuals, slopes = zip(*(model.compared(at, record) for record in records), strict=True)
            known[key] = np.concatenate(residuals), np.vstack(slopes)
        return known[key]

    def residual(at: Array) -> Array:
        try:
            return compared(at)[0]
        except NotComputed:
            return np.full(sum(r.output.size for r in records), far)

    compared(place)
    return optimize.least_squares(
        residual, place, jac=lambda at: compared(at)[1], bounds=bounds, x_scale="jac", **ending
    )


def fit_output_error(
    records: Sequence[Record], model: ChainModel, start: Mapping[str, float], *, tolerance: float = 1e-8
) -> ChainFit:
    """Fit a chain to several records from a value for each parameter; `NotComputed` if it does not settle."""
    size = _size([r.output.ravel() for r in records])
    found = _searched(records, model, start, FAR * size, max_nfev=MOST_EVALUATIONS, ftol=tolerance)
    if found.status == 0:
        raise NotComputed(
            f"output error has not converged after {MOST_EVALUATIONS} evaluations: start nearer, or allow "
            "more"
        )
    count, parts = max(12, SEGMENTS // len(records)), []
    for record in records:
        residual, sensitivities = model.compared(found.x, record)
        parts.append(factor(-sensitivities, residual, model.names, min(count, residual.size // 20)))
    fit, by_value = solve(suited_segments(joined(parts))), model.slopes(found.x)
    return ChainFit(
        model=model,
        values=model.values_at(found.x),
        covariance=fit.covariance * by_value[:, None] * by_value,
        freedom=fit.freedom,
        residual=float(np.sqrt(np.mean(found.fun**2))),
    )


@np.errstate(over="ignore", invalid="ignore")  # of starts from which the motion grows beyond all bounds
def fit_from_many_starts(
    records: Sequence[Record],
    models: Sequence[ChainModel],
    starts: Sequence[Mapping[str, float]],
    say: Callable[[str], None],
) -> tuple[ChainFit, int, int]:
    """Fit from every start what the first samples show, the best to more of them, the best of those to all.

    ``models``: with the same parameters, as with another hold of the input; the best start is tried in each.
    Returns the fit, and of the fits in the first model how many were made and how many ended in one minimum.
    Raises `NotComputed` if no start leads anywhere.
    """
    short, middle = [r.begun(SCOUTED) for r in records], [r.begun(SETTLED) for r in records]
    quick = [replace(model, substeps=max(1, model.substeps // 2)) for model in models]
    scouts: list[tuple[float, dict[str, float]]] = []
    for k, start in enumerate(starts):
        say(f"two inertias: start {k + 1} of {len(starts)}")
        try:
            tried = _searched(short, quick[0], start, RUN_AWAY, max_nfev=SCOUT_EVALUATIONS)
        except (InputRefused, NotComputed, ValueError):
            continue
        scouts.append((float(tried.cost), quick[0].values_at(tried.x)))
    scouts.sort(key=lambda entry: entry[0])
    fits: list[tuple[ChainFit, ChainModel]] = []
    own: list[float] = []
    for model, coarse in zip(models, quick, strict=True):
        for _, start in scouts[: FULL if model is models[0] else 1]:
            say(f"two inertias: fit {len(fits) + 1} of the best starts")
            begin = fits[0][0].values if model is not models[0] and fits else start
            try:
                fits.append((fit_output_error(middle, coarse, begin), model))
            except NotComputed:
                continue
            own += [fits[-1][0].residual] if model is models[0] else []
    if not fits:
        raise NotComputed(f"none of {len(starts)} starts leads to a model that reproduces the log")
    best, model = min(fits, key=lambda entry: entry[0].residual)
    near = sum(residual < min(own) * (1.0 + ALIKE) for residual in own)
    say(f"two inertias: the best fit over all {sum(r.input.size for r in records)} rows")
    return fit_output_error(records, model, best.values, tolerance=ENOUGH), len(own), near


def excited_to(records: Sequence[Record]) -> float:
    """Frequency [Hz] below which nearly all power of the input lies, of the log that reaches highest."""
    found = []
    for record in records:
        power = np.abs(np.fft.rfft(record.input - record.input.mean())) ** 2
        place = int(np.searchsorted(np.cumsum(power), EXCITED * power.sum()))
        found.append(place / (record.input.size * record.interval))
    return max(found)


def starts_for(
    records: Sequence[Record], rectified: bool, rng: np.random.Generator
) -> tuple[dict[str, float], list[dict[str, float]]]:
    """Scales of the log, and starts for two inertias: a rigid axis's totals, the rest drawn."""
    total, viscous, coulomb = _rigid(records, rectified)
    interval = records[0].interval
    duration = max(record.interval * record.input.size for record in records)
    low, high = max(0.5, 10.0 / duration), FASTEST / interval
    starts = []
    for k in range(STARTS):
        share = LOW_SHARE + (HIGH_SHARE - LOW_SHARE) * float(rng.uniform())
        # low frequencies first: stratified, so that no octave is left out
        omega = 2 * np.pi * low * (high / low) ** ((k + float(rng.uniform())) / STARTS)
        reduced = total * share * (1.0 - share)
        start = {"inertia_motor": share * total, "inertia_load": (1.0 - share) * total}
        start |= {"stiffness": reduced * omega**2, "damping": 0.06 * reduced * omega}
        for side in ("motor", "load"):
            start[f"viscous_friction_{side}"] = 0.5 * viscous
            start[f"coulomb_friction_{side}"] = 0.5 * coulomb
        starts.append(start | {"offset": 0.0, "sensor_lag": 2.0 * interval})
    middle = 2 * np.pi * np.sqrt(low * high)
    scale = {
        "inertia": total,
        "stiffness": total * middle**2,
        "damping": total * middle,
        "viscous": max(viscous, 1e-3 * total / interval),
        "coulomb": _size([record.input for record in records]),
    }
    return scale, starts


def _rigid(records: Sequence[Record], rectified: bool) -> tuple[float, float, float]:
    """Total inertia, viscous and Coulomb friction of one rigid axis, all positive."""
    rows, left = [], []
    for record in records:
        speed, input_, h = record.output[:, 0], record.input, record.interval
        if rectified:
            speed = speed * np.where(zero_phase(input_, h, 0.02 / h) < 0, -1.0, 1.0)
        smooth = zero_phase(speed, h, 0.05 / h)
        jump = np.tanh(smooth / (0.05 * np.abs(smooth).max() + 1e-300))
        rows.append(np.column_stack([difference(smooth, h), smooth, jump, np.ones(smooth.size)]))
        left.append(zero_phase(input_, h, 0.05 / h))
    found = np.linalg.lstsq(np.vstack(rows), np.concatenate(left), rcond=None)[0]
    size, force = _size([r.output.ravel() for r in records]), _size(left)
    rate = _size([row[:, 0] for row in rows])
    total = float(found[0]) if found[0] > 1e-3 * force / rate else force / rate
    return total, max(float(found[1]), 1e-3 * force / size), max(float(found[2]), 1e-3 * force)


def _size(parts: Sequence[Array]) -> float:
    return float(np.sqrt(np.mean(np.concatenate(parts) ** 2)))
