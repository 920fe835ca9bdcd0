"""`compare`: tune laws by one procedure, run them on the same plants, and keep what is done."""

import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from functools import reduce
from pathlib import Path
from typing import Any

import numpy as np

from cabledrive.parameters import Drive, InputRefused, NotComputed, content_hash
from cabledrive.parameters.files import one_process
from cabledrive.parameters.route.drive import RoutedDrive
from cabledrive.parameters.route.two_pulleys import AxisDrive
from cabledrive.reduction.network_axis import as_axis, axis_notes
from cabledrive.rig.disturbances import torque_limit
from cabledrive.rig.disturbed.disturbances_file import Disturbances, load_disturbances, standard_disturbances
from cabledrive.rig.laws.controllers import DesignSpec
from cabledrive.rig.laws.registry import CONTROLLERS, needed_order
from cabledrive.rig.ranking.ranked import COMPARED, LEARNS, checked_names, goal_of, offered
from cabledrive.rig.ranking.scores import Scores, scored
from cabledrive.rig.setting import DEGREE, Motion
from cabledrive.rig.trial import check_motion, spec_for
from cabledrive.rig.tuning import LEAST_DISK, TunedLaw, law_as_tuned, ripple_limit, tuned
from cabledrive.studies.controller_comparison.comparison import (
    ComparedLaw,
    Comparison,
    TuningRecord,
    law_words,
    recorded,
    untuned,
)
from cabledrive.studies.study.stage_cache import Made, StageCache

DRAWS, BLOCK, MOST_DRAWS = 100, 20, 100_000
PULSES = 2
"""Of the motion where none is given: one to learn from, one to show what was learnt."""
NOT_COVERED = (
    "lumped plants only: the distributed cable and its transverse motion are not run",
    "margins are those of the nominal plant with frozen estimates and a slipping motor",
)


