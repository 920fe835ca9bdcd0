"""The regressors of one axis over time, filtered and not, and what the model leaves: Figs. 4.7 to 4.16."""

from dataclasses import dataclass

import numpy as np

from cabledrive.identification.axis.axis import AxisOptions, channels_of
from cabledrive.identification.axis.equation import direction_of
from cabledrive.identification.estimates import Identification
from cabledrive.identification.filters import causal_filter, difference, ideal_low_pass
from cabledrive.identification.logs.log import Log
from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array

FILTER = 20.0
"""Natural frequency of the causal filter [Hz], as section 4.2.1 has it; damping 1."""
IDEAL = 50.0
"""Cutoff of the ideal low-pass for speed and acceleration [Hz], as section 4.2.1 has it."""
RESTING = 0.02
"""Share of the speed's size below which an axis counts as at rest."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RegressorCurves:
    """One axis over time."""

    time: Array  # (samples,): [s]
    names: tuple[str, ...]  # "acceleration", "speed", "friction"
    # unfiltered, filtered: (3, samples): by differences and the ideal low-pass; through the causal filter
    # (4.1)
    unfiltered: Array
    filtered: Array
    # torque, error: (samples,): Measured, and the modelling error of (4.9) [N m or N]
    torque: Array
    error: Array

    @property
    def error_share(self) -> float:
        """Root mean square of the modelling error over that of the torque."""
        return float(np.sqrt(np.mean(self.error**2) / np.mean(self.torque**2)))


def regressor_curves(
    log: Log, found: Identification, options: AxisOptions | None = None, *, slope: float = 0.5
) -> RegressorCurves:
    r"""Regressors and modelling error of an identified axis with one Coulomb friction.

    :math:`\tilde d = [\ddot\theta,\ \dot\theta,\ S(\dot\theta),\ -1]\,P - \tau`; ``slope``: K of tanh(K w),
    where that is the regressor [s/rad].
    """
    kind = found.model.removeprefix("rigid-axis-")
    if kind not in ("coulomb", "tanh") or not found.identifiable:
        raise InputRefused(f"{found.model}: curves are drawn of identified axes with one Coulomb friction")
    torque_name, position_name = channels_of(log, options or AxisOptions())
    torque, position = log.channel(torque_name), log.channel(position_name)
    interval = log.interval
    cutoff, natural = min(IDEAL, 0.2 / interval), min(FILTER, 0.1 / interval)
    speed = ideal_low_pass(difference(position, interval), interval, cutoff)
    acceleration = ideal_low_pass(difference(difference(position, interval), interval), interval, cutoff)
    if kind == "tanh":
        friction = np.tanh(slope * speed)
    else:
        friction = direction_of(speed, RESTING * float(np.sqrt(np.mean(speed**2))))
    unfiltered = np.array([acceleration, speed, friction])
    _, slow, slower = causal_filter(position, interval, natural)
    filtered = np.array([slower, slow, causal_filter(friction, interval, natural)[0]])
    inertia, viscous, coulomb, offset = (estimate.value for estimate in found.parameters.values())
    model = np.array([inertia, viscous, coulomb]) @ unfiltered - offset
    return RegressorCurves(
        time=log.time,
        names=("acceleration", "speed", "friction"),
        unfiltered=unfiltered,
        filtered=filtered,
        torque=torque,
        error=model - torque,
    )
