"""Stage 6: the laws that a study tries, simplest first, each tuned as `track` and `compare` tune it.

Besides the limits of `cabledrive.rig.tuning` a setting keeps its runs on plants drawn for tuning alone, from
what is known of the drive; the acceptance draws others.
"""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

from cabledrive.parameters import Drive, InputRefused, NotComputed
from cabledrive.rig.closed_loop.loop import Loop, run
from cabledrive.rig.closed_loop.loop_numbers import SUMMARY
from cabledrive.rig.disturbed.disturbances_file import Disturbances
from cabledrive.rig.laws.controllers import Controller
from cabledrive.rig.laws.load_learning import KINDS
from cabledrive.rig.laws.registry import MAIN_LAWS
from cabledrive.rig.setting import Motion
from cabledrive.rig.trial import spec_for
from cabledrive.rig.tuning import LEAST_DISK, TUNING_DRAWS, TUNING_SEED, law_at, ripple_limit, tuned
from cabledrive.studies.study.closed_loop import joined_loop, make_law, near_encoder, rig_options, with_values
from cabledrive.studies.study.controller_stage import ControllerResult
from cabledrive.studies.study.knowledge_stage import Knowledge
from cabledrive.studies.study.sampled_plants import sampled_plant

FIXED = ("pd", "shaper", "pid", "dob", "lqg", "lqi", "hinf", "l1", "mrac")
"""Tried before the law of the chain, simplest first; after it those that learn the load along the motion."""
MOST_TORQUE = 2.0 / 3.0
"""Share of the torque limit that the tuning may use: the acceptance draws plants that need more."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LawSetting:
    """A control law with the one number that tunes it.

    Attributes
    ----------
    controller : str
        A name that `track` knows.
    model : int or None
        Of a law of the chain; None: any other law.
    value : float or None
        Bandwidth [Hz]; None: nothing could be used.
    filter : str
        Of `cabledrive.rig.tuning.filters`; empty: of the law of the chain, or of a carriage.
    reason : str
        Why it cannot be used; empty where it can.
    """

    controller: str
    model: int | None
    value: float | None
    filter: str = ""
    reason: str = ""

    @property
    def words(self) -> str:
        """The setting in a few words; empty where there is none."""
        if self.value is None:
            return ""
        return f"{self.value:.3g} Hz" + (f", filter {self.filter}" if self.filter else "")


@dataclass(frozen=True, slots=True, kw_only=True)
class LawSettings:
    """Every law that is tried, simplest first."""

    settings: tuple[LawSetting, ...]


def tuned_laws(
    drive: Drive,
    motion: Motion,
    known: Knowledge,
    chain_law: ControllerResult,
    torque: float | None,
    *,
    every_law: bool = False,
) -> LawSettings:
    """Each law at its best setting: those that a comparison offers, or every one.

    ``drive``: with the best values; ``chain_law``: the damped law of the chain, whose bandwidth its bound has
    chosen; ``torque``: largest torque of the goals [N m].
    """
    usable = chain_law.bandwidth is not None
    chain = LawSetting(
        controller=chain_law.name,
        model=chain_law.model,
        value=chain_law.bandwidth,
        reason="" if usable else chain_law.reason,
    )
    fixed, learning = (
        [_tuned(name, drive, motion, known, torque) for name in names if every_law or name in MAIN_LAWS]
        for names in (FIXED, KINDS)
    )
    return LawSettings(settings=(*fixed, chain, *learning))


def law_of(setting: LawSetting, drive: Drive, motion: Motion, known: Knowledge) -> Controller:
    """A law at its setting, ready to run.

    ``setting``: with a value; ``drive``: with the best values.
    """
    assert setting.value is not None
    if setting.model is not None:
        return make_law(drive, motion, known.quantities, setting.model, setting.value)
    spec = spec_for(drive, motion, feedback=near_encoder(drive), options=rig_options(drive))
    return law_at(setting.controller, setting.value, setting.filter, spec)


def _tuned(name: str, drive: Drive, motion: Motion, known: Knowledge, torque: float | None) -> LawSetting:
    spec = spec_for(drive, motion, feedback=near_encoder(drive), options=rig_options(drive))

    def worst(made: Controller) -> float:
        """Largest error over the plants for tuning [rad]; infinite where one ends early or asks too much."""
        loop = joined_loop(drive, drive, made, motion, torque)
        first = _error(loop, drive, known, 0)
        if first == float("inf"):
            return first
        with ThreadPoolExecutor(2) as pool:
            return max(first, *pool.map(lambda k: _error(loop, drive, known, k), range(1, TUNING_DRAWS)))

    empty = LawSetting(controller=name, model=None, value=None)
    try:
        found = tuned(name, spec, Disturbances(), worst)
    except (NotComputed, InputRefused) as failure:
        return replace(empty, reason=str(failure))
    if not found.accepted:
        why = (
            f"no bandwidth keeps a disk margin of {LEAST_DISK:g}, a torque ripple of "
            f"{ripple_limit(spec):.3g} N m and {100 * MOST_TORQUE:.0f} % of the torque limit on the plants "
            "for tuning"
        )
        return replace(empty, reason=why)
    return replace(empty, value=found.bandwidth, filter=found.filter)


def _error(loop: Loop, drive: Drive, known: Knowledge, draw: int) -> float:
    values, phases = sampled_plant(
        known.quantities, len(loop.rig.phases), TUNING_SEED, draw, known.correlations
    )
    done = run(with_values(loop, drive, values, phases), log=False)
    score = dict(zip(SUMMARY, (float(v) for v in done.state.summary), strict=True))
    if done.failed or score["peak_torque"] > MOST_TORQUE * loop.rig.torque_limit:
        return float("inf")
    return score["peak"] / loop.gear
