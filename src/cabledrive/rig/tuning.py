"""One tuning procedure for every law: the highest bandwidth within the same limits of ripple and robustness.

With each of the filters that are offered, the highest bandwidth is searched at which the disk margin and the
torque ripple by rounding keep their limits; of the filters the one with the smallest worst error on plants
that are set apart for tuning is taken. `track`, `export`, `compare` and `best` take their laws from here.
"""

import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, field, replace
from functools import cache, lru_cache, partial
from math import inf

import numpy as np

from cabledrive.control.linear_laws import feedforward_generator
from cabledrive.control.numbers import KALMAN
from cabledrive.control.observers import QUIET, KalmanTuning
from cabledrive.control.reference import flat_output
from cabledrive.parameters import InputRefused, NotComputed
from cabledrive.rig.closed_loop.loop import Loop, close_loop, run, with_plant
from cabledrive.rig.laws import registry
from cabledrive.rig.laws.baselines import BASELINES
from cabledrive.rig.laws.controllers import Controller, DesignSpec, tuning_by_uncertainty
from cabledrive.rig.laws.load_learning import KINDS
from cabledrive.rig.margins import Margins, margins_of
from cabledrive.rig.plant_samples import Disturbances, scored, standard_disturbances
from cabledrive.rig.setting import RigOptions, torque_limit

SETTINGS_HZ = (
    *(0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 12.0, 15.0, 18.0, 22.0, 26.0, 30.0),
    *(35.0, 42.0, 50.0, 60.0, 75.0, 90.0),
)
LEAST_DISK = 0.25
"""Gain may change by a factor of 1.29, or phase by 14 deg."""
LOADED_DISK = 0.1
"""At the ends of the range of the load's inertia, where a comparison states one."""
RIPPLE_SHARE = 1.0 / 6.0
"""Of the torque limit, for five deviations of the torque by rounding."""
TUNING_SEED, TUNING_DRAWS = 1_000_003, 8
FILTERS = ("as known", "a tenth of the uncertainty", "by uncertainty")
"""Noise of the load's acceleration in the filter: none, a tenth of what the spreads make of it, all of it."""
UNLIMITED = Margins(disk=np.inf, gain=np.inf, phase=np.inf, ripple=0.0)
"""Of a loop whose margins are not known, as it has no Kalman filter: a run decides."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TunedLaw:
    """A law as the procedure tuned it."""

    loop: Loop  # Nominal, with law and filter
    bandwidth: float  # [Hz]
    filter: str  # of `FILTERS`, or what the law brings
    margins: Margins
    # smallest of what it keeps of each limit, over that limit; below 1 it is the one that comes closest
    reached: float

    @property
    def accepted(self) -> bool:
        """Whether it keeps the limits."""
        return self.reached >= 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class LawSetting:
    """A control law with the numbers that tune it."""

    controller: str  # a name that `track` knows
    model: int | None = None  # of a law of the chain that its bound tunes; None: any other
    bandwidth: float | None = None  # [Hz]; None: nothing keeps the limits
    filter: str = ""  # of `filters`; empty: the law brings its own
    # disk, gain, phase, ripple: as `cabledrive.rig.margins.Margins` has them; None: infinite
    margins: dict[str, float | None] = field(default_factory=dict)
    seconds: float = 0.0  # what the tuning took [s]
    reason: str = ""  # why there is no bandwidth; empty where there is one

    @property
    def words(self) -> str:
        """The setting in a few words; empty where there is none."""
        if self.bandwidth is None:
            return ""
        return f"{self.bandwidth:.3g} Hz" + (f", filter {self.filter}" if self.filter else "")


Worst = Callable[[Controller], float] | None
"""Largest error of a law over plants of the caller's, finite in a setting; None: there are none."""


def setting_of(
    name: str, spec: DesignSpec, disturbances: Disturbances, worst: Worst = None, more: str = ""
) -> LawSetting:
    """A law `tuned` within the limits, or why it cannot be; ``more``: what ``worst`` adds to them."""
    begun = time.perf_counter()
    try:
        found = tuned(name, spec, disturbances, worst)
    except (NotComputed, InputRefused) as failure:
        return LawSetting(controller=name, reason=str(failure))
    seconds = time.perf_counter() - begun
    if not found.accepted:
        why = f"no bandwidth keeps {limit_words(spec)}{more}"
        return LawSetting(controller=name, seconds=seconds, reason=why)
    limits = {key: float(value) for key, value in asdict(found.margins).items()}
    return LawSetting(
        controller=name,
        bandwidth=found.bandwidth,
        filter=found.filter,
        margins={key: value if np.isfinite(value) else None for key, value in limits.items()},
        seconds=seconds,
    )


