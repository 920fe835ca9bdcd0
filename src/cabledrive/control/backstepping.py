r"""Backstepping for a rigid joint and a flexible cable of uncertain stiffness, (6.66)-(6.106).

States are :math:`x_1 = \theta_2`, :math:`x_2 = \dot\theta_2`, :math:`\bar x_3 = \beta_n(\theta_1 -
\theta_2)`,
:math:`\bar x_4`; the seven parameters follow (6.69). The law itself is
`cabledrive.control.backstepping_recursion`.
"""

from dataclasses import dataclass
from math import isfinite, pi

import numpy as np

from cabledrive.control.numbers import BACKSTEPPING, LawNumbers, learning_table
from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.lumped_chain import LumpedChain

PRINTED_HZ = 10.5
SMOOTH = 0.5
# Table 6.3 over its own nominal values, p5 and p7 corrected; p2 and p6 are not printed.
_SHARES = {1: 0.05, 3: 0.03, 4: 0.03, 5: 0.03, 7: 0.03}
_LOAD_ACCELERATION, _MOTOR_TORQUE = 2.0, 0.01  # rad/s^2, N m


@dataclass(frozen=True, slots=True, kw_only=True)
class BacksteppingGains:
    """Gains of (6.71), (6.76), (6.82) and (6.90), robust ones included and constant.

    The source prints a bandwidth of 10.5 Hz and no gain. Here each step has the bandwidth, and the cross
    gains make the error dynamics (6.103) nearly triangular: k21 = k32 = k43 = 1, k42 = 0.
    """

    k1: float  # [rad/s]
    k21: float  # [1/s^2]
    k22: float  # [rad/s]
    k32: float  # [1/s^2]
    k33: float  # [rad/s]
    k42: float  # [1/s^3]
    k43: float  # [1/s^2]
    k44: float  # [rad/s]
    adaptation: float  # gamma of Gamma = gamma W_p^2, (6.36); 0: estimates stay

    @property
    def matrix(self) -> Array:
        """The gains by step and error, shape (4, 4)."""
        return np.array(
            [
                [self.k1, 0.0, 0.0, 0.0],
                [self.k21, self.k22, 0.0, 0.0],
                [0.0, self.k32, self.k33, 0.0],
                [0.0, self.k42, self.k43, self.k44],
            ]
        )


def backstepping_gains(bandwidth: float | None = None, *, adaptation: float = 1e-6) -> BacksteppingGains:
    """Equal bandwidth [Hz] in every step, default that of the source; ``adaptation``: gamma.

    Refused: a bandwidth that is not positive, a negative adaptation.
    """
    hertz = PRINTED_HZ if bandwidth is None else bandwidth
    if not isfinite(hertz) or hertz <= 0.0:
        raise InputRefused(
            f"bandwidth = {hertz:.6g} Hz must be finite and above 0: the errors grow otherwise"
        )
    if not isfinite(adaptation) or adaptation < 0.0:
        raise InputRefused(f"adaptation = {adaptation:.6g} must not be negative: give 0 to switch it off")
    k = 2.0 * pi * hertz
    return BacksteppingGains(
        k1=k, k21=1.0, k22=k, k32=1.0, k33=k, k42=0.0, k43=1.0, k44=k, adaptation=adaptation
    )


def unmatched_parameters(chain: LumpedChain) -> tuple[Array, Array, float]:
    """The seven parameters of (6.69), their half widths, and beta_n [1/s^2], of two inertias, Model 3.

    Half widths: Table 6.3 in proportion; 2 rad/s^2 for p2 and 0.01 N m for p6, which it lacks.
    """
    if chain.size != 2:
        raise InputRefused(f"{chain.size} inertias given, backstepping of (6.69) takes 2: use Model 3")
    j1, j2 = chain.inertias
    beta = chain.stiffness[0] / j2
    scale = beta / j1
    parameters = np.array(
        [
            1.0,
            0.0,
            chain.stiffness[0] / j1 + beta,
            chain.viscous[0] * scale,
            chain.coulomb[0] * scale,
            chain.offsets[0] * scale,
            1.0 / j1,
        ]
    )
    widths = np.array([_SHARES.get(i, 0.0) for i in range(1, 8)]) * parameters
    widths[1], widths[5] = _LOAD_ACCELERATION, _MOTOR_TORQUE * scale
    return parameters, widths, beta


def backstepping_numbers(chain: LumpedChain, gains: BacksteppingGains, interval: float) -> LawNumbers:
    """Freeze the backstepping law of Model 3. ``interval``: sample time [s]."""
    parameters, widths, beta = unmatched_parameters(chain)
    learning = learning_table(
        parameters, parameters - widths, parameters + widths, gains.adaptation * (2.0 * widths) ** 2
    )
    scalars = np.array([interval, 0.0, SMOOTH, 0.0, 0.0, 1.0, beta])
    return LawNumbers(
        kind=BACKSTEPPING, matrix=gains.matrix, rows=np.array([[beta]]), learning=learning, scalars=scalars
    )
