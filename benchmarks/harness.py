"""Side-by-side timing: contestants take turns in one process, on one core, and the figures are medians.

Seconds are those the processor spends on this process and its children: on an idle machine the seconds on the
wall, on a busy one free of the time that others had the core. Ratios are taken round by round, so that what
still slows one contestant, a cache or a clock shared with others, slows its rival alike.
"""

import gc
import os
import platform
import resource
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from typing import Any

import numpy as np

ROUNDS = 9
SHORTEST = 0.02  # seconds that one sample lasts at least
PACKAGES = ("numpy", "scipy", "numba", "cabledrive")


@dataclass(frozen=True)
class Timing:
    """Seconds per call in each round, and what the first call returned."""

    seconds: np.ndarray
    result: Any

    @property
    def median(self) -> float:
        return float(np.median(self.seconds))

    @property
    def spread(self) -> float:
        """Half of the interquartile range, relative to the median."""
        low, high = np.percentile(self.seconds, [25, 75])
        return float(high - low) / 2 / self.median

    def times_slower_than(self, other: "Timing") -> float:
        """Median over the rounds of the ratio to another contestant of the same run."""
        return float(np.median(self.seconds / other.seconds))


def side_by_side(contestants: dict[str, Callable[[], Any]], rounds: int = ROUNDS) -> dict[str, Timing]:
    """Time contestants in turns, in the opposite order every second round; each is warmed up by one call."""
    results, repeats = {}, {}
    for name, contestant in contestants.items():
        results[name] = contestant()
        once = _seconds(contestant, 1)
        repeats[name] = max(1, round(SHORTEST / once))
    seconds: dict[str, list[float]] = {name: [] for name in contestants}
    for turn in range(rounds):
        for name in list(contestants)[:: -1 if turn % 2 else 1]:
            seconds[name].append(_seconds(contestants[name], repeats[name]))
    return {name: Timing(np.array(seconds[name]), results[name]) for name in contestants}


def _seconds(contestant: Callable[[], Any], repeats: int) -> float:
    gc.collect()
    gc.disable()
    try:
        start = _processor_seconds()
        for _ in range(repeats):
            contestant()
        return (_processor_seconds() - start) / repeats
    finally:
        gc.enable()


def _processor_seconds() -> float:
    """Of this process, whose threads are one, and of children that have ended."""
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + children.ru_utime + children.ru_stime


def table(columns: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A Markdown table."""
    lines = [columns, ["---"] * len(columns), *rows]
    return "\n".join("| " + " | ".join(map(str, line)) + " |" for line in lines)


def duration(timing: Timing) -> str:
    """Median and spread: ``1.23 ms +- 4 %``."""
    seconds = timing.median
    unit, factor = next(
        (u, f) for u, f in (("s", 1), ("ms", 1e3), ("µs", 1e6)) if seconds * f >= 1 or f == 1e6
    )
    return f"{seconds * factor:.3g} {unit} ± {100 * timing.spread:.0f} %"


def worst_error(found: np.ndarray, exact: np.ndarray) -> float:
    """Largest relative error of a list of frequencies; infinite if the lists differ in length."""
    if np.size(found) != np.size(exact):
        return float("inf")
    return float(np.max(np.abs(np.asarray(found) / np.asarray(exact) - 1.0)))


def one_core() -> None:
    """Stay on one core where the system lets a process choose."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})


def machine() -> str:
    """The machine and the versions, in one line."""
    load = f"load {os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else "load unknown"
    packages = ", ".join(f"{name} {_version(name)}" for name in PACKAGES)
    python = f"Python {platform.python_version()}"
    return f"{_processor()}, {os.cpu_count()} cores of which one is used, {load}; {python}, {packages}"


def _processor() -> str:
    try:
        with open("/proc/cpuinfo") as lines:
            names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    except OSError:
        names = []
    return names[0] if names else platform.processor() or platform.machine()


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "absent"
