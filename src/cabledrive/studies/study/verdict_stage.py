"""Stage 8: yes, no or unknown, why, with which margins, and what would help."""

from dataclasses import dataclass

from cabledrive.rig.setting import DEGREE
from cabledrive.studies.study.acceptance_stage import AcceptanceResult
from cabledrive.studies.study.check_stage import CheckResult
from cabledrive.studies.study.controller_stage import ControllerResult
from cabledrive.studies.study.demand_stage import DemandResult
from cabledrive.studies.study.goals import Goals
from cabledrive.studies.study.knowledge_stage import Knowledge
from cabledrive.studies.study.machine import LOG, WORDS
from cabledrive.studies.study.resonance_stage import ResonanceResult

YES, NO, UNKNOWN = "yes", "no", "unknown"
ENOUGH = {"lumped": 0.99, "cable": 0.95}
"""Share of the runs that must keep within bound and goal."""

RECORD = (
    "record a log of the whole drive with torque, motor, drive and load angle, excited from 0.25 to 10 Hz "
    "in both directions (cabledrive experiment --excitation shows one)"
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Margin:
    """One figure against what is allowed.

    Attributes
    ----------
    name : str
    value, allowed : float
    unit : str
    """

    name: str
    value: float
    allowed: float
    unit: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Verdict:
    """The end of a study.

    Attributes
    ----------
    answer : {"yes", "no", "unknown"}
    reasons : tuple of str
        What decides first.
    remedies : tuple of str
    margins : tuple of Margin
    cautions : tuple of str
        What does not decide, and should be known.
    """

    answer: str
    reasons: tuple[str, ...]
    remedies: tuple[str, ...]
    margins: tuple[Margin, ...]
    cautions: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Findings:
    """What the verdict is made of.

    Attributes
    ----------
    goals : Goals
    check : CheckResult
    knowledge : Knowledge
    demand : DemandResult
    resonance : ResonanceResult
    controller : ControllerResult or None
    lumped, cable : AcceptanceResult
    """

    goals: Goals
    check: CheckResult
    knowledge: Knowledge
    demand: DemandResult
    resonance: ResonanceResult
    controller: ControllerResult | None
    lumped: AcceptanceResult
    cable: AcceptanceResult


def judge(found: Findings) -> Verdict:
    """Put the stages together.

    Parameters
    ----------
    found : Findings

    Returns
    -------
    Verdict
    """
    refusals, remedies = _refusals(found)
    if refusals:
        answer, reasons = NO, refusals
    elif found.check.missing:
        answer, reasons, remedies = UNKNOWN, list(found.check.missing), list(found.check.missing)
    elif found.controller is None or found.controller.bound is None:
        why = found.controller.reason if found.controller else "no controller was designed"
        answer, reasons, remedies = NO, [why], ["sample faster, fit finer encoders, or identify the drive"]
    else:
        answer, reasons, remedies = _by_acceptance(found)
    return Verdict(
        answer=answer,
        reasons=tuple(reasons),
        remedies=tuple(remedies),
        margins=_margins(found),
        cautions=_cautions(found),
    )


def _refusals(found: Findings) -> tuple[list[str], list[str]]:
    """Torque, speed, slack and resonance: what no controller mends."""
    reasons, remedies = [], []
    for demand in found.demand.exceeded:
        name = demand.name.replace("_", " ")
        reasons.append(
            f"{name}: the motion asks for {demand.asked:.4g} {demand.unit}, and {demand.limit:.4g} "
            f"{demand.unit} {'carry before a span goes slack' if name == 'slack torque' else 'is the limit'}"
        )
        if found.demand.shortest is not None:
            remedies.append(
                f"take {found.demand.shortest:.3g} s for the move instead of {found.goals.duration:.3g} s"
            )
        if name == "slack torque":
            remedies.append("raise cable.pretension")
    resonance = found.resonance
    if resonance.refuses:
        assert resonance.frequency_ratio is not None
        what = (
            f"pumps a span to {_millimetres(resonance.largest)}, {_millimetres(resonance.limit)} are allowed"
            if resonance.alarm == "alarm"
            else f"has {resonance.torque:.4g} N m, inside the tongue: at the pulley mode it feeds the spans"
        )
        reasons.append(
            f"resonance: the span's frequency is {resonance.frequency_ratio:.4g} of the pulley mode's "
            f"{resonance.pulley_frequency:.4g} Hz, near 1/2, and the motion {what}"
        )
        tuned = resonance.tuned_pretension
        remedies += [resonance.remedy] if resonance.remedy and resonance.remedy != "none needed" else []
        if tuned is not None:
            remedies.append(
                f"keep cable.pretension away from {tuned:.4g} N, where the 1:2 resonance is exact"
            )
    return reasons, remedies


def _millimetres(amplitude: float | None) -> str:
    return "any amplitude" if amplitude is None else f"{1e3 * amplitude:.2g} mm"


def _by_acceptance(found: Findings) -> tuple[str, list[str], list[str]]:
    controller, goals = found.controller, found.goals
    assert controller is not None
    assert controller.bound is not None
    runs = [one for one in (found.lumped, found.cable) if one.draws]
    short = [words for one in runs for words in _short_of(one, goals)]
    open_words = [WORDS[name] for name in found.knowledge.open_names]
    if open_words:
        told = "; ".join(found.knowledge.undetermined)
        reasons = [f"the log cannot tell {', '.join(open_words)}: {told}"]
        return UNKNOWN, [*reasons, *short], [RECORD]
    if not short:
        return YES, _accepted(found), []
    sheet = [name for name, q in found.knowledge.quantities.items() if q.source != LOG]
    median = found.lumped.quantile(0.5)
    possible = goals.error is not None and median is not None and median <= goals.error
    if sheet and possible and found.knowledge.residual is None:
        return (
            UNKNOWN,
            [*short, "it depends on which of the plants the datasheet allows this one is"],
            [RECORD],
        )
    return NO, short, _remedies(found)


def _short_of(one: AcceptanceResult, goals: Goals) -> list[str]:
    words, enough = [], ENOUGH[one.plant]
    if one.failed > (1.0 - enough) * one.draws:
        words.append(
            f"{one.failed} of {one.draws} runs on the {one.plant} plant ended early: unstable or slack"
        )
    if one.inside < enough:
        words.append(
            f"the stated bound held in {100 * one.inside:.1f} % of {one.draws} {one.plant} runs; "
            f"asked are {100 * enough:.0f} %"
        )
    if one.reached is not None and one.reached < enough:
        assert goals.error is not None
        most = one.quantile(enough)
        assert most is not None
        words.append(
            f"error: {100 * one.reached:.1f} % of {one.draws} runs on the {one.plant} plant kept within "
            f"{goals.error / DEGREE:.3g} deg; {100 * enough:.0f} % keep within {most / DEGREE:.3g} deg"
        )
    return words


def _accepted(found: Findings) -> list[str]:
    controller, goals = found.controller, found.goals
    assert controller is not None
    assert controller.bound is not None
    bound, move = controller.bound / DEGREE, f"{goals.angle / DEGREE:g} deg in {goals.duration:g} s"
    words = [f"the load follows {move} within the stated bound of {bound:.3g} deg"]
    if goals.error is not None:
        kept = "the bound keeps it" if controller.bound <= goals.error else "by the runs, not by the bound"
        words = [f"the load follows {move} within the goal of {goals.error / DEGREE:.3g} deg: {kept}"]
    for one in (found.lumped, found.cable):
        if one.draws:
            words.append(
                f"{one.draws} runs on the {one.plant} plant: largest error {one.peaks[-1] / DEGREE:.3g} deg; "
                "the "
                f"stated bound of {bound:.3g} deg held in {100 * one.inside:.1f} %"
            )
    return words


def _remedies(found: Findings) -> list[str]:
    controller = found.controller
    assert controller is not None
    assert controller.chosen is not None
    chosen, words = controller.chosen, []
    parts = {
        "sensors": chosen.sensors or 0.0,
        "unmatched": chosen.unmatched or 0.0,
        "matched": chosen.theorem or 0.0,
    }
    largest = max(parts, key=lambda name: parts[name])
    if largest == "sensors":
        words.append("fit finer encoders: counts make the largest part of the bound")
    elif largest == "unmatched" and controller.shares:
        name = max(controller.shares, key=lambda key: controller.shares[key])
        words.append(f"know the {WORDS[name]} better: it makes the largest part of the bound; {RECORD}")
    else:
        words.append(f"know friction and inertia of the motor better, or sample faster; {RECORD}")
    words.append("take longer for the move: acceleration falls with its square")
    return words


def _margins(found: Findings) -> tuple[Margin, ...]:
    rows = [
        Margin(name=demand.name, value=demand.asked, allowed=demand.limit, unit=demand.unit)
        for demand in found.demand.demands
        if demand.limit is not None
    ]
    controller, goals = found.controller, found.goals
    if controller is not None and controller.bound is not None:
        for one in (found.lumped, found.cable):
            worst = one.quantile(ENOUGH[one.plant])
            if worst is not None:
                rows.append(
                    Margin(name=f"error, {one.plant}", value=worst, allowed=controller.bound, unit="rad")
                )
        if goals.error is not None:
            rows.append(Margin(name="bound", value=controller.bound, allowed=goals.error, unit="rad"))
    return tuple(rows)


def _cautions(found: Findings) -> tuple[str, ...]:
    words = list(found.knowledge.findings)
    words += found.knowledge.undetermined if not found.knowledge.open_names else ()
    if found.knowledge.residual is None:
        words.append("no log could be used: every value is the datasheet's, with the uncertainty stated")
    if found.resonance.alarm == "saturates":
        words.append("the motion pumps a span, and the exchange of energy ends before the limit")
    if found.resonance.verdict == "close":
        words.append(
            "were the motion's torque steady at the pulley mode, the drive would be close to the tongue"
        )
    if found.resonance.slack:
        words.append("the pulley mode's answer to the motion takes a span's tension away for a moment")
    for one in (found.lumped, found.cable):
        if not one.draws and one.reason:
            words.append(f"acceptance on the {one.plant} plant was not run: {one.reason}")
        if one.saturated:
            words.append(f"{one.saturated} of {one.draws} {one.plant} runs met the torque limit")
    if found.controller is not None and found.controller.broken:
        words.append(
            "assumptions of the theorem that do not hold on the rig: "
            + "; ".join(found.controller.broken)
            + " (the other parts of the bound answer for them)"
        )
    return tuple(words)
