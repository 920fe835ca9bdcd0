r"""Doubts about a fit of a lumped chain: bounds hit, errors above values, a residual that is not white.

Intervals of what is positive are those of its logarithm,

.. math:: [\hat p\,e^{-t s/\hat p},\; \hat p\,e^{+t s/\hat p}],

which never reach below zero; others are symmetric.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from cabledrive.identification.chain_model import Record
from cabledrive.identification.output_error import RowFit

Array = NDArray[np.float64]

NEAR = 0.01
"""Distance to a bound, in the logarithm or in the range, that counts as having reached it."""
SIGNIFICANT = 1e-4
"""Chance of a correlation as large as that of the residual, if it were white."""
LARGE = 0.1
"""Correlation that matters whatever the number of samples."""
LAGS = 20


def interval_of(fit: RowFit, name: str, level: float = 0.95) -> tuple[float, float]:
    """Interval of one parameter."""
    t = float(stats.t.ppf(0.5 + level / 2, max(1, fit.freedom)))
    value, error = fit.values[name], fit.errors[name]
    positive = next(s.positive for s in fit.model.free if s.name == name)
    if not positive:
        return value - t * error, value + t * error
    share = min(t * error / value, 700.0)
    return value * float(np.exp(-share)), value * float(np.exp(share))


def at_bounds(fit: RowFit) -> dict[str, float]:
    """Parameters that the search left at a bound.

    Returns the bound of each.
    """
    found: dict[str, float] = {}
    for s in fit.model.free:
        value = fit.values[s.name]
        for bound in (s.low, s.high):
            reach = NEAR * bound if s.positive else NEAR * (s.high - s.low)
            if abs(value - bound) <= abs(reach):
                found[s.name] = bound
    return found


def undetermined(fit: RowFit) -> tuple[str, ...]:
    """Parameters whose standard error is above their value.

    Returns offsets and initial values are not among them: they may be zero.
    """
    return tuple(
        s.name for s in fit.model.free if s.positive and not fit.errors[s.name] <= abs(fit.values[s.name])
    )


def correlation_of(fit: RowFit, records: Sequence[Record], first_lag: int = 1) -> tuple[float, float]:
    """Largest correlation of the residual with its past, over records and channels.

    ``first_lag``: from which lag on; what a sensor or a difference correlates lies below it.
    Returns ``largest``: between 0 and 1; ``chance``: of one as large in white noise, by the portmanteau
    statistic of Ljung and Box.
    """
    largest, chance = 0.0, 1.0
    for record in records:
        off = record.seen(fit.simulated(record) - record.output)[record.training]
        for residual in (off - off.mean(axis=0)).T:
            n, power = residual.size, float(residual @ residual)
            if power <= 0.0 or n < 4 * (first_lag + LAGS):
                continue
            lags = np.arange(first_lag, first_lag + LAGS)
            r = np.array([float(residual[k:] @ residual[:-k]) / power for k in lags])
            q = n * (n + 2) * float(np.sum(r**2 / (n - lags)))
            largest, chance = (
                max(largest, float(np.abs(r).max())),
                min(chance, float(stats.chi2.sf(q, LAGS))),
            )
    return largest, chance


def doubts_of(fit: RowFit, records: Sequence[Record], first_lag: int = 1) -> tuple[tuple[str, str], ...]:
    """What a reader of a fit has to know.

    ``first_lag``: see `correlation_of`.
    Returns code and sentence: "at-bound", "undetermined", "residual-not-white".
    """
    found = [
        ("at-bound", f"{name} ends at the bound {bound:.4g} of its search: no interval")
        for name, bound in at_bounds(fit).items()
    ]
    found += [
        ("undetermined", f"{name} is not determined: its standard error {fit.errors[name]:.3g} is above its "
         f"value {fit.values[name]:.3g}")
        for name in undetermined(fit)
    ]  # fmt: skip
    largest, chance = correlation_of(fit, records, first_lag)
    if chance < SIGNIFICANT and largest > LARGE:
        found.append(
            (
                "residual-not-white",
                f"the residual is correlated with its past (up to {largest:.2f}): an effect that the model "
                "lacks acts on the machine, and the intervals are valid only for the model as given",
            )
        )
    return tuple(found)
