"""One tuning procedure for every law: the highest bandwidth within the same limits of ripple and robustness.

With each of the filters that are offered, the highest bandwidth is searched at which the disk margin and the
torque ripple by rounding keep their limits; of the filters the one with the smallest worst error on plants
that are set apart for tuning is taken.
"""

import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np

from cabledrive.control.kalman import QUIET, KalmanTuning
from cabledrive.parameters import InputRefused, NotComputed
from cabledrive.rig.closed_loop.loop import Loop, close_loop, run
from cabledrive.rig.closed_loop.loop_numbers import SUMMARY
from cabledrive.rig.closed_loop.other_plants import with_plant
from cabledrive.rig.disturbances import torque_limit
from cabledrive.rig.disturbed.disturbances_file import Disturbances
from cabledrive.rig.disturbed.disturbed_plants import disturbed_loop
from cabledrive.rig.laws.controllers import Controller, DesignSpec
from cabledrive.rig.laws.filter_tuning import read_encoders, tuning_by_uncertainty
from cabledrive.rig.laws.load_learning import KINDS
from cabledrive.rig.laws.registry import CONTROLLERS
from cabledrive.rig.laws.trial_runs import needed_torque
from cabledrive.rig.laws.tuned_gains import SETTINGS_HZ
from cabledrive.rig.ranking.margins import Margins, margins_of
from cabledrive.rig.setting import RigOptions

