"""Time stamps: backwards, doubled, missing, jittering; what can be repaired is, and said."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cabledrive.identification.logs.channel_check import require_size
from cabledrive.parameters import InputRefused

Array = NDArray[np.float64]
LONGEST_GAP = 5
"""Missing rows in a row that are filled by straight lines."""
MOST_MISSING = 0.02
"""Share of missing rows above which a log is refused."""
LARGEST_JITTER = 0.25
"""Deviation from an even grid, in intervals, that is still taken for an even grid."""

LONGEST_STEP = 2.5
"""Steps, in intervals, that jitter may make of one where samples may be resampled; longer is a gap."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TimeCheck:
    """An even grid for a log, and where its rows belong on it.

    Attributes
    ----------
    start, interval : float
        [s].
    keep : ndarray of int
        Rows of the file that are used.
    place : ndarray of int
        Place of each of them on the grid.
    stamps : ndarray
        Their time stamps [s].
    jitter : float
        Standard deviation about the grid, in intervals.
    uneven : bool
        Whether the stamps deviate more than `LARGEST_JITTER`.
    repaired, findings : list of str
    """

    start: float
    interval: float
    keep: NDArray[np.int64]
    place: NDArray[np.int64]
    stamps: Array
    jitter: float
    uneven: bool
    repaired: list[str]
    findings: list[str]

    @property
    def grid(self) -> Array:
        """Times of the even grid [s], up to the last sample."""
        whole = int((self.stamps[-1] - self.start) / self.interval + 1e-6)
        count = whole if self.uneven else int(self.place[-1])
        return np.asarray(self.start + self.interval * np.arange(count + 1), dtype=float)


def check_time(time: Array, source: str, *, resample: bool = False) -> TimeCheck:
    """Find the even grid behind time stamps.

    ``time``, shape (rows,) [s]; ``source``: name of the file, for refusals; ``resample``: whether samples may
    be put onto an even grid wherever they lie: rows are then missing only where a step is longer than the
    jitter explains.
    Raises `InputRefused` if time is missing, runs backwards or is no time of a test, or too much of it is
    missing.
    """
    repaired: list[str] = []
    findings: list[str] = []
    keep = _without_doubles(time, source, repaired)
    stamps = time[keep]
    steps = np.diff(stamps)
    interval = float(np.median(steps))
    place = _places(stamps, interval, resample)
    interval = _fitted_interval(stamps, place, interval)
    _check_gaps(stamps, place, interval, source, repaired)
    off = (stamps - stamps[0]) / interval - place
    off -= np.median(off)
    uneven = bool(np.abs(off).max() > LARGEST_JITTER)
    jitter = float(off.std())
    if jitter > 1e-3:
        findings.append(f"time stamps jitter by {jitter:.2g} of an interval of {interval:.4g} s")
    return TimeCheck(
        start=float(stamps[0]),
        interval=interval,
        keep=keep,
        place=place,
        stamps=stamps,
        jitter=jitter,
        uneven=uneven,
        repaired=repaired,
        findings=findings,
    )


def _without_doubles(time: Array, source: str, repaired: list[str]) -> NDArray[np.int64]:
    if time.size < 3:
        raise InputRefused(
            f"{source}: only {time.size} row{'s' * (time.size > 1)} of numbers: a log needs more than 2"
        )
    if not np.all(np.isfinite(time)):
        row = int(np.argmin(np.isfinite(time)))
        raise InputRefused(
            f"{source}: row {row + 1} has no time: cut the row, or give the sample rate instead"
        )
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
        raise InputRefused(
            f"{source}: {doubled.size} of {time.size} time stamps are doubled (too few digits?): "
            "give the sample rate"
        )
    if doubled.size:
        repaired.append(f"{doubled.size} rows with a doubled time stamp left out")
    return np.delete(np.arange(time.size), doubled + 1)


def _places(stamps: Array, interval: float, resample: bool) -> NDArray[np.int64]:
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
    return np.concatenate(
        ([0], np.cumsum(np.maximum(1, np.rint(np.diff(stamps) / interval)).astype(np.int64)))
    )


def _fitted_interval(stamps: Array, place: NDArray[np.int64], interval: float) -> float:
    centred = place - place.mean()
    fitted = float(centred @ (stamps - stamps[0]) / (centred @ centred))
    return fitted if abs(fitted / interval - 1.0) > 1e-12 else interval


def _check_gaps(
    stamps: Array, place: NDArray[np.int64], interval: float, source: str, repaired: list[str]
) -> None:
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
