"""Time stamps and channels of a log: what is wrong with them, what can be repaired."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array, Integers
from cabledrive.parameters.fields import LARGEST, SMALLEST

LONGEST_HOLE = 5
MOST_HOLES = 0.02
FEW_LEVELS, MANY_LEVELS = 8, 20
CUT = 3.0
"""Time at an end of the range over that at the levels beside it, from which the rest is cut off."""
UNROUNDED = 0.3
"""Levels over samples within the range of a channel from which its values are not rounded."""


def fill_holes(values: Array, name: str, source: str, repaired: list[str]) -> Array:
    """Replace few missing values by straight lines; refused if many are missing, or one is infinite."""
    if np.isinf(values).any():
        row = int(np.argmax(np.isinf(values)))
        raise InputRefused(f"{source}: {name} is infinite at row {row + 1}: correct it")
    hole = np.isnan(values)
    if not hole.any():
        return values
    edges = np.flatnonzero(np.diff(np.concatenate(([0], hole.astype(np.int8), [0]))))
    longest = int((edges[1::2] - edges[::2]).max())
    if longest > LONGEST_HOLE or hole.mean() > MOST_HOLES:
        raise InputRefused(
            f"{source}: {name} has {hole.sum()} missing values ({100 * hole.mean():.3g} %, {longest} in a "
            f"row); at most {LONGEST_HOLE} in a row and {100 * MOST_HOLES:g} % are filled: cut the log there"
        )
    repaired.append(f"{int(hole.sum())} missing values of {name} filled by straight lines")
    rows = np.arange(values.size)
    return np.interp(rows, rows[~hole], values[~hole])


def require_size(values: Array, name: str, unit: str, source: str) -> None:
    """Refuse values that no machine has: a wrong unit or factor, or a file read the wrong way."""
    largest = float(np.abs(values).max(initial=0.0))
    if largest > LARGEST or 0.0 < largest < SMALLEST:
        said = f"{source}: {name} reaches {largest:.3g} {unit}, no size of a machine"
        raise InputRefused(f"{said} ({SMALLEST:g} to {LARGEST:g}): check its unit and factor")


def quantum_of(values: Array) -> float:
    """Step of which all values are multiples, up to a common offset; 0 where there is none."""
    levels = np.unique(values[:: max(1, values.size // 200_000)])
    if levels.size < 3:
        return 0.0
    gaps = np.diff(levels)
    tiny = 1e-9 * max(np.abs(levels[0]), np.abs(levels[-1]))
    gaps = gaps[gaps > 4 * tiny]
    if gaps.size < 2:
        return 0.0
    step = float(np.median(gaps[gaps < 1.5 * gaps.min()]))
    counts = gaps / step
    tolerance = np.maximum(1e-3, 4.0 * tiny / step)
    return step if np.abs(counts - np.rint(counts)).max() < max(0.01, tolerance) and step > 50 * tiny else 0.0


def unwrap(values: Array, name: str, quantum: float, repaired: list[str]) -> Array:
    """Undo the wraps of an encoder [rad]: jumps by one and the same large amount, forth and back."""
    steps = np.diff(values)
    span = np.ptp(values)
    far = np.abs(steps) > 0.6 * span
    if not far.any() or span <= 20.0 * quantum or far.sum() > 0.2 * steps.size:
        return values
    usual = np.abs(steps[~far]).max(initial=0.0)
    if span < 8.0 * usual:
        return values
    turn = span + max(quantum, usual / 2)
    turns = turn / (2 * np.pi)  # a whole turn where it is near one, else what was seen
    if round(turns) >= 1 and abs(turns - round(turns)) < 0.05 * turns:
        turn = 2 * np.pi * round(turns)
    repaired.append(f"{int(far.sum())} wraps of {name} by {turn:.5g} rad undone")
    return values - np.concatenate(([0.0], np.cumsum(np.where(far, np.sign(steps) * turn, 0.0))))


def lost_counts(values: Array, quantum: float) -> int:
    """Jumps of a position: two neighbouring second differences, equal and opposite, far outside others."""
    bend = np.diff(values, 2)
    if bend.size < 10:
        return 0
    scale = max(float(np.median(np.abs(bend))), 0.5 * quantum, 1e-300)
    usual = np.quantile(np.abs(bend), 0.99)
    large = np.abs(bend) > max(12.0 * scale, 4.0 * usual)
    pairs = large[:-1] & large[1:] & (np.abs(bend[:-1] + bend[1:]) < 0.5 * np.abs(bend[:-1]))
    return int(pairs.sum())


def saturated(values: Array) -> NDArray[np.bool_]:
    """Samples (samples,) that stand at an end of the channel's range for three or more in a row.

    A smooth rounded torque stands there at most about twice as long as at the levels beside it, one that is
    cut longer. Beside plateaus only other levels count; unrounded every stand counts, of few levels none.
    """
    first = np.concatenate(([0], np.flatnonzero(np.diff(values)) + 1))
    length, level = np.diff(np.append(first, values.size)), values[first]
    end = (level == values.max()) | (level == values.min())
    long = length >= 3
    stands = int(length[end & long].sum())
    within = np.where(end, 0, length)
    every, inner = (np.append(n[1:], 0) + np.insert(n[:-1], 0, 0) for n in (length, within))  # of both sides
    plateaus = int(length[long & ~end & (length > CUT * every)].sum())
    cut = stands > CUT * every[end & long].sum()
    levels = np.unique(level).size
    cut |= stands > max(plateaus, CUT * inner[end & long].sum()) and levels > MANY_LEVELS
    cut |= levels > UNROUNDED * length[~end].sum()
    if levels <= FEW_LEVELS or not cut or stands < 0.001 * values.size:
        return np.zeros(values.size, dtype=bool)
    return np.repeat(end & long, length)


LONGEST_GAP = 5
"""Missing rows in a row that are filled by straight lines."""
MOST_MISSING = 0.02
"""Share of missing rows above which a log is refused."""
LARGEST_JITTER = 0.25
"""Deviation from an even grid, in intervals, that is still taken for an even grid."""
LONGEST_STEP = 2.5
"""Steps, in intervals, that jitter may make of one where samples may be resampled; longer is a gap."""


@dataclass(frozen=True, slots=True, eq=False)
class TimeCheck:
    """An even grid for a log, and where its rows belong on it."""

    interval: float  # [s]
    keep: Integers  # rows of the file that are used
    place: Integers  # place of each of them on the grid
    stamps: Array  # their time stamps [s]
    jitter: float  # standard deviation about the grid, in intervals
    uneven: bool  # whether the stamps deviate more than `LARGEST_JITTER`
    repaired: list[str]
    findings: list[str]

    @property
    def grid(self) -> Array:
        """Times of the even grid [s], up to the last sample."""
        start = float(self.stamps[0])
        whole = int((self.stamps[-1] - start) / self.interval + 1e-6)
        count = whole if self.uneven else int(self.place[-1])
        return np.asarray(start + self.interval * np.arange(count + 1), dtype=float)

    def on_grid(self, values: Array) -> Array:
        """A channel of the rows that are used at the times of the grid."""
        if self.uneven:
            return np.interp(self.grid, self.stamps, values)
        if self.place.size == self.place[-1] + 1:
            return values
        return np.interp(np.arange(self.place[-1] + 1, dtype=float), self.place.astype(float), values)


def check_time(time: Array, source: str, *, resample: bool = False) -> TimeCheck:
    """The even grid behind time stamps (rows,) [s]; ``resample``: wherever the samples lie."""
    repaired: list[str] = []
    findings: list[str] = []
    keep = _without_doubles(time, source, repaired)
    stamps = time[keep]
    steps = np.diff(stamps)
    interval = float(np.median(steps))
    place = _places(stamps, interval, resample)
    centred = place - place.mean()
    fitted = float(centred @ (stamps - stamps[0]) / (centred @ centred))
    interval = fitted if abs(fitted / interval - 1.0) > 1e-12 else interval
    missing = np.diff(place) - 1
    total, longest = int(missing.sum()), int(missing.max(initial=0))
    if longest > LONGEST_GAP or total > MOST_MISSING * place[-1]:
        at = stamps[int(np.argmax(missing))]
        raise InputRefused(
            f"{source}: {total} of {place[-1] + 1} rows are missing ({100 * total / (place[-1] + 1):.2g} %, "
            f"longest gap {longest * interval:.4g} s at {at:.6g} s); at most {100 * MOST_MISSING:g} % and "
            f"{LONGEST_GAP} rows are filled: cut the log there"
        )
    if total:
        repaired.append(f"{total} missing rows filled by straight lines (longest gap {longest} rows)")
    off = (stamps - stamps[0]) / interval - place
    off -= np.median(off)
    uneven = bool(np.abs(off).max() > LARGEST_JITTER)
    jitter = float(off.std())
    if jitter > 1e-3:
        findings.append(f"time stamps jitter by {jitter:.2g} of an interval of {interval:.4g} s")
    return TimeCheck(interval, keep, place, stamps, jitter, uneven, repaired, findings)


def _without_doubles(time: Array, source: str, repaired: list[str]) -> Integers:
    if time.size < 3:
        raise InputRefused(
            f"{source}: only {time.size} row{'s' * (time.size > 1)} of numbers: 3 or more are needed"
        )
    if not np.all(np.isfinite(time)):
        row = int(np.argmin(np.isfinite(time)))
        raise InputRefused(f"{source}: row {row + 1} has no time: cut it, or give the sample rate instead")
    steps = np.diff(time)
    if (steps < 0.0).any():
        row = int(np.argmax(steps < 0.0))
        raise InputRefused(
            f"{source}: time runs backwards at row {row + 2}: {time[row + 1]:.6g} s after {time[row]:.6g} s; "
            "sort or split the log, or give the sample rate"
        )
    require_size(time - time[0], "time", "s", source)
    doubled = np.flatnonzero(steps == 0.0)
    if doubled.size > MOST_MISSING * time.size:
        said = f"{source}: {doubled.size} of {time.size} time stamps are doubled (too few digits?)"
        raise InputRefused(f"{said}: give the sample rate")
    if doubled.size:
        repaired.append(f"{doubled.size} rows with a doubled time stamp left out")
    return np.delete(np.arange(time.size), doubled + 1)


def _places(stamps: Array, interval: float, resample: bool) -> Integers:
    """Each stamp's number on the grid; where rows are missing, steps are counted one by one."""
    if resample:
        steps = np.diff(stamps) / interval
        counted = np.where(steps > LONGEST_STEP, np.rint(steps), 1.0).astype(np.int64)
        return np.concatenate(([0], np.cumsum(counted)))
    whole = np.arange(stamps.size)
    off = (stamps - stamps[0]) / (stamps[-1] - stamps[0]) * whole[-1] - whole
    regular = np.mean(np.abs(np.diff(stamps) / interval - 1.0) < 0.05) > 0.6
    if np.ptp(off) < 1.5 and not regular:
        return whole
    counted = np.maximum(1, np.rint(np.diff(stamps) / interval)).astype(np.int64)
    return np.concatenate(([0], np.cumsum(counted)))
