"""What a log says of itself before any model: samples far out of range, an interval that no servo has."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from cabledrive.identification.estimates import Finding
from cabledrive.identification.logs.log import Log

FAR = 4.0
"""Of the size that all but a thousandth of the samples keep within."""
MOST = 1e-3
"""Share of the samples that may lie far outside."""
SLOWEST = 0.1
"""Interval from which the unit of the time is doubted [s]."""


def without_outliers(logs: Sequence[Log], channel: str) -> tuple[list[Log], tuple[Finding, ...]]:
    """Logs with single samples far out of range replaced by straight lines, and what was found."""
    cleaned, found = [], []
    for log in logs:
        values = log.channel(channel)
        size = np.abs(values - np.median(values))
        far = size > FAR * float(np.quantile(size, 1.0 - MOST))
        count = int(far.sum())
        if count == 0 or count > max(1, MOST * values.size):
            cleaned.append(log)
            continue
        places = np.arange(values.size)
        mended = np.interp(places, places[~far], values[~far])
        cleaned.append(replace(log, channels={**log.channels, channel: mended}))
        first, largest = int(np.argmax(far)), float(values[int(np.argmax(size))])
        found.append(
            Finding(
                "outliers",
                f"{log.source}: {count} samples of {channel} lie far outside the others (up to {largest:.4g} "
                f"{log.units[channel]}, the first at {log.time[first]:.6g} s) and were replaced by straight "
                "lines: check the channel",
            )
        )
    return cleaned, tuple(found)


def saturated_torque(logs: Sequence[Log], channel: str) -> tuple[Finding, ...]:
    """Where a torque channel stands at an end of its range: what acts on the axis is then not known."""
    found = []
    for log in logs:
        flat = log.saturated.get(channel)
        if flat is not None and flat.any():
            words = (
                f"{log.source}: {channel} stands at an end of its range in {100 * flat.mean():.2g} % of the "
                "samples, which were left out, and the model is not checked: give the sensor more range, "
                "or excite less"
            )
            found.append(Finding("saturated", words))
    return tuple(found)


def doubtful_interval(logs: Sequence[Log]) -> tuple[Finding, ...]:
    """Whether the time of a log is likely to have another unit."""
    return tuple(
        Finding(
            "interval",
            f"{log.source}: the interval is {log.interval:.4g} s, too long for a drive's log: is the time in "
            'milliseconds? Then write --column "time=COLUMN:ms"',
        )
        for log in logs
        if log.interval >= SLOWEST
    )


def drifting_clocks(rate: float) -> tuple[Finding, ...]:
    """Whether torque and angle were recorded by two clocks; ``rate``: 0 where one is as good."""
    if rate == 0.0:
        return ()
    words = (
        f"the clocks of torque and angle drift apart by {1e6 * rate:.3g} parts in a million: corrected; "
        "record both with one clock"
    )
    return (Finding("clock-drift", words),)
