"""Stage 6: the laws that a study tries, simplest first, each at the setting that follows best.

The setting of a law is searched on plants drawn for tuning alone; the acceptance draws others.
"""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np

from cabledrive.control.observers import KalmanTuning
from cabledrive.parameters import Drive, InputRefused, NotComputed
from cabledrive.rig.closed_loop.loop import Loop, run
from cabledrive.rig.closed_loop.loop_numbers import SUMMARY
from cabledrive.rig.laws.baselines import lqg
from cabledrive.rig.laws.controllers import Controller, DesignSpec
from cabledrive.rig.laws.filter_tuning import read_encoders, tuning_by_uncertainty
from cabledrive.rig.laws.load_learning import KINDS
from cabledrive.rig.laws.registry import CONTROLLERS, MAIN_LAWS
from cabledrive.rig.setting import Motion
from cabledrive.rig.trial import spec_for
from cabledrive.studies.study.bandwidth_search import SAMPLES_PER_PERIOD
from cabledrive.studies.study.closed_loop import joined_loop, make_law, near_encoder, with_values
from cabledrive.studies.study.controller_stage import ControllerResult
from cabledrive.studies.study.knowledge_stage import Knowledge
from cabledrive.studies.study.sampled_plants import sampled_plant

SETTINGS: dict[str, tuple[float, ...]] = {
    "pd": (2.0, 5.0, 8.0, 11.0, 15.0, 20.0, 30.0, 45.0),
    "shaper": (2.0, 5.0, 11.0, 20.0, 35.0),
    "pid": (0.5, 1.0, 1.5, 2.0, 3.0, 5.0),
    "dob": (2.0, 5.0, 11.0),
    "lqg": (0.001, 0.005, 0.02, 0.05, 0.1, 0.2, 0.4, 0.8),
    "lqi": (5.0, 10.0, 15.0, 22.0, 30.0),
    "hinf": (2.0, 5.0, 10.0),
    "l1": (10.0, 22.0),
    "mrac": (10.0, 22.0),
}
"""Simplest law first: bandwidth [Hz]; of lqg the share of the torque limit that weighs as one count."""
LEARNING: dict[str, tuple[float, ...]] = dict.fromkeys(KINDS, (8.0, 15.0, 22.0, 32.0))
"""Laws that learn the load's torque along the motion, tried after the law of the chain: bandwidth [Hz]."""
QUIET, UNCERTAIN, OWN = "as known", "by uncertainty", ""
TUNING_SEED, TUNING_DRAWS = 1_000_003, 8
MOST_TORQUE = 2.0 / 3.0
"""Share of the torque limit that the tuning may use: the acceptance draws plants that need more."""
LQG_TORQUE = 1.0
"""What stands for the torque limit of a motor without one [N m]."""


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
        Bandwidth [Hz]; of lqg the torque that weighs as one count [N m]; None: nothing could be used.
    filter : {"as known", "by uncertainty", ""}
        What the Kalman filter takes as its noise: the encoders' counts, or also what is not known; empty: the
        law has its own.
    reason : str
        Why it cannot be used; empty where it can.
    """

    controller: str
    model: int | None
    value: float | None
    filter: str = QUIET
    reason: str = ""

    @property
    def words(self) -> str:
        """The setting in a few words; empty where there is none."""
        if self.value is None:
            return ""
        unit = "N m per count" if self.controller == "lqg" else "Hz"
        return f"{self.value:.3g} {unit}" + (f", filter noise {self.filter}" if self.filter else "")


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
    spec = spec_for(drive, motion, feedback=near_encoder(drive))
    usable = chain_law.bandwidth is not None
    chain = LawSetting(
        controller=chain_law.name,
        model=chain_law.model,
        value=chain_law.bandwidth,
        reason="" if usable else chain_law.reason,
    )
    fixed, learning = (
        [
            _tuned(name, offered, drive, motion, known, spec, torque)
            for name, offered in table.items()
            if every_law or name in MAIN_LAWS
        ]
        for table in (SETTINGS, LEARNING)
    )
    return LawSettings(settings=(*fixed, chain, *learning))


def law_of(setting: LawSetting, drive: Drive, motion: Motion, known: Knowledge) -> Controller:
    """A law at its setting, ready to run.

    ``setting``: with a value; ``drive``: with the best values.
    """
    assert setting.value is not None
    if setting.model is not None:
        return make_law(drive, motion, known.quantities, setting.model, setting.value)
    spec = spec_for(drive, motion, feedback=near_encoder(drive))
    if setting.controller == "lqg":
        made = lqg(spec, setting.value)
    else:
        made = CONTROLLERS[setting.controller](replace(spec, bandwidth=setting.value))
    if setting.filter != UNCERTAIN:
        return made
    return replace(made, tuning=replace(_uncertain(spec, made.model), cancels=made.tuning.cancels))


def _uncertain(spec: DesignSpec, model: int) -> KalmanTuning:
    counts = np.array(list(read_encoders(spec, 4).values()))
    return tuning_by_uncertainty(spec, spec.model(model), counts)


def _tuned(
    name: str,
    settings: Sequence[float],
    drive: Drive,
    motion: Motion,
    known: Knowledge,
    spec: DesignSpec,
    torque: float | None,
) -> LawSetting:
    limit = drive.motor.torque_limit if drive.motor and drive.motor.torque_limit else LQG_TORQUE
    limit = limit if torque is None else min(limit, torque)
    offered = [value * limit for value in settings] if name == "lqg" else _carried(settings, spec)
    filters = (OWN,) if name in LEARNING else (QUIET, UNCERTAIN)
    empty = LawSetting(controller=name, model=None, value=None)
    if not offered:
        rate = 1.0 / spec.interval
        return replace(empty, reason=f"the sample rate of {rate:.4g} Hz is too low for all of its bandwidths")
    tried = [replace(empty, value=value, filter=kind) for value in offered for kind in filters]
    worst = np.full(len(tried), np.inf)
    why = f"unstable, slack, or beyond {100 * MOST_TORQUE:.0f} % of the torque limit at every setting tried"
    for i, one in enumerate(tried):
        try:
            worst[i] = _worst(one, drive, motion, known, torque)
        except (NotComputed, np.linalg.LinAlgError) as failure:  # of this setting; another may do
            why = str(failure)
        except InputRefused as failure:
            return replace(empty, reason=str(failure))
    if not np.isfinite(worst).any():
        return replace(empty, reason=why)
    return tried[int(np.argmin(worst))]


def _carried(settings: Sequence[float], spec: DesignSpec) -> list[float]:
    """Bandwidths with enough samples in a period."""
    return [hertz for hertz in settings if hertz * spec.interval * SAMPLES_PER_PERIOD <= 1.0]


def _worst(
    setting: LawSetting, drive: Drive, motion: Motion, known: Knowledge, torque: float | None
) -> float:
    """Largest error over the plants for tuning [rad]; infinite where a run ends early or asks too much."""
    loop = joined_loop(drive, drive, law_of(setting, drive, motion, known), motion, torque)
    first = _error(loop, drive, known, 0)
    if not np.isfinite(first):
        return first
    with ThreadPoolExecutor(2) as pool:
        others = list(pool.map(lambda k: _error(loop, drive, known, k), range(1, TUNING_DRAWS)))
    return max(first, *others)


def _error(loop: Loop, drive: Drive, known: Knowledge, draw: int) -> float:
    values, phases = sampled_plant(
        known.quantities, len(loop.rig.phases), TUNING_SEED, draw, known.correlations
    )
    done = run(with_values(loop, drive, values, phases), log=False)
    score = dict(zip(SUMMARY, (float(v) for v in done.state.summary), strict=True))
    if done.failed or score["peak_torque"] > MOST_TORQUE * loop.rig.torque_limit:
        return float("inf")
    return score["peak"] / loop.gear
