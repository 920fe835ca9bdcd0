r"""Morris screening: elementary effects of each key along the paths of a design of that kind.

A step of a path moves key i by half of its interval; the effect :math:`d_i = \Delta f/0.5` is the change of
the output per whole interval. Over the paths, :math:`\mu_i^* = \overline{|d_i|}` says how much a key matters
(Campolongo et al., 2007), :math:`\mu_i = \overline{d_i}` in which direction, and the standard deviation
:math:`\sigma_i` how far that depends on the other keys or bends. A path with a row that is not done is left
out whole.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cabledrive.campaign.design import MORRIS_STEP, Morris
from cabledrive.campaign.results import Results, open_results
from cabledrive.campaign.sensitivity import CONFIDENCE, FEWEST_GROUPS, RESAMPLES, Index
from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array

MORRIS = "morris"


@dataclass(frozen=True, slots=True, kw_only=True)
class Effect:
    """What a key does to an output, per whole interval of the key, in the unit of the output."""

    mean_size: Index  # mu*, mean of the size, with its bootstrap interval
    mean: float  # mu
    deviation: float  # sigma


@dataclass(frozen=True, slots=True, kw_only=True)
class Screening:
    """Which keys matter to an output, the largest mean size first."""

    output: str
    rows: int  # that are used
    effects: dict[str, Effect]  # by key; linked keys stand together
    groups: int  # paths of k + 1 rows
    groups_left_out: int  # for a row that was refused, not completed or not yet computed
    refused: int  # rows of the store
    failed: int  # rows of the store


def is_screening(store: str | Path) -> bool:
    """Whether a store holds the paths of a screening. Raises `InputRefused` if it is no store."""
    return _kind(open_results(store)) == MORRIS


def _kind(results: Results) -> str:
    return str(results.attributes["campaign"]["design.kind"])


def screening(store: str | Path, output: str, *, generator: np.random.Generator) -> Screening:
    """Elementary effects of each key on an output; refused: another design, no such output, few paths."""
    results = open_results(store)
    if _kind(results) != MORRIS:
        raise InputRefused(f'design.kind = "{_kind(results)}" has no paths: sweep with kind = "morris"').at(
            str(store)
        )
    names = [" + ".join(keys) for keys in results.attributes["axes"]]
    values = results.output(output).reshape(-1, len(names) + 1)
    values = np.where(results.code.reshape(values.shape) == 0, values, np.nan)
    kept = np.all(np.isfinite(values), axis=1)
    paths = int(np.count_nonzero(kept))
    if paths < FEWEST_GROUPS:
        raise InputRefused(
            f"{paths} of {len(values)} paths are done in all their rows, {FEWEST_GROUPS} are needed: finish "
            "the sweep, or narrow what is varied"
        ).at(str(store))
    seed = int(results.attributes["campaign"]["design.seed"])
    design = Morris(base=len(values), axes=len(names), seed=seed)
    points = design.points(0, design.rows).reshape(len(values), -1, len(names))
    effects = elementary_effects(points[kept], values[kept])
    found = dict(zip(names, _summaries(effects, generator), strict=True))
    counts = results.counts
    return Screening(
        output=output,
        rows=paths * values.shape[1],
        effects=dict(sorted(found.items(), key=lambda item: -item[1].mean_size.value)),
        groups=paths,
        groups_left_out=len(values) - paths,
        refused=counts["refused"],
        failed=counts["failed"],
    )


def elementary_effects(points: Array, values: Array) -> Array:
    """Change of the output per whole interval of each key, (N, k), from points, (N, k + 1, k), and values."""
    steps, changes = np.diff(points, axis=1), np.diff(values, axis=1)
    return np.asarray(np.sum(steps * changes[:, :, None], axis=1) / MORRIS_STEP**2)


def _summaries(effects: Array, generator: np.random.Generator) -> list[Effect]:
    """Mean size, mean and standard deviation of each column."""
    count, size = len(effects), np.abs(effects)
    spread = np.array([size[generator.integers(count, size=count)].mean(axis=0) for _ in range(RESAMPLES)])
    tail = 0.5 * (1.0 - CONFIDENCE)
    low, high = np.quantile(spread, [tail, 1.0 - tail], axis=0)
    columns = (size.mean(axis=0), low, high, effects.mean(axis=0), effects.std(axis=0, ddof=1))
    return [
        Effect(
            mean_size=Index(value=float(value), low=float(a), high=float(b)),
            mean=float(mean),
            deviation=float(deviation),
        )
        for value, a, b, mean, deviation in zip(*columns, strict=True)
    ]