def design(name: str | None, spec: DesignSpec) -> Controller:
    """Design a law by name, tuned where ``spec.best`` asks for it; default: see `known_name`."""
    name = registry.known_name(name, spec.drive)
    if spec.feedforward != "damped" and name not in BASELINES:
        said = f"feedforward = {spec.feedforward!r} is for {', '.join(BASELINES)}; {name} brings its own"
        raise InputRefused(f"{said}: leave it out")
    if name in registry.OPEN_LOOPS and spec.bandwidth is not None:
        raise InputRefused(f"bandwidth = {spec.bandwidth:.4g} Hz: {name} is an open loop: leave it out")
    tunable = name not in registry.OPEN_LOOPS and spec.best
    if tunable and spec.bandwidth is None:
        found, limits = tuned(name, spec, standard_disturbances(spec.drive)), limit_words(spec)
        why = f"the highest that keeps {limits}"
        if not found.accepted:
            why = f"no bandwidth keeps {limits}; this one comes closest"
        elif found.margins is UNLIMITED:
            why = "the highest with which a run without a Kalman filter ends below the torque limit"
        made = law_at(name, found.bandwidth, found.filter, spec)
        reason = f"bandwidth {found.bandwidth:g} Hz, filter {found.filter}: {why}"
        made = replace(made, gains=made.gains | {"reasons": [reason]})
    else:
        made = registry.CONTROLLERS[name](spec)
    registry.check_sample_rate(made, spec.interval)
    registry.check_least_bandwidth(registry.CONTROLLERS[name], made, spec)
    return made


def law_at(name: str, hertz: float, words: str, spec: DesignSpec) -> Controller:
    """A law at a bandwidth with one of its filters, along the motion of a spec."""
    made = registry.CONTROLLERS[name](replace(spec, bandwidth=hertz))
    return _filtered(made, dict(filters(name, spec))[words])


def tuned_loop(name: str, hertz: float, words: str, spec: DesignSpec) -> Loop:
    """The same on its nominal plant."""
    return nominal_loop(law_at(name, hertz, words, spec), spec)


def _filtered(made: Controller, tuning: KalmanTuning | None) -> Controller:
    if tuning is None:
        return made
    return replace(made, tuning=replace(tuning, cancels=made.tuning.cancels))


def limit_words(spec: DesignSpec) -> str:
    """What every setting keeps."""
    return f"a disk margin of {LEAST_DISK:g} and a torque ripple of {ripple_limit(spec):.3g} N m by rounding"


@lru_cache(maxsize=16)
def ripple_limit(spec: DesignSpec) -> float:
    """Torque rounding may make [N m]: a share of the limit; without a limit, the exact inverse's need."""
    if np.isfinite(limit := torque_limit(spec.drive)):
        return RIPPLE_SHARE * limit
    generator = feedforward_generator(spec.chain, flat_output(spec.chain), spec.interval)
    return float(np.abs(spec.rows(generator)[:, -1]).max())


def tuned(name: str, spec: DesignSpec, disturbances: Disturbances, worst: Worst = None) -> TunedLaw:
    """Tune a law by name on one pulse, with the sensors of the options; ``worst`` chooses the filter."""
    given, motion = spec.options, spec.motion
    options = RigOptions(
        forbid_slack=False,
        observer=given.observer,
        feedback=given.feedback,
        encoder_phase=given.encoder_phase,
        ideal_sensors=given.ideal_sensors,
    )
    if not disturbances.changes_load:
        motion = replace(motion, pulses=1, payload=())
    alike = replace(spec, motion=motion, options=options, plant=None)
    return _tuned(name, replace(alike, bandwidth=None, best=False), disturbances, worst)


