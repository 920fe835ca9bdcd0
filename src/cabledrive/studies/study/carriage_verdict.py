"""Remedies and cautions of a carriage's verdict: no theorem bounds its error, the runs decide."""

from cabledrive.studies.study.carriage_controller import CarriageController
from cabledrive.studies.study.carriage_demand import CarriageModel
from cabledrive.studies.study.findings import Findings
from cabledrive.studies.study.machine import WORDS

NO_BOUND = "no theorem bounds the error of the scheduled law: the error is a result of the runs"
LONGER = "lengthen the move: the force falls with the square of its duration"


def _millimetres(value: float) -> str:
    return f"{1e3 * value:.3g} mm"


def carriage_remedies(control: CarriageController) -> list[str]:
    """What would make the error of a carriage smaller.

    ``control``: with a bandwidth.
    """
    assert control.chosen is not None
    chosen = control.chosen
    parts = {"sensors": chosen.sensors or 0.0, "uncertain": chosen.uncertain or 0.0}
    words = []
    if parts["sensors"] > max(parts["uncertain"], chosen.nominal or 0.0):
        words.append("fit finer encoders: quantisation is the largest part of the error")
    elif control.shares:
        name = max(control.shares, key=lambda key: control.shares[key])
        words.append(f"identify the {WORDS[name]} more accurately: it causes the largest part of the error")
    if not control.both:
        words.append(
            "fit sensors.load_encoder with the resolution of the drive pulley's: the law then uses both"
        )
    return [*words, LONGER]


def carriage_cautions(found: Findings, current_loop: bool) -> list[str]:
    """What does not decide, and should be known.

    ``found``: of a carriage; ``current_loop``: whether the drive file names a torque loop or a delay.
    """
    runs, model, control = found.runs, found.model, found.controller
    words = [NO_BOUND] if runs.draws else []
    if found.goals.rail_friction is None:
        words.append(
            "friction of the carriage on its guide is an estimate, 0 to 1 N s/m: state rail_friction "
            "in [carriage]"
        )
    if isinstance(model, CarriageModel) and model.left_out > 0.0:
        words.append(
            "the motor joint is taken as rigid: its windup and backlash, "
            f"{_millimetres(model.left_out)} at the carriage, are added to every error"
        )
    if current_loop:
        words.append(
            "the runs contain neither delay nor torque loop; both are short compared with the period of "
            "the carriage"
        )
    if isinstance(control, CarriageController) and not control.both:
        words.append("the law uses the motor-side encoder only: the load pulley has no equal encoder")
    if runs.saturated:
        words.append(f"{runs.saturated} of {runs.draws} runs reached the torque limit")
    return words