def compare(
    drive: Drive | RoutedDrive,
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
    drive : Drive or RoutedDrive
        As every law believes it to be; of a machine with routes the chain of its axis, where it is one.
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
    motion = motion or Motion(pulses=PULSES)
    asked = _disturbances(drive, disturbances)
    if every_law and controllers is None:
        controllers = tuple(CONTROLLERS)
    names = offered(drive, asked) if controllers is None else checked_names(controllers)
    if asked.changes_load:
        (low, high), (least, most) = asked.announced, motion.payload_range
        motion = replace(motion, payload_range=(min(low, least), max(high, most)))
    if motion.order is None:
        motion = replace(motion, order=max(needed_order(name, drive) for name in names))
    _check(draws, seed, goal)
    check_motion(drive, motion)
    spec = spec_for(drive, motion, options=COMPARED)
    allowed = goal_of(drive) if goal is None else goal * DEGREE
    job = _Job(drive, motion, asked, draws, seed, note or (lambda line: None), folder)
    if folder is None:
        laws = job.run(names)
    else:
        with one_process(Path(folder)):
            laws = job.run(names)
    laws = tuple(sorted(laws, key=lambda law: law.rank(allowed)))
    return Comparison(summary=_summary(spec, laws, asked, draws, seed, allowed), laws=laws)


def _disturbances(drive: Drive, given: Disturbances | str | Path | None) -> Disturbances:
    if given is None:
        return standard_disturbances(drive)
    return given if isinstance(given, Disturbances) else load_disturbances(given)


def _check(draws: int, seed: int, goal: float | None) -> None:
    if not 1 <= draws <= MOST_DRAWS:
        raise InputRefused(f"draws = {draws} must be from 1 to {MOST_DRAWS}: give a number of plants")
    if seed < 0:
        raise InputRefused(f"seed = {seed} must not be negative: give 0 or more")
    if goal is not None and not 0.0 < goal < float("inf"):
        raise InputRefused(
            f"goal = {goal:.4g} deg must be finite and above 0: give the largest error allowed"
        )


class _Job:
    """A comparison in progress: tunings and blocks of runs, each kept when it is done."""

    def __init__(
        self,
        drive: Drive,
        motion: Motion,
        disturbances: Disturbances,
        draws: int,
        seed: int,
        note: Callable[[str], None],
        folder: str | Path | None,
    ) -> None:
        self.asked = replace(drive, name="", title="", source=""), motion, disturbances
        self.draws, self.seed, self.note, self.several = draws, seed, note, motion.pulses > 1
        self.cache = StageCache(folder=None if folder is None else Path(folder), note=note)
        self.begun, self.finished, self.planned = time.monotonic(), 0.0, 1.0

    def run(self, names: Sequence[str]) -> tuple[ComparedLaw, ...]:
        """Every law tuned and run."""
        self.planned = float(len(names))
        return tuple(self._law(name) for name in names)

    def _law(self, name: str) -> ComparedLaw:
        self.note(f"{name}: tuning")
        tuning = self.cache.staged(f"tuning-{name}", tuning_of, name, *self.asked)
        scores = None if tuning.bandwidth is None else self._scores(tuning)
        if scores is None:
            self._progress(f"{name}: {tuning.reason}", 1.0)
        return ComparedLaw(tuning=tuning, scores=scores, learns=self.several and name in LEARNS)

    def _scores(self, tuning: TuningRecord) -> Scores:
        law, blocks = Made(tuned_again, (replace(tuning, seconds=0.0), *self.asked[:2])), []
        for first in range(0, self.draws, BLOCK):
            last, name = min(first + BLOCK, self.draws), f"runs-{tuning.name}-{first:05d}"
            blocks.append(self.cache.staged(name, runs_of, law, *self.asked, self.seed, first, last))
            self._progress(f"{tuning.name}: {last} of {self.draws} plants", (last - first) / self.draws)
        return reduce(Scores.joined, blocks)

    def _progress(self, words: str, share: float) -> None:
        self.finished += share
        left = (time.monotonic() - self.begun) * (self.planned / self.finished - 1.0)
        self.note(f"{words}; about {left:.0f} s left" if left >= 1.0 else words)


def tuning_of(name: str, drive: Drive, motion: Motion, disturbances: Disturbances) -> TuningRecord:
    """A law tuned within the limits, or why it cannot be."""
    spec = spec_for(drive, motion, options=COMPARED)
    try:
        found = tuned(name, spec, disturbances)
    except (NotComputed, InputRefused) as failure:
        return untuned(name, str(failure))
    if not found.accepted:
        why = f"{name}: no bandwidth keeps a disk margin of {LEAST_DISK:g} and a torque ripple of "
        return untuned(name, f"{why}{ripple_limit(spec):.3g} N m", found.seconds)
    return recorded(name, found.bandwidth, found.filter, found.margins, found.seconds)


def tuned_again(record: TuningRecord, drive: Drive, motion: Motion) -> TunedLaw:
    """The law of a tuning that was kept."""
    assert record.bandwidth is not None
    spec = spec_for(drive, motion, options=COMPARED)
    return law_as_tuned(record.name, record.bandwidth, record.filter, spec)


def runs_of(
    law: TunedLaw,
    drive: Drive,
    motion: Motion,
    disturbances: Disturbances,
    seed: int,
    first: int,
    last: int,
) -> Scores:
    """A tuned law on the plants of some draws."""
    spec = spec_for(drive, motion, options=COMPARED)
    return scored(law, spec, disturbances, COMPARED, seed, range(first, last))


def _summary(
    spec: DesignSpec,
    laws: Sequence[ComparedLaw],
    disturbances: Disturbances,
    draws: int,
    seed: int,
    goal: float,
) -> dict[str, Any]:
    motion, limit = spec.motion, torque_limit(spec.drive)
    assert motion is not None
    ran = [law for law in laws if law.scores is not None]
    return {
        "controllers": [law_words(law, goal) for law in laws],
        "best": ran[0].tuning.name if ran else None,
        "draws": draws,
        "seed": seed,
        "goal_deg": goal / DEGREE,
        "motion": {
            "angle_deg": motion.angle,
            "rise": motion.rise,
            "dwell": motion.dwell,
            "pulses": motion.pulses,
            "order": motion.rise_order,
        },
        "disturbances": {name: list(ends) for name, ends in asdict(disturbances).items()},
        "limits": {
            "disk_margin": LEAST_DISK,
            "torque_ripple": ripple_limit(spec),
            "torque": limit if np.isfinite(limit) else None,
        },
        "not_covered": [*NOT_COVERED, *axis_notes(spec.drive)[1:]],
        "drive": spec.drive.name,
        "drive_hash": content_hash(spec.drive),
    } | ({"axis": spec.drive.words} if isinstance(spec.drive, AxisDrive) else {})
