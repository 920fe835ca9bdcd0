"""Stages 3 to 5: certified modes, the internal resonance, and which reduced model holds how far."""

from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cabledrive.mechanics.holding import FREE
from cabledrive.modal import modes
from cabledrive.parameters import Drive, InputRefused, NotComputed
from cabledrive.parameters.route.strain_free import place_of
from cabledrive.parameters.route.two_pulleys import AxisDrive
from cabledrive.reduction.lumped_chain import highest_model
from cabledrive.reduction.quality import ModelQuality, model_quality, with_measured_stiffness
from cabledrive.rig.laws.controllers import plant_chain
from cabledrive.rig.setting import DEGREE, Motion
from cabledrive.rig.trial import one_count
from cabledrive.studies.alarm import DANGEROUS, SAFE, AlarmResult, alarm
from cabledrive.studies.planned_motion import PlannedMotion
from cabledrive.studies.resonance import resonance
from cabledrive.studies.resonance_detuning import RESONANT, UNKNOWN
from cabledrive.studies.route_pairs import route_resonance
from cabledrive.studies.study.machine import values_of

SHOWN = 4
NEGLIGIBLE = 0.1
"""Share of the error goal that a neglected spring may cause."""

MODEL_WORDS = {
    1: "rigid joint, rigid cable",
    2: "flexible joint, rigid cable",
    3: "rigid joint, flexible cable",
    4: "flexible joint, flexible cable",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class ModeRow:
    """One certified mode."""

    frequency: float  # [Hz]
    kind: str
    family: str
    multiplicity: int


@dataclass(frozen=True, slots=True, kw_only=True)
class ModesResult:
    """Distributed and lumped modes."""

    rows: tuple[ModeRow, ...]  # the first few of each kind
    certified: bool
    certified_reason: str | None  # why not
    warnings: tuple[str, ...]  # what of the drive touches the list
    # longitudinal, transverse: counts of the certificate
    longitudinal: int
    transverse: int
    models: tuple[ModelQuality, ...]  # empty where the reduced models do not apply
    why_no_models: str


def find_modes(drive: Drive, why_no_models: str) -> ModesResult:
    """Certified modes of the distributed drive, its stiffness as identified, and its lumped models."""
    machine = with_measured_stiffness(drive)
    found = modes(machine, count=SHOWN)
    rows = tuple(
        ModeRow(frequency=m.frequency, kind=m.kind, family=m.family, multiplicity=m.multiplicity)
        for m in sorted(found.modes, key=lambda m: m.frequency)
    )
    return ModesResult(
        rows=rows,
        **{name: getattr(found, name) for name in ("certified", "certified_reason", "warnings")},
        longitudinal=found.certificate.longitudinal,
        transverse=found.certificate.transverse,
        models=model_quality(drive) if not why_no_models else (),
        why_no_models=why_no_models,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelEvidence:
    """What one reduced model leaves out along the motion."""

    model: int
    words: str
    holds: float  # up to which frequency its response is right to 5 % [Hz]
    windup: float  # largest twist, along the motion, of the springs it takes as rigid [rad at the load]


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelResult:
    """The model that the controller is made for."""

    chosen: int
    tolerance: float  # windup that may be left out [rad]
    evidence: tuple[ModelEvidence, ...]
    reason: str


def choose_reduced_model(
    drive: Drive, motion: Motion, error: float | None, qualities: tuple[ModelQuality, ...]
) -> ModelResult:
    """The simplest model whose neglected springs wind up by less than a tenth of ``error`` [rad]."""
    allowed = error if error is not None else one_count(drive)
    tolerance = NEGLIGIBLE * allowed
    # Largest twist along the motion of the springs that each model takes as rigid [rad at the load].
    chain, gear = plant_chain(drive, None), drive.load_pulley.radius / drive.drive_pulley.radius
    acceleration = gear * motion.trajectory.peak(2)
    pulled = np.cumsum(acceleration * np.array(chain.inertias[:0:-1]))
    cable, joint = [*(pulled / chain.stiffness[::-1] / gear).tolist(), 0.0][:2]
    windups = {1: cable + joint, 2: cable, 3: joint, 4: 0.0}
    evidence = tuple(
        ModelEvidence(model=q.model, words=MODEL_WORDS[q.model], holds=q.holds_5, windup=windups[q.model])
        for q in qualities
        if q.model != 2
    )
    fitting = [one for one in evidence if one.windup <= tolerance]
    chosen = fitting[0].model if fitting else highest_model(drive)
    simpler = [one for one in evidence if one.model < chosen]
    least = ", ".join(f"Model {one.model} {one.windup / DEGREE:.3g} deg" for one in simpler)
    reason = f"Model {chosen} ({MODEL_WORDS[chosen]}) neglects {windups[chosen] / DEGREE:.3g} deg"
    if least:
        reason += f"; simpler models neglect more than the {tolerance / DEGREE:.3g} deg allowed: {least}"
    return ModelResult(chosen=chosen, tolerance=tolerance, evidence=evidence, reason=reason)


RIPPLE_SHARE = 0.05
"""Torque at the pulley mode's frequency over the motion's largest: cogging, friction, counts of encoders."""

REPEATED = 4
"""Pulses in a row for which the alarm is asked: the energy of one is still there when the next begins."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ResonanceResult:
    """Where a drive stands."""

    # {"safe", "close", "resonant", "unknown"}: under the ripple, if it swung at the pulley mode's frequency
    verdict: str
    # frequency_ratio, detuning, pulley_frequency: [-], [-], [Hz]
    frequency_ratio: float | None = None
    detuning: float | None = None
    pulley_frequency: float | None = None
    # tuned_pretension, threshold_torque: [N], [N m]
    tuned_pretension: float | None = None
    threshold_torque: float | None = None
    # torque, ripple: largest torque of the motion, and what is taken to ripple at the pulley mode's frequency
    # [N m]
    torque: float
    ripple: float
    # {"safe", "dangerous", "unknown"}: of the planned motion; None: it could not be computed
    alarm: str | None = None
    largest: float | None  # largest transverse amplitude along the motion [m]; None: beyond all numbers
    limit: float = 0.0  # what is allowed [m]
    slack: bool = False  # whether the pulley mode's response takes a span's tension away
    reasons: tuple[str, ...]
    remedy: str

    @property
    def refuses(self) -> bool:
        """Whether the motion is not to be run on this drive."""
        return self.alarm == DANGEROUS or self.verdict == RESONANT


def motion_torque(
    drive: Drive, motion: Motion, samples: int = 4001, *, rubbing: bool = True
) -> tuple[np.ndarray, np.ndarray]:
    """Times [s] and torque [N m] that a motion asks of the motor, drive as one rigid machine."""
    values = values_of(drive)
    gear = drive.load_pulley.radius / drive.drive_pulley.radius
    time = np.linspace(0.0, motion.trajectory.duration, samples)
    _, speed, acceleration = gear * motion.trajectory(time, 2)
    carried = sum(carriage.mass for carriage in drive.carriage) * drive.drive_pulley.radius**2
    inertia = values["near_inertia"] + values["load_inertia"] / gear**2 + carried
    torque = inertia * acceleration + values["viscous_friction"] * speed
    return time, torque + (values["coulomb_friction"] * np.sign(speed) if rubbing else 0.0)


def resonance_of(drive: Drive, motion: Motion) -> ResonanceResult:
    """Internal resonance of a drive, stiffness as identified, under a motion; of an axis its machine's."""
    repeated = replace(motion, pulses=max(motion.pulses, REPEATED))
    time, torque = motion_torque(drive, repeated, samples=8001)
    largest = float(np.abs(torque).max())
    ripple = RIPPLE_SHARE * largest
    names = ["verdict", "frequency_ratio", "detuning", "threshold_torque", "pulley_frequency"]
    found: dict[str, Any] = {"torque": largest, "ripple": ripple}
    judged: AlarmResult | None = None
    if isinstance(drive, AxisDrive):
        machine, failed, remedy = drive.machine, "", "move the pretension of the span away, or damp the cable"
        time, smooth = motion_torque(drive, repeated, samples=8001, rubbing=False)
        try:
            judged = alarm(machine, _shared_motion(drive, repeated, time, smooth))
        except (InputRefused, NotComputed) as failure:
            failed = f"planned motion: {failure}"
        else:
            remedy = judged.remedy
        reasons = (failed,) if judged is None else (*judged.reasons, *judged.assumptions)
        try:
            pairs = route_resonance(machine, torque=ripple / len(machine.motor), motor=FREE)
        except InputRefused as refusal:
            found |= {"verdict": UNKNOWN, "reasons": (f"pairs of modes: {refusal}", *reasons)}
        else:
            found |= {name: getattr(pairs, name) for name in names}
            found["reasons"] = (*pairs.reasons, *pairs.left_out, *reasons)
    else:
        stiff, remedy = with_measured_stiffness(drive), ""
        summary = resonance(stiff, torque=ripple, details=False)
        names += ["tuned_pretension", "reasons"]
        found |= {name: getattr(summary, name) for name in names}
        with suppress(InputRefused, NotComputed):
            judged = alarm(stiff, PlannedMotion(time=time, torque=torque))
            remedy = judged.remedy
        if summary.verdict == RESONANT and judged is not None and judged.verdict == SAFE:
            remedy = "move the pretension away from the tuned one, or damp the cable"
    if judged is None:
        largest_swing = None if isinstance(drive, AxisDrive) else 0.0
        return ResonanceResult(**found, largest=largest_swing, remedy=remedy)
    swing = float(judged.largest_transverse)
    found |= {"alarm": judged.verdict, "limit": float(judged.limit), "slack": bool(judged.slack)}
    return ResonanceResult(**found, largest=swing if np.isfinite(swing) else None, remedy=remedy)


def _shared_motion(drive: AxisDrive, motion: Motion, time: np.ndarray, torque: np.ndarray) -> PlannedMotion:
    """The motion of an axis as its machine makes it; ``torque``: of all motors together, (samples,) [N m]."""
    machine, signs = drive.machine, drive.words["motors"]
    first, *others = [machine.pulley[number].name for number in machine.driven]
    shares = {name: sign * torque / len(signs) for name, sign in signs.items()}
    way = motion.trajectory(time, 0)[0] * (drive.gain if drive.slides else np.sign(drive.gain))
    moves = [f"{body.name}.{move}" for body in machine.body for move in body.moves]
    places = {drive.load: place_of(machine, drive.load) + way} if drive.load in moves else {}
    torques = {one: shares[one] for one in others}
    return PlannedMotion(time=time, torque=shares[first], places=places, torques=torques)
