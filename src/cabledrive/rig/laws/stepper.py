r"""A stepper: an open loop whose field turns as the motion asks for, with or without an input shaper.

The rotor follows on its magnetic spring, :math:`T\sin(N(\theta_f - \theta_1))` with :math:`NT` the holding
stiffness and T the torque limit; beyond a quarter of a period steps are lost. No encoder is read. The shaped
motion is late by the shaper's mean delay, and errors are counted against the motion so late.
"""

from math import pi

import numpy as np

from cabledrive.control.linear_laws import linear_law
from cabledrive.control.observers import QUIET
from cabledrive.parameters import InputRefused
from cabledrive.reduction.lumped_chain import highest_model, state_space
from cabledrive.rig.laws.controllers import Controller, DesignSpec
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
    number = highest_model(spec.drive)
    chain = spec.model(number)
    n, wanted, late = chain.size, spec.wanted(0)[0], 0.0
    gains: dict[str, object] = {"bandwidth_hz": None, "field_periods": stiffness / torque}
    if shaped:
        rates = state_space(chain)[0]
        rates[n, 0] -= stiffness / chain.inertias[0]
        poles = np.linalg.eigvals(rates)
        lowest = min(poles[poles.imag > 1e-6], key=abs)
        made = input_shaper(SHAPER, abs(lowest) / (2.0 * pi), float(-lowest.real / abs(lowest)))
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
        shafts=("motor", "drive", "load") if n == 3 else ("motor", "load"),
        start=np.zeros(0),
        tuning=QUIET,
        gains=gains,
        model=number,
        damped=True,
        field=(torque, stiffness / torque),
        late=late,
    )
