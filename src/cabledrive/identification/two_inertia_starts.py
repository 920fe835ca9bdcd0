"""Where the search for two inertias begins: totals from a rigid regression, the rest drawn."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cabledrive.identification.chain_model import Record
from cabledrive.identification.filters import difference, zero_phase

Array = NDArray[np.float64]

STARTS = 12
LOW_SHARE, HIGH_SHARE = 0.1, 0.9
"""Shares of the total inertia that the motor may have at the start."""
FASTEST = 0.2
"""Highest resonance of a start, in samples."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Starts:
    """Starts, and the scales of the log."""

    scale: dict[str, float]  # "inertia", "stiffness", "damping", "viscous" and "input"
    starts: tuple[dict[str, float], ...]


def starts_for(records: Sequence[Record], rectified: bool, rng: np.random.Generator) -> Starts:
    """Starts of the search.

    ``rectified``: whether the sensor shows absolute values.
    """
    total, viscous, coulomb = _rigid(records, rectified)
    interval = records[0].interval
    duration = max(record.interval * record.input.size for record in records)
    low, high = max(0.5, 10.0 / duration), FASTEST / interval
    size = float(np.sqrt(np.mean(np.concatenate([record.input for record in records]) ** 2)))
    starts = []
    for k in range(STARTS):
        share = LOW_SHARE + (HIGH_SHARE - LOW_SHARE) * float(rng.uniform())
        # low frequencies first: stratified, so that no octave is left out
        place = (k + float(rng.uniform())) / STARTS
        omega = 2 * np.pi * low * (high / low) ** place
        reduced = total * share * (1.0 - share)
        starts.append(
            {
                "inertia_motor": share * total,
                "inertia_load": (1.0 - share) * total,
                "stiffness": reduced * omega**2,
                "damping": 0.06 * reduced * omega,
                "viscous_friction_motor": 0.5 * viscous,
                "viscous_friction_load": 0.5 * viscous,
                "coulomb_friction_motor": 0.5 * coulomb,
                "coulomb_friction_load": 0.5 * coulomb,
                "offset": 0.0,
                "sensor_lag": 2.0 * interval,
            }
        )
    middle = 2 * np.pi * np.sqrt(low * high)
    scale = {
        "inertia": total,
        "stiffness": total * middle**2,
        "damping": total * middle,
        "viscous": max(viscous, 1e-3 * total / interval),
        "input": size,
    }
    return Starts(scale=scale, starts=tuple(starts))


def _rigid(records: Sequence[Record], rectified: bool) -> tuple[float, float, float]:
    """Total inertia, viscous and Coulomb friction of one rigid axis, all positive."""
    rows, left = [], []
    for record in records:
        speed, input_ = record.output[:, 0], record.input
        if rectified:
            speed = speed * np.where(
                zero_phase(input_, record.interval, 0.02 / record.interval) < 0, -1.0, 1.0
            )
        bandwidth = 0.05 / record.interval
        smooth = zero_phase(speed, record.interval, bandwidth)
        rows.append(
            np.column_stack(
                [
                    difference(smooth, record.interval),
                    smooth,
                    np.tanh(smooth / (0.05 * np.abs(smooth).max() + 1e-300)),
                    np.ones(smooth.size),
                ]
            )
        )
        left.append(zero_phase(input_, record.interval, bandwidth))
    found = np.linalg.lstsq(np.vstack(rows), np.concatenate(left), rcond=None)[0]
    size = float(np.sqrt(np.mean(np.concatenate([r.output.ravel() for r in records]) ** 2)))
    force = float(np.sqrt(np.mean(np.concatenate(left) ** 2)))
    rate = float(np.sqrt(np.mean(np.concatenate([row[:, 0] for row in rows]) ** 2)))
    total = float(found[0]) if found[0] > 1e-3 * force / rate else force / rate
    viscous = max(float(found[1]), 1e-3 * force / size)
    return total, viscous, max(float(found[2]), 1e-3 * force)
