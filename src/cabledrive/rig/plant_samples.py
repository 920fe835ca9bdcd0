"""Many plants at random within what is known of a drive, plain or disturbed, and a load that changes."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, fields, replace
from itertools import product
from math import ceil, inf, pi
from pathlib import Path
from typing import Any

import numpy as np

from cabledrive.control.darc import printed_bounds
from cabledrive.parameters import Drive, InputRefused
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.fields import require_known
from cabledrive.parameters.toml_values import quantity_of, read_toml
from cabledrive.reduction.lumped_chain import LumpedChain
from cabledrive.rig.closed_loop.chain_kernels import SUMMARY
from cabledrive.rig.closed_loop.chain_plant import drawn_pair, in_steps
from cabledrive.rig.closed_loop.loop import Loop, run, with_plant
from cabledrive.rig.laws import load_learning as learning
from cabledrive.rig.laws.controllers import Spreads
from cabledrive.rig.setting import DEGREE, Payload, none

CONFIDENCE = 0.95


def share_low(inside: int, runs: int) -> float:
    """Lower limit of the share of plants inside, with `CONFIDENCE` (Clopper and Pearson, one-sided)."""
    from scipy.stats import beta

    if inside == 0:
        return 0.0
    return float(beta.ppf(1.0 - CONFIDENCE, inside, runs - inside + 1))


def error_kept(errors: Sequence[float] | Array, share: float, runs: int | None = None) -> float | None:
    """Error that a share of the runs kept below: that of one of them, no value between two.

    Runs that ended early are infinite, or count in ``runs`` alone; None where they reach into the share.
    """
    needed = max(ceil(share * (len(errors) if runs is None else runs) - 1e-9), 1)
    found = float(np.sort(errors)[needed - 1]) if needed <= len(errors) else inf
    return found if np.isfinite(found) else None


def error_words(errors: Sequence[float] | Array, shares: Mapping[str, float]) -> dict[str, Any]:
    """Error that each share of the runs keeps, by its key; where there is none, how many ended early."""
    words = dict[str, Any]()
    for key, share in shares.items():
        error = error_kept(errors, share)
        words |= none(key, early_words(errors)) if error is None else {key: error}
    return words


def early_words(errors: Sequence[float] | Array) -> str:
    """How many runs ended early, with infinite errors; empty where none did."""
    failed = int(np.isinf(errors).sum())
    return f"{failed} of {len(errors)} runs ended early" if failed else ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Draws:
    """Runs of one law on many plants, one entry a plant."""

    # peak, first_peak, later_peak: largest error of the whole run, in its first pulse with its dwell, and
    # after that [rad at the load]
    peak: tuple[float, ...] = ()
    first_peak: tuple[float, ...] = ()
    later_peak: tuple[float, ...] = ()
    peak_torque: tuple[float, ...] = ()  # [N m]
    # saturated, loose: samples at the torque limit, and with an open flank of a pair of motors
    saturated: tuple[float, ...] = ()
    loose: tuple[float, ...] = ()
    failed: tuple[bool, ...] = ()  # whether the run ended before its time
    learns: bool = False  # whether the first pulse is for learning, and the error counts after it

    def joined(self, other: "Draws") -> "Draws":
        """These runs and others."""
        names = [f.name for f in fields(self)][:-1]
        runs: dict[str, Any] = {name: (*getattr(self, name), *getattr(other, name)) for name in names}
        return replace(self, **runs)

    @property
    def errors(self) -> Array:
        """Error of each run [rad]; infinite where it ended early."""
        return np.where(np.array(self.failed, dtype=bool), inf, self.later_peak if self.learns else self.peak)

    def quantile(self, share: float) -> float | None:
        """Error [deg] that this share of the runs keeps, see `error_kept`."""
        return error_kept(self.errors / DEGREE, share)

    def rank(self, goal: float) -> tuple[float, float, float]:
        """Shares of plants outside the goal [rad] and of early ends, largest error: smaller is better."""
        errors = self.errors
        if not errors.size:
            return inf, inf, inf
        return float(np.mean(errors > goal)), float(np.mean(errors == inf)), float(errors.max())


def over(loops: Iterable[Loop], threads: int = 2) -> Draws:
    """Run a law on plants, in threads; one that is made anew after a pulse learns on each."""
    names = [field.name for field in fields(Draws)][:-2]
    angles = np.array([name.endswith("peak") for name in names])

    def score(one: Loop) -> tuple[float, ...]:
        done = learning.run_indirect(one)[1] if learning.made_anew(one.controller) else run(one, log=False)
        found = done.state.summary[[SUMMARY.index(name) for name in names]]
        return *np.where(angles, found / one.gear, found).tolist(), done.failed

    with ThreadPoolExecutor(threads) as pool:
        rows = list(pool.map(score, loops))
    runs: dict[str, Any] = dict(zip((*names, "failed"), zip(*rows, strict=True), strict=True))
    return Draws(**runs)


def sampled_chain(
    chain: LumpedChain, generator: np.random.Generator, spreads: Spreads | None = None
) -> LumpedChain:
    """One plant at random: motor within the printed bounds, the rest within its spreads, all uniform."""
    spreads = spreads or Spreads()
    bounds = printed_bounds(chain, flexible_joint="drive" in chain.names[1:])
    inertia, viscous, coulomb, offset = bounds.low + generator.random(4) * bounds.spread

    widths = [(spreads.drive_inertia, spreads.joint_stiffness, spreads.joint_damping)] * (chain.size - 1)
    if widths and "load" in chain.names:
        widths[-1] = spreads.load_inertia, spreads.cable_stiffness, spreads.cable_damping
    moved = 1.0 + np.reshape(widths, (-1, 3)) * generator.uniform(-1.0, 1.0, (len(widths), 3))
    links = moved.T * [chain.inertias[1:], chain.stiffness, chain.damping]
    inertias, stiffness, damping = (tuple(values) for values in links.tolist())
    return replace(
        chain,
        inertias=(inertia, *inertias),
        viscous=(viscous, *chain.viscous[1:]),
        coulomb=(coulomb, *chain.coulomb[1:]),
        offsets=(offset, *chain.offsets[1:]),
        stiffness=stiffness,
        damping=damping,
    )


def corners(chain: LumpedChain, spreads: Spreads | None = None) -> list[LumpedChain]:
    """Chains at the ends of the intervals of cable stiffness and damping and of the load's inertia."""
    spread = spreads or Spreads()
    widths = np.array([spread.cable_stiffness, spread.cable_damping, spread.load_inertia])
    ends = product((-1.0, 1.0), repeat=3) if chain.size > 1 else ()
    return [varied(chain, chain.size - 1, *(widths * signs).tolist()) for signs in ends]


