"""The yield of a campaign against goals, and which key must be tighter, by how much."""

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cabledrive.campaign.results import Results, open_results
from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.units import to_si

Flags = NDArray[np.bool_]

BINS = 20
"""Equal counts of rows along a key."""
FEWEST_ROWS = 100
CONFIDENCE = 0.95
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


@dataclass(frozen=True, slots=True, kw_only=True)
class Tolerance:
    """Yield of a campaign, refused and failed rows counted as not holding.

    Of each key, the one whose tightening gains most first: ``unit``, its ends in the campaign (``low``,
    ``high``, SI), the yield of the twentieth of the rows at either end (``share_at_low``, ``share_at_high``),
    the gain of the yield per SI unit by which an end is drawn in (``gain_per_low``, ``gain_per_high``), and
    ``tightened``, the widest interval of it alone in which the yield reaches the target, or None.
    """

    goals: tuple[LimitOf, ...]
    target: float  # yield that is wanted
    rows: int  # with a status
    held: int  # hold every goal
    refused: int
    failed: int  # not completed
    share: float
    share_low: float  # 95 % interval of Clopper and Pearson
    share_high: float
    missed: dict[str, int]  # rows that miss each goal
    keys: dict[str, dict[str, Any]]


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
    try:
        return float(text)
    except ValueError:
        return to_si(text, unit) / to_si(f"1 {unit}", unit)


def tolerance(store: str | Path, goals: list[str], *, target: float = 0.99) -> Tolerance:
    """Yield against goals such as ``"peak_error_deg < 0.05 deg"``, all of which have to hold, key by key.

    Refused: a goal that is not understood, no goal, fewer than 100 rows done.
    """
    results = open_results(store)
    if not goals:
        raise InputRefused('--goal is missing: give such as --goal "peak_error_deg < 0.05 deg"')
    if not 0.0 < target <= 1.0:
        raise InputRefused(f"target = {target:.6g} must be above 0 and at most 1: give a share of the rows")
    limits = tuple(goal_of(text, results) for text in goals)
    done = results.code >= 0
    if np.count_nonzero(done) < FEWEST_ROWS:
        raise InputRefused(
            f"{np.count_nonzero(done)} rows are done, {FEWEST_ROWS} are needed: finish the sweep"
        )
    fine = results.code[done] == 0
    each = [limit.holds(results)[done] & fine for limit in limits]
    held = np.all(each, axis=0)
    low, high = yield_bounds(int(held.sum()), held.size)
    keys = {}
    for key in results.keys:
        values = results.key(key)[done]
        if np.ptp(values) > 0.0:
            keys[key] = _key_tolerance(values, held, results.unit(key), target)
    counts = results.counts
    missed = {one.text: int(np.count_nonzero(fine & ~ok)) for one, ok in zip(limits, each, strict=True)}
    return Tolerance(
        goals=limits,
        target=target,
        rows=int(held.size),
        held=int(held.sum()),
        refused=counts["refused"],
        failed=counts["failed"],
        share=float(held.mean()),
        share_low=low,
        share_high=high,
        missed=missed,
        keys=dict(sorted(keys.items(), key=lambda item: -_gain(item[1]))),
    )


def _gain(key: dict[str, Any]) -> float:
    """Largest gain of the yield when one end of a key is drawn in by a hundredth of the interval."""
    return float(0.01 * (key["high"] - key["low"]) * max(key["gain_per_low"], key["gain_per_high"]))


def yield_bounds(held: int, rows: int) -> tuple[float, float]:
    """Two-sided 95 % interval of Clopper and Pearson."""
    from scipy.stats import binomtest

    found = binomtest(held, rows).proportion_ci(CONFIDENCE, "exact")
    return float(found.low), float(found.high)


def _key_tolerance(values: Array, held: Flags, unit: str, target: float) -> dict[str, Any]:
    r"""Yield along one key.

    Of an interval with a share :math:`d` of the rows per SI unit at its end, where the yield is :math:`Y_e`,
    drawing the end in gains :math:`(Y - Y_e)\,d` per SI unit.
    """
    order = np.argsort(values, kind="stable")
    x, good = values[order], held[order].astype(float)
    parts = np.array_split(np.arange(x.size), min(BINS, x.size // 5))
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
    """The widest run of parts whose yield reaches the target: its ends, its yield, the rows inside."""
    best: dict[str, Any] | None = None
    for first in range(len(parts)):
        for last in range(first, len(parts)):
            a, b = int(parts[first][0]), int(parts[last][-1])
            share = float(good[a : b + 1].mean())
            if share >= target and (best is None or x[b] - x[a] > best["high"] - best["low"]):
                best = {"low": float(x[a]), "high": float(x[b]), "share": share, "rows": b - a + 1}
    return best
