"""Eigenvalues of a law on the actual plant: most of what is seen in a run is in them."""

from dataclasses import dataclass
from math import pi
from typing import Any

import numpy as np

from cabledrive.control.backstepping import backstepping_row
from cabledrive.control.darc import darc_step
from cabledrive.control.numbers import BACKSTEPPING, DARC, LINEAR, NOMINAL
from cabledrive.parameters import Drive, InputRefused
from cabledrive.reduction.lumped_chain import LumpedChain, state_space
from cabledrive.rig.closed_loop.loop import Loop, plant_chain
from cabledrive.rig.laws.controllers import Controller
from cabledrive.rig.laws.fitting import place


@dataclass(frozen=True, slots=True, kw_only=True)
class Pole:
    """A pole of the closed loop, or a pair.

    Attributes
    ----------
    frequency : float
        Its distance from the origin [Hz].
    damping_ratio : float
        1 and more: real; negative: unstable.
    """

    frequency: float
    damping_ratio: float


def closed_loop_poles(
    drive: Drive, controller: Controller, *, plant_model: int | None = None
) -> tuple[Pole, ...]:
    """Poles of the linear closed loop with true states, fixed estimates, and no Coulomb friction.

    ``drive``: the plant; ``controller``: a law of the chain, or a linear law without memory; ``plant_model``,
    {1, 2, 3, 4}.
    Returns ascending in frequency, one entry for each pair.
    Raises `InputRefused` if the law is of another kind.
    """
    return poles_of(plant_chain(drive, plant_model), controller)


def pole_words(loop: Loop) -> dict[str, Any]:
    """Poles of a loop's law on its lumped chain, in words.

    Returns none with a reason for laws of another kind.
    """
    if loop.own_plant is not None:
        reason = f'plant "{loop.own_plant.name}" is your own: its equations are not known'
        return {"closed_loop_poles": None, "closed_loop_poles_reason": reason}
    try:
        poles = poles_of(loop.chain, loop.controller)
    except InputRefused as refusal:
        return {"closed_loop_poles": None, "closed_loop_poles_reason": str(refusal)}
    words = [{"frequency_hz": pole.frequency, "damping_ratio": pole.damping_ratio} for pole in poles]
    return {"closed_loop_poles": words}


def poles_of(chain: LumpedChain, controller: Controller) -> tuple[Pole, ...]:
    """Poles of a law on a lumped chain, with true states, fixed estimates, and no Coulomb friction.

    ``chain``: the plant, at the first shaft.
    Returns ascending in frequency, one entry for each pair.
    Raises `InputRefused` if the law is none of the chain, or linear with a memory.
    """
    a, b = state_space(chain)
    n, law = chain.size, controller.law
    places = [place(chain, shaft) for shaft in controller.shafts]
    chosen = [*places, *(n + i for i in places)]
    count = len(chosen)
    if law.kind == DARC:
        frozen = law.learning[NOMINAL].copy()
        frozen[2:] = 0.0
        rows = [darc_step(law, frozen, unit, np.zeros(count + 3)).command for unit in np.eye(count)]
    elif law.kind == BACKSTEPPING:
        rows = backstepping_row(law, count)
    elif law.kind == LINEAR and law.matrix.shape[0] == 0:
        rows = list(law.rows[0])
    else:
        raise InputRefused(f"{controller.name} is no law of the chain, and only those have eigenvalues")
    feedback = np.zeros(2 * n)
    np.add.at(feedback, chosen, rows)
    if controller.field is not None:  # the magnetic spring of a stepper
        feedback[0] -= controller.field[0] * controller.field[1]
    values = np.linalg.eigvals(a + np.outer(b[:, 0], feedback))
    kept = sorted((v for v in values if v.imag >= 0.0), key=abs)
    return tuple(
        Pole(frequency=abs(v) / (2.0 * pi), damping_ratio=float(-v.real / abs(v)) if abs(v) else 1.0)
        for v in kept
    )