def varied(chain: LumpedChain, place: int, stiff: float, damped: float, heavy: float) -> LumpedChain:
    """A chain whose inertia at a place and link before it are changed by these shares."""
    stiffness, damping, inertias = list(chain.stiffness), list(chain.damping), list(chain.inertias)
    stiffness[place - 1] *= 1.0 + stiff
    damping[place - 1] *= 1.0 + damped
    inertias[place] *= 1.0 + heavy
    return replace(chain, stiffness=tuple(stiffness), inertias=tuple(inertias), damping=tuple(damping))


def sampled_loops(loop: Loop, draws: int, seed: int) -> Iterator[Loop]:
    """The same law and filter on one plant after another."""
    options = loop.spec.options
    random = options.encoder_phase == "random" and not options.ideal_sensors
    for generator in np.random.default_rng(seed).spawn(draws):
        chain = sampled_chain(loop.chain, generator)
        phases = generator.uniform(-0.5, 0.5, len(loop.rig.phases))
        rig = loop.rig._replace(phases=phases) if random else loop.rig
        other = replace(with_plant(loop, chain), rig=rig)
        yield other if loop.pair is None else replace(other, pair=drawn_pair(loop.pair, generator))


def loop_with_loads(loop: Loop) -> Loop:
    """A loop whose plant's load changes as its options say."""
    motion, options = loop.spec.motion, loop.spec.options
    if motion.payload and loop.controller.schedule is None:
        raise InputRefused(
            f"payload = {motion.payload[0].factor:.4g} is announced, and {loop.controller.name} takes no "
            f"announcement: take {learning.SCHEDULED}, or leave payload out"
        )
    end = (len(loop.controller.reference) - 1) * loop.rig.interval
    for one in motion.payload:
        if one.start > end:
            raise InputRefused(
                f"payload from {one.start:.4g} s on: the run ends at {end:.4g} s: name a time in it"
            )
    if options.load_change is None:
        return loop
    if options.load_change[0] > end:
        raise InputRefused(
            f"load_change at {options.load_change[0]:.4g} s: the run ends at {end:.4g} s: name a time in it"
        )
    if loop.cable is not None or loop.own_plant is not None:
        raise InputRefused("load_change is of a lumped chain: leave the plant or --load-change out")
    time, factor = options.load_change
    return replace(loop, plant=loop.plant._replace(load_time=time, load_factor=factor), disturbed=True)


Range = tuple[float, float]
NONE: Range = (0.0, 0.0)


def within(unit: str, least: float, most: float) -> dict[str, Any]:
    """SI unit of a range, and the least and the largest value that it may hold."""
    return {"unit": unit, "ends": (least, most)}


