"""Stage 8: yes, no or unknown, why, with which margins, and what would help."""

from collections.abc import Sequence
from dataclasses import dataclass

from cabledrive.mechanics.warnings import elastic_range, largest_pretension
from cabledrive.parameters import Drive
from cabledrive.parameters.fields import rounded
from cabledrive.studies.study.carriage_verdict import ENOUGH as CARRIAGE_ENOUGH
from cabledrive.studies.study.carriage_verdict import carriage_cautions, judge_carriage
from cabledrive.studies.study.findings import Findings
from cabledrive.studies.study.machine import LOG, WORDS
from cabledrive.studies.study.verdict_words import (
    ENOUGH,
    RECORD,
    accepted,
    remedies_for,
    resonance_words,
    short_of,
    unrun,
)

YES, NO, UNKNOWN = "yes", "no", "unknown"
OTHER = "give the carriage what is needed where the machine allows it; modes, resonance and torque hold as is"
ENDS = {"slack torque": "carry before a span goes slack", "lost tension": "are the pretension"}
COMPLETE = "complete the drive file; what stands here of modes, resonance and torque holds without it"


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
        carries = found.drive is not None and bool(found.drive.carriage)
        answer, reasons, remedies = UNKNOWN, list(found.check.missing), [OTHER if carries else COMPLETE]
    elif found.carriage is not None:
        answer, reasons, remedies = judge_carriage(found.carriage, found.goals)
    elif found.controller is None or found.controller.bound is None:
        why = found.controller.reason if found.controller else "no controller was designed"
        answer, reasons, remedies = NO, [why], ["sample faster, fit finer encoders, or identify the drive"]
    else:
        answer, reasons, remedies = _by_acceptance(found)
    return Verdict(
        answer=answer,
        reasons=tuple(reasons),
        remedies=tuple(dict.fromkeys(remedies)),
        margins=_margins(found),
        cautions=_cautions(found, reasons),
    )


def _refusals(found: Findings) -> tuple[list[str], list[str]]:
    """Torque, speed, slack and resonance: what no controller mends."""
    reasons, remedies = [], []
    for demand in found.demand.exceeded:
        name = demand.name.replace("_", " ")
        assert demand.limit is not None
        asked, limit = (f"{rounded(value, 4)} {demand.unit}" for value in (demand.asked, demand.limit))
        reasons.append(f"{name}: the motion asks for {asked}, and {limit} {ENDS.get(name, 'is the limit')}")
        if found.demand.shortest is not None:
            remedies.append(
                f"take {found.demand.shortest:.3g} s for the move instead of {found.goals.duration:.3g} s"
            )
        if name in ENDS:
            remedies.append("raise cable.pretension")
    resonance = found.resonance
    if resonance.refuses:
        reasons.append(resonance_words(resonance))
        remedies += [resonance.remedy] if resonance.remedy and resonance.remedy != "none needed" else []
        if resonance.tuned_pretension is not None:
            remedies.append(_away_from_tuning(resonance.tuned_pretension, found.drive))
    return reasons, remedies


def _away_from_tuning(tuned: float, drive: Drive | None) -> str:
    if drive is None or tuned <= largest_pretension(drive):
        return f"keep cable.pretension away from {tuned:.4g} N, where the 1:2 resonance is exact"
    return (
        f"no pretension {elastic_range(drive)} tunes the lowest mode of an empty span: keep away from the "
        "pretensions of the other pairs, which cabledrive resonance lists"
    )


def _by_acceptance(found: Findings) -> tuple[str, list[str], list[str]]:
    controller, goals = found.controller, found.goals
    assert controller is not None
    assert controller.bound is not None
    runs = [one for one in (found.lumped, found.cable) if one.draws]
    short = [words for one in runs for words in short_of(one, goals)]
    open_words = [WORDS[name] for name in found.knowledge.open_names]
    if open_words:
        reasons = [f"the log cannot tell {', '.join(open_words)}", *found.knowledge.undetermined]
        return UNKNOWN, [*reasons, *short], [RECORD]
    if not short:
        return YES, accepted(found), []
    sheet = [name for name, q in found.knowledge.quantities.items() if q.source != LOG]
    median = found.lumped.quantile(0.5)
    possible = goals.error is not None and median is not None and median <= goals.error
    bounded = all(one.inside >= ENOUGH[one.plant] for one in runs)
    if sheet and possible and bounded and found.knowledge.residual is None:
        return (
            UNKNOWN,
            [*short, "it depends on which of the plants the datasheet allows this one is"],
            [RECORD],
        )
    return NO, short, remedies_for(found)


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
    if found.carriage is not None and found.carriage.acceptance is not None and goals.carriage_error:
        most = found.carriage.acceptance.quantile(CARRIAGE_ENOUGH)
        if most is not None:
            goal = goals.carriage_error
            rows.append(Margin(name="error, carriage", value=most, allowed=goal, unit="m"))
    return tuple(rows)


def _cautions(found: Findings, reasons: Sequence[str]) -> tuple[str, ...]:
    words = list(found.knowledge.findings)
    words += found.knowledge.undetermined if not found.knowledge.open_names else ()
    if found.knowledge.residual is None:
        given = "could be used" if found.check.logs else "was given"
        words.append(f"no log {given}: every value is the data sheet's, with the uncertainty stated")
    if found.resonance.alarm == "saturates":
        words.append("the motion pumps a span, and the exchange of energy ends before the limit")
    if found.resonance.verdict == "close":
        words.append(
            "a twentieth of the torque as ripple at the pulley mode would bring a span close to swinging"
        )
    if found.resonance.slack:
        words.append("the pulley mode's answer to the motion takes a span's tension away for a moment")
    if found.carriage is not None:
        return (*words, *carriage_cautions(found.carriage, found.goals, _late(found.drive)))
    words += unrun(found, reasons)
    for one in (found.lumped, found.cable):
        if one.saturated:
            words.append(f"{one.saturated} of {one.draws} {one.plant} runs met the torque limit")
    if found.controller is not None and found.controller.broken:
        words.append(
            "assumptions of the theorem that do not hold on the rig: "
            + "; ".join(found.controller.broken)
            + " (the other parts of the bound answer for them)"
        )
    return tuple(words)


def _late(drive: Drive | None) -> bool:
    """Whether the drive file names a delay or a torque loop."""
    if drive is None or drive.motor is None or drive.sensors is None:
        return False
    return drive.sensors.delay > 0.0 or drive.motor.current_bandwidth is not None
