"""How the regression of one rigid axis is formed."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from cabledrive.identification.filters import causal_filter, ideal_low_pass, zero_phase
from cabledrive.identification.friction_regressors import FrictionModel
from cabledrive.parameters import InputRefused

Array = NDArray[np.float64]

FILTERS = ("zero-phase", "causal", "ideal")


@dataclass(frozen=True, slots=True, kw_only=True)
class AxisEquation:
    """How the regression of one axis is formed.

    Attributes
    ----------
    linear : bool
        Whether the axis slides (mass, force) instead of turning (inertia, torque).
    bandwidth : float
        Of the filter on both sides [Hz].
    filter : str
        One of `FILTERS`: Butterworth of order 4 forwards and backwards; (4.1) with damping 1; ideal.
    friction : FrictionModel
    quantum : float
        Step of the position [rad or m]; 0: none.
    kink : float
        Friction over inertia [rad/s^2 or m/s^2]: the jump of the acceleration at a turn is twice that. Known
        roughly from a first pass; the speed whose sign is taken then keeps its kinks when it is smoothed.
    lag : bool
        Whether the rate of the torque is the last column, see `cabledrive.identification.torque_timing`.
    """

    linear: bool
    bandwidth: float
    filter: str = "zero-phase"
    friction: FrictionModel = field(default_factory=FrictionModel)
    quantum: float = 0.0
    kink: float = 0.0
    lag: bool = False

    def __post_init__(self) -> None:
        if self.filter not in FILTERS:
            raise InputRefused(f'filter "{self.filter}" is unknown: take one of {", ".join(FILTERS)}')

    @property
    def offset(self) -> str:
        """Name of the constant torque or force."""
        return "offset_force" if self.linear else "offset_torque"

    @property
    def inertia(self) -> str:
        """Name of the inertia."""
        return "mass" if self.linear else "inertia"


def filtered(values: Array, equation: AxisEquation, interval: float) -> Array:
    """One signal through the filter of the regression, Eqs. (4.4), (4.5).

    ``values``, shape (samples,); ``interval`` [s].
    Returns shape (samples,).
    """
    if equation.filter == "causal":
        return causal_filter(values, interval, equation.bandwidth)[0]
    if equation.filter == "ideal":
        return ideal_low_pass(values, interval, equation.bandwidth)
    return zero_phase(values, interval, equation.bandwidth)
