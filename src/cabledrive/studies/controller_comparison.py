"""`compare`: control laws side by side on one drive, tuned and run by one procedure."""

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import nullcontext
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from cabledrive.answers.result import Result
from cabledrive.answers.runs import COSTS, ERRORS
from cabledrive.parameters import Drive, InputRefused, Machine, content_hash
from cabledrive.parameters.fields import described, meaning
from cabledrive.parameters.files import one_process
from cabledrive.reduction.network_axis import as_axis, axis_notes, axis_words
from cabledrive.rig.laws.controllers import DesignSpec
from cabledrive.rig.laws.registry import CONTROLLERS, needed_order
from cabledrive.rig.plant_samples import (
    Disturbances,
    Draws,
    early_words,
    load_disturbances,
    scored,
    share_low,
    standard_disturbances,
)
from cabledrive.rig.setting import DEGREE, Motion, check_run, random_from, torque_limit
from cabledrive.rig.trial import COMPARED, check_motion, checked_names, goal_of, no_runs, offered
from cabledrive.rig.tuning import LEAST_DISK, LawSetting, ripple_limit, setting_of, tuned_loop
from cabledrive.studies.study.stage_cache import Made, StageCache


@dataclass(frozen=True, slots=True, kw_only=True)
class ComparedLaw:
    """One law of a comparison."""

    tuning: LawSetting
    scores: Draws  # empty where it could not be tuned


@described
@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class Comparison(Result):
    """Controllers side by side, the best first."""

    _table, _heading = "summary.controllers", "{0.summary[draws]} plants"
    _columns = " ".join(row.key for row in (*ERRORS, *COSTS))
    summary: dict[str, Any] = meaning("what `cabledrive compare --json` prints")
    laws: tuple[ComparedLaw, ...] = meaning("the best first")

    @property
    def figures(self) -> list[tuple[str, str]]:
        """Median and worst error of each law."""
        said = "median {median_deg:.4f}, worst {worst_deg:.4f} deg"
        return [(one["name"], one["reason"] or said.format(**one)) for one in self.summary["controllers"]]


def law_words(law: ComparedLaw, goal: float) -> dict[str, Any]:
    """One row of the answer: errors in degrees, torques in N m, margins; ``goal`` [rad]."""
    tuning, scores = law.tuning, law.scores
    inside, runs = int(np.count_nonzero(scores.errors <= goal)), len(scores.peak)
    return {
        "name": tuning.controller,
        "bandwidth_hz": tuning.bandwidth,
        "filter": tuning.filter,
        "learns": scores.learns,
        "disk_margin": tuning.margins.get("disk"),
        "gain_margin": tuning.margins.get("gain"),
        "phase_margin_deg": None if (phase := tuning.margins.get("phase")) is None else phase / DEGREE,
        "torque_ripple": tuning.margins.get("ripple"),
        "tuning_seconds": tuning.seconds,
        "reason": tuning.reason or early_words(scores.errors),
        "runs": runs,
        "failed": sum(scores.failed),
        "worst_deg": scores.quantile(1.0),
        "median_deg": scores.quantile(0.5),
        "error_99_deg": scores.quantile(0.99),
        "worst_whole_run_deg": replace(scores, learns=False).quantile(1.0),
        "worst_later_deg": replace(scores, learns=True).quantile(1.0),
        "share_within": inside / runs if runs else None,
        "share_low": share_low(inside, runs) if runs else None,
        "peak_torque": max(scores.peak_torque, default=None),
        "median_torque": float(np.median(scores.peak_torque)) if runs else None,
        "saturated_runs": int(np.count_nonzero(np.array(scores.saturated) > 0.0)),
    }


DRAWS, BLOCK = 100, 20
PULSES = 2
"""Of the motion where none is given: one to learn from, one to show what was learnt."""
NOT_COVERED = (
    "lumped plants only: the distributed cable and its transverse motion are not run",
    "margins are those of the nominal plant with frozen estimates and a slipping motor",
)


