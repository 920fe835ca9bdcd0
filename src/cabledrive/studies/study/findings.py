"""Everything that a verdict is made of, and its sentences."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil, floor, log10

from cabledrive.answers.figures import percent, rounded
from cabledrive.parameters import Drive
from cabledrive.parameters.fields import meaning
from cabledrive.rig.plant_samples import CONFIDENCE
from cabledrive.rig.setting import DEGREE
from cabledrive.studies.study.acceptance_stage import ENOUGH, AcceptanceResult, ExportedRuns, TriedLaws
from cabledrive.studies.study.bandwidth_cost import CarriageCandidate, CarriageController
from cabledrive.studies.study.carriage import CarriageModel
from cabledrive.studies.study.check_stage import CheckResult
from cabledrive.studies.study.goals import ErrorUnit, Goals, goal_of
from cabledrive.studies.study.knowledge_stage import Knowledge
from cabledrive.studies.study.machine import WORDS, DemandResult
from cabledrive.studies.study.modes_stage import ModelResult, ResonanceResult
from cabledrive.studies.study.plants import ControllerResult


@dataclass(frozen=True, slots=True, kw_only=True)
class Findings:
    """What the stages before the verdict found."""

    goals: Goals = meaning("what was asked, the motion complete")
    known: Drive | None = meaning("with the best values, after identification", None)
    check: CheckResult = meaning("of drive and logs")
    knowledge: Knowledge = meaning("what is known of the drive")
    demand: DemandResult = meaning("what the motion asks of motor and cable")
    resonance: ResonanceResult = meaning("internal resonance under the motion")
    model: ModelResult | CarriageModel | None = meaning("reduced model, or that of a carriage", None)
    controller: ControllerResult | CarriageController | None = meaning(
        "the damped law of the chain, by its bound; the scheduled law of a carriage, by its estimated error"
    )
    laws: TriedLaws = meaning("every law under one acceptance test")
    exported: ExportedRuns | None = meaning("the chosen law as `export` writes it; of a load", None)

    @property
    def runs(self) -> AcceptanceResult:
        """Of the law that is chosen, on the plants that decide first."""
        return self.laws.runs

    @property
    def cable(self) -> AcceptanceResult:
        """Of the same law on the distributed cable."""
        return self.laws.cable

    @property
    def carried(self) -> bool:
        """Whether a carriage is controlled, and not a load."""
        return self.runs.plant == "carriage"


PLANTS = {
    "lumped": "lumped plants",
    "cable": "plants on the distributed cable",
    "carriage": "plants with a carriage",
}

FAR = 0.2
"""Distance of the ratio from one half beyond which a higher mode is the resonant one."""

RECORD = (
    "record a log of the whole drive with torque, motor, drive and load angle, excited from 0.25 to 10 Hz "
    "in both directions (cabledrive experiment --excitation shows one)"
)


def resonance_words(resonance: ResonanceResult) -> str:
    """Detuning of the drive from its resonance, in one line; ``resonance``: one that refuses."""
    ratio, pulley = resonance.frequency_ratio, resonance.pulley_frequency
    mode = f"pulley mode's frequency ({pulley:.4g} Hz)"
    where = f"the lowest transverse mode of a span has {ratio:.4g} of the {mode}"
    if ratio is not None and abs(ratio - 0.5) > FAR:
        where = f"a higher transverse mode of a span lies at half the {mode}"
    if resonance.alarm == "dangerous":
        largest, limit = _millimetres(resonance.largest), _millimetres(resonance.limit)
        return f"resonance: {where}, and the motion excites it to {largest} (limit: {limit})"
    return (
        f"resonance: {where}, inside the 1:2 instability region of a torque ripple of "
        f"{resonance.ripple:.4g} N m, a twentieth of the motion's torque"
    )


def _millimetres(amplitude: float | None) -> str:
    return "an unbounded amplitude" if amplitude is None else f"{rounded(1e3 * amplitude, 2)} mm"


def move_words(goals: Goals) -> str:
    """The move that is planned, in words."""
    if goals.travel is not None:
        hung = " with the mass below it" if goals.hanging_mass else ""
        return f"{goals.travel:.4g} m in {goals.duration:g} s{hung}"
    assert goals.angle is not None
    if goals.gain is not None:
        return f"{1e3 * goals.gain * goals.angle:.4g} mm in {goals.duration:g} s"
    return f"{goals.angle / DEGREE:g} deg in {goals.duration:g} s"


def rounded_up(value: float) -> float:
    """The next number of two digits; ``value``: above 0."""
    scale = 10.0 ** (floor(log10(value)) - 1)
    return float(f"{ceil(value / scale - 1e-9) * scale:.2g}")


def reached_words(chosen: AcceptanceResult, cable: AcceptanceResult, goals: Goals, unit: ErrorUnit) -> str:
    """What is reached without a goal."""
    move, reached = move_words(goals), chosen.reached
    if reached is None or reached.error is None:
        early = f"{chosen.failed} of {chosen.draws} runs ended early, so no error can be stated"
        return f"no error goal given; {chosen.law.controller} at {move}: {early}"
    words = f"no error goal given; {chosen.law.controller} follows {move} within {unit.words(reached.error)}"
    words += f" in {percent(reached.share)} of the plants, {100 * reached.confidence:g} % confidence"
    if cable.reached is not None and cable.reached.error is not None:
        inside = f"{unit.words(cable.reached.error)} in {percent(cable.reached.share)}"
        return f"{words}; on the distributed cable within {inside}"
    return words + _only(chosen)


def held_words(chosen: AcceptanceResult, cable: AcceptanceResult, goals: Goals, unit: ErrorUnit) -> list[str]:
    """What is reached where the goal is held; ``chosen``: with a goal."""
    goal = goal_of(goals)
    assert goal is not None
    first = f"{chosen.law.controller} follows {move_words(goals)} within the goal of {unit.words(goal)}"
    first += "" if cable.draws else _only(chosen)
    return [first, *(_share_words(one) for one in (chosen, cable) if one.draws)]


def _only(chosen: AcceptanceResult) -> str:
    return "; tested on lumped plants only, not on the distributed cable" if chosen.plant == "lumped" else ""


def _share_words(one: AcceptanceResult) -> str:
    assert one.share is not None
    assert one.share_low is not None
    words = f"{percent(one.share)} of {one.draws} {PLANTS[one.plant]} keep within the goal: at least "
    return f"{words}{percent(one.share_low)} of all, with {100 * CONFIDENCE:g} % confidence"


def short_of(one: AcceptanceResult, goal: float, unit: ErrorUnit) -> list[str]:
    """What a law lacks, in words; empty where nothing is short; ``goal`` [rad] or [m]."""
    if one.holds is not False:
        return []
    enough = ENOUGH[one.plant]
    if one.share == 1.0:
        why = f"all of {one.draws} {PLANTS[one.plant]} keep within {unit.words(goal)} under "
        few = f"so few runs prove only {percent(one.share_low or 0.0)}; {percent(enough)} are required"
        return [f"{why}{one.law.controller}, but {few}"]
    words = f"none of the tried laws meets the goal of {unit.words(goal)}; closest is {one.law.controller}: "
    words += f"{_share_words(one)}; {percent(enough)} are required"
    if one.reached is not None and one.reached.error is not None:
        kept = f"{percent(one.reached.share)} keep within {unit.words(one.reached.error)}"
        words += f"; {kept}"
    found = [words]
    if one.failed:
        found.append(
            f"{one.failed} of {one.draws} runs on {PLANTS[one.plant]} ended early: unstable or slack"
        )
    return found


def unrun(found: Findings, reasons: Sequence[str]) -> list[str]:
    """Why plants were not run; what is among the reasons of the verdict is not repeated."""
    left = {one.reason: one.plant for one in (found.cable, found.runs) if not one.draws and one.reason}
    words = []
    for reason, plant in left.items():
        where = "" if len(left) == 1 and not found.runs.draws else f" on the {plant} plant"
        why = reason
        if reason in reasons:
            why = "no controller was found, see above"
        elif found.check.missing and set(found.check.missing) <= set(reasons):
            why = "no controller can be designed, see above"
        words.append(f"acceptance{where} was not run: {why}")
    return words


def remedies_for(found: Findings) -> list[str]:
    """Changes that keep the runs from ending early, or else make the error, or the bound of it, smaller."""
    control, carried = found.controller, isinstance(found.controller, CarriageController)
    pull = "force" if carried else "acceleration"
    slower = f"lengthen the move: the {pull} falls with the square of its duration"
    if found.runs.failed and not carried:
        unstable = f"where the loop is unstable, identify the drive more accurately: {RECORD}"
        return ["raise cable.pretension to keep the spans from going slack", slower, unstable]
    if control is None or control.chosen is None:
        return [slower, RECORD]
    chosen, words, what = control.chosen, [], "error" if carried else "bound"
    if isinstance(chosen, CarriageCandidate):
        noisy = (chosen.sensors or 0.0) > max(chosen.uncertain or 0.0, chosen.nominal or 0.0)
        by_values = True
    else:
        noisy = (chosen.sensors or 0.0) >= max(chosen.unmatched or 0.0, chosen.theorem or 0.0)
        by_values = (chosen.unmatched or 0.0) >= (chosen.theorem or 0.0)
    record = "" if carried else f": {RECORD}"
    if noisy:
        words.append(f"fit finer encoders: quantisation is the largest part of the {what}")
    elif by_values and control.shares:
        name = max(control.shares, key=lambda key: control.shares[key])
        words.append(f"identify the {WORDS[name]} more accurately, the largest part of the {what}{record}")
    elif not carried:
        words.append(f"identify friction and inertia of the motor more accurately, or sample faster{record}")
    if isinstance(control, CarriageController) and not control.both:
        words.append(
            "fit sensors.load_encoder with the resolution of the drive pulley's: the law then uses both"
        )
    return [*words, slower]
