r"""Every control law of the rig by its name; a stepper's open loop; eigenvalues of a law on a plant.

The rotor follows on its magnetic spring, :math:`T\sin(N(\theta_f - \theta_1))` with :math:`NT` the holding
stiffness and T the torque limit; beyond a quarter of a period steps are lost. No encoder is read. The shaped
motion is late by the shaper's mean delay, and errors are counted against the motion so late.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from math import pi
from typing import Any

import numpy as np

from cabledrive.control.backstepping import fixed_row
from cabledrive.control.linear_laws import linear_law
from cabledrive.control.numbers import BACKSTEPPING, DARC, LINEAR
from cabledrive.parameters import Drive, InputRefused
from cabledrive.parameters.fields import nearest
from cabledrive.reduction.lumped_chain import LumpedChain, highest_model, state_space
from cabledrive.rig.closed_loop.loop import Loop
from cabledrive.rig.laws import load_learning as learning
from cabledrive.rig.laws.baselines import BASELINES, backstepping, reference_model
from cabledrive.rig.laws.baselines import NAME as MRAC
from cabledrive.rig.laws.controllers import Controller, DesignSpec, chain_law, damped_law, place, plant_chain
from cabledrive.rig.setting import DISSERTATION_ORDER, none
from cabledrive.trajectories.input_shaping import input_shaper

STEPPER, SHAPED = "stepper", "stepper-shaped"
OPEN_LOOPS = (STEPPER, SHAPED)
NO_FILTER = "none, an open loop"
TEETH = 50.0
"""Of a rotor of 1.8 deg a step, where no torque limit says how many there are."""
SHAPER = "mzv"
"""Klipper's own default."""


def stepper(spec: DesignSpec, *, shaped: bool = False) -> Controller:
    """An open loop on the stepper's magnetic spring; ``shaped``: for the mode that is left with it held."""
    motor, name = spec.drive.motor, SHAPED if shaped else STEPPER
    if motor is None or motor.holding_stiffness is None:
        raise InputRefused(
            f"{name}: motor.holding_stiffness is missing, the spring of a stepper: give teeth times holding "
            'torque, such as "20 N m/rad", or take a servo law'
        )
    stiffness = motor.holding_stiffness
    torque = stiffness / TEETH if motor.torque_limit is None else motor.torque_limit
    chain = spec.chain
    n, wanted, late = chain.size, spec.wanted(0)[0], 0.0
    gains: dict[str, object] = {"bandwidth_hz": None, "field_periods": stiffness / torque}
    if shaped:
        rates = state_space(chain)[0]
        rates[n, 0] -= stiffness / chain.inertias[0]
        poles = np.linalg.eigvals(rates)
        lowest = min(poles[poles.imag > 1e-6], key=abs, default=None)
        if lowest is None:
            raise InputRefused(f"{SHAPED}: with the motor held nothing swings: take {STEPPER}")
        made = input_shaper(SHAPER, abs(lowest) / (2.0 * pi), max(0.0, float(-lowest.real / abs(lowest))))
        time = spec.interval * np.arange(spec.samples)
        parts = zip(made.amplitudes, made.times, strict=True)
        wanted, late = sum(a * np.interp(time - t, time, wanted) for a, t in parts), made.delay
        gains |= {"shaper": SHAPER, "shaper_hz": made.frequency, "shaper_damping": made.damping, "late": late}
        gains["reasons"] = [
            f"shaper {SHAPER} at {made.frequency:.4g} Hz, damping ratio {made.damping:.3g}: the motion comes "
            f"{1e3 * late:.3g} ms late, and errors are counted against it so late"
        ]
    return Controller(
        name=name,
        law=linear_law(np.zeros((0, 2 * n + 1)), np.zeros((1, 2 * n)), spec.interval),
        reference=np.column_stack((np.zeros((spec.samples, 2 * n)), wanted)),
        shafts=spec.shafts,
        gains=gains,
        model=spec.number,
        field=(torque, stiffness / torque),
        late=late,
    )


