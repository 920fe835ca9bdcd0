"""What a multisine will identify of Models 1 to 4, and whether it would drive the 1:2 resonance."""

from collections.abc import Mapping
from math import pi

import numpy as np
from numpy.typing import NDArray

from cabledrive.identification.response_models import PARAMETERS, chain_for
from cabledrive.parameters import Drive, InputRefused
from cabledrive.reduction.autoparametric import autoparametric_model
from cabledrive.reduction.lumped_chain import speed_response
from cabledrive.reduction.threshold import threshold_torque

Array = NDArray[np.float64]

STEP = 1e-5
LOUD = 0.01
"""Lines below this share of the largest are not looked at."""
NEAR = 0.25
"""Lines within this share of the pulley mode's frequency are compared with the threshold."""


def predicted_response_errors(
    model: int,
    values: Mapping[str, float],
    frequency: Array,
    amplitude: Array,
    *,
    radius: float,
    quantum: float,
    sample_rate: float,
    duration: float,
    torque_noise: float = 0.0,
) -> dict[str, float]:
    r"""Relative standard error of each parameter from a fit of the response at the lines of a multisine.

    A line that lasts for N samples is known to the variance :math:`4\sigma^2/N` in the torque and, through
    the rounded angle, to :math:`\omega^2 q^2/(3N)` in the speed.

    ``model``, {1, 2, 3, 4}; ``values``: guess of the parameters of
    `cabledrive.identification.response_models.PARAMETERS`; ``frequency``, ``amplitude``, shape (m,): lines of
    the torque [Hz], [N m]; ``radius`` [m]; ``quantum``: step of the motor's encoder [rad]; ``sample_rate``,
    ``duration`` [Hz], [s]; ``torque_noise``: standard deviation of one sample of the torque [N m].
    Returns infinite where the lines do not identify a parameter.
    Raises `InputRefused` if there are fewer lines than parameters need.
    """
    names = PARAMETERS[model]
    if 2 * frequency.size <= len(names):
        raise InputRefused(f"{frequency.size} lines are too few for {len(names)} parameters: add lines")
    omega = 2 * pi * np.asarray(frequency, dtype=float)
    samples = sample_rate * duration
    base = speed_response(chain_for(model, values, radius), omega)
    of_speed = omega**2 * quantum**2 / 3.0
    variance = (of_speed + 4.0 * torque_noise**2 * np.abs(base) ** 2) / samples / amplitude**2
    columns = []
    for name in names:
        moved = {k: v * (np.exp(STEP) if k == name else 1.0) for k, v in values.items()}
        slope = (speed_response(chain_for(model, moved, radius), omega) - base) / STEP
        columns.append(slope / np.sqrt(variance))
    rows = np.column_stack(columns)
    r = np.linalg.qr(np.vstack([rows.real, rows.imag]), mode="r")
    s = np.linalg.svd(r / np.maximum(np.linalg.norm(r, axis=0), 1e-300), compute_uv=False)
    if s[-1] < 1e-9 * s[0]:
        return dict.fromkeys(names, float("inf"))
    errors = np.linalg.norm(np.linalg.inv(r), axis=1) / np.sqrt(2.0)  # each part carries half the variance
    return {name: float(error) for name, error in zip(names, errors, strict=True)}


def resonance_warnings(drive: Drive, torque: Array, sample_rate: float) -> tuple[str, ...]:
    """Lines of a torque that would make the spans grow through the 1:2 resonance.

    ``torque``, shape (samples,): at the motor [N m]; ``sample_rate`` [Hz].
    Returns empty where no line is near the pulley mode or above its threshold.
    """
    try:
        model = autoparametric_model(drive)
    except InputRefused as refusal:
        return (f"the 1:2 resonance was not checked: {refusal}",)
    frequency = np.asarray(np.fft.rfftfreq(torque.size, 1.0 / sample_rate)[1:], dtype=float)
    size = 2.0 * np.abs(np.fft.rfft(torque))[1:] / torque.size
    pulley = float(model.natural) / (2 * pi)
    loud = size > LOUD * size.max()
    near = loud & (np.abs(frequency / pulley - 1.0) < NEAR)
    if not near.any():
        return ()
    lines, sizes = frequency[near], _joined(frequency, size, near, model.modal_damping)
    thresholds = np.asarray(threshold_torque(model, 2 * pi * lines))
    over = sizes > thresholds
    if not over.any():
        return ()
    worst = int(np.argmax(np.where(over, sizes / np.maximum(thresholds, 1e-300), 0.0)))
    return (
        f"would drive the 1:2 resonance: {sizes[worst]:.3g} N m at {lines[worst]:.5g} Hz, a span is "
        f"unstable above {thresholds[worst]:.3g} N m (pulley mode {pulley:.5g} Hz): leave that line out, "
        "lower it, or change the pretension",
    )


def _joined(frequency: Array, size: Array, near: NDArray[np.bool_], damping: float) -> Array:
    """Amplitude at each line with its neighbours within the pulley mode's half-width, which sum up in it."""
    width = max(0.5 * damping / (2 * pi), 0.5 * float(frequency[0]))
    lines = frequency[near]
    return np.array([np.sqrt(np.sum(size[np.abs(frequency - f) <= width] ** 2)) for f in lines])
