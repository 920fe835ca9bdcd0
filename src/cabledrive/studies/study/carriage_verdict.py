"""Yes, no or unknown for a carriage: no theorem bounds its error, so the goal decides, by the runs."""

from math import ceil, floor, log10

from cabledrive.studies.study.carriage_acceptance import CarriageAcceptance
from cabledrive.studies.study.carriage_controller import CarriageController
from cabledrive.studies.study.carriage_pipeline import CarriageStages
from cabledrive.studies.study.goals import Goals
from cabledrive.studies.study.machine import WORDS

YES, NO, UNKNOWN = "yes", "no", "unknown"
ENOUGH = 0.99
"""Share of the runs that must keep within the goal."""
NO_BOUND = "no theorem bounds the error of the scheduled law: what stands here is what the runs showed"
MEASURE = "measure the numbers that make the largest part of the error, and state what is left open"
LONGER = "take longer for the move: the force falls with the square of its duration"


def judge_carriage(found: CarriageStages, goals: Goals) -> tuple[str, list[str], list[str]]:
    """What the runs of a carriage decide.

    Parameters
    ----------
    found : CarriageStages
        Of a motion that motor, cable and resonance allow.
    goals : Goals

    Returns
    -------
    answer : {"yes", "no", "unknown"}
    reasons, remedies : list of str
    """
    control, runs = found.controller, found.acceptance
    if control is None:
        return UNKNOWN, [found.model.reason], ["model the cable in more pieces, or state a lighter cable"]
    if runs is None:
        return NO, [control.reason], [LONGER, "raise cable.pretension, or know the cable's stiffness better"]
    short = _short_of(runs, goals)
    if goals.carriage_error is None:
        return UNKNOWN, [*short, *_without_a_goal(runs, goals)], ["state error in [goals], as a length"]
    if not short:
        return YES, _accepted(runs, goals), []
    median = runs.quantile(0.5)
    if median is not None and median <= goals.carriage_error:
        sheet = "it depends on which of the plants the datasheet allows this one is"
        return UNKNOWN, [*short, sheet], [*_remedies(control), MEASURE]
    return NO, short, _remedies(control)


def _millimetres(value: float) -> str:
    return f"{1e3 * value:.3g} mm"


def _move(goals: Goals) -> str:
    assert goals.travel is not None
    hung = "the carriage and the mass below it follow" if goals.hanging_mass else "the carriage follows"
    return f"{hung} {goals.travel:.4g} m in {goals.duration:g} s"


def _short_of(runs: CarriageAcceptance, goals: Goals) -> list[str]:
    words = []
    if runs.failed > (1.0 - ENOUGH) * runs.draws:
        words.append(
            f"{runs.failed} of {runs.draws} runs ended early: a strand went slack, or the carriage left its "
            "span"
        )
    if runs.reached is not None and runs.reached < ENOUGH:
        assert goals.carriage_error is not None
        most = runs.quantile(ENOUGH)
        kept = "" if most is None else f"; {100 * ENOUGH:.0f} % keep within {_millimetres(most)}"
        words.append(
            f"error: {100 * runs.reached:.1f} % of {runs.draws} runs kept within "
            f"{_millimetres(goals.carriage_error)}{kept}"
        )
    return words


def _without_a_goal(runs: CarriageAcceptance, goals: Goals) -> list[str]:
    most = runs.quantile(ENOUGH)
    if most is None:
        return ["no error goal is stated, and too many runs ended early to name one that could be"]
    return [
        f"no error goal is stated, and no theorem gives one: {_move(goals)}, {100 * ENOUGH:.0f} % of "
        f'{runs.draws} runs within {_millimetres(most)}; error = "{rounded_up(1e3 * most):g} mm" could be '
        "stated"
    ]


def rounded_up(value: float) -> float:
    """The next number of two digits.

    Parameters
    ----------
    value : float
        Above 0.

    Returns
    -------
    float
    """
    scale = 10.0 ** (floor(log10(value)) - 1)
    return float(f"{ceil(value / scale - 1e-9) * scale:.2g}")


def _accepted(runs: CarriageAcceptance, goals: Goals) -> list[str]:
    assert goals.carriage_error is not None
    rest = runs.quantile(ENOUGH, rest=True)
    words = [
        f"{_move(goals)} within the goal of {_millimetres(goals.carriage_error)}: by the runs, for no "
        "theorem bounds this law's error"
    ]
    words.append(
        f"{runs.draws} runs: largest error {_millimetres(runs.peaks[-1])}; the goal was kept in "
        f"{100 * (runs.reached or 0.0):.1f} %"
        + ("" if rest is None else f"; at rest {100 * ENOUGH:.0f} % stay within {_millimetres(rest)}")
    )
    return words


def _remedies(control: CarriageController) -> list[str]:
    assert control.chosen is not None
    chosen = control.chosen
    parts = {"sensors": chosen.sensors or 0.0, "uncertain": chosen.uncertain or 0.0}
    words = []
    if parts["sensors"] > max(parts["uncertain"], chosen.nominal or 0.0):
        words.append("fit finer encoders: counts make the largest part of the error")
    elif control.shares:
        name = max(control.shares, key=lambda key: control.shares[key])
        words.append(f"know the {WORDS[name]} better: it makes the largest part of the error")
    if not control.both:
        words.append("fit sensors.load_encoder with the count of the drive pulley's: the law then sees more")
    return [*words, LONGER]


def carriage_cautions(found: CarriageStages, goals: Goals, current_loop: bool) -> list[str]:
    """What does not decide, and should be known.

    Parameters
    ----------
    found : CarriageStages
    goals : Goals
    current_loop : bool
        Whether the drive file names a torque loop or a delay.

    Returns
    -------
    list of str
    """
    words = [NO_BOUND] if found.acceptance is not None else []
    if goals.rail_friction is None:
        words.append(
            "friction of the carriage on its guide is guessed, 0 to 1 N s/m: state rail_friction "
            "in [carriage]"
        )
    if found.model.left_out > 0.0:
        words.append(
            "the motor joint is taken as rigid: its windup and free play, "
            f"{_millimetres(found.model.left_out)} at the carriage, are added to every error"
        )
    if current_loop:
        words.append(
            "the runs hold neither delay nor torque loop; both are short beside the carriage's period"
        )
    if found.controller is not None and not found.controller.both:
        words.append("the law listens to the motor's side alone: no like encoder on the load pulley")
    if found.acceptance is not None and found.acceptance.saturated:
        runs = found.acceptance
        words.append(f"{runs.saturated} of {runs.draws} runs met the torque limit")
    return words
