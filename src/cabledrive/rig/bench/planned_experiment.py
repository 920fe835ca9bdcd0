"""What an experiment on the virtual rig would identify and needs, before it is run."""

from math import pi
from typing import Any

import numpy as np

from cabledrive.identification.planned_response import predicted_response_errors, resonance_warnings
from cabledrive.identification.planning import WEAK, largest_amplitude, plan_test
from cabledrive.identification.predicted_errors import AxisGuess, Instruments
from cabledrive.identification.response_models import PARAMETERS
from cabledrive.parameters import Drive, InputRefused
from cabledrive.reduction.lumped_chain import LumpedChain
from cabledrive.rig.bench.chapter_4 import rig_of
from cabledrive.rig.bench.experiment import Excitation, command_of, random_from
from cabledrive.rig.bench.virtual_rig import VirtualRig

MULTISINES = ("multisine", "idinput")


def plan_experiment(
    drive: Drive,
    excitation: Excitation | None = None,
    *,
    model: int | None = None,
    stroke: float | None = None,
    seed: int = 0,
) -> dict[str, Any]:
    """Predict standard errors, peaks and warnings of an experiment.

    ``drive``: its own figures serve as the guess; its motor's limits are held against the peaks; ``model``,
    {1, 2, 3, 4}; ``stroke``: largest travel from end to end [rad].
    Returns "relative_standard_error" of each parameter, "peaks" of the axis moved as a whole,
    "amplitude_factor" by which the torque reaches the first limit (None without limits), "warnings".
    Raises `InputRefused` if the torque does not move the axis, or the motor has no encoder.
    """
    excitation = excitation or Excitation()
    rig = rig_of(drive, model)
    command = command_of(excitation, rig.sample_rate, random_from(seed))
    torque = rig.torque_per_volt * command
    instruments = Instruments(torque_noise=rig.imperfections.torque_noise, quantum=_quantum(rig))
    limits, guess, interval = _limits(drive, stroke), _whole(rig.chain), 1.0 / rig.sample_rate
    plan = plan_test(torque, interval, guess, instruments, limits)
    errors: dict[str, float | None] = dict(plan.relative_errors)
    warnings = [*plan.findings, *resonance_warnings(drive, torque, rig.sample_rate)]
    if rig.chain.size > 1:
        errors, words = _of_response(drive, rig, excitation, torque)
        warnings = [w for w in warnings if WEAK not in w] + words
    return {
        "relative_standard_error": {
            k: v if v is not None and np.isfinite(v) else None for k, v in errors.items()
        },
        "peaks": plan.peaks,
        "moving": plan.moving,
        "amplitude_factor": largest_amplitude(torque, interval, guess, limits) if limits else None,
        "warnings": warnings,
    }


def _quantum(rig: VirtualRig) -> float:
    """One count of the motor's encoder [rad], of which alone the errors are predicted."""
    if "angle" not in rig.encoders:
        raise InputRefused("sensors.motor_encoder is missing, a plan counts on it: add it, such as 2600")
    return 2 * pi / rig.encoders["angle"]


def _whole(chain: LumpedChain) -> AxisGuess:
    """The lumped chain as one, seen from the motor."""
    reach, inertia, viscous, coulomb = 1.0, 0.0, 0.0, 0.0
    for k in range(chain.size):
        if k > 0:
            first, second = chain.ratios[k - 1]
            reach *= first / second
        inertia += reach**2 * chain.inertias[k]
        viscous += reach**2 * chain.viscous[k]
        coulomb += abs(reach) * chain.coulomb[k]
    return AxisGuess(inertia=inertia, viscous=viscous, coulomb=coulomb, offset=chain.offsets[0])


def _limits(drive: Drive, stroke: float | None) -> dict[str, float]:
    motor = drive.motor
    known = {
        "torque": None if motor is None else motor.torque_limit,
        "speed": None if motor is None else motor.speed_limit,
        "stroke": stroke,
    }
    return {name: float(limit) for name, limit in known.items() if limit is not None}


def _of_response(
    drive: Drive, rig: VirtualRig, excitation: Excitation, torque: np.ndarray
) -> tuple[dict[str, float | None], list[str]]:
    """Errors of stiffnesses and dampings from the response to a multisine; none from other excitations."""
    if rig.chain.names != ("motor", "drive", "load") or excitation.kind not in MULTISINES:
        return {}, ["errors of a flexible drive are predicted for Model 4 and multisines only"]
    radius, lumped = drive.drive_pulley.radius, rig.chain
    joint, cable = (first * second for first, second in lumped.ratios)
    values = {
        "motor_inertia": lumped.inertias[0],
        "drive_inertia": lumped.inertias[1],
        "load_inertia": lumped.inertias[2],
        "viscous_friction": max(lumped.viscous[0], 1e-9),
        "joint_stiffness": joint * lumped.stiffness[0],
        "joint_damping": joint * lumped.damping[0],
        "cable_stiffness": cable * lumped.stiffness[1] / (2 * radius**2),
        "cable_damping": cable * lumped.damping[1] / (2 * radius),
    }
    if min(values[name] for name in PARAMETERS[4]) <= 0.0:
        return {}, ["errors are not predicted: a stiffness or damping of the guess is zero"]
    period = round(excitation.period * rig.sample_rate)
    spectrum = 2 * np.abs(np.fft.rfft(torque[:period])) / period
    lines = np.flatnonzero(spectrum[1:] > 0.1 * spectrum[1:].max()) + 1
    try:
        errors = predicted_response_errors(
            4,
            values,
            lines * rig.sample_rate / period,
            spectrum[lines],
            radius=radius,
            quantum=_quantum(rig),
            sample_rate=rig.sample_rate,
            duration=max(excitation.duration - excitation.period, excitation.period),
            torque_noise=rig.imperfections.torque_noise,
        )
    except InputRefused as refusal:
        return {}, [str(refusal)]
    return dict(errors), []
