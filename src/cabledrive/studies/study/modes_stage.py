"""Stages 3 to 5: certified modes, the internal resonance, and which reduced model holds how far."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cabledrive.mechanics.holding import released
from cabledrive.modal import modes
from cabledrive.parameters import Drive, InputRefused, NotComputed
from cabledrive.parameters.route.strain_free import place_of
from cabledrive.reduction.lumped_chain import highest_model
from cabledrive.reduction.quality import ModelQuality, distributed, model_quality
from cabledrive.reduction.threshold import RESONANT
from cabledrive.rig.laws.controllers import plant_chain
from cabledrive.rig.setting import DEGREE, Motion
from cabledrive.rig.trial import one_count
from cabledrive.studies.alarm import DANGEROUS, SAFE, AlarmResult, alarm
from cabledrive.studies.planned_motion import PlannedMotion
from cabledrive.studies.resonance import resonance
from cabledrive.studies.resonance_detuning import UNKNOWN
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
    found = modes(released(distributed(drive)), count=SHOWN)
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
    """Internal resonance of a machine, stiffness of a loop as identified, under a motion of its axis."""
    repeated = replace(motion, pulses=max(motion.pulses, REPEATED))
    machine, motors = released(distributed(drive)), drive.axis.words["motors"]
    largest = float(np.abs(motion_torque(drive, repeated, samples=8001)[1]).max())
    ripple = RIPPLE_SHARE * largest
    found: dict[str, Any] = {"torque": largest, "ripple": ripple}
    judged: AlarmResult | None = None
    reasons: tuple[str, ...]
    try:
        judged = alarm(machine, planned_motion(drive, repeated, samples=8001))
        reasons = (*judged.reasons, *judged.assumptions)
    except (InputRefused, NotComputed) as failure:
        reasons = (f"planned motion: {failure}",)
    try:
        pairs = resonance(machine, torque=ripple / len(motors), details=False)
    except InputRefused as refusal:
        found |= {"verdict": UNKNOWN, "reasons": (f"pairs of modes: {refusal}", *reasons)}
    else:
        names = ("verdict", "frequency_ratio", "detuning", "threshold_torque", "pulley_frequency")
        found |= {name: getattr(pairs, name) for name in (*names, "tuned_pretension")}
        found["reasons"] = (*pairs.reasons, *pairs.left_out, *reasons)
    remedy = "" if judged is None else judged.remedy
    if found["verdict"] == RESONANT and (judged is None or judged.verdict == SAFE):
        remedy = "move the pretension away from the tuned one, or damp the cable"
    if judged is None:
        return ResonanceResult(**found, largest=None, remedy=remedy)
    swing = float(judged.largest_transverse)
    found |= {"alarm": judged.verdict, "limit": float(judged.limit), "slack": bool(judged.slack)}
    return ResonanceResult(**found, largest=swing if np.isfinite(swing) else None, remedy=remedy)


def planned_motion(drive: Drive, motion: Motion, samples: int) -> PlannedMotion:
    """The motion of an axis as its machine makes it, the torque shared by its motors.

    Coulomb friction is in it where `alarm` takes that from the file, of two pulleys alone.
    """
    axis = drive.axis
    machine, motors = axis.machine, axis.words["motors"]
    time, torque = motion_torque(drive, motion, samples, rubbing=not drive.chain_of)
    first, *others = (sign * torque / len(motors) for sign in motors.values())
    moves = [f"{body.name}.{move}" for body in machine.body for move in body.moves]
    way = motion.trajectory(time, 0)[0] * axis.per_angle
    places = {axis.load: place_of(machine, axis.load) + way} if axis.load in moves else {}
    torques = dict(zip(list(motors)[1:], others, strict=True))
    return PlannedMotion(time=time, torque=first, places=places, torques=torques)
