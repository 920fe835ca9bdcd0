r"""A store read again, and on which keys its outputs depend: Sobol indices, elementary effects.

With :math:`f` on the samples A, B and on A with column i taken from B,

.. math:: S_i = \frac{\overline{f_B\,(f_{AB_i} - f_A)}}{V}, \qquad
          S_{Ti} = \frac{\overline{(f_A - f_{AB_i})^2}}{2V},

the first by Saltelli et al. (2010), the second by Jansen (1999); V is the variance over A and B, and their
mean is taken off f before. Groups with a row that is not done are left out whole.

A step of a path moves key i by half of its interval; the effect :math:`d_i = \Delta f/0.5` is the change of
the output per whole interval. Over the paths, :math:`\mu_i^* = \overline{|d_i|}` says how much a key matters
(Campolongo et al., 2007), :math:`\mu_i = \overline{d_i}` in which direction, and the standard deviation
:math:`\sigma_i` how far that depends on the other keys or bends. A path with a row that is not done is left
out whole.
"""

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cabledrive.campaign.design import MORRIS_STEP, Morris
from cabledrive.campaign.rows import DONE, REFUSED
from cabledrive.campaign.store import STATUS, attributes_of, zarr_at_hand
from cabledrive.parameters import InputRefused, NotComputed
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.fields import nearest

BESIDE = (STATUS, "reason", "seed", "time")
"""Variables that are neither keys nor outputs."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Results:
    """A store."""

    path: Path
    attributes: dict[str, Any]  # what the store says of itself
    group: Any
    code: NDArray[np.int8]  # (rows,): status

    @property
    def keys(self) -> tuple[str, ...]:
        """Varied keys that are numbers."""
        return tuple(key for key in self.attributes["varied"] if self.group[key].dtype.kind == "f")

    @property
    def outputs(self) -> dict[str, tuple[int, ...]]:
        """Outputs that are numbers or flags, with the shape of a row."""
        others = {*self.attributes["varied"], *BESIDE}
        return {
            name: array.shape[1:]
            for name, array in self.group.arrays()
            if name not in others and array.dtype.kind in "fi"
        }

    def unit(self, name: str) -> str:
        """SI unit of a variable; "1" of flags."""
        return str(self.group[name.partition("[")[0]].attrs.get("units", "1"))

    def key(self, name: str) -> Array:
        """Values of a key, shape (rows,), in SI."""
        return np.asarray(self.group[name][:], dtype=float)

    def output(self, name: str) -> Array:
        """Values of an output such as ``longitudinal_hz[0]``, (rows,), NaN: none; others are refused."""
        found = re.fullmatch(r"(\w+)((?:\[\d{1,6}\])*)", name.replace(" ", ""))
        known = self.outputs
        word = found[1] if found else name[:60]
        if found is None or word not in known:
            raise InputRefused(f'"{word}" is no number of this store{nearest(word, known)}')
        place = tuple(int(number) for number in re.findall(r"\d+", found[2]))
        shape = known[word]
        if len(place) != len(shape) or any(i >= n for i, n in zip(place, shape, strict=True)):
            example = word + "".join("[0]" for _ in shape)
            sizes = " x ".join(map(str, shape)) or "one number"
            raise InputRefused(f'"{name[:60]}": each row has {sizes}: write, for instance, {example}')
        values = np.asarray(self.group[word][(slice(None), *place)], dtype=float)
        return np.where(values < 0.0, np.nan, values) if self.group[word].dtype.kind == "i" else values

    @property
    def counts(self) -> dict[str, int]:
        """Rows in all, with a status, refused, and not completed."""
        return {
            "rows": int(self.code.size),
            "done": int(np.count_nonzero(self.code >= 0)),
            "refused": int(np.count_nonzero(self.code == REFUSED)),
            "failed": int(np.count_nonzero((self.code > DONE) & (self.code != REFUSED))),
        }


def open_results(path: str | Path) -> Results:
    """Open the store of a campaign to read. Raises `InputRefused` if it is none, or no row of it is done."""
    path = Path(path)
    attributes = attributes_of(path)
    group = zarr_at_hand().open_group(str(path), mode="r")
    code = np.asarray(group[STATUS][:])
    if not np.any(code >= 0):
        raise InputRefused("no row is done yet: run the sweep first").at(str(path))
    return Results(path=path, attributes=attributes, group=group, code=code)


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
