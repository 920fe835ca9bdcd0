r"""A slow sweep of the pretension through the resonance, as in Fig. 5.5: the onset of transverse vibration.

The onset is not the edge of the instability region. From a floor at the edge the amplitude must grow to what
can be seen, and the sweep goes on meanwhile. Without a stated floor the onset is an artefact of where the
sweep began.
"""

from dataclasses import dataclass
from math import asin, log, sqrt

import numpy as np
from scipy.optimize import brentq

from cabledrive.parameters import NotComputed
from cabledrive.parameters.arrays import Array

STEPS_PER_PERIOD, FAR = 64, 1e3  # the sweep is not followed beyond FAR times the level


@dataclass(frozen=True, slots=True, kw_only=True)
class Sweep:
    """A sweep of the transverse detuning while the pulley mode swings with a constant amplitude."""

    pumping: float  # mu, the size of k Q, above Gamma / 2 [rad/s]
    damping: float  # Gamma [1/s]
    rate: float  # of the detuning, upwards [rad/s^2]
    floor: float  # amplitude when the sweep enters the instability region [m]
    level: float  # amplitude that counts as onset [m]
    half_forcing: float  # nu [rad/s]

    @property
    def half_width(self) -> float:
        """Half-width of the instability region [rad/s]."""
        return sqrt(self.pumping**2 - 0.25 * self.damping**2)

    @property
    def entry(self) -> float:
        """Detuning at which the sweep enters the instability region, second order [rad/s]."""
        return -self.half_width - self.pumping**2 / (4 * self.half_forcing)


def onset_by_growth_integral(sweep: Sweep) -> float:
    r"""Detuning at which the amplitude reaches the level, by the growth integral, Eq. (A.34).

    .. math:: \int \Big[S - \tfrac12\Gamma\Big]\frac{\mathrm{d}\delta}{r} - \tfrac12\ln\frac{2S}{\Gamma}
              = \ln\frac{\text{level}}{\text{floor}}, \qquad S = \sqrt{\mu^2 - (\delta + \mu^2/4\nu)^2}

    The logarithm is what the turning of its phase costs the growing motion, the geometric factor of the first
    adiabatic correction. It is left out where the cable is undamped, whose edge is singular.
    """
    mu, half = sweep.pumping, sweep.half_width

    def area(x: float) -> float:
        return 0.5 * (x * sqrt(mu**2 - x**2) + mu**2 * asin(x / mu) - sweep.damping * x)

    def left(x: float) -> float:  # what the logarithm of the amplitude still has to grow by, times the rate
        turned = 0.5 * log(2 * sqrt(mu**2 - x**2) / sweep.damping) if sweep.damping > 0.0 else 0.0
        return sweep.rate * (log(sweep.level / sweep.floor) + turned) + area(-half) - area(x)

    if left(half) > 0.0:
        raise NotComputed(f"the sweep ends before the amplitude reaches {sweep.level:.4g} m")
    return float(brentq(left, -half, half, xtol=1e-12)) - mu**2 / (4 * sweep.half_forcing)


def swept_amplitude(sweep: Sweep) -> tuple[Array, Array]:
    """Amplitude by Hill's equation, Eq. (A.32), from the floor at the edge of the instability region.

    Returns ``detuning`` [rad/s], through the instability region, or until it is far above the level, and
    ``amplitude`` [m], shapes (n,).
    """
    nu, mu, duration = sweep.half_forcing, sweep.pumping, 2 * sweep.half_width / sweep.rate
    steps = int(np.ceil(duration * nu / (2 * np.pi) * STEPS_PER_PERIOD))
    h = duration / steps
    time = h * np.arange(steps)
    across = np.sqrt(nu**2 + 2 * nu * (sweep.entry + sweep.rate * time))
    phase = -0.5 * np.angle((0.5 * sweep.damping - 1j * (sweep.entry + mu**2 / (4 * nu))) / (1j * mu))
    a, b = sweep.floor * float(np.cos(phase)), -sweep.floor * float(np.sin(phase)) * float(across[0])
    # a leapfrog whose stiffness turns by exactly the frequency of each step, also where it is negative
    squared = across**2 + 4 * nu * mu * np.cos(2 * nu * time)
    sharp = 2 * np.sin(0.5 * h * np.sqrt(np.maximum(squared, 0.0))) / h
    turned = np.where(squared > 0.0, sharp**2, squared)
    loss, edges, sizes = 0.5 * h * sweep.damping, [0], [sweep.floor]
    for n, stiff in enumerate(turned.tolist()):
        b = ((1.0 - loss) * b - h * stiff * a) / (1.0 + loss)
        a += h * b
        if (n + 1) % STEPS_PER_PERIOD == 0 or n + 1 == steps:
            edges.append(n + 1)
            sizes.append(float(np.hypot(a, b / across[n])))
            if sizes[-1] > FAR * sweep.level:
                break
    return sweep.entry + sweep.rate * h * np.array(edges), np.array(sizes)


def onset(detuning: Array, amplitude: Array, level: float) -> float:
    """Detuning at which an amplitude first reaches a level, between the samples in its logarithm."""
    above = np.flatnonzero(amplitude >= level)
    if above.size == 0 or above[0] == 0:
        raise NotComputed(f"the amplitude never rises to {level:.4g} m along the sweep")
    around = slice(above[0] - 1, above[0] + 1)
    return float(np.interp(np.log(level), np.log(amplitude[around]), detuning[around]))