FRICTION_SHARE = 0.5
"""Largest Coulomb friction of the load, over that of the motor, where nothing else is stated."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Disturbances:
    """Ranges from which each plant of a comparison draws, all at the first shaft."""

    # load_coulomb, load_viscous: friction of the load beside that of the drive
    load_coulomb: Range = field(default=NONE, metadata=within("N m", 0.0, inf))
    load_viscous: Range = field(default=NONE, metadata=within("N m s/rad", 0.0, inf))
    # friction at standstill over Coulomb friction
    stribeck_excess: Range = field(default=NONE, metadata=within("1", 0.0, 10.0))
    # at which a third of it is left
    stribeck_speed: Range = field(default=(0.3, 0.3), metadata=within("rad/s", 1e-3, inf))
    # of the motor's gearhead, from end to end
    backlash: Range = field(default=NONE, metadata=within("rad", 0.0, 0.5))
    # cogging_periods, ripple_periods: per turn of the motor's shaft; torque_ripple: share of the torque
    cogging: Range = field(default=NONE, metadata=within("N m", 0.0, inf))
    cogging_periods: Range = field(default=(24.0, 24.0), metadata=within("1", 1.0, 10_000.0))
    torque_ripple: Range = field(default=NONE, metadata=within("1", 0.0, 1.0))
    ripple_periods: Range = field(default=(6.0, 48.0), metadata=within("1", 1.0, 10_000.0))
    # error of the load's encoder, once per turn
    encoder_eccentricity: Range = field(default=NONE, metadata=within("rad", 0.0, 0.5))
    # on top of the drive's own, unknown to the filter
    added_delay: Range = field(default=NONE, metadata=within("s", 0.0, inf))
    # standard deviation of the sample times
    jitter: Range = field(default=NONE, metadata=within("s", 0.0, inf))
    # load_factor, load_time: factor of the load's inertia from a time on
    load_factor: Range = field(default=(1.0, 1.0), metadata=within("1", 0.05, 20.0))
    load_time: Range = field(default=NONE, metadata=within("s", 0.0, inf))
    # announced_error, announced_late: of the load that is announced to a law scheduled by it: error as a
    # share of the true one, and by how much later than the change it comes, negative: earlier
    announced_error: Range = field(default=NONE, metadata=within("1", -0.9, 9.0))
    announced_late: Range = field(default=NONE, metadata=within("s", -inf, inf))
    # share of the cable's stiffness that is lost in a second
    softening: Range = field(default=NONE, metadata=within("1/s", 0.0, 1.0))
    # share of all Coulomb friction that is lost in a second
    warming: Range = field(default=NONE, metadata=within("1/s", 0.0, 1.0))
    # shock_torque, shock_time, shock_duration: torque on the load, its start and duration
    shock_torque: Range = field(default=NONE, metadata=within("N m", -inf, inf))
    shock_time: Range = field(default=NONE, metadata=within("s", 0.0, inf))
    shock_duration: Range = field(default=(0.01, 0.01), metadata=within("s", 0.0, inf))

    def __post_init__(self) -> None:
        for one in fields(self):
            unit, (least, most) = one.metadata["unit"], one.metadata["ends"]
            low, high = getattr(self, one.name)
            words = "" if unit == "1" else f" {unit}"
            if not least <= low <= high <= most:
                raise InputRefused(
                    f"{one.name} = {low:.4g} to {high:.4g}{words}: give smallest and largest, from "
                    f"{least:.4g} to {most:.4g}{words}"
                )

    @property
    def announced(self) -> Range:
        """Least and largest load that is announced, as factors; the drive's own is among them."""
        (low, high), (less, more) = self.load_factor, self.announced_error
        return min(1.0, low * (1.0 + less)), max(1.0, high * (1.0 + more))

    @property
    def changes_load(self) -> bool:
        """Whether the load's inertia may be another than that of the drive."""
        return self.load_factor != (1.0, 1.0)


def standard_disturbances(drive: Drive) -> Disturbances:
    """Coulomb friction of the load up to half that of the motor, where no file says otherwise."""
    own = drive.motor.coulomb_friction if drive.motor else 0.0
    return Disturbances(load_coulomb=(0.0, FRICTION_SHARE * own))


def load_disturbances(path: str | Path) -> Disturbances:
    """Read disturbances; a key that the file leaves out does not disturb."""
    return read_toml(path, 'write TOML such as load_coulomb = ["0 N m", "0.02 N m"]', disturbances_of)


def disturbances_of(content: Mapping[str, Any]) -> Disturbances:
    """Disturbances from a table of TOML: a quantity, or [smallest, largest]."""
    found: dict[str, Range] = {}
    units = {one.name: one.metadata["unit"] for one in fields(Disturbances)}
    for key, value in content.items():
        require_known(key, units, f"{key}: unknown key")
        ends = value if isinstance(value, list) else [value, value]
        if len(ends) != 2:
            raise InputRefused(f"{key}: {len(ends)} values are no range: write [smallest, largest]")
        low, high = (quantity_of(key, end, units[key]) for end in ends)
        found[key] = (low, high)
    return Disturbances(**found)


