r"""Sobol indices of an output, first and total, from a store whose design is of Saltelli's kind.

With :math:`f` on the samples A, B and on A with column i taken from B,

.. math:: S_i = \frac{\overline{f_B\,(f_{AB_i} - f_A)}}{V}, \qquad
          S_{Ti} = \frac{\overline{(f_A - f_{AB_i})^2}}{2V},

the first by Saltelli et al. (2010), the second by Jansen (1999); V is the variance over A and B, and their
mean is taken off f before. Groups with a row that is not done are left out whole.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cabledrive.campaign.results import open_results
from cabledrive.parameters import InputRefused, NotComputed
from cabledrive.parameters.arrays import Array

RESAMPLES = 1000
CONFIDENCE = 0.95
FEWEST_GROUPS = 8


@dataclass(frozen=True, slots=True, kw_only=True)
class Index:
    """An index with its bootstrap interval."""

    value: float
    low: float
    high: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Sensitivity:
    """Which keys the variance of an output comes from."""

    output: str
    rows: int  # that are used
    first: dict[str, Index]  # share of the variance by a key alone; linked keys stand together
    total: dict[str, Index]  # with all its interactions
    groups: int  # of k + 2 rows each
    groups_left_out: int  # for a row that was refused, not completed or not yet computed
    refused: int  # rows of the store
    failed: int  # rows of the store
    mean: float  # of the output over the samples A and B
    standard_deviation: float  # likewise


def sensitivity(store: str | Path, output: str, *, generator: np.random.Generator) -> Sensitivity:
    """Sobol indices with bootstrap intervals of an output, such as "longitudinal_hz[0]", of a store.

    Refused: a design that is not of Saltelli's kind, an unknown output, too few groups done. `NotComputed`:
    the output does not vary.
    """
    results = open_results(store)
    axes = results.attributes["axes"]
    kind = results.attributes["campaign"]["design.kind"]
    if kind != "saltelli":
        raise InputRefused(
            f'design.kind = "{kind}" has no groups for indices: sweep with kind = "saltelli", base = N'
        ).at(str(store))
    groups = results.output(output).reshape(-1, len(axes) + 2)
    groups = np.where(results.code.reshape(groups.shape) == 0, groups, np.nan)
    kept = groups[np.all(np.isfinite(groups), axis=1)]
    if len(kept) < FEWEST_GROUPS:
        raise InputRefused(
            f"{len(kept)} of {len(groups)} groups are done in all their rows, {FEWEST_GROUPS} are needed: "
            "finish the sweep, or narrow what is varied"
        ).at(str(store))
    if not np.all(np.isfinite(_estimates(kept))):
        raise NotComputed(f"{output} is the same in all {len(kept)} groups: it depends on none of the keys")
    first, total = indices(kept, generator)
    names = [" + ".join(keys) for keys in axes]
    samples = kept[:, :2]
    counts = results.counts
    return Sensitivity(
        output=output,
        rows=kept.size,
        first=dict(zip(names, first, strict=True)),
        total=dict(zip(names, total, strict=True)),
        groups=len(kept),
        groups_left_out=len(groups) - len(kept),
        refused=counts["refused"],
        failed=counts["failed"],
        mean=float(samples.mean()),
        standard_deviation=float(samples.std()),
    )


def indices(groups: Array, generator: np.random.Generator) -> tuple[list[Index], list[Index]]:
    """First and total indices, with intervals by drawing groups anew.

    ``groups``, (N, k + 2): values at A, B, then at A with each column from B.
    """
    best, count = _estimates(groups), len(groups)
    spread = np.array([_estimates(groups[generator.integers(count, size=count)]) for _ in range(RESAMPLES)])
    tail = 0.5 * (1.0 - CONFIDENCE)
    low, high = np.nanquantile(spread, [tail, 1.0 - tail], axis=0)
    first, total = (
        [Index(value=float(v), low=float(a), high=float(b)) for v, a, b in zip(*triple, strict=True)]
        for triple in zip(best, low, high, strict=True)
    )
    return first, total


def _estimates(groups: Array) -> Array:
    """First and total indices, shape (2, k); NaN where nothing varies."""
    samples = groups[:, :2]
    centred = groups - samples.mean()
    variance = float(np.mean(centred[:, :2] ** 2))
    if variance <= 1e-24 * float(np.mean(groups**2)):
        return np.full((2, groups.shape[1] - 2), np.nan)
    a, b, mixed = centred[:, :1], centred[:, 1:2], centred[:, 2:]
    first = np.mean(b * (mixed - a), axis=0) / variance
    total = np.mean((a - mixed) ** 2, axis=0) / (2.0 * variance)
    return np.array([first, total])
