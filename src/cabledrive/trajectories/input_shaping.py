r"""Input shapers: impulses that a motion is convolved with, and how far they round the corners of a path.

Definitions of the types are those of Klipper's documentation [1]_, so that a printer moves as computed here.
After [2]_ the motion about its mean delay :math:`\bar t` deviates from the path, at
a reversal under the acceleration a by :math:`\tfrac a2\sum A_i(t_i - \bar t)^2`, at a right angle passed at
the square-corner speed v by
:math:`\sqrt2\sum_{t_i>\bar t} A_i\,(v + \tfrac a2 (t_i - \bar t))(t_i - \bar t)`.

.. [1] Klipper documentation, "Resonance compensation", https://www.klipper3d.org/Resonance_Compensation.html
.. [2] Klipper documentation, "Measuring resonances", https://www.klipper3d.org/Measuring_Resonances.html
"""

from dataclasses import dataclass
from math import exp, pi, sqrt

import numpy as np
from numpy.polynomial.polynomial import polyval, polyval2d

from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.fields import described, meaning

TOLERANCE = 0.05
"""Residual amplitude that EI shapers allow at their humps, relative to the motion without a shaper."""
LARGEST_DAMPING = {"zv": 0.99, "mzv": 0.99, "zvd": 0.99, "ei": 0.4, "2hump_ei": 0.3, "3hump_ei": 0.2}
"""Types of shapers, and the damping ratio up to which the fits of their impulses hold."""
HIGHEST_FREQUENCY = 1e6  # Hz

# Impulses of EI, 2HUMP_EI and 3HUMP_EI for a damped mode have no closed form. These polynomials are fits to
# numerical solutions: W. Singhose, S. Derezinski, N. Singer, "Extra-insensitive input shapers for controlling
# flexible spacecraft", J. Guidance 19(2), 1996; W. Singhose, L. Porter, T. Tuttle, N. Singer, "Vibration
# reduction using multi-hump input shapers", J. Dyn. Sys. Meas. Control 119(2), 1997.
# EI, rows: powers of the damping ratio, columns: powers of the tolerance.
_EI_FIRST = [[0.24968, 0.24961], [0.80008, 1.23328], [0.49599, 3.17316]]
_EI_LAST = [[0.25149, 0.21474], [-0.83249, 1.41498], [0.85181, -4.90094]]
_EI_MIDDLE_TIME = [
    [0.4999, 0.0, 0.0],
    [0.0, 0.46159, 8.57843],
    [0.0, 4.26169, -108.644],
    [0.0, 1.75601, 336.989],
]
# Humps at a tolerance of 5 %, a row for each impulse, columns: powers of the damping ratio.
_TIMES = {
    "2hump_ei": [
        [0.0, 0.0, 0.0, 0.0],
        [0.49890, 0.16270, -0.54262, 6.16180],
        [0.99748, 0.18382, -1.58270, 8.17120],
        [1.49920, -0.09297, -0.28338, 1.85710],
    ],
    "3hump_ei": [
        [0.0, 0.0, 0.0, 0.0],
        [0.49974, 0.23834, 0.44559, 12.4720],
        [0.99849, 0.29808, -2.36460, 23.3990],
        [1.49870, 0.10306, -2.01390, 17.0320],
        [1.99960, -0.28231, 0.61536, 5.40450],
    ],
}
_AMPLITUDES = {
    "2hump_ei": [
        [0.16054, 0.76699, 2.26560, -1.22750],
        [0.33911, 0.45081, -2.58080, 1.73650],
        [0.34089, -0.61533, -0.68765, 0.42261],
        [0.15997, -0.60246, 1.00280, -0.93145],
    ],
    "3hump_ei": [
        [0.11275, 0.76632, 3.29160, -1.44380],
        [0.23698, 0.61164, -2.57850, 4.85220],
        [0.30008, -0.19062, -2.14560, 0.13744],
        [0.23775, -0.73297, 0.46885, -2.08650],
        [0.11244, -0.45439, 0.96382, -1.46000],
    ],
}


