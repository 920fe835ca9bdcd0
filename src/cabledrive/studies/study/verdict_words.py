"""The sentences of a verdict."""

from collections.abc import Sequence

from cabledrive.parameters.fields import rounded
from cabledrive.rig.setting import DEGREE
from cabledrive.studies.study.acceptance_stage import AcceptanceResult
from cabledrive.studies.study.findings import Findings
from cabledrive.studies.study.goals import Goals
from cabledrive.studies.study.machine import WORDS
from cabledrive.studies.study.resonance_stage import ResonanceResult

ENOUGH = {"lumped": 0.99, "cable": 0.95}
"""Share of the runs that must keep within bound and goal."""

FAR = 0.2
"""From one half: then it is no lowest mode that resonates."""

RECORD = (
    "record a log of the whole drive with torque, motor, drive and load angle, excited from 0.25 to 10 Hz "
    "in both directions (cabledrive experiment --excitation shows one)"
)


def resonance_words(resonance: ResonanceResult) -> str:
    """Where the drive stands against its resonance, in one line.

    Parameters
    ----------
    resonance : ResonanceResult
        One that refuses.

    Returns
    -------
    str
    """
    ratio, pulley = resonance.frequency_ratio, resonance.pulley_frequency
    where = f"a span swings at {ratio:.4g} of the pulley mode's {pulley:.4g} Hz"
    if ratio is not None and abs(ratio - 0.5) > FAR:
        where = f"a higher mode of a span lies at half the pulley mode's {pulley:.4g} Hz"
    if resonance.alarm == "alarm":
        largest, limit = _millimetres(resonance.largest), _millimetres(resonance.limit)
        return f"resonance: {where}, and the motion pumps it to {largest}; {limit} are allowed"
    return (
        f"resonance: {where}, so near 1/2 that {resonance.ripple:.4g} N m of ripple, a twentieth of the "
        "motion's torque, feed its swing"
    )


def _millimetres(amplitude: float | None) -> str:
    return "any amplitude" if amplitude is None else f"{rounded(1e3 * amplitude, 2)} mm"


def _too_many_early(one: AcceptanceResult) -> bool:
    return one.failed > (1.0 - ENOUGH[one.plant]) * one.draws


def short_of(one: AcceptanceResult, goals: Goals) -> list[str]:
    """What an acceptance lacks, in words.

    Parameters
    ----------
    one : AcceptanceResult
    goals : Goals

    Returns
    -------
    list of str
        Empty where nothing is short.
    """
    words, enough = [], ENOUGH[one.plant]
    if _too_many_early(one):
        words.append(
            f"{one.failed} of {one.draws} runs on the {one.plant} plant ended early: unstable or slack"
        )
    if not one.peaks:
        return words
    if one.inside < enough:
        words.append(
            f"the stated bound held in {100 * one.inside:.1f} % of {one.draws} {one.plant} runs; "
            f"asked are {100 * enough:.0f} %"
        )
    if one.reached is not None and one.reached < enough:
        assert goals.error is not None
        most = one.quantile(enough)
        kept = "" if most is None else f"; {100 * enough:.0f} % keep within {most / DEGREE:.3g} deg"
        words.append(
            f"error: {100 * one.reached:.1f} % of {one.draws} runs on the {one.plant} plant kept within "
            f"{goals.error / DEGREE:.3g} deg{kept}"
        )
    return words


def accepted(found: Findings) -> list[str]:
    """What was reached, in words.

    Parameters
    ----------
    found : Findings
        With a controller and a bound.

    Returns
    -------
    list of str
    """
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
            early = f", {one.failed} ended early" if one.failed else ""
            words.append(
                f"{_runs(one.draws)} on the {one.plant} plant{early}: largest error "
                f"{one.peaks[-1] / DEGREE:.3g} deg; the stated bound of {bound:.3g} deg held in "
                f"{100 * one.inside:.1f} %"
            )
    return words


def _runs(count: int) -> str:
    return f"{count} run{'' if count == 1 else 's'}"


def unrun(found: Findings, reasons: Sequence[str]) -> list[str]:
    """Why plants were not run; what stands among the reasons of the verdict is not said once more.

    Parameters
    ----------
    found : Findings
    reasons : sequence of str
        Of the verdict.

    Returns
    -------
    list of str
    """
    left = {one.reason: one.plant for one in (found.cable, found.lumped) if not one.draws and one.reason}
    words = []
    for reason, plant in left.items():
        where = "" if len(left) == 1 and not found.lumped.draws else f" on the {plant} plant"
        why = reason
        if reason in reasons:
            why = "no controller was found, see above"
        elif found.check.missing and set(found.check.missing) <= set(reasons):
            why = "no controller can be designed, see above"
        words.append(f"acceptance{where} was not run: {why}")
    return words


def remedies_for(found: Findings) -> list[str]:
    """What would let the runs last, or else make the bound smaller.

    Parameters
    ----------
    found : Findings
        With a controller.

    Returns
    -------
    list of str
    """
    controller = found.controller
    assert controller is not None
    assert controller.chosen is not None
    slower = "take longer for the move: acceleration falls with its square"
    if any(_too_many_early(one) for one in (found.lumped, found.cable) if one.draws):
        unstable = f"where the loop is unstable know the drive better; {RECORD}"
        return ["raise cable.pretension, so that no span goes slack", slower, unstable]
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
    return [*words, slower]
