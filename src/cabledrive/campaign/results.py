r"""A store read again: on which keys its outputs depend, and the yield against goals.

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
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cabledrive.answers.keys import Keys
from cabledrive.campaign.design import GROUPED, MORRIS_STEP, NamedDesign
from cabledrive.campaign.rows import BESIDE, STATUS, counts
from cabledrive.campaign.store import attributes_of, zarr_at_hand
from cabledrive.parameters import InputRefused, NotComputed
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.fields import nearest
from cabledrive.parameters.units import to_si


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Results:
    """A store."""

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
        return {"rows": int(self.code.size)} | counts(self.code)


def open_results(path: str | Path) -> Results:
    """Open the store of a campaign to read. Raises `InputRefused` if it is none, or no row of it is done."""
    path = Path(path)
    attributes = attributes_of(path)
    group = zarr_at_hand().open_group(str(path), mode="r")
    code = np.asarray(group[STATUS][:])
    if not np.any(code >= 0):
        raise InputRefused("no row is done yet: run the sweep first").at(str(path))
    return Results(attributes=attributes, group=group, code=code)


RESAMPLES = 1000
CONFIDENCE = 0.95
FEWEST_GROUPS = 8


CAMPAIGN = Keys("text: output count: groups rows refused failed groups_left_out number: confidence")
INDICES = Keys(
    "map: first{number: value low high} total{number: value low high} number: mean standard_deviation",
    also=(CAMPAIGN,),
)
EFFECTS = Keys(
    "map: effects{object: mean_size{number: value low high} number: mean deviation}", also=(CAMPAIGN,)
)


def influence(store: str | Path, output: str, *, generator: np.random.Generator) -> dict[str, Any]:
    """What an output, such as "longitudinal_hz[0]", owes to each key: indices, or effects of a screening.

    Plain data, an index or size with its bootstrap interval. Refused: a design without groups or paths, an
    unknown output, too few groups done. `NotComputed`: the output does not vary.
    """
    results = open_results(store)
    campaign = results.attributes["campaign"]
    kind, names = campaign["design.kind"], [" + ".join(keys) for keys in results.attributes["axes"]]
    if kind not in GROUPED:
        raise InputRefused(
            f'design.kind = "{kind}" has no groups for indices or effects: sweep with kind = "saltelli" or '
            '"morris", base = N'
        ).at(str(store))
    values = results.output(output).reshape(-1, len(names) + GROUPED[kind])
    whole = np.all(np.isfinite(values) & (results.code.reshape(values.shape) == 0), axis=1)
    kept = values[whole]
    if len(kept) < FEWEST_GROUPS:
        raise InputRefused(
            f"{len(kept)} of {len(values)} groups are done in all their rows, {FEWEST_GROUPS} are needed: "
            "finish the sweep, or narrow what is varied"
        ).at(str(store))
    found = {
        "output": output,
        "rows": kept.size,
        "groups": len(kept),
        "groups_left_out": len(values) - len(kept),
        **{name: results.counts[name] for name in ("refused", "failed")},
    }
    if kind == "morris":
        seed = int(campaign["design.seed"])
        design = NamedDesign(kind=kind, rows=values.size, axes=len(names), seed=seed)
        points = design.points(0, design.rows).reshape(*values.shape, len(names))[whole]
        effects = dict(zip(names, _summaries(points, kept, generator), strict=True))
        largest = sorted(effects.items(), key=lambda item: -item[1]["mean_size"]["value"])
        return found | {"effects": dict(largest)}
    if not np.all(np.isfinite(_estimates(kept))):
        raise NotComputed(f"{output} is the same in all {len(kept)} groups: it depends on none of the keys")
    first, total = indices(kept, generator)
    return found | {
        "first": dict(zip(names, first, strict=True)),
        "total": dict(zip(names, total, strict=True)),
        "mean": float(kept[:, :2].mean()),
        "standard_deviation": float(kept[:, :2].std()),
    }


def indices(groups: Array, generator: np.random.Generator) -> list[list[dict[str, float]]]:
    """First and total indices, each with an interval by drawing groups anew.

    ``groups``, (N, k + 2): values at A, B, then at A with each column from B.
    """
    values = zip(_estimates(groups), *_interval(groups, _estimates, generator), strict=True)
    return [[_valued(*one) for one in zip(*triple, strict=True)] for triple in values]


def _valued(value: float, low: float, high: float) -> dict[str, float]:
    """A value with the ends of its interval, as plain data."""
    return {"value": float(value), "low": float(low), "high": float(high)}


def _interval(rows: Array, estimate: Callable[[Array], Array], generator: np.random.Generator) -> Array:
    """Ends of the bootstrap interval of an estimate from rows, shape (2, ...)."""
    count, tail = len(rows), 0.5 * (1.0 - CONFIDENCE)
    spread = np.array([estimate(rows[generator.integers(count, size=count)]) for _ in range(RESAMPLES)])
    return np.asarray(np.nanquantile(spread, [tail, 1.0 - tail], axis=0))


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


def _summaries(points: Array, values: Array, generator: np.random.Generator) -> Iterator[dict[str, Any]]:
    """Mean size with its interval, mean and deviation of each key's effects, per whole interval.

    ``points``, (N, k + 1, k), of the paths and ``values``, (N, k + 1), of the output.
    """
    steps, changes = np.diff(points, axis=1), np.diff(values, axis=1)
    effects = np.sum(steps * changes[:, :, None], axis=1) / MORRIS_STEP**2
    size = np.abs(effects)
    low, high = _interval(size, lambda rows: np.asarray(rows.mean(axis=0)), generator)
    columns = (size.mean(axis=0), low, high, effects.mean(axis=0), effects.std(axis=0, ddof=1))
    for value, a, b, mean, deviation in np.column_stack(columns).tolist():
        yield {"mean_size": _valued(value, a, b), "mean": mean, "deviation": deviation}


Flags = NDArray[np.bool_]

BINS = 20
"""Equal counts of rows along a key."""
BY_CHANCE = 0.05
"""Chance that a key which does not bear on the yield is given an interval."""
CHOSEN = ("grid", "morris")
NO_SAMPLE = "no interval: the points of a grid or of morris are chosen, no sample of what is varied"
FEWEST_ROWS = 100
_GOAL = re.compile(r"\s*([\w\[\]]+)\s*(<=|>=|<|>)\s*(.+?)\s*")


@dataclass(frozen=True, slots=True, kw_only=True)
class LimitOf:
    """A goal: a limit of an output."""

    output: str
    below: bool  # whether the limit is an upper one; the limit itself is allowed
    limit: float  # in the unit of the output
    text: str

    def holds(self, results: Results) -> Flags:
        """Whether each row holds it, shape (rows,); rows without the output do not."""
        values = results.output(self.output)
        return np.asarray(values <= self.limit if self.below else values >= self.limit)


def goal_of(text: str, results: Results) -> LimitOf:
    """A goal from its text, ``longitudinal_hz[0] > 5.8 Hz``; refused: none, no output, another unit."""
    found = _GOAL.fullmatch(text)
    if found is None:
        raise InputRefused(f'--goal "{text[:60]}" is none: write such as "peak_error_deg < 0.05 deg"')
    results.output(found[1])
    unit = results.unit(found[1])
    try:
        limit = to_si(found[3], unit) if unit == "1" else _in_unit(found[3], unit)
    except InputRefused as refusal:
        raise InputRefused(f"--goal {found[1]}: {refusal}") from None
    return LimitOf(output=found[1], below=found[2] in ("<", "<="), limit=limit, text=text.strip())


def _in_unit(text: str, unit: str) -> float:
    """A limit in the unit of its output, which may be deg or mm; a bare number is taken to be in it."""
    with suppress(ValueError):
        if isfinite(number := float(text)):
            return number
    return to_si(text, unit) / to_si(f"1 {unit}", unit)


YIELD = Keys(
    "number: target yield yield_low yield_high count: rows held refused failed rows: "
    "goals{text: goal output number: limit} map: missed keys{text: unit number: low high share_at_low "
    "share_at_high gain_per_low gain_per_high object: tightened{number: low high share count: rows}}",
    {
        "tightened": "no interval of this key alone reaches the target by more than chance",
        **dict.fromkeys(("yield_low", "yield_high"), NO_SAMPLE),
    },
)


def tolerance(store: str | Path, goals: list[str], *, target: float = 0.99) -> dict[str, Any]:
    """Yield against goals such as ``"peak_error_deg < 0.05 deg"``, all of which have to hold, key by key.

    Plain data but for the goals; rows that were refused or not completed do not hold. Of each key, the one
    whose tightening gains most first: its ends in the campaign (``low``, ``high``, SI), the yield of the
    twentieth of the rows at either end, the gain of the yield per SI unit by which an end is drawn in, and
    ``tightened``, the widest interval of it alone in which the yield reaches the target, or None. Refused: a
    goal that is not understood, no goal, fewer than 100 rows done.
    """
    from scipy.stats import beta

    results = open_results(store)
    if not goals:
        raise InputRefused('--goal is missing: give such as --goal "peak_error_deg < 0.05 deg"')
    if not 0.0 < target <= 1.0:
        raise InputRefused(f"target = {target:.6g} must be above 0 and at most 1: give a share of the rows")
    limits = [goal_of(text, results) for text in goals]
    done = results.code >= 0
    if np.count_nonzero(done) < FEWEST_ROWS:
        raise InputRefused(
            f"{np.count_nonzero(done)} rows are done, {FEWEST_ROWS} are needed: finish the sweep"
        )
    fine = results.code[done] == 0
    each = [limit.holds(results)[done] & fine for limit in limits]
    held = np.all(each, axis=0)
    kind, axes = results.attributes["campaign"]["design.kind"], len(results.attributes["axes"])
    drawn = 2.0 / (axes + 2) if kind == "saltelli" else 1.0  # the rows of a group repeat two points
    hold, miss, tail = drawn * held.sum(), drawn * np.sum(~held), 0.5 * (1.0 - CONFIDENCE)
    columns = {key: np.asarray(results.group[key][:])[done] for key in results.keys}
    keys = {
        key: _key_tolerance(values, held, results.unit(key), target)
        for key, values in columns.items()
        if np.ptp(values) > 0.0
    }

    def gain(key: str) -> float:
        one = keys[key]
        return float((one["high"] - one["low"]) * max(one["gain_per_low"], one["gain_per_high"]))

    return {
        "goals": limits,
        "target": target,
        "yield": float(held.mean()),
        "yield_low": None if kind in CHOSEN else float(np.nan_to_num(beta.ppf(tail, hold, miss + 1.0))),
        "yield_high": None
        if kind in CHOSEN
        else float(np.nan_to_num(beta.ppf(1.0 - tail, hold + 1.0, miss), nan=1.0)),
        "keys": {key: keys[key] for key in sorted(keys, key=gain, reverse=True)},
        "rows": int(held.size),
        "held": int(held.sum()),
        **{name: results.counts[name] for name in ("refused", "failed")},
        "missed": {one.text: int(np.count_nonzero(fine & ~ok)) for one, ok in zip(limits, each, strict=True)},
    }


def yield_interval(found: dict[str, Any]) -> str:
    """The interval of a yield in words, or why there is none."""
    low, high = found["yield_low"], found["yield_high"]
    return NO_SAMPLE if low is None else f"95 % interval {100 * low:.2f} to {100 * high:.2f} %"


def _key_tolerance(values: Array, held: Flags, unit: str, target: float) -> dict[str, Any]:
    r"""Yield along one key.

    Of an interval with a share :math:`d` of the rows per SI unit at its end, where the yield is :math:`Y_e`,
    drawing the end in gains :math:`(Y - Y_e)\,d` per SI unit.
    """
    order = np.argsort(values, kind="stable")
    x, good = values[order], held[order].astype(float)
    bins = min(BINS, x.size // 5)
    starts = np.unique(np.searchsorted(x, x[np.arange(bins) * x.size // bins]))  # equal values together
    parts = np.split(np.arange(x.size), starts[1:])
    shares = np.array([good[part].mean() for part in parts])
    whole = float(good.mean())

    def gain(part: NDArray[np.intp], share: float) -> float:
        width = float(x[part[-1]] - x[part[0]])
        return (whole - share) * (part.size / x.size) / width if width > 0.0 else 0.0

    return {
        "unit": unit,
        "low": float(x[0]),
        "high": float(x[-1]),
        "share_at_low": float(shares[0]),
        "share_at_high": float(shares[-1]),
        "gain_per_low": gain(parts[0], float(shares[0])),
        "gain_per_high": gain(parts[-1], float(shares[-1])),
        "tightened": _widest(x, good, parts, target),
    }


def _widest(x: Array, good: Array, parts: list[NDArray[np.intp]], target: float) -> dict[str, Any] | None:
    """The widest run of parts whose yield reaches the target by more than chance: ends, yield, rows inside.

    Chance is that of so few misses in an interval over which the misses of all rows are spread evenly.
    """
    from scipy.stats import hypergeom

    runs = [(int(one[0]), int(other[-1]) + 1) for i, one in enumerate(parts) for other in parts[i:]]
    first, last = np.array(runs).T
    rows, before = last - first, np.concatenate(([0.0], np.cumsum(good)))
    held = before[last] - before[first]
    chance = hypergeom.cdf(rows - held, x.size, x.size - before[-1], rows)
    enough = (held / rows >= target) & ((chance <= BY_CHANCE / len(runs)) | (rows == x.size))
    if not enough.any():
        return None
    best = int(np.argmax(np.where(enough, x[last - 1] - x[first], -1.0)))
    low, high = float(x[first[best]]), float(x[last[best] - 1])
    return {"low": low, "high": high, "share": float(held[best] / rows[best]), "rows": int(rows[best])}
