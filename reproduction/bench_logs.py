"""Logs of section 4.2 from a virtual rig that has the printed parameters; the measured ones are lost."""

from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from cabledrive.identification.estimates import Identification
from cabledrive.identification.logs.log import Log
from cabledrive.identification.one_log import IdentifyOptions, identify
from cabledrive.rig.bench.virtual_rig import BENCH_TESTS, BenchTest, bench_command, bench_rig, run_rig

SEED = 2015


@dataclass(frozen=True, slots=True, kw_only=True)
class Experiment:
    """One experiment of section 4.2.

    Attributes
    ----------
    regressors, error : str
        Numbers of its two figures.
    rig : BenchTest
    frequencies, amplitudes : tuple of float
        [Hz], [V].
    """

    regressors: str
    error: str
    rig: BenchTest
    frequencies: tuple[float, ...]
    amplitudes: tuple[float, ...]


EXPERIMENTS = (
    Experiment(
        regressors="4.7", error="4.8", rig=BENCH_TESTS[1], frequencies=(3.0, 4.0), amplitudes=(0.1, 0.1)
    ),
    Experiment(
        regressors="4.9", error="4.10", rig=BENCH_TESTS[1], frequencies=(1.0, 5.0), amplitudes=(0.1, 0.1)
    ),
    Experiment(
        regressors="4.11",
        error="4.12",
        rig=BENCH_TESTS[1],
        frequencies=(1.0, 3.0, 5.0),
        amplitudes=(0.1, 0.1, 0.1),
    ),
    Experiment(
        regressors="4.13",
        error="4.14",
        rig=BENCH_TESTS[0],
        frequencies=(1.0, 3.0, 5.0),
        amplitudes=(0.05, 0.05, 0.1),
    ),
    Experiment(
        regressors="4.15",
        error="4.16",
        rig=BENCH_TESTS[2],
        frequencies=(1.0, 3.0, 5.0),
        amplitudes=(0.05, 0.05, 0.1),
    ),
)


@cache
def bench_log(rig: BenchTest, frequencies: tuple[float, ...], amplitudes: tuple[float, ...]) -> Log:
    """Log of a bench test on the virtual rig.

    ``frequencies``, ``amplitudes`` [Hz], [V].
    """
    rng = np.random.default_rng(SEED)
    test = replace(rig, frequencies=frequencies, amplitudes=amplitudes)
    return run_rig(bench_rig(test), bench_command(test, rng), rng)


@cache
def identified(rig: BenchTest) -> Identification:
    """What the identification finds of one rig of Table 4.1."""
    log = bench_log(rig, rig.frequencies, rig.amplitudes)
    return identify(log, IdentifyOptions(check=False), method="output-error")
