"""The law that identifies in the loop on many plants drawn at random: what it reaches, what it learns."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cabledrive.parameters import NotComputed
from cabledrive.rig.closed_loop.loop import Loop
from cabledrive.rig.closed_loop.loop_numbers import Array
from cabledrive.rig.laws.controllers import DesignSpec
from cabledrive.rig.laws.indirect import Learnt, run_indirect
from cabledrive.rig.plant_samples import Spreads, sampled_loops
from cabledrive.rig.setting import DEGREE, RigOptions

RUBBING_LOAD = Spreads(load_coulomb=0.02 / 0.0376)
"""With Coulomb friction of the load up to 0.02 N m on the rig of the dissertation."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LearningSamples:
    """Peaks before and after learning, and what was learnt, one entry per draw that ran to its end."""

    # first, later: (draws,): peak error in the first pulse and its dwell, and after, of the true load angle
    # [rad]
    first: Array
    later: Array
    # own_first, own_later: (draws,): the same against the load encoder's own zero [rad]
    own_first: Array
    own_later: Array
    torque: Array  # (draws,): largest [N m]
    # beta, damping: (draws,): relative errors of beta and gamma
    beta: Array
    damping: Array
    # (draws, 8): whether the 95 % intervals of beta, gamma, whole inertia, viscous and Coulomb friction,
    # offset torque, and Coulomb and viscous friction of the load hold the true value
    covered: NDArray[np.bool_]
    friction: Array  # (draws,): Coulomb friction of the load [N m]
    failed: int  # runs that ended before their time
    unused: int  # runs in which what was learnt was not used

    @property
    def words(self) -> dict[str, Any]:
        """The figures, angles in deg."""
        own = self.own_later / DEGREE
        names = (
            *("beta", "gamma", "inertia", "viscous", "coulomb", "offset"),
            *("load_coulomb", "load_viscous"),
        )
        return {
            "draws": len(self.first) + self.failed,
            "failed": self.failed,
            "unused": self.unused,
            "largest_load_friction": float(self.friction.max()),
            "worst_first_pulse_error_deg": float(self.first.max() / DEGREE),
            "median_peak_error_deg": float(np.median(self.later) / DEGREE),
            "peak_error_99_deg": float(np.quantile(self.later, 0.99) / DEGREE),
            "worst_peak_error_deg": float(self.later.max() / DEGREE),
            "median_encoder_error_deg": float(np.median(own)),
            "encoder_error_99_deg": float(np.quantile(own, 0.99)),
            "worst_encoder_error_deg": float(own.max()),
            "worst_torque": float(self.torque.max()),
            "worst_relative_error_of_beta": float(np.abs(self.beta).max()),
            "interval_coverage": dict(zip(names, self.covered.mean(axis=0).tolist(), strict=True)),
        }


def run_learning_samples(
    loop: Loop,
    spec: DesignSpec,
    options: RigOptions,
    draws: int,
    seed: int,
    *,
    threads: int = 2,
    spreads: Spreads | None = None,
) -> LearningSamples:
    """Draw plants and encoder phases, run one pulse, learn, rebuild, run the rest."""

    def score(one: Loop) -> tuple[Array, Array] | None:
        _, done, found = run_indirect(spec, one, options)
        if found is None or done.failed:
            return None
        return _peaks(one, done.log), _truths(one, found)

    with ThreadPoolExecutor(threads) as pool:
        results = list(pool.map(score, sampled_loops(loop, options, draws, seed, spreads)))
    kept = [result for result in results if result is not None]
    if not kept:
        raise NotComputed(f"none of {draws} drawn plants ran to its end: take longer, turn less")
    peaks = np.array([peak for peak, _ in kept]).reshape(-1, 5)
    truths = np.array([truth for _, truth in kept]).reshape(-1, 12)
    return LearningSamples(
        first=peaks[:, 0],
        later=peaks[:, 1],
        own_first=peaks[:, 2],
        own_later=peaks[:, 3],
        torque=peaks[:, 4],
        beta=truths[:, 0],
        damping=truths[:, 1],
        friction=truths[:, 2],
        unused=int(np.count_nonzero(truths[:, 3] < 0.5)),
        covered=truths[:, 4:] > 0.5,
        failed=len(results) - len(kept),
    )


def _peaks(loop: Loop, log: Array) -> Array:
    """Peaks of true and own error in the first pulse and after, and of the torque."""
    n, pause = loop.chain.size, loop.rig.first_end
    error = loop.load_error(log)
    own = error + loop.rig.counts[-1] * loop.rig.phases[-1] / loop.gear
    command = log[:, 2 * n + 1 + len(loop.rig.encoders)]
    pairs = [[np.abs(e[:pause]).max(), np.abs(e[pause:]).max()] for e in (error, own)]
    return np.array([*pairs[0], *pairs[1], np.abs(command).max()])


def _truths(loop: Loop, found: Learnt) -> Array:
    """Relative errors of beta and gamma, friction of the load, use, and whether intervals hold the truth."""
    chain, load, motor = loop.chain, found.load, found.motor
    beta, gamma = chain.stiffness[-1] / chain.inertias[-1], chain.damping[-1] / chain.inertias[-1]
    actual = np.array([sum(chain.inertias), sum(chain.viscous), sum(chain.coulomb), chain.offsets[0]])
    inside = (motor.intervals[0] <= actual) & (actual <= motor.intervals[1])
    own = [chain.coulomb[-1] / chain.inertias[-1], chain.viscous[-1] / chain.inertias[-1]]
    pairs = (
        (beta, load.interval),
        (gamma, load.damping_interval),
        (own[0], load.coulomb_interval),
        (own[1], load.viscous_interval),
    )
    held = [low <= value <= high for value, (low, high) in pairs]
    errors = [load.beta / beta - 1.0, load.gamma / gamma - 1.0]
    return np.array(
        [*errors, chain.coulomb[-1], load.excited, *held[:2], *inside, *held[2:]], dtype=np.float64
    )
