"""Stage 8: yes, no or unknown, why, with which margins, and what would help.

Yes: a law holds the error goal with confidence, and nothing known contradicts the plants that it was tested
on. No: torque, speed, slack or resonance refuse the motion, which no law can mend. Unknown: all else.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from cabledrive.answers.figures import rounded
from cabledrive.mechanics.datasheet import elastic_range, largest_pretension
from cabledrive.reduction.network_axis import cross_motion
from cabledrive.rig.setting import control_delay, current_rate
from cabledrive.studies.study import findings
from cabledrive.studies.study.acceptance_stage import ENOUGH, ReachedError
from cabledrive.studies.study.bandwidth_cost import CarriageController
from cabledrive.studies.study.carriage import CarriageModel
from cabledrive.studies.study.goals import error_unit, goal_of
from cabledrive.studies.study.machine import WORDS
from cabledrive.studies.study.modes_stage import motion_torque
from cabledrive.studies.study.plants import ControllerResult

NO_BOUND = "no theorem bounds the error of the scheduled law: the error is a result of the runs"


YES, NO, UNKNOWN = "yes", "no", "unknown"
OTHER = (
    "complete what the carriage controller needs, where the machine allows it; modes, resonance and torque "
    "are valid without it"
)
ENDS = {
    "slack torque": "carry before a span goes slack",
    "slip torque": "carry before the rope slides on its pulley",
    "lost tension": "are the pretension",
}
NO_LOAD_ENCODER = (
    "no encoder at the load: the law computes its angle from the motor's; errors are of the simulated "
    "load, and what slips or stretches otherwise than the file says is not seen"
)
COMPLETE = "complete the drive file; modes, resonance and torque are valid without it"
CORRECT = (
    "decide between data sheet and log; then correct the drive file (drive.toml in the output folder has "
    "the identified values) or widen [uncertainty], and run the study again"
)
SHEET = "the verdict differs between plants within the tolerances of the data sheet"


@dataclass(frozen=True, slots=True, kw_only=True)
class Margin:
    """One figure against what is allowed."""

    name: str
    value: float
    allowed: float
    unit: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Verdict:
    """The end of a study."""

    answer: str  # {"yes", "no", "unknown"}
    # the first is the headline: what decides, or what is reached, and what was assumed for it
    reasons: tuple[str, ...]
    remedies: tuple[str, ...]
    margins: tuple[Margin, ...]
    cautions: tuple[str, ...]  # what does not decide, and should be known
    reached: ReachedError | None = None  # error of the chosen law [rad] or [m]; None: no law was run


def judge(found: findings.Findings) -> Verdict:
    """Put the stages together."""
    goals, chosen = found.goals, found.runs
    refusals, remedies = _refusals(found)
    if refusals:
        certain = goal_of(goals) is not None and not goals.assumed
        answer, reasons = NO if certain else UNKNOWN, refusals
    elif found.check.missing:
        carries = found.known is not None and bool(found.known.carriage)
        answer, reasons, remedies = UNKNOWN, list(found.check.missing), [OTHER if carries else COMPLETE]
    elif not chosen.draws:
        answer, reasons, remedies = UNKNOWN, [chosen.reason], ["sample faster, or fit finer encoders"]
    else:
        answer, reasons, remedies = _by_acceptance(found)
    if goals.assumed:
        reasons = [f"{reasons[0]} ({goals.assumed})", *reasons[1:]]
    margins = [
        Margin(name=demand.name, value=demand.asked, allowed=demand.limit, unit=demand.unit)
        for demand in found.demand.demands
        if demand.limit is not None
    ]
    goal, bound = goal_of(goals), _bound(found)
    for one in (chosen, found.cable):
        if goal is not None and one.reached and one.reached.error is not None:
            name, unit = f"error, {one.plant}", error_unit(goals).si
            margins.append(Margin(name=name, value=one.reached.error, allowed=goal, unit=unit))
    if goal is not None and bound is not None:
        margins.append(Margin(name="bound", value=bound, allowed=goal, unit="rad"))
    return Verdict(
        answer=answer,
        reasons=tuple(reasons),
        remedies=tuple(dict.fromkeys(remedies)),
        margins=tuple(margins),
        cautions=_cautions(found, reasons),
        reached=chosen.reached,
    )


def _refusals(found: findings.Findings) -> tuple[list[str], list[str]]:
    """Torque, speed, slack and resonance: limits that no controller removes."""
    reasons, remedies = [], []
    for demand in found.demand.exceeded:
        name = demand.name.replace("_", " ")
        assert demand.limit is not None
        asked, limit = (f"{rounded(value, 4)} {demand.unit}" for value in (demand.asked, demand.limit))
        reasons.append(f"{name}: the motion needs {asked}, and {limit} {ENDS.get(name, 'is the limit')}")
        if found.demand.shortest is not None:
            remedies.append(
                f"lengthen the move from {found.goals.duration:.3g} s to {found.demand.shortest:.3g} s"
            )
        if name in ENDS:
            remedies.append("raise cable.pretension")
    resonance = found.resonance
    if resonance.refuses:
        reasons.append(findings.resonance_words(resonance))
        remedies += [resonance.remedy] if resonance.remedy and resonance.remedy != "none needed" else []
        if resonance.tuned_pretension is not None:
            tuned, drive = resonance.tuned_pretension, found.known
            if drive is None or tuned <= largest_pretension(drive.cable):
                words = f"keep cable.pretension away from {tuned:.4g} N, where the 1:2 resonance is exact"
            else:
                words = f"no pretension {elastic_range(drive.cable)} tunes the lowest mode of an empty span: "
                words += "keep away from the pretensions of the other pairs, which cabledrive resonance lists"
            remedies.append(words)
    return reasons, remedies


def _by_acceptance(found: findings.Findings) -> tuple[str, list[str], list[str]]:
    goals, unit, chosen, cable = found.goals, error_unit(found.goals), found.runs, found.cable
    goal, known = goal_of(goals), found.knowledge
    # What makes the plants of the acceptance other than the machine that was logged.
    doubts = [f"the log contradicts the assumptions: {one}" for one in known.findings if one.decides]
    if known.open_names:
        named = ", ".join(WORDS[name] for name in known.open_names)
        doubts += [f"the log does not determine {named}", *known.undetermined]
    correct = [CORRECT] if any(one.id != "slip" for one in known.findings) else []
    if goal is None:
        remedy = "set error in [goals] to get a verdict"
        if chosen.reached and chosen.reached.error is not None:
            enough = findings.rounded_up(unit.of(chosen.reached.error))
            remedy += f', such as error = "{enough:g} {unit.name}"'
        return UNKNOWN, [*doubts, findings.reached_words(chosen, cable, goals, unit)], [remedy, *correct]
    short = [words for one in (chosen, cable) for words in findings.short_of(one, goal, unit)]
    off, words = _coupling(found)
    if off and chosen.reached and chosen.reached.error is not None and chosen.reached.error + off > goal:
        short += words
    if doubts:
        return UNKNOWN, [*doubts, *short], [*correct, *([findings.RECORD] if known.open_names else [])]
    if not short:
        return YES, findings.held_words(chosen, cable, goals, unit), []
    if chosen.share_low is not None and chosen.share == 1.0:
        key = "carriage_draws" if chosen.plant == "carriage" else "draws"
        return UNKNOWN, short, [f"run more plants: raise {key} in [acceptance], or omit --quick"]
    median = found.runs.quantile(0.5)
    if known.residual is None and median is not None and median <= goal and chosen.share != 1.0:
        return UNKNOWN, [*short, SHEET], [findings.RECORD, *findings.remedies_for(found)]
    return UNKNOWN, short, findings.remedies_for(found)


def _bound(found: findings.Findings) -> float | None:
    """Stated for the chosen law [rad]; None: the chosen law is not the one that a bound is stated for."""
    chosen, control = found.laws.chosen, found.controller
    if chosen is None or chosen.model is None or not isinstance(control, ControllerResult):
        return None
    return control.bound


def _cautions(found: findings.Findings, reasons: Sequence[str]) -> tuple[str, ...]:
    said = (one for one in found.knowledge.findings if found.laws.chosen is None or one.id == "slip")
    words = [f"the log: {one}" for one in said]
    words += found.knowledge.undetermined if not found.knowledge.open_names else ()
    if found.knowledge.residual is None:
        given = "could be used" if found.check.logs else "was given"
        words.append(f"no log {given}: all values are from the data sheet, with the stated uncertainty")
    sensors = None if found.carried or found.known is None else found.known.sensors
    if sensors is not None and sensors.load_encoder is None:
        words.append(NO_LOAD_ENCODER)
    if found.resonance.alarm == "unknown":
        words.append("undecided: whether the motion excites the transverse modes beyond the limit")
    if found.resonance.verdict == "close":
        words.append(
            "a twentieth of the torque as ripple at the pulley mode would bring a span close to resonance"
        )
    if found.resonance.slack:
        words.append(
            "the response of the pulley mode to the motion takes a span's tension to zero for a moment"
        )
    if found.known is not None and found.known.chain_of:
        words += ["modes, lumped models and resonance are of the machine as its file gives it"]
        words += _coupling(found)[1]
        if found.knowledge.residual is not None:
            what = "drive.toml is the machine as given"
            words.append(f"{what}; identified numbers are those of its chain, in results.json")
    if found.exported is not None and not found.exported.holds:
        words.append(
            f"as `export` writes it, with the last gain of its filter, the law misses the goal on "
            f"{found.exported.misses} of {found.exported.draws} lumped plants"
        )
    asked = (found.runs,) if found.carried else (found.runs, found.cable)
    words += _of_the_carriage(found) if found.carried else findings.unrun(found, reasons)
    for one in asked:
        if one.saturated:
            kind = "" if found.carried else f"{one.plant} "
            words.append(f"{one.saturated} of {one.draws} {kind}runs reached the torque limit")
    controller = found.controller
    if _bound(found) is None or not isinstance(controller, ControllerResult):
        return tuple(words)
    for one in asked:
        if one.inside is not None and one.inside < ENOUGH[one.plant]:
            words.append(f"the stated bound held in {100 * one.inside:.1f} % of {one.draws} {one.plant} runs")
    if controller.broken:
        broken = "; ".join(controller.broken)
        what = "assumptions of the theorem that do not hold on the rig"
        words.append(f"{what}: {broken} (covered by the other parts of the bound)")
    return tuple(words)


def _of_the_carriage(found: findings.Findings) -> list[str]:
    """What does not decide of a carriage."""
    model, control, drive = found.model, found.controller, found.known
    words = [NO_BOUND] if found.runs.draws else []
    if found.goals.rail_friction is None:
        said = "friction of the carriage on its guide is an estimate, 0 to 1 N s/m"
        words.append(f"{said}: state rail_friction in [carriage]")
    if isinstance(model, CarriageModel) and model.left_out > 0.0:
        said = "the motor joint is taken as rigid: its windup and backlash"
        words.append(f"{said}, {1e3 * model.left_out:.3g} mm at the carriage, are added to every error")
    if drive is not None and (control_delay(drive) > 0.0 or current_rate(drive) > 0.0):
        said = "the runs contain neither delay nor torque loop"
        words.append(f"{said}; both are short compared with the period of the carriage")
    if isinstance(control, CarriageController) and not control.both:
        words.append("the law uses the motor-side encoder only: the load pulley has no equal encoder")
    return words


def _coupling(found: findings.Findings) -> tuple[float, list[str]]:
    """How far the other axis of a coupled machine moves the load along the motion [rad], in words."""
    drive = found.known
    if drive is None:
        return 0.0, []
    time, torque = motion_torque(drive, found.goals.motion)
    other = cross_motion(drive, torque, time[1])
    if other is None:
        return 0.0, []
    off = max(other["load"]) / abs(drive.axis.per_angle)
    moved = error_unit(found.goals).words(off)
    return off, [f"{drive.axis.words['coupled']}: along this motion that adds up to {moved} to the error"]
