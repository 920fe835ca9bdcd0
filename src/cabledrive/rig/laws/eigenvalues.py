"""Eigenvalues of a law on the actual plant, the least bandwidth it tolerates, and its filter."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import pi
from typing import Any

import numpy as np

from cabledrive.control.backstepping import fixed_row
from cabledrive.control.numbers import BACKSTEPPING, DARC, LINEAR
from cabledrive.control.observers import KalmanTuning
from cabledrive.parameters import Drive, InputRefused
from cabledrive.reduction.lumped_chain import LumpedChain, state_space
from cabledrive.rig.closed_loop.loop import Loop, plant_chain
from cabledrive.rig.laws.controllers import (
    Controller,
    DesignSpec,
    chain_law,
    fitted_encoders,
    law_shafts,
    own_filter,
    place,
)
from cabledrive.rig.setting import Spreads


@dataclass(frozen=True, slots=True, kw_only=True)
class Pole:
    """A pole of the closed loop, or a pair."""

    frequency: float  # its distance from the origin [Hz]
    damping_ratio: float  # 1 and more: real; negative: unstable


def closed_loop_poles(
    drive: Drive, controller: Controller, *, plant_model: int | None = None
) -> tuple[Pole, ...]:
    """Poles of the linear closed loop with true states and fixed estimates, a pair once, slowest first."""
    return poles_of(plant_chain(drive, plant_model), controller)


def pole_words(loop: Loop) -> dict[str, Any]:
    """Poles of a loop's law on its lumped chain, in words; none with a reason for laws of another kind."""
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
    """Poles of a law on a chain, true states, fixed estimates, no Coulomb friction, slowest first."""
    a, b = state_space(chain)
    n, law = chain.size, controller.law
    places = [place(chain, shaft) for shaft in controller.shafts]
    chosen = [*places, *(n + i for i in places)]
    count = len(chosen)
    if law.kind in (DARC, BACKSTEPPING):
        rows = fixed_row(law, count)
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


HIGHEST_HZ = 200.0


def check_least_bandwidth(
    law: Callable[[DesignSpec], Controller], made: Controller, spec: DesignSpec
) -> None:
    """Refuse a bandwidth below which a law of Model 4 is unstable on its own drive.

    Without the dampers in its model the law needs a stiffness of its own to outdo them. Other laws are let
    through: what they excite belongs to what is to be seen.
    """
    hertz = spec.bandwidth
    one_of_them = made.law.kind == BACKSTEPPING or not (made.damped or made.flat is None)
    if hertz is None or made.model != 4 or not one_of_them or _stable(made, spec):
        return
    high = hertz
    while not _stable(law(replace(spec, bandwidth=high)), spec):
        high *= 1.5
        if high > HIGHEST_HZ:
            return
    low = high / 1.5
    while high - low > 0.01 * high:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if _stable(law(replace(spec, bandwidth=middle)), spec) else (middle, high)
    raise InputRefused(
        f"bandwidth = {hertz:.4g} Hz is below {high:.3g} Hz, where {made.name} is unstable on this drive "
        "(its feedback leaves the damping of the cable out): raise it, or take darc-4-damped"
    )


def _stable(made: Controller, spec: DesignSpec) -> bool:
    return all(pole.damping_ratio > -1e-9 for pole in closed_loop_poles(spec.drive, made))


def damped_law(spec: DesignSpec, number: int) -> Controller:
    """The damping-aware law of a model, {1, 2, 3, 4}; its filter by what is not known."""
    own = own_filter(number, spec.feedback)
    only = None if own is None else law_shafts(number, spec.feedback)
    tuning = tuning_by_uncertainty(spec, spec.model(own or spec.number), only)
    return chain_law(spec, number, damped=True, tuning=tuning)


def tuning_by_uncertainty(
    spec: DesignSpec, chain: LumpedChain, only: Sequence[str] | None = None
) -> KalmanTuning:
    """Noise of the filter from what is not known of the drive.

    ``only``: as `fitted_encoders` has it. The load's equation is off by the spreads of stiffness and inertia
    times the largest acceleration wanted, for a sixteenth of the rise; friction by the Coulomb torque, within
    a second as a walk and within a millisecond as noise; each encoder's zero by half a count, walking that
    far within some seconds.
    """
    spreads = Spreads()
    wanted = spec.wanted(2)
    moving = np.abs(wanted[1]) > 0.0
    sets_out = int(np.count_nonzero(np.diff(moving.astype(int)) > 0)) + int(moving[0])
    rise = float(np.count_nonzero(moving)) * spec.interval / max(1, sets_out)
    off = (spreads.cable_stiffness + spreads.load_inertia) * float(np.abs(wanted[2]).max())
    coulomb, counts = chain.coulomb[0], list(fitted_encoders(spec.drive, only).values())
    return KalmanTuning(
        torque=1e-3 * coulomb**2,
        disturbance=coulomb**2,
        load_acceleration=off**2 * rise / 16.0,
        offsets=tuple(count**2 / 6.0 for count in counts[:-1]),
    )