CONTROLLERS: dict[str, Callable[[DesignSpec], Controller]] = {
    **{f"darc-{number}": partial(chain_law, number=number, damped=False) for number in (1, 2, 3, 4)},
    **{f"darc-{number}-damped": partial(damped_law, number=number) for number in (1, 2, 3, 4)},
    "backstepping": backstepping,
    "backstepping-6": partial(backstepping, number=4),
    learning.INDIRECT: lambda spec: replace(damped_law(spec, spec.number), name=learning.INDIRECT),
    learning.LOAD_LEARNING: learning.load_learning,
    learning.CHANGING: lambda spec: learning.load_learning(spec, learning.CHANGING),
    MRAC: reference_model,
    learning.SCHEDULED: learning.scheduled,
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


MAIN_LAWS = ("pd", "pid", "lqg", "lqi", "darc-4-damped", learning.LOAD_LEARNING)
"""What is compared, studied and listed first; the others where all are asked for."""


def known_name(name: str | None, drive: Drive) -> str:
    """Name of a law; default: with a flexible motor joint "darc-4-damped", else "darc-3"."""
    if name is None:
        return "darc-4-damped" if highest_model(drive) == 4 else "darc-3"
    if name not in CONTROLLERS:
        raise InputRefused(
            f"controller = {name!r} is not known{nearest(name, CONTROLLERS)}: see docs/control"
        )
    return name


def needed_order(name: str, drive: Drive) -> int:
    """Least order of a rise with as many bounded derivatives as a law takes, 4n - 1; 9 or more, (6.1)."""
    inertias = INERTIAS.get(name, 3 if highest_model(drive) == 4 else 2)
    return max(DISSERTATION_ORDER, 4 * inertias - 1)


LARGEST_SHARE = 1.0 / 20.0
"""Of the sample rate, for a bandwidth."""


def check_sample_rate(controller: Controller, interval: float) -> None:
    """Refuse a bandwidth that the sample rate does not carry; ``interval``: sample time [s]."""
    hertz = float(controller.gains.get("bandwidth_hz") or 0.0)
    if hertz * interval > LARGEST_SHARE:
        said = f"sensors.sample_rate = {1.0 / interval:.6g} Hz is below 20 times the bandwidth {hertz:.4g} Hz"
        raise InputRefused(f"{said}: sample faster, or lower --bandwidth")


def pole_words(loop: Loop) -> dict[str, Any]:
    """Poles of a loop's law on its lumped chain, in words; none with a reason for laws of another kind."""
    if loop.own_plant is not None:
        own = f'plant "{loop.own_plant.name}" is your own'
        return none("closed_loop_poles", f"{own}: its equations are not known")
    try:
        poles = poles_of(loop.chain, loop.controller)
    except InputRefused as refusal:
        return none("closed_loop_poles", str(refusal))
    return {"closed_loop_poles": [{"frequency_hz": hertz, "damping_ratio": ratio} for hertz, ratio in poles]}


def poles_of(chain: LumpedChain, controller: Controller) -> list[tuple[float, float]]:
    """Poles of a law on a chain, true states, fixed estimates, no Coulomb friction, slowest first.

    Of each, or of a pair, its distance from the origin [Hz] and the damping ratio, from 1 on real.
    """
    a, b = state_space(chain)
    n, law = chain.size, controller.law
    places = [place(chain, shaft) for shaft in controller.shafts]
    chosen = [*places, *(n + i for i in places)]
    if law.kind in (DARC, BACKSTEPPING):
        rows = fixed_row(law, len(chosen))
    elif law.kind == LINEAR and law.matrix.shape[0] == 0:
        rows = list(law.rows[0])
    else:
        raise InputRefused(f"{controller.name} is no law of the chain, and only those have eigenvalues")
    feedback = np.zeros(2 * n)
    np.add.at(feedback, chosen, rows)
    if controller.field is not None:  # the magnetic spring of a stepper
        feedback[0] -= controller.field[0] * controller.field[1]
    kept = sorted((v for v in np.linalg.eigvals(a + np.outer(b[:, 0], feedback)) if v.imag >= 0.0), key=abs)
    return [(abs(v) / (2.0 * pi), float(-v.real / abs(v)) if abs(v) else 1.0) for v in kept]


UNSTABLE = {
    2: ("it feeds the twist back positively", "raise it"),
    4: ("its feedback leaves the damping of the cable out", "raise it, or take darc-4-damped"),
}
"""Why a law of a model is unstable at low bandwidths, and what to do."""


def check_least_bandwidth(
    law: Callable[[DesignSpec], Controller], made: Controller, spec: DesignSpec
) -> None:
    """Refuse a bandwidth at which a law of Model 2, or of 4 without dampers, is unstable on its own drive."""
    hertz, highest = spec.bandwidth, LARGEST_SHARE / spec.interval
    undamped = made.law.kind == BACKSTEPPING or not (made.damped or made.flat is None)
    if hertz is None or not (made.model == 2 or (made.model == 4 and undamped)) or _stable(made, spec):
        return
    (why, remedy), high = UNSTABLE[made.model], hertz
    asked, said = f"bandwidth = {hertz:.4g} Hz", f"{made.name} is unstable on this drive ({why})"
    while not _stable(law(replace(spec, bandwidth=high)), spec):
        high *= 1.5
        if high > highest:
            raise InputRefused(
                f"{asked}: {said} up to {highest:.4g} Hz, what its samples carry: take another law"
            )
    low = high / 1.5
    while high - low > 0.01 * high:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if _stable(law(replace(spec, bandwidth=middle)), spec) else (middle, high)
    raise InputRefused(f"{asked} is below {high:.3g} Hz, where {said}: {remedy}")


def _stable(made: Controller, spec: DesignSpec) -> bool:
    return all(ratio > -1e-9 for _, ratio in poles_of(plant_chain(spec.drive, None), made))
