"""A log in memory: evenly sampled channels in SI, and what was found in them."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.fields import nearest


@dataclass(frozen=True, slots=True, kw_only=True)
class DataReport:
    """What was found in a log, and what was repaired."""

    rows: int
    duration: float  # [s]
    interval: float  # time between samples [s]
    jitter: float = 0.0  # standard deviation of the time stamps about an even grid, in intervals
    # smallest step of each channel that has one, in SI
    quantum: Mapping[str, float] = field(default_factory=dict)
    repaired: tuple[str, ...] = ()  # what was changed, in words
    findings: tuple[str, ...] = ()  # what else a reader should know, in words

    def as_dict(self) -> dict[str, Any]:
        """The report as JSON has it."""
        return {
            "rows": self.rows,
            "duration": self.duration,
            "interval": self.interval,
            "jitter": self.jitter,
            "quantum": dict(self.quantum),
            "repaired": list(self.repaired),
            "findings": list(self.findings),
        }


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Log:
    """Channels at even intervals."""

    source: str  # name of the file, or what made it
    time: Array  # (samples,): [s]
    channels: Mapping[str, Array]  # in SI; every one as long as the time
    units: Mapping[str, str]  # SI units
    report: DataReport
    # samples at which a channel stands at the end of its range, where that was found
    saturated: Mapping[str, NDArray[np.bool_]] = field(default_factory=dict)

    @property
    def interval(self) -> float:
        """Time between samples [s]."""
        return self.report.interval

    @property
    def sample_rate(self) -> float:
        """Samples per second [Hz]."""
        return 1.0 / self.report.interval

    def __len__(self) -> int:
        return self.time.size

    def channel(self, name: str) -> Array:
        """One channel, shape (samples,); refused if the log has none of that name."""
        if name not in self.channels:
            raise InputRefused(f'{self.source}: no channel "{name}"{nearest(name, self.channels)}')
        return self.channels[name]

    def part(self, start: float | None = None, end: float | None = None) -> "Log":
        """The log from one time [s] to before another; refused if nothing is left."""
        keep = np.ones(self.time.size, dtype=bool)
        if start is not None:
            keep &= self.time >= start - 0.5 * self.interval
        if end is not None:
            keep &= self.time < end - 0.5 * self.interval
        if keep.sum() < 2:
            first, last = 0.0 if start is None else start, self.time[-1] if end is None else end
            raise InputRefused(
                f"{self.source}: nothing between {first:.6g} s and {last:.6g} s, the log ends at "
                f"{self.time[-1]:.6g} s: choose a part of it"
            )
        return replace(
            self,
            time=self.time[keep],
            channels={name: values[keep] for name, values in self.channels.items()},
            saturated={name: values[keep] for name, values in self.saturated.items()},
            report=replace(self.report, rows=int(keep.sum()), duration=float(np.ptp(self.time[keep]))),
        )


def log_of(time: Array, channels: Mapping[str, Array], units: Mapping[str, str], source: str = "log") -> Log:
    """Put channels (samples,) that are in memory, and known to be even over time [s], together."""
    if any(np.shape(values) != np.shape(time) for values in channels.values()) or time.size < 3:
        raise InputRefused(f"{source}: needs at least 3 samples and channels as long as the time")
    interval = float(time[-1] - time[0]) / (time.size - 1)
    report = DataReport(rows=time.size, duration=float(time[-1] - time[0]), interval=interval)
    return Log(source=source, time=time, channels=dict(channels), units=dict(units), report=report)
