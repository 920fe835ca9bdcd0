"""Plants drawn from what is known of a drive, each with a generator of its own."""

from collections.abc import Mapping, Sequence

import numpy as np

from cabledrive.studies.study.correlations import Correlation, root_of
from cabledrive.studies.study.machine import LOG, Quantity

TWO_SIDED_95 = 1.96
RIPPLE_ORDERS = (1.0, 50.0)
"""Periods of torque ripple per radian of the motor: from once a turn and more to slots behind a gear."""


def sampled_values(
    quantities: Mapping[str, Quantity],
    generator: np.random.Generator,
    correlations: Sequence[Correlation] = (),
) -> dict[str, float]:
    """One plant from what is known: normal where a log gave the interval, else anywhere within the bounds.

    ``correlations``: of quantities that a log gave.
    """
    names = sorted(quantities)
    from_log = [name for name in names if quantities[name].source == LOG]
    chance = {name: generator.standard_normal() if name in from_log else generator.random() for name in names}
    if correlations:
        mixed = root_of(correlations, from_log) @ [chance[name] for name in from_log]
        chance |= dict(zip(from_log, mixed, strict=True))
    found = {}
    for name in names:
        q = quantities[name]
        if q.source == LOG:
            value = q.value + q.half_width / TWO_SIDED_95 * chance[name]
        else:
            value = q.low + (q.high - q.low) * chance[name]
        most = 0.999 if name == "motor_share" else np.inf
        found[name] = float(np.clip(value, q.least, most))
    return found


def sampled_plant(
    quantities: Mapping[str, Quantity],
    encoders: int,
    seed: int,
    draw: int,
    correlations: Sequence[Correlation] = (),
) -> tuple[dict[str, float], np.ndarray]:
    """Quantities and encoder phases of one draw; every draw has a generator of its own.

    Returns ``phases``, shape (encoders,).
    """
    generator = np.random.default_rng([seed, draw])
    values = sampled_values(quantities, generator, correlations)
    phases = generator.uniform(-0.5, 0.5, encoders)
    if "ripple_torque" in values:
        values["ripple_order"] = float(generator.uniform(*RIPPLE_ORDERS))
        values["ripple_phase"] = float(generator.uniform(0.0, 2.0 * np.pi))
    return values, phases