@described
@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class InputShaper:
    """A few positive impulses whose sum is 1."""

    type: str = meaning('"zv", "mzv", "zvd", "ei", "2hump_ei" or "3hump_ei"')
    frequency: float = meaning("undamped natural frequency of the mode that it is made for [Hz]")
    damping: float = meaning("damping ratio of that mode")
    times: Array = meaning("(n,): of the impulses [s], from 0")
    amplitudes: Array = meaning("(n,): their sum is 1")

    @property
    def duration(self) -> float:
        """By how much a shaped motion is longer [s]."""
        return float(self.times[-1])

    @property
    def delay(self) -> float:
        """Mean delay of a shaped motion [s]."""
        return float(self.amplitudes @ self.times)


def input_shaper(type: str, frequency: float, damping: float = 0.1) -> InputShaper:
    r"""Make a shaper for a mode.

    With :math:`K = e^{-\zeta\pi/\sqrt{1-\zeta^2}}` and the damped period :math:`T_d`, ZV has impulses 1, K at
    0, :math:`T_d/2`; ZVD has 1, 2K, K^2 at steps of :math:`T_d/2`; MZV has
    :math:`1 - 1/\sqrt 2, (\sqrt 2 - 1)K^{3/4}, (1 - 1/\sqrt 2)K^{3/2}` at steps of :math:`3T_d/8`; EI,
    2HUMP_EI and 3HUMP_EI are fits for a tolerance of 5 %. All are normalised to a sum of 1.

    Parameters
    ----------
    type : {"zv", "mzv", "zvd", "ei", "2hump_ei", "3hump_ei"}
    frequency : float
        Undamped natural frequency of the mode [Hz].
    damping : float, default 0.1
        Damping ratio of the mode; the default is Klipper's.

    Returns
    -------
    InputShaper

    Raises
    ------
    InputRefused
        If there is no such type, the frequency is not from 1e-6 to 1e6 Hz, or the damping is beyond the fit.
    """
    if type not in LARGEST_DAMPING:
        raise InputRefused(f'shaper "{type}" is unknown: choose one of {", ".join(LARGEST_DAMPING)}')
    if not 1.0 / HIGHEST_FREQUENCY <= frequency <= HIGHEST_FREQUENCY:
        raise InputRefused(f"frequency = {frequency:.4g} Hz of a shaper must lie from 1e-6 to 1e6 Hz")
    if not 0.0 <= damping <= LARGEST_DAMPING[type]:
        said = f"damping = {damping:.4g} of a shaper {type} must lie from 0 to {LARGEST_DAMPING[type]:g}"
        raise InputRefused(f"{said}: choose another type, or the damping ratio of the mode (0.1 is 10 %)")
    periods, weights = _impulses(type, damping)
    return InputShaper(
        type=type,
        frequency=frequency,
        damping=damping,
        times=periods / frequency,
        amplitudes=weights / weights.sum(),
    )


def _impulses(type: str, damping: float) -> tuple[Array, Array]:
    """Times in undamped periods of the mode, and amplitudes."""
    if type in _TIMES:
        times = [polyval(damping, row) for row in _TIMES[type]]
        return np.array(times), np.array([polyval(damping, row) for row in _AMPLITUDES[type]])
    root = sqrt(1.0 - damping**2)
    decay = exp(-damping * pi / root)  # K, of half a damped period
    if type == "zv":
        steps, weights = [0.0, 0.5], [1.0, decay]
    elif type == "zvd":
        steps, weights = [0.0, 0.5, 1.0], [1.0, 2.0 * decay, decay**2]
    elif type == "mzv":
        end = 1.0 - sqrt(0.5)
        steps, weights = [0.0, 0.375, 0.75], [end, (sqrt(2.0) - 1.0) * decay**0.75, end * decay**1.5]
    else:
        first, last = (float(polyval2d(damping, TOLERANCE, c)) for c in (_EI_FIRST, _EI_LAST))
        middle = float(polyval2d(damping, TOLERANCE, _EI_MIDDLE_TIME))
        steps, weights = [0.0, middle, 1.0], [first, 1.0 - first - last, last]
    return np.array(steps) / root, np.array(weights)