ANNOUNCED = ("announced_error", "announced_late")
"""Drawn last, and for laws that know the load alone: every law meets the same plants."""
STEP = 20e-6
"""Longest internal step [s]; a hundredth of a degree at 4 rad/s is forty of them."""
FIELDS = {
    **{name: name for name in ("cogging", "softening", "warming", "load_factor", "load_time")},
    **{"excess": "stribeck_excess", "fading": "stribeck_speed", "cogging_lines": "cogging_periods"},
    **{"ripple": "torque_ripple", "ripple_lines": "ripple_periods"},
}
"""Fields of a plant that take what is drawn as it is."""


def disturbed_loop(loop: Loop, disturbances: Disturbances, generator: np.random.Generator) -> Loop:
    """The same law and filter on one plant at random with its disturbances."""
    options = loop.spec.options
    if loop.cable is not None or loop.own_plant is not None:
        raise InputRefused("disturbed plants are lumped chains: leave the plant out")
    chain = sampled_chain(loop.chain, generator)
    names = [one.name for one in fields(disturbances) if one.name not in ANNOUNCED]
    drawn = {name: generator.uniform(*getattr(disturbances, name)) for name in names}
    chain = replace(
        chain,
        coulomb=(*chain.coulomb[:-1], chain.coulomb[-1] + drawn["load_coulomb"]),
        viscous=(*chain.viscous[:-1], chain.viscous[-1] + drawn["load_viscous"]),
    )
    phases = generator.uniform(-0.5, 0.5, len(loop.rig.phases))
    turned = generator.uniform(0.0, 2.0 * pi, 3)
    jitter = generator.normal(0.0, 1.0, len(loop.target) + 1)
    late = loop.rig.late_part + drawn["added_delay"]
    interval = loop.rig.interval
    if late >= interval:
        raise InputRefused(
            f"added_delay = {drawn['added_delay']:.4g} s reaches the next sample, {interval:.4g} s: keep it "
            "and the drive's own part of a sample below, or raise sensors.delay by whole samples"
        )
    random = options.encoder_phase == "random" and not options.ideal_sensors
    forces, first = loop.rig.forces.copy(), round(drawn["shock_time"] / interval)
    lasts = max(1, round(drawn["shock_duration"] / interval))  # at least a sample
    forces[first : first + lasts, 1] += drawn["shock_torque"]
    phases = phases if random else loop.rig.phases
    rig = loop.rig._replace(phases=phases, late_part=late, forces=forces)
    if drawn["jitter"] > 0.0:
        rig = rig._replace(jitter=np.clip(drawn["jitter"] * jitter, -0.4 * interval, 0.4 * interval))
    made = loop.controller
    if disturbances.changes_load and made.schedule is not None:
        drawn |= {name: generator.uniform(*getattr(disturbances, name)) for name in ANNOUNCED}
        start = max(drawn["load_time"] + drawn["announced_late"], 0.0)
        payload = Payload(factor=drawn["load_factor"] * (1.0 + drawn["announced_error"]), start=start)
        made = learning.with_announced_load(made, learning.announced((payload,), interval, len(loop.target)))
    return replace(with_disturbances(loop, chain, drawn, turned), rig=rig, controller=made)


def with_disturbances(loop: Loop, chain: LumpedChain, drawn: dict[str, float], turned: Array) -> Loop:
    """A loop on a chain with what was drawn; ``turned``, shape (3,): phases of its ripples [rad]."""
    if drawn["backlash"] > 0.0 and not {"motor", "drive"} <= set(chain.names):
        raise InputRefused(
            "backlash needs a flexible motor joint: give motor.joint_stiffness, or leave it out"
        )
    fresh, interval = with_plant(loop, chain, max(drawn["backlash"], loop.backlash)), loop.rig.interval
    more: dict[str, Any] = {field: drawn[name] for field, name in FIELDS.items()}
    more |= {"eccentricity": drawn["encoder_eccentricity"] * loop.gear, "turning": 1.0 / loop.gear}
    plant = fresh.plant._replace(phases=turned, **more)
    return replace(fresh, plant=in_steps(plant, interval, ceil(interval / STEP)), disturbed=True)


def scored(loop: Loop, disturbances: Disturbances, seed: int, draws: Sequence[int]) -> Draws:
    """Run a law on the plants of some draws, the same for every law: each has a generator of its own."""
    generators = (np.random.default_rng([seed, draw]) for draw in draws)
    return over(disturbed_loop(loop, disturbances, generator) for generator in generators)