def compare(
    drive: Machine | Drive,
    *,
    axis: str | None = None,
    controllers: Sequence[str] | None = None,
    every_law: bool = False,
    disturbances: Disturbances | str | Path | None = None,
    draws: int = DRAWS,
    seed: int = 0,
    motion: Motion | None = None,
    goal: float | None = None,
    folder: str | Path | None = None,
    note: Callable[[str], None] | None = None,
) -> Comparison:
    """Compare control laws on a drive.

    Parameters
    ----------
    drive : Machine or Drive
        As every law believes it to be: a machine whose axis is a chain, or the drive of that axis.
    axis : str, optional
        Of a machine with routes: its load, such as "head.x".
    controllers : sequence of str, optional
        Names of laws, as `track` knows them; default: PD, PID, LQG, LQI, the damped DARC and `lqi-learning`.
    every_law : bool, default False
        Every law that `track` knows, where none are named.
    disturbances : Disturbances or path, optional
        Ranges from which each plant draws, or a TOML file with them; default: Coulomb friction of the load up
        to half that of the motor.
    draws : int, default 100
        Plants, the same for every law.
    seed : int, default 0
    motion : Motion, optional
        Default: two pulses of 45 deg in 0.5 s.
    goal : float, optional
        Largest error allowed [deg]; default: the drive's own, or one count of the load's encoder.
    folder : path, optional
        Where finished parts are kept, so that the same call goes on; nothing is kept without one.
    note : callable, optional
        Called with a line on what is being done.

    Returns
    -------
    Comparison

    Raises
    ------
    InputRefused
        If a name, a file or a number is not understood, or the motion exceeds what the drive can do.
    """
    drive = as_axis(drive, axis)
    motion = Motion.asked(motion or Motion(pulses=PULSES))
    asked = standard_disturbances(drive) if disturbances is None else disturbances
    if not isinstance(asked, Disturbances):
        asked = load_disturbances(asked)
    if every_law and controllers is None:
        controllers = tuple(CONTROLLERS)
    names = offered(drive, asked) if controllers is None else checked_names(controllers, drive)
    if asked.changes_load:
        (low, high), (least, most) = asked.announced, motion.payload_range
        motion = replace(motion, payload_range=(min(low, least), max(high, most)))
    if motion.order is None:
        motion = replace(motion, order=max(needed_order(name, drive) for name in names))
    for name in ("shock_time", "load_time"):
        latest, end = getattr(asked, name)[1], motion.trajectory.duration
        if latest >= end:
            said = f"{name} up to {latest:.4g} s, and the motion ends at {end:.4g} s"
            raise InputRefused(f"{said}: lower it, or add pulses")
    if draws < 1:
        raise InputRefused(f"draws = {draws} must be at least 1: give a number of plants")
    _ = random_from(seed)  # refuses what is no seed
    if goal is not None and not 0.0 < goal < float("inf"):
        raise InputRefused(
            f"goal = {goal:.4g} deg must be finite and above 0: give the largest error allowed"
        )
    check_run(drive, motion, COMPARED, draws=draws)
    check_motion(drive, motion)
    spec = DesignSpec(drive, motion, options=COMPARED)
    allowed = goal_of(drive) if goal is None else goal * DEGREE
    cache = StageCache(folder=None if folder is None else Path(folder), note=note or (lambda line: None))
    plain = replace(spec, drive=replace(drive, name="", title="", source=""))
    with nullcontext() if folder is None else one_process(Path(folder)):
        found = list(_laws(names, (plain, asked), draws, seed, cache))
    laws = tuple(sorted(found, key=lambda law: law.scores.rank(allowed)))
    return Comparison(summary=_summary(spec, laws, asked, draws, seed, allowed), laws=laws)


def _laws(
    names: Sequence[str], about: tuple[DesignSpec, Disturbances], draws: int, seed: int, cache: StageCache
) -> Iterator[ComparedLaw]:
    """Every law tuned and run: tunings and blocks of runs, each kept when it is done."""
    begun, finished = time.monotonic(), 0.0

    def progress(words: str, share: float) -> None:
        nonlocal finished
        finished += share
        left = (time.monotonic() - begun) * (len(names) / finished - 1.0)
        cache.note(f"{words}; about {left:.0f} s left" if left >= 1.0 else words)

    for name in names:
        cache.note(f"{name}: tuning")
        tuning = cache.staged(f"tuning-{name}", setting_of, name, *about)
        scores = no_runs(name, about[0].motion)
        if tuning.bandwidth is None:
            progress(f"{name}: {tuning.reason}", 1.0)
        else:
            law = Made(tuned_loop, (name, tuning.bandwidth, tuning.filter, about[0]))
            for first in range(0, draws, BLOCK):
                last, stage = min(first + BLOCK, draws), f"runs-{name}-{first:05d}"
                block = cache.staged(stage, scored, law, about[1], seed, tuple(range(first, last)))
                scores = scores.joined(block)
                progress(f"{name}: {last} of {draws} plants", (last - first) / draws)
        yield ComparedLaw(tuning=tuning, scores=scores)


def _summary(
    spec: DesignSpec,
    laws: Sequence[ComparedLaw],
    disturbances: Disturbances,
    draws: int,
    seed: int,
    goal: float,
) -> dict[str, Any]:
    motion, limit = spec.motion, torque_limit(spec.drive)
    ran = [law for law in laws if law.scores.peak]
    return {
        "controllers": [law_words(law, goal) for law in laws],
        "best": ran[0].tuning.controller if ran else None,
        "draws": draws,
        "seed": seed,
        "goal_deg": goal / DEGREE,
        "motion": {"angle_deg": motion.angle} | motion.words,
        "disturbances": {name: list(ends) for name, ends in asdict(disturbances).items()},
        "limits": {
            "disk_margin": LEAST_DISK,
            "torque_ripple": ripple_limit(spec),
            "torque": limit if np.isfinite(limit) else None,
        },
        "not_covered": [*NOT_COVERED, *axis_notes(spec.drive)[1:]],
        "drive": spec.drive.name,
        "drive_hash": content_hash(spec.drive),
    } | axis_words(spec.drive)
