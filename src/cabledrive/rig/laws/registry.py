"""Every control law of the rig by its name."""

from collections.abc import Callable

from cabledrive.parameters import Drive, InputRefused
from cabledrive.parameters.fields import nearest
from cabledrive.reduction.lumped_chain import highest_model
from cabledrive.rig.laws.backstepping_laws import backstepping_6
from cabledrive.rig.laws.baselines import BASELINES
from cabledrive.rig.laws.controllers import Controller, DesignSpec, backstepping, darc
from cabledrive.rig.laws.filter_tuning import damped_law
from cabledrive.rig.laws.indirect import NAME, indirect
from cabledrive.rig.laws.load_learning import CHANGING, load_learning
from cabledrive.rig.laws.load_learning import NAME as LOAD_LEARNING
from cabledrive.rig.laws.reference_model import NAME as MRAC
from cabledrive.rig.laws.reference_model import reference_model
from cabledrive.rig.laws.scheduled import NAME as SCHEDULED
from cabledrive.rig.laws.scheduled import scheduled
from cabledrive.rig.laws.stepper import SHAPED, STEPPER, stepper
from cabledrive.rig.setting import DISSERTATION_ORDER

CONTROLLERS: dict[str, Callable[[DesignSpec], Controller]] = {
    "darc-1": lambda spec: darc(spec, 1),
    "darc-2": lambda spec: darc(spec, 2),
    "darc-3": lambda spec: darc(spec, 3),
    "darc-4": lambda spec: darc(spec, 4),
    "darc-1-damped": lambda spec: damped_law(spec, "darc-1-damped", 1),
    "darc-2-damped": lambda spec: damped_law(spec, "darc-2-damped", 2),
    "darc-3-damped": lambda spec: damped_law(spec, "darc-3-damped", 3),
    "darc-4-damped": lambda spec: damped_law(spec, "darc-4-damped"),
    "backstepping": backstepping,
    "backstepping-6": backstepping_6,
    NAME: indirect,
    LOAD_LEARNING: load_learning,
    CHANGING: lambda spec: load_learning(spec, CHANGING),
    MRAC: reference_model,
    SCHEDULED: scheduled,
    STEPPER: stepper,
    SHAPED: lambda spec: stepper(spec, shaped=True),
    **BASELINES,
}

INERTIAS = {
    **{f"darc-{model}{kind}": n for model, n in ((1, 1), (2, 2), (3, 2), (4, 3)) for kind in ("", "-damped")},
    "backstepping": 2,
    "backstepping-6": 3,
}
"""Inertias of the models of laws; the others are made for the drive's highest model."""


MAIN_LAWS = ("pd", "pid", "lqg", "lqi", "darc-4-damped", LOAD_LEARNING)
"""What is compared, studied and listed first; the others where all are asked for."""


def main_laws(drive: Drive) -> tuple[str, ...]:
    """Laws that are compared and studied where none are named, simplest first."""
    rigid = "darc-3-damped" if highest_model(drive) < 4 else "darc-4-damped"
    return tuple(rigid if name == "darc-4-damped" else name for name in MAIN_LAWS)


def known_name(name: str | None, drive: Drive) -> str:
    """Name of a control law, or the one that the drive's joint calls for.

    ``name``: default: with a flexible motor joint "darc-4-damped", else "darc-3".
    Raises `InputRefused` if there is no such law.
    """
    if name is None:
        return "darc-4-damped" if highest_model(drive) == 4 else "darc-3"
    if name not in CONTROLLERS:
        raise InputRefused(
            f"controller = {name!r} is not known{nearest(name, CONTROLLERS)}: see docs/control"
        )
    return name


def needed_order(name: str, drive: Drive) -> int:
    """Least order of a rise with as many bounded derivatives as a law takes, and at least the 9 of (6.1).

    The torque of a lumped chain of n inertias holds 2n derivatives of the load's angle, and a rise of order
    2m - 1 has
    m bounded ones.
    """
    inertias = INERTIAS.get(
        name, 3 if highest_model(drive) == 4 or name in ("darc-4", "darc-4-damped") else 2
    )
    return max(DISSERTATION_ORDER, 4 * inertias - 1)


def check_sample_rate(controller: Controller, interval: float) -> None:
    """Refuse a bandwidth that the sample rate does not carry.

    ``interval``: sample time [s].
    Raises `InputRefused` if there are fewer than 20 samples per period of the bandwidth.
    """
    hertz = float(controller.gains.get("bandwidth_hz") or 0.0)
    if hertz * interval > 1.0 / 20.0:
        raise InputRefused(
            f"sensors.sample_rate = {1.0 / interval:.6g} Hz is below 20 times the bandwidth {hertz:.4g} Hz: "
            "sample faster, or lower --bandwidth"
        )
