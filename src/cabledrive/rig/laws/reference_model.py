"""Direct model reference adaptive control: quadratic feedback, factors of the motor's torque adapted."""

from math import pi

import numpy as np

from cabledrive.control.darc import printed_bounds
from cabledrive.control.linear_laws import (
    FRICTION_SLOPE,
    feedforward,
    lq_law,
    reference_model_generator,
    reference_model_law,
)
from cabledrive.control.observers import QUIET
from cabledrive.control.reference import flat_output, flat_reference
from cabledrive.reduction.lumped_chain import highest_model
from cabledrive.rig.laws.baselines import rigid_bandwidth, weights
from cabledrive.rig.laws.controllers import Controller, DesignSpec

NAME = "mrac"
SLOWER = 0.1
"""Bandwidth of adaptation over that of the feedback."""


def reference_model(spec: DesignSpec) -> Controller:
    """Quadratic feedback whose closed loop is the reference model; the motor's four parameters adapt."""
    number = highest_model(spec.drive)
    chain = spec.model(number)
    count, torque, settings = weights(spec)
    flat = flat_output(chain)
    motion = flat_reference(flat, spec.wanted(2 * chain.size), spec.interval)
    speed, acceleration = motion[:, -2], motion[:, -1]
    functions = np.column_stack((acceleration, speed, np.tanh(FRICTION_SLOPE * speed), np.ones(len(speed))))
    bounds = printed_bounds(chain, flexible_joint=chain.size == 3)
    # The offset of a motor acts against its torque's sign in the model: it is subtracted.
    low, high = bounds.low - bounds.nominal, bounds.high - bounds.nominal
    low[3], high[3] = -high[3], -low[3]
    law = reference_model_law(
        lq_law(chain, count, torque, spec.interval),
        low,
        high,
        np.abs(functions).max(axis=0),
        SLOWER * 2.0 * pi * rigid_bandwidth(chain, count, torque) * float(spec.adapt),
    )
    return Controller(
        name=NAME,
        law=law,
        reference=np.ascontiguousarray(np.hstack((feedforward(chain, flat, motion), functions))),
        shafts=("motor", "drive", "load") if chain.size == 3 else ("motor", "load"),
        start=np.zeros(4),
        tuning=QUIET,
        gains=settings
        | {"learns": ["inertia_motor", "viscous_friction", "coulomb_friction", "offset_torque"]},
        model=number,
        damped=True,
        generator=reference_model_generator(chain, flat, spec.interval),
    )