@lru_cache(maxsize=64)
def _tuned(name: str, spec: DesignSpec, disturbances: Disturbances, worst: Worst) -> TunedLaw:
    design = registry.CONTROLLERS[name]

    def tried(words: str, tuning: KalmanTuning | None, hertz: float) -> TunedLaw | None:
        try:
            loop = nominal_loop(design(replace(spec, bandwidth=hertz)), spec, tuning)
            margins = margins_of(loop) if loop.observer.kind == KALMAN else UNLIMITED
        except (InputRefused, NotComputed, np.linalg.LinAlgError):
            return None
        share = share_of_limits(loop, margins, disturbances.load_factor)
        if share >= 1.0 and worst is not None and worst(loop.controller) == inf:
            share = 0.0
        return TunedLaw(loop=loop, bandwidth=hertz, filter=words, margins=margins, reached=share)

    if name in registry.OPEN_LOOPS:
        loop = nominal_loop(design(spec), spec)
        share, words = share_of_limits(loop, UNLIMITED, disturbances.load_factor), registry.NO_FILTER
        return TunedLaw(loop=loop, bandwidth=0.0, filter=words, margins=UNLIMITED, reached=share)
    top = sum(hertz <= 1.0 / (20.0 * spec.interval) for hertz in SETTINGS_HZ)
    best_of = [_highest(partial(tried, words, tuning), top) for words, tuning in filters(name, spec)]
    found = [one for one in best_of if one is not None]
    if not found:
        registry.check_sample_rate(design(replace(spec, bandwidth=SETTINGS_HZ[0])), spec.interval)
        raise NotComputed(f"{name}: no loop can be made at any bandwidth: give one")
    kept = [one for one in found if one.accepted]
    if not kept:
        return max(found, key=lambda one: one.reached)
    errors = []
    for one in kept:
        drawn = one.loop, disturbances, TUNING_SEED, range(TUNING_DRAWS)
        errors.append(scored(*drawn).errors.max() if worst is None else worst(one.loop.controller))
    best = kept[int(np.argmin(errors))]
    return best if np.isfinite(min(errors)) else replace(best, reached=0.0)


def _highest(tried: Callable[[float], TunedLaw | None], top: int) -> TunedLaw | None:
    """The highest of the first bandwidths accepted, by a comb and bisection; else the one that is closest."""
    at = cache(lambda place: tried(SETTINGS_HZ[place]))
    seen: dict[int, TunedLaw] = {}

    def accepted(place: int) -> bool:
        found = at(place)
        seen.update({place: found} if found is not None else {})
        return found is not None and found.accepted

    low = next((place for place in range(top - 1, -1, -4) if accepted(place)), None)
    if low is None:
        return max(seen.values(), key=lambda one: one.reached, default=None)
    high = min(low + 4, top)
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if accepted(middle) else (low, middle)
    return seen[low]


def filters(name: str, spec: DesignSpec) -> Iterator[tuple[str, KalmanTuning | None]]:
    """Filters that are offered to a law; none: it brings its own."""
    if name in (*KINDS, *registry.OPEN_LOOPS):
        yield registry.NO_FILTER if name in registry.OPEN_LOOPS else "its own", None
        return
    made = registry.CONTROLLERS[name](replace(spec, bandwidth=SETTINGS_HZ[10]))
    own = made.filter_model
    whole = tuning_by_uncertainty(spec, spec.model(own or spec.number), None if own is None else made.shafts)
    shares = (QUIET, replace(whole, load_acceleration=0.1 * whole.load_acceleration), whole)
    yield from zip(FILTERS, shares, strict=True)


def share_of_limits(loop: Loop, margins: Margins, loads: tuple[float, float]) -> float:
    """What a nominal loop keeps of the limits, over them; ``loads``: factors of the load that it meets."""
    if margins is UNLIMITED:
        done = run(loop, log=False)
        return float(not done.failed and done.score["saturated"] == 0.0)
    share = min(margins.disk / LEAST_DISK, ripple_limit(loop.spec) / margins.ripple)
    if share < 1.0 or loads == (1.0, 1.0):
        return share
    *others, own = loop.chain.inertias
    for load in loads:  # on the nominal plant with another load, announced if it can be
        loaded = with_plant(loop, replace(loop.chain, inertias=(*others, load * own)))
        share = min(share, margins_of(loaded, load).disk / LOADED_DISK)
    return share


def nominal_loop(made: Controller, spec: DesignSpec, tuning: KalmanTuning | None = None) -> Loop:
    """A law with a filter on its nominal plant; ``tuning``: default: that of the law."""
    return close_loop(replace(spec, plant=None), _filtered(made, tuning), np.random.default_rng(0))
