"""A pinned string in other packages: does it agree, and what does a simulated second of it cost?"""

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache

import numpy as np
import pinned_string
from case_chain import Integrated
from harness import duration, side_by_side, table
from pinned_string import DRIVE, DURATION, HEIGHT, RATE, TIMES

from cabledrive.simulation import Pluck, Recording, Scheme, Start, simulate

TITLE = "Pinned string in other packages"
PIECES = {"EXUDYN": (4, 8, 16), "MoorDyn": (25, 50, 100), "MuJoCo": (25, 50, 100), "PyElastica": (10, 20, 40)}
REFERENCE = 2000
FINER = (10, 12, 16, 20, 25, 32, 40, 50, 64, 80, 100, 128, 160, 200, 256, 320, 400, 512, 640)
ROUNDS = 5
TARGETS = {"MuJoCo": 100, "MoorDyn": 100, "PyElastica": 1000}


def report() -> str:
    exact = chain(REFERENCE)
    simulations, absent = at_hand()
    agreement = [row for name, found in simulations.items() for row in agreeing(name, found, exact)]
    speed = [compared(name, n, run, exact) for name, found in simulations.items() for n, run in found.items()]
    missing = f"\n\nNot installed here, hence not compared: {', '.join(absent)}." if absent else ""
    return (
        table(["package", "n", "its error", "our error", "difference", "agrees"], agreement)
        + f"\n\n{SETTING}\n\n"
        + table(["package", "n", "its time per second", "our n", "our time per second", "times ours"], speed)
        + f"\n\n{SPEED}{missing}"
    )


SETTING = (
    f"{1e3 * HEIGHT:g} mm half-sine on one span of `dissertation-2` at 5 N, ends held, no weight, no "
    f"damping, {1e3 * DURATION:g} ms, {RATE:g} records per second: displacement at midspan, largest difference "
    f"over time relative to the pluck. Errors are against {REFERENCE} segments of ours; difference: from "
    "our chain of as many segments. It agrees if the difference is at most both errors together and the "
    "package's error falls at least threefold as n doubles, so that it converges to what ours converges to. "
    "MuJoCo and MoorDyn lump the cable as the chain does, MuJoCo with the same steps, MoorDyn with "
    "Runge-Kutta of order 4. EXUDYN's elements are cubic, its step shrinks with them. PyElastica's rod "
    "bends; its radius falls with n."
)
SPEED = (
    "Against the coarsest chain of ours with no larger error. Targets: "
    + ", ".join(f"{package} {times}" for package, times in TARGETS.items())
    + " times."
)


def at_hand() -> tuple[dict[str, dict[int, Callable[[], np.ndarray]]], list[str]]:
    """Integrators of each package that is installed, and those that are not."""
    simulations, absent = {}, []
    for package, pieces in PIECES.items():
        try:
            with silence():
                simulations[package] = {n: getattr(pinned_string, f"in_{package.lower()}")(n) for n in pieces}
        except ImportError:
            absent.append(package)
    return simulations, absent


def agreeing(package: str, simulations, exact: np.ndarray) -> Iterator[tuple[object, ...]]:
    before = np.inf
    for n, run in simulations.items():
        with silence():
            found = run()
        error, ours = distance(found, exact), distance(chain(n), exact)
        difference = distance(found, chain(n))
        agrees = difference <= error + ours and (before == np.inf or error < before / 3.0)
        yield package, n, f"{error:.1e}", f"{ours:.1e}", f"{difference:.0e}", "yes" if agrees else "no"
        before = error


def compared(package: str, pieces: int, run, exact: np.ndarray) -> tuple[object, ...]:
    with silence():
        error = distance(run(), exact)
    ours = next(n for n in FINER if distance(chain(n), exact) <= error)
    case = pinned_string.chain_case(ours)
    integrated = Integrated(case)
    with silence():
        times = side_by_side({"theirs": run, "ours": lambda: integrated(case.grid.steps)}, rounds=ROUNDS)
    theirs, mine = (type(t)(t.seconds / DURATION, None) for t in times.values())
    ratio = f"{theirs.times_slower_than(mine):.0f}"
    return package, pieces, duration(theirs), ours, duration(mine), ratio


@cache
def chain(segments: int) -> np.ndarray:
    """Displacement at midspan of our own chain."""
    result = simulate(
        DRIVE,
        DURATION,
        start=Start(plucks=(Pluck(height=HEIGHT, shape="half-sine"),)),
        scheme=Scheme(segments=segments),
        recording=Recording(rate=RATE),
    )
    return np.interp(TIMES, result.time, result.midpoint()[:, 2])


def distance(found: np.ndarray, exact: np.ndarray) -> float:
    return float(np.max(np.abs(found - exact)) / HEIGHT)


@contextmanager
def silence():
    """Nothing on standard output and error from compiled code that will not be quiet."""
    sys.stdout.flush()
    sys.stderr.flush()
    kept, nothing = [os.dup(number) for number in (1, 2)], os.open(os.devnull, os.O_WRONLY)
    for number in (1, 2):
        os.dup2(nothing, number)
    try:
        yield
    finally:
        for number, place in zip((1, 2), kept, strict=True):
            os.dup2(place, number)
            os.close(place)
        os.close(nothing)
