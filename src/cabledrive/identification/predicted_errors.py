r"""Standard errors of inverse dynamics before a test is run, from the noise of its instruments.

The motion is that of guessed parameters under the planned torque. The regression of inverse dynamics then
has known regressors, and its residual is the noise of the torque measurement and of the encoder,

.. math::

    S_e(f) = S_\tau + \big|J (2\pi f)^2 + 2\pi i f\,b\big|^2 S_\theta, \qquad
    C = (\Phi^T\Phi)^{-1} \Big(\sum_k \hat\phi_k^* \hat\phi_k^T |H_f|^2 S_e(f_k)\Big) (\Phi^T\Phi)^{-1},

white both, an encoder's rounding with a twelfth of its step squared.
"""

from dataclasses import dataclass
from math import pi

import numpy as np
from numpy.typing import NDArray

from cabledrive.identification.axis_equation import AxisEquation, filtered
from cabledrive.identification.filters import butterworth, difference
from cabledrive.parameters import InputRefused

Array = NDArray[np.float64]

NAMES = ("inertia", "viscous_friction", "coulomb_friction", "offset_torque")


@dataclass(frozen=True, slots=True, kw_only=True)
class AxisGuess:
    """What is thought of an axis before it is tested.

    Attributes
    ----------
    inertia, viscous, coulomb, offset : float
        [kg m^2, N m s/rad, N m, N m], or of a slide [kg, N s/m, N, N].
    """

    inertia: float
    viscous: float
    coulomb: float
    offset: float = 0.0

    def __post_init__(self) -> None:
        if not (self.inertia > 0.0 and self.viscous >= 0.0 and self.coulomb >= 0.0):
            raise InputRefused(
                f"guess of inertia {self.inertia:g}, viscous {self.viscous:g} and Coulomb friction "
                f"{self.coulomb:g}: the first must be positive, the others not negative"
            )


@dataclass(frozen=True, slots=True, kw_only=True)
class Instruments:
    """Noise of the test's instruments.

    Attributes
    ----------
    torque_noise : float
        Standard deviation of one sample of the torque [N m].
    quantum : float
        Step of the encoder [rad]; 0: none.
    bandwidth : float
        Of the filter on both sides of the regression [Hz].
    """

    torque_noise: float = 0.006
    quantum: float = 2 * pi / 2600
    bandwidth: float = 20.0


def predicted_errors(
    speed: Array, interval: float, guess: AxisGuess, instruments: Instruments
) -> dict[str, float]:
    """Standard error of each parameter of an axis that moves with a known speed.

    ``speed``, shape (samples,) [rad/s]; ``interval`` [s].
    Returns by the names of `NAMES`, in their units.
    """
    equation = AxisEquation(linear=False, bandwidth=min(instruments.bandwidth, 0.2 / interval))
    columns = [difference(speed, interval), speed, np.sign(speed)]
    smooth = [filtered(column, equation, interval) for column in columns]
    edge = int(np.ceil(2.0 / (equation.bandwidth * interval)))
    regressors = np.column_stack([*smooth, -np.ones(speed.size)])[edge:-edge]
    sizes = np.linalg.norm(regressors, axis=0)
    q, r = np.linalg.qr(regressors / sizes)
    frequency = np.asarray(np.fft.rfftfreq(len(q), interval), dtype=float)
    noise = _residual_spectrum(frequency, interval, guess, instruments) * _gain(frequency, interval, equation)
    spectrum = np.fft.rfft(q, axis=0)
    both = np.where((frequency == 0.0) | (2 * np.arange(frequency.size) == len(q)), 1.0, 2.0)
    weights = both * noise / len(q)
    middle = np.real(np.einsum("ki,k,kj->ij", spectrum.conj(), weights, spectrum))
    inverse = np.linalg.inv(r)
    covariance = inverse @ middle @ inverse.T
    errors = np.sqrt(np.diag(covariance)) / sizes
    return {name: float(error) for name, error in zip(NAMES, errors, strict=True)}


def _residual_spectrum(
    frequency: Array, interval: float, guess: AxisGuess, instruments: Instruments
) -> Array:
    """Variance of the residual's noise per sample, over frequency [(N m)^2]."""
    omega = 2 * pi * frequency
    from_angle = np.abs(-guess.inertia * omega**2 + 1j * omega * guess.viscous) ** 2
    return instruments.torque_noise**2 + from_angle * instruments.quantum**2 / 12.0


def _gain(frequency: Array, interval: float, equation: AxisEquation) -> Array:
    """Power gain of the filter without phase."""
    from scipy import signal

    _, response = signal.sosfreqz(butterworth(interval, equation.bandwidth), 2 * pi * frequency * interval)
    return np.asarray(np.abs(response) ** 4)