def residual_vibration(shaper: InputShaper, frequency: Array, damping: Array | float) -> Array:
    r"""Amplitude that a mode keeps after the last impulse, over that after one impulse of size 1.

    .. math:: V = \Big|\sum_i A_i\,e^{-\zeta\omega(t_n - t_i)}\,e^{j\omega\sqrt{1-\zeta^2}\,t_i}\Big|

    Parameters
    ----------
    shaper : InputShaper
    frequency : ndarray
        Undamped natural frequencies of the mode [Hz].
    damping : ndarray or float
        Its damping ratios, below 1; broadcast against ``frequency``.

    Returns
    -------
    ndarray
        Of the broadcast shape; 0 at rest, 1 as without a shaper.
    """
    omega, zeta = np.broadcast_arrays(2.0 * np.pi * np.asarray(frequency, dtype=float), damping)
    pole = omega * (zeta + 1j * np.sqrt(1.0 - zeta**2))
    decay = np.exp(pole[..., None] * shaper.times - (zeta * omega)[..., None] * shaper.duration)
    return np.asarray(np.abs(decay @ shaper.amplitudes), dtype=float)


def insensitive_band(shaper: InputShaper) -> tuple[float, float] | None:
    """Frequencies around the design between which 5 % are left of its mode [Hz]; None: nowhere near it."""
    ratio = np.linspace(0.3, 2.0, 6801)  # steps of 0.00025 of the frequency of the design
    slack = 0.005 if "ei" in shaper.type else 0.0  # the humps of the fits exceed 5 % by about so much
    held = residual_vibration(shaper, ratio * shaper.frequency, shaper.damping) <= TOLERANCE + slack
    near = np.flatnonzero(held & (np.abs(ratio - 1.0) < 0.1))
    if near.size == 0:
        return None
    centre = int(near[np.argmin(np.abs(ratio[near] - 1.0))])
    gaps = np.flatnonzero(~held)
    low = int(gaps[gaps < centre].max(initial=-1)) + 1
    high = int(gaps[gaps > centre].min(initial=ratio.size)) - 1
    return float(ratio[low] * shaper.frequency), float(ratio[high] * shaper.frequency)


ACCELERATION = 5.0
"""At which smoothing is stated [m/s^2]."""
CORNER_SPEED = 0.005
"""Square-corner speed, where none is given [m/s]."""
LARGEST_SMOOTHING = 0.12e-3
"""Smoothing up to which the highest acceleration is recommended [m]."""


def smoothing(
    shaper: InputShaper, acceleration: float = ACCELERATION, corner_speed: float = CORNER_SPEED
) -> float:
    """Largest deviation from the path that a shaper causes at a corner.

    Parameters
    ----------
    shaper : InputShaper
    acceleration : float, default 5.0
        Of the motion [m/s^2].
    corner_speed : float, default 0.005
        At which a right angle is passed [m/s].

    Returns
    -------
    float
        Deviation [m].
    """
    first, later, second = _moments(shaper)
    square = sqrt(2.0) * (corner_speed * first + 0.5 * acceleration * later)
    return max(square, 0.5 * acceleration * second)


def highest_acceleration(shaper: InputShaper, corner_speed: float = CORNER_SPEED) -> float:
    """Largest acceleration whose smoothing stays within 0.12 mm; both deviations are linear in it.

    Parameters
    ----------
    shaper : InputShaper
    corner_speed : float, default 0.005
        At which a right angle is passed [m/s].

    Returns
    -------
    float
        Acceleration [m/s^2]; 0 where the corner speed alone takes more than the bound.
    """
    first, later, second = _moments(shaper)
    square = 2.0 * (LARGEST_SMOOTHING / sqrt(2.0) - corner_speed * first) / later
    return max(0.0, min(square, 2.0 * LARGEST_SMOOTHING / second))


def _moments(shaper: InputShaper) -> tuple[float, float, float]:
    """About the mean delay: first [s] and second [s^2] of the later impulses, second of all."""
    distance = shaper.times - shaper.delay
    later = distance > 0.0
    weighted = shaper.amplitudes * distance
    return (
        float(np.sum(weighted[later])),
        float(np.sum((weighted * distance)[later])),
        float(weighted @ distance),
    )
