"""Many plants at random within what is known of a drive, each run with encoder phases of its own."""

from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from cabledrive.control.darc import printed_bounds
from cabledrive.reduction.lumped_chain import LumpedChain
from cabledrive.rig.closed_loop.chain_plant import drawn_pair
from cabledrive.rig.closed_loop.loop import Loop, Run, run, with_plant
from cabledrive.rig.closed_loop.loop_numbers import SUMMARY, Array
from cabledrive.rig.setting import DEGREE

CONFIDENCE = 0.95


def share_low(inside: int, runs: int) -> float:
    """Lower limit of the share of plants inside, with `CONFIDENCE` (Clopper and Pearson, one-sided)."""
    from scipy.stats import beta

    if inside == 0:
        return 0.0
    return float(beta.ppf(1.0 - CONFIDENCE, inside, runs - inside + 1))


@dataclass(frozen=True, slots=True, kw_only=True)
class Spreads:
    """Relative half widths of what the bounds of p2 to p5 do not say."""

    cable_stiffness: float = 0.05
    load_inertia: float = 0.05
    cable_damping: float = 0.2
    joint_damping: float = 0.2
    joint_stiffness: float = 0.1
    drive_inertia: float = 0.05
    # largest Coulomb friction of the load over that of the motor; uniform from zero
    load_coulomb: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PlantSamples:
    """Peaks of many runs."""

    scores: Array  # (draws, scores): as `SUMMARY` names them, angles in rad at the load
    failed: int  # runs that ended before their time

    def degrees(self, name: str) -> Array:
        """A peak of every run by its name in `SUMMARY`, shape (draws,) [deg]."""
        return self.scores[:, SUMMARY.index(name)] / DEGREE


def sampled_chain(
    chain: LumpedChain, generator: np.random.Generator, spreads: Spreads | None = None
) -> LumpedChain:
    """One plant at random: motor within the printed bounds, the rest within its spreads, all uniform."""
    spreads = spreads or Spreads()
    bounds = printed_bounds(chain, flexible_joint="drive" in chain.names[1:])
    inertia, viscous, coulomb, offset = bounds.low + generator.random(4) * bounds.spread

    def about(value: float, spread: float) -> float:
        return value * (1.0 + spread * generator.uniform(-1.0, 1.0))

    inertias, stiffness, damping = [inertia], [], []
    for i in range(1, chain.size):
        last = i == chain.size - 1 and "load" in chain.names
        inertias.append(about(chain.inertias[i], spreads.load_inertia if last else spreads.drive_inertia))
        stiffness.append(
            about(chain.stiffness[i - 1], spreads.cable_stiffness if last else spreads.joint_stiffness)
        )
        damping.append(about(chain.damping[i - 1], spreads.cable_damping if last else spreads.joint_damping))
    friction = chain.coulomb[1:]
    if spreads.load_coulomb > 0.0 and chain.size > 1:
        drawn = spreads.load_coulomb * chain.coulomb[0] * generator.random()
        friction = (*friction[:-1], friction[-1] + drawn)
    return replace(
        chain,
        inertias=tuple(inertias),
        viscous=(viscous, *chain.viscous[1:]),
        coulomb=(coulomb, *friction),
        offsets=(offset, *chain.offsets[1:]),
        stiffness=tuple(stiffness),
        damping=tuple(damping),
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


def sampled_loops(loop: Loop, draws: int, seed: int, spreads: Spreads | None = None) -> Iterator[Loop]:
    """The same law and filter on one plant after another."""
    options = loop.options
    random = options.encoder_phase == "random" and not options.ideal_sensors
    for generator in np.random.default_rng(seed).spawn(draws):
        chain = sampled_chain(loop.chain, generator, spreads)
        phases = generator.uniform(-0.5, 0.5, len(loop.rig.phases))
        rig = loop.rig._replace(phases=phases) if random else loop.rig
        other = replace(with_plant(loop, chain), rig=rig)
        yield other if loop.pair is None else replace(other, pair=drawn_pair(loop.pair, generator))


def run_samples(
    loop: Loop, draws: int, seed: int, *, each: Callable[[Loop], Run] | None = None, threads: int = 2
) -> PlantSamples:
    """Run many plants, in threads; ``each``: how a plant is run, default from rest to the end."""
    ran = each or (lambda one: run(one, log=False))

    def score(one: Loop) -> tuple[Array, bool]:
        done = ran(one)
        return done.state.summary, done.failed

    with ThreadPoolExecutor(threads) as pool:
        results = list(pool.map(score, sampled_loops(loop, draws, seed)))
    scores = np.array([result for result, _ in results])
    angles = [SUMMARY.index(name) for name in ("peak", "first_peak", "later_peak", "own_peak")]
    scores[:, angles] /= loop.gear
    return PlantSamples(scores=scores, failed=sum(failed for _, failed in results))


def draw_words(found: PlantSamples, name: str = "peak") -> dict[str, object]:
    """Draws, median, 99 % and worst peak error [deg], largest torque [N m] and failures of many runs."""
    peak = found.degrees(name)
    return {
        "draws": len(peak),
        "median_peak_error_deg": float(np.median(peak)),
        "peak_error_99_deg": float(np.quantile(peak, 0.99)),
        "worst_peak_error_deg": float(peak.max()),
        "worst_first_pulse_error_deg": float(found.degrees("first_peak").max()),
        "worst_torque": float(found.scores[:, SUMMARY.index("peak_torque")].max()),
        "failed": found.failed,
    }