LEAST_DISK = 0.25
"""Gain may change by a factor of 1.29, or phase by 14 deg."""
LOADED_DISK = 0.1
"""At the ends of the range of the load's inertia, where a comparison states one."""
RIPPLE_SHARE = 1.0 / 6.0
"""Of the torque limit, for five deviations of the torque by rounding."""
TUNING_SEED, TUNING_DRAWS = 1_000_003, 8
FILTERS = ("as known", "a tenth of the uncertainty", "by uncertainty")
"""Noise of the load's acceleration in the filter: none, a tenth of what the spreads make of it, all of it."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TunedLaw:
    """A law as the procedure tuned it.

    Attributes
    ----------
    name : str
    loop : Loop
        Nominal, with law and filter.
    bandwidth : float
        [Hz].
    filter : str
        Of `FILTERS`, or what the law brings.
    margins : Margins
    seconds : float
        What the tuning took [s].
    """

    name: str
    loop: Loop
    bandwidth: float
    filter: str
    margins: Margins
    seconds: float


def ripple_limit(spec: DesignSpec) -> float:
    """Torque that rounding may make: a share of the limit; without one, what the motion needs [N m]."""
    limit = torque_limit(spec.drive)
    return RIPPLE_SHARE * limit if np.isfinite(limit) else needed_torque(spec)


def tuned_by_limits(
    name: str, spec: DesignSpec, disturbances: Disturbances, options: RigOptions, seed: int = TUNING_SEED
) -> TunedLaw:
    """Tune a law by name.

    Raises `NotComputed` if no bandwidth keeps the limits, or every run of those that do ends early.
    """
    begun = time.perf_counter()
    found: list[tuple[float, TunedLaw]] = []
    for words, tuning in filters(name, spec):
        one = _highest(name, spec, options, words, tuning, disturbances.load_factor)
        if one is not None:
            found.append((worst_error(one.loop, disturbances, options, TUNING_DRAWS, seed), one))
    if not found:
        raise NotComputed(
            f"{name}: no bandwidth keeps a disk margin of {LEAST_DISK:g} and a torque ripple of "
            f"{ripple_limit(spec):.3g} N m"
        )
    best = min(found, key=lambda pair: pair[0])[1]
    return replace(best, seconds=time.perf_counter() - begun)


def filters(name: str, spec: DesignSpec) -> Iterator[tuple[str, KalmanTuning | None]]:
    """Filters that are offered to a law; none: it brings its own."""
    if name in KINDS:
        yield "its own", None
        return
    counts = np.array(list(read_encoders(spec, 4).values()))
    whole = tuning_by_uncertainty(spec, spec.model(_number(name, spec)), counts)
    shares = (QUIET, replace(whole, load_acceleration=0.1 * whole.load_acceleration), whole)
    yield from zip(FILTERS, shares, strict=True)


def _number(name: str, spec: DesignSpec) -> int:
    return CONTROLLERS[name](replace(spec, bandwidth=SETTINGS_HZ[10])).model


def _highest(
    name: str,
    spec: DesignSpec,
    options: RigOptions,
    words: str,
    tuning: KalmanTuning | None,
    loads: tuple[float, float],
) -> TunedLaw | None:
    """The highest bandwidth of the grid within the limits, by bisection from the highest that is stable."""
    most = ripple_limit(spec)
    tried: dict[int, TunedLaw | None] = {}

    def at(place: int) -> TunedLaw | None:
        if place not in tried:
            tried[place] = _within(name, spec, options, words, tuning, SETTINGS_HZ[place], most, loads)
        return tried[place]

    top = sum(hertz <= 1.0 / (20.0 * spec.interval) for hertz in SETTINGS_HZ)
    # A law may need a least bandwidth as well: from a coarse comb on, then upwards by bisection.
    low = next((place for place in range(top - 1, -1, -4) if at(place) is not None), None)
    if low is None:
        return None
    high = min(low + 4, top)
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if at(middle) is not None else (low, middle)
    return at(low)


def _within(
    name: str,
    spec: DesignSpec,
    options: RigOptions,
    words: str,
    tuning: KalmanTuning | None,
    hertz: float,
    most: float,
    loads: tuple[float, float],
) -> TunedLaw | None:
    try:
        loop = nominal_loop(CONTROLLERS[name](replace(spec, bandwidth=hertz)), spec, options, tuning)
        margins = margins_of(loop)
    except (InputRefused, np.linalg.LinAlgError):
        return None
    if not margins.stable or margins.disk < LEAST_DISK or margins.ripple > most:
        return None
    if loads != (1.0, 1.0) and min(disk_under_load(loop, load, options) for load in loads) < LOADED_DISK:
        return None
    return TunedLaw(name=name, loop=loop, bandwidth=hertz, filter=words, margins=margins, seconds=0.0)


def disk_under_load(loop: Loop, factor: float, options: RigOptions) -> float:
    """Disk margin of a law with its filter on the nominal plant with another load, announced if it can be."""
    *others, load = loop.chain.inertias
    chain = replace(loop.chain, inertias=(*others, factor * load))
    return margins_of(with_plant(loop, chain, options), factor).disk


def nominal_loop(
    made: Controller, spec: DesignSpec, options: RigOptions, tuning: KalmanTuning | None = None
) -> Loop:
    """A law with a filter on its nominal plant; ``tuning``: default: that of the law."""
    assert spec.motion is not None
    if tuning is not None:
        made = replace(made, tuning=replace(tuning, cancels=made.tuning.cancels))
    return close_loop(spec.drive, spec.drive, made, spec.motion, options, np.random.default_rng(0))


def worst_error(loop: Loop, disturbances: Disturbances, options: RigOptions, draws: int, seed: int) -> float:
    """Largest error of a law over drawn plants [rad at the first shaft]; infinite where a run ends early."""

    def one(draw: int) -> float:
        plant = disturbed_loop(loop, disturbances, options, np.random.default_rng([seed, draw]))
        done = run(plant, log=False)
        return float("inf") if done.failed else float(done.state.summary[SUMMARY.index("peak")])

    return max(in_threads(one, draws))


def in_threads(one: Callable[[int], float], draws: int) -> list[float]:
    """Runs in two threads, which the compiled loop lets work at once."""
    with ThreadPoolExecutor(2) as pool:
        return list(pool.map(one, range(draws)))
