"""Stages 3 and 5: certified modes, how far each reduced model holds, and which one the motion calls for."""

from dataclasses import dataclass

import numpy as np

from cabledrive.modal import modes
from cabledrive.parameters import Drive
from cabledrive.reduction.lumped_chain import highest_model
from cabledrive.reduction.quality import ModelQuality, model_quality, with_measured_stiffness
from cabledrive.rig.closed_loop.loop import plant_chain
from cabledrive.rig.ranking.ranked import one_count
from cabledrive.rig.setting import DEGREE, Motion

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
    """One certified mode.

    Attributes
    ----------
    frequency : float
        [Hz].
    kind, family : str
    multiplicity : int
    """

    frequency: float
    kind: str
    family: str
    multiplicity: int


@dataclass(frozen=True, slots=True, kw_only=True)
class ModesResult:
    """Distributed and lumped modes.

    Attributes
    ----------
    rows : tuple of ModeRow
        The first few of each kind.
    certified : bool
    certified_reason : str or None
        Why not.
    warnings : tuple of str
        What of the drive touches the list.
    longitudinal, transverse : int
        Counts of the certificate.
    models : tuple of ModelQuality
        Empty where the reduced models do not apply.
    why_no_models : str
    """

    rows: tuple[ModeRow, ...]
    certified: bool
    certified_reason: str | None
    warnings: tuple[str, ...]
    longitudinal: int
    transverse: int
    models: tuple[ModelQuality, ...]
    why_no_models: str


def find_modes(drive: Drive, why_no_models: str) -> ModesResult:
    """Certified modes of the distributed drive, its stiffness as identified, and the lumped models beside it.

    ``why_no_models``: empty where the reduced models apply.
    """
    machine = with_measured_stiffness(drive)
    found = modes(machine, count=SHOWN)
    rows = tuple(
        ModeRow(frequency=m.frequency, kind=m.kind, family=m.family, multiplicity=m.multiplicity)
        for m in sorted(found.modes, key=lambda m: m.frequency)
    )
    return ModesResult(
        rows=rows,
        certified=found.certified,
        certified_reason=found.certified_reason,
        warnings=found.warnings,
        longitudinal=found.certificate.longitudinal,
        transverse=found.certificate.transverse,
        models=model_quality(drive) if not why_no_models else (),
        why_no_models=why_no_models,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelEvidence:
    """What one reduced model leaves out along the motion.

    Attributes
    ----------
    model : int
    words : str
    holds : float
        Up to which frequency its response is right to 5 % [Hz].
    windup : float
        Largest twist, along the motion, of the springs it takes as rigid [rad at the load].
    """

    model: int
    words: str
    holds: float
    windup: float


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelResult:
    """The model that the controller is made for.

    Attributes
    ----------
    chosen : int
    tolerance : float
        Windup that may be left out [rad].
    evidence : tuple of ModelEvidence
    reason : str
    """

    chosen: int
    tolerance: float
    evidence: tuple[ModelEvidence, ...]
    reason: str


def choose_reduced_model(
    drive: Drive, motion: Motion, error: float | None, qualities: tuple[ModelQuality, ...]
) -> ModelResult:
    """The simplest model whose neglected springs wind up by less than a tenth of the error allowed.

    ``error``: allowed [rad]; None: one count of the load encoder, else of the one nearest to it.
    """
    allowed = error if error is not None else one_count(drive)
    tolerance = NEGLIGIBLE * allowed
    windups = neglected_windup(drive, motion)
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
    reason += (
        f"; simpler models neglect more than the {tolerance / DEGREE:.3g} deg allowed: {least}"
        if least
        else ""
    )
    return ModelResult(chosen=chosen, tolerance=tolerance, evidence=evidence, reason=reason)


def neglected_windup(drive: Drive, motion: Motion) -> dict[int, float]:
    """Largest twist of the springs that each model takes as rigid, along a motion.

    Returns by model [rad at the load].
    """
    chain = plant_chain(drive, None)
    gear = drive.load_pulley.radius / drive.drive_pulley.radius
    time = np.linspace(0.0, motion.trajectory.duration, 2001)
    acceleration = gear * float(np.abs(motion.trajectory(time, 2)[2]).max())
    torque, twists = 0.0, []
    for inertia, stiffness in zip(chain.inertias[:0:-1], chain.stiffness[::-1], strict=True):
        torque += inertia * acceleration
        twists.append(torque / stiffness / gear)
    cable, joint = twists[0], (twists[1] if len(twists) > 1 else 0.0)
    return {1: cable + joint, 2: cable, 3: joint, 4: 0.0}
