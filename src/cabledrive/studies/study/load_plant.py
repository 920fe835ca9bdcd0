"""Loads on the pulleys of a loop or a line: lumped plants first, then the distributed cable."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from cabledrive.mechanics.holding import released
from cabledrive.parameters import Drive
from cabledrive.parameters.route.two_pulleys import AxisDrive
from cabledrive.rig.closed_loop.loop import Loop, run
from cabledrive.rig.closed_loop.loop_numbers import SUMMARY
from cabledrive.rig.setting import Motion
from cabledrive.studies.study.closed_loop import joined_loop, with_values
from cabledrive.studies.study.controller_stage import design_controller
from cabledrive.studies.study.demand_stage import DemandResult, demand_of
from cabledrive.studies.study.goals import Goals
from cabledrive.studies.study.knowledge_stage import Knowledge, know, known_drive
from cabledrive.studies.study.law_settings import LawSetting, law_of, tuned_laws
from cabledrive.studies.study.log_files import Logs
from cabledrive.studies.study.modes_stage import ModesResult, choose_reduced_model
from cabledrive.studies.study.plant import EXCEEDED, Array, Candidates, ClosedLoop, RunHistory, Score
from cabledrive.studies.study.stage_cache import Made, StageCache

AXIS = "the lumped chain of an axis is run, its machine's spans are in the network of `simulate`"
LINE = "the cable plant is a loop round two pulleys, this drive is a line"
BACKLASH = "the distributed cable does not support motor.backlash"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LoadPlant:
    """A drive whose load pulley follows the motion.

    Attributes
    ----------
    drive : Drive
    goals : Goals
    cache : StageCache
    known : Knowledge or None
        None: not yet.
    missing : str
        What the file lacks for a controller; empty where one can be designed.
    """

    drive: Drive
    goals: Goals
    cache: StageCache
    known: Knowledge | None = None
    missing: str = ""

    kind = "lumped"

    @property
    def no_models(self) -> str:
        """Why the reduced models do not apply."""
        return self.missing

    @property
    def no_cable(self) -> str:
        """Why there are no plants on the distributed cable."""
        if isinstance(self.drive, AxisDrive):
            return AXIS
        if self.drive.kind != "loop":
            return LINE
        motor = self.drive.motor
        return BACKLASH if motor is not None and motor.backlash > 0.0 else ""

    def quantities(self, logs: Logs) -> Knowledge:
        """What is identified from the logs; the rest from the data sheet."""
        goals = self.goals
        return self.cache.staged(
            "knowledge", know, self.drive, logs, goals.spreads, goals.load_inertia, backlash=goals.backlash
        )

    def knowing(self, known: Knowledge) -> "LoadPlant":
        """The drive with the best values; as its file says where something is missing."""
        drive = self.drive if self.missing else known_drive(self.drive, known)
        return replace(self, drive=released(drive), known=known)

    def demand(self) -> DemandResult:
        """What the motion asks of motor and cable."""
        return self.cache.staged("demand", demand_of, self.drive, self.goals.motion, self.goals.torque)

    def candidates(self, modes: ModesResult, *, possible: bool) -> Candidates:
        """The reduced model, the damped law of the chain by its bound, and every law at its best setting."""
        if self.missing or not possible:
            return Candidates(reason=self.missing or EXCEEDED)
        goals, note, staged = self.goals, self.cache.note, self.cache.staged
        drive, motion = replace(self.drive, name="", title="", source=""), goals.motion
        assert self.known is not None
        note("[5/8] choice of the reduced model")
        model = staged("model", choose_reduced_model, drive, motion, goals.error, modes.models)
        note("[6/8] controllers: settings of each law")
        models = models_for_the_law(model.chosen, modes)
        controller = staged(
            "controller", design_controller, drive, motion, self.known.quantities, models, goals.torque
        )
        laws = staged(
            "laws",
            tuned_laws,
            drive,
            motion,
            self.known,
            controller,
            goals.torque,
            every_law=goals.every_law,
        )
        return Candidates(model=model, controller=controller, laws=laws.settings, bound=controller.bound)

    def closed_loop(self, law: LawSetting, *, cable: bool) -> Made[ClosedLoop]:
        """A law on this drive."""
        goals, drive = self.goals, replace(self.drive, name="", title="", source="")
        return Made(load_loop, (drive, goals.motion, self.known, law, goals.torque, cable))


def models_for_the_law(chosen: int, modes: ModesResult) -> dict[int, float]:
    """The model that the motion calls for, then the others that bend the cable, and up to where they hold.

    ``chosen``, {1, 3, 4}.
    Returns [Hz].
    """
    holds = {one.model: one.holds_5 for one in modes.models}
    others = [number for number in (4, 3) if number in holds and number != chosen]
    return {number: holds[number] for number in (chosen, *others)}


def load_loop(
    drive: Drive, motion: Motion, known: Knowledge, law: LawSetting, torque: float | None, cable: bool
) -> "LoadLoop":
    """A law at its setting; ``drive``: with the best values; ``torque``: largest of the goals [N m]."""
    made = law_of(law, drive, motion, known)
    return LoadLoop(joined_loop(drive, drive, made, motion, torque, cable=cable), drive)


@dataclass(frozen=True, slots=True, eq=False)
class LoadLoop:
    """A law on the plants of a drive, whose best values stand in ``drive``."""

    loop: Loop
    drive: Drive

    @property
    def encoders(self) -> int:
        """Encoders that are read."""
        return len(self.loop.rig.phases)

    def run(self, values: Mapping[str, float], phases: Array) -> Score:
        """Eccentricity of the load encoder is added to the error, since the law follows what it reads."""
        moved = with_values(self.loop, self.drive, values, phases)
        done = run(moved, log=False)
        found = dict(zip(SUMMARY, (float(v) for v in done.state.summary), strict=False))
        share = found["saturated"] / len(moved.target)
        if done.failed:
            return Score(peak=None, torque=None, saturated=share)
        peak = found["peak"] / moved.gear + values.get("eccentricity", 0.0)
        return Score(peak=peak, torque=found["peak_torque"], saturated=share)

    def history(self, values: Mapping[str, float], phases: Array) -> RunHistory:
        """The wanted angle of the load, its error, and the command."""
        moved = with_values(self.loop, self.drive, values, phases)
        log, rig = run(moved).log, moved.rig
        return RunHistory(
            time=np.asarray(rig.interval * np.arange(len(log)), dtype=np.float64),
            reference=moved.target / moved.gear,
            error=moved.load_error(log),
            torque=log[:, 2 * moved.chain.size + 1 + len(rig.encoders)],
        )
