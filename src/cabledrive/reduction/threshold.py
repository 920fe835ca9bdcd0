r"""How much torque it takes: threshold, growth rate and instability region of the internal resonance.

With :math:`\mu = |k_jQ|` and the pulley mode at its forced amplitude :math:`|Q| = |f|/|{-c/2} + i\delta|`, a
vanishing transverse motion grows where

.. math:: \mu^2 > \tfrac14\Gamma^2 + \Big(\delta_j + \frac{\mu^2}{4\nu}\Big)^2, \qquad \text{Eq. (A.22)}

the last term being the third harmonic's share. Without damping of the pulley mode the amplitude grows without
bound at its own frequency, and the threshold is zero.
"""

from dataclasses import dataclass
from itertools import pairwise
from math import log, pi, sqrt

import numpy as np
from numpy.typing import ArrayLike

from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.autoparametric import AutoparametricModel
from cabledrive.reduction.averaging import AveragedCoefficients, averaged_coefficients
from cabledrive.reduction.waves import Waves

_INSTANTS = 2001
_ACROSS = ("pump", "transverse_detuning", "transverse_damping")


def critical_pumping(c: AveragedCoefficients) -> Array:
    r"""Smallest :math:`\mu` [rad/s] at which each transverse mode grows, Eq. (A.22); infinite: at none."""
    nu = 0.5 * c.forcing
    least = 0.25 * c.transverse_damping**2 + c.transverse_detuning**2
    return np.sqrt(with_third_harmonic(least, c.transverse_detuning, nu))


def with_third_harmonic(least: Array, detuning: Array, nu: Array) -> Array:
    r"""Smallest :math:`\mu^2` [1/s^2] of (A.22) from the one without the third harmonic; infinite: none."""
    linear = 1.0 - 0.5 * detuning / nu
    inside = linear**2 - least / (4 * nu**2)
    with np.errstate(invalid="ignore"):
        squared = 2.0 * least / (linear + np.sqrt(inside))
    return np.where((inside >= 0.0) & (linear > 0.0), squared, np.inf)


def threshold_torque(model: AutoparametricModel, forcing: ArrayLike | None = None) -> Array:
    r"""Amplitude of a steady torque above which a vanishing transverse motion grows, Eq. (A.23).

    .. math:: \tau_\mathrm{th} = \min_j \frac{\mu_j}{|k_j|\,|Q|/\tau}

    ``model``: its arrays may end in an axis of lanes; ``forcing``, shape (...): omega [rad/s]; the pulley
    mode's own unless given.
    Returns shape (...) [N m]; zero at the frequency of an undamped pulley mode, infinite where no torque
    makes a mode grow.
    """
    return np.asarray(np.min(mode_thresholds(model, forcing), axis=0))


def mode_thresholds(model: AutoparametricModel, forcing: ArrayLike | None = None) -> Array:
    """Threshold torque of each transverse mode by itself, shape (J, ...) [N m].

    ``forcing``: as of `threshold_torque`. Infinite where no torque makes the mode grow: the torque does not
    move the pulley mode, the pulley mode does not stretch the section, or the pair is too far from 1:2.
    """
    c = averaged_coefficients(model, torque=1.0, forcing=forcing, drift=False)
    per_torque = np.abs(c.force) * np.abs(c.pump)
    resistance = np.abs(-0.5 * c.damping + 1j * c.detuning)
    pumping = np.where(resistance == 0.0, 0.0, critical_pumping(c))
    moved = per_torque > 0.0
    return np.asarray(np.where(moved, pumping * resistance / np.where(moved, per_torque, 1.0), np.inf))


def pulley_amplitude(c: AveragedCoefficients, build_up: float = np.inf) -> Array:
    """Amplitude [m] of the pulley mode under its torque after a time ``build_up`` [s], the spans at rest."""
    rate = -0.5 * c.damping + 1j * c.detuning
    still = np.abs(rate) < 1e-12 * c.forcing
    safe = np.where(still, 1.0, rate)
    if np.isinf(build_up):
        return np.where(still, np.where(c.force == 0.0, 0.0, np.inf), np.abs(c.force / safe))
    grown = np.where(still, build_up, np.expm1(safe * build_up) / safe)
    return np.asarray(np.abs(c.force * grown))


def growth_rates(c: AveragedCoefficients, amplitude: ArrayLike) -> Array:
    r"""Growth rate of each transverse mode while the pulley mode swings with a given amplitude, Eq. (A.24).

    .. math:: \sqrt{\mu^2 - (\delta_j + \mu^2/4\nu)^2} - \tfrac12\Gamma

    ``amplitude``, shape (...): size of Q [m].
    Returns shape (J, ...) [1/s]; minus half of Gamma outside the instability region.
    """
    pumping = np.abs(c.pump) * np.asarray(amplitude, dtype=float)
    shifted = c.transverse_detuning + pumping**2 / (2.0 * c.forcing)
    return np.sqrt(np.maximum(pumping**2 - shifted**2, 0.0)) - 0.5 * c.transverse_damping


def instability_half_width(c: AveragedCoefficients, amplitude: ArrayLike) -> Array:
    r"""Half-width of the instability region in :math:`\delta_j`, :math:`\sqrt{\mu^2 - \Gamma^2/4}` [rad/s].

    ``amplitude``, shape (...): size of Q [m]. Zero below the threshold.
    """
    pumping = np.abs(c.pump) * np.asarray(amplitude, dtype=float)
    return np.sqrt(np.maximum(pumping**2 - 0.25 * c.transverse_damping**2, 0.0))


def required_detuning(model: AutoparametricModel, torque: float) -> float:
    """Detuning [rad/s] at which a torque [N m] cannot make the spans grow; infinite without damping of q."""
    c = averaged_coefficients(model, torque=torque, drift=False)
    return float(np.max(instability_half_width(c, pulley_amplitude(c))))


def growth_torque(model: AutoparametricModel, factor: float, duration: float) -> float:
    r"""Torque, switched on at rest, that multiplies a small transverse motion within a time, Eq. (A.25).

    .. math:: \int_0^T\operatorname{Re}\sqrt{\mu^2 - (\delta_j + \mu^2/4\nu)^2}\,\mathrm{d}t
              - \tfrac12\Gamma T
              = \ln F, \qquad \mu = |k_j f|\,\Big|\frac{e^{\lambda t} - 1}{\lambda}\Big|, \quad
              \lambda = -\tfrac12 c + i\delta

    Without dampings and detunings: :math:`|k_jf|T^2/2 = \ln F`. Of a pluck at rest about 0.7 grows, the rest
    dies out.

    ``factor``: F, above 1; ``duration``: T [s].
    Returns [N m]; infinite where no torque below slack does it.
    Raises `InputRefused` if the factor is not above 1 or the duration not positive.
    """
    if not factor > 1.0:
        raise InputRefused(f"factor = {factor:.6g} must be above 1: 10 for tenfold growth")
    if not duration > 0.0:
        raise InputRefused(f"duration = {duration:.6g} s must be positive")
    c = averaged_coefficients(model, torque=1.0, drift=False)
    time = np.linspace(0.0, duration, _INSTANTS)
    unit = np.array([pulley_amplitude(c, t) for t in time]).reshape(-1)
    wide = c._replace(**{key: getattr(c, key)[:, None] for key in _ACROSS})

    def missing(torque: float) -> float:
        rates = growth_rates(wide, torque * unit)
        return float(np.max(np.trapezoid(rates, time, axis=1))) - log(factor)

    from scipy.optimize import brentq

    trial = np.linspace(0.0, model.slack_amplitude / max(float(unit.max()), 1e-300), 65)
    for low, high in pairwise(trial.tolist()):
        if missing(high) >= 0.0:
            return float(brentq(missing, low, high, xtol=1e-14, rtol=1e-13))
    return float("inf")


def coulomb_onset_torque(model: AutoparametricModel) -> float:
    r"""Torque below which Coulomb friction keeps the pulley mode from growing, Eq. (A.26).

    A friction force of constant size takes :math:`4/\pi` of its amount from a swing's driving force:

    .. math:: \tau_c = \frac{4}{\pi}\,\frac{r_1}{|\phi_\tau|}\sum\frac{c_i|\phi_i|}{r_i}

    It does not hold while the drive turns one way faster than it vibrates: there the friction is constant and
    damps nothing.

    Returns [N m].
    """
    return 4.0 / pi * model.coulomb_force / abs(model.torque_arm)


def pair_threshold(natural: float, across: Array, loss: Array) -> float:
    """Amplitude times coupling above which two modes of decay rates ``loss`` grow, Eq. (A.33) [1/s^2]."""
    (a, b), turning = across.tolist(), float(across.prod())
    if a != b:
        least = lost_square(loss[0], loss[1], natural - a - b)
    else:  # as the averaged equations count it
        detuning, turning = 0.5 * natural - 2.0 * a**2 / natural, 0.25 * natural**2
        least = lost_square(loss[0], loss[1], detuning)
        least = with_third_harmonic(least, np.array(-0.5 * detuning), np.array(0.5 * natural))
    return 4.0 * sqrt(turning) * float(np.sqrt(least))


def lost_square(first: ArrayLike, second: ArrayLike, detuning: ArrayLike) -> Array:
    """Square of the growth rate that two modes with these decay rates lose [1/s^2]."""
    a, b, off = np.asarray(first), np.asarray(second), np.asarray(detuning)
    both = a + b
    damped = a * b * (1.0 + (off / np.where(both > 0.0, both, 1.0)) ** 2)
    return np.where(both > 0.0, damped, 0.25 * off**2)


_AROUND, _MOST_TOGETHER = 0.3, 40
"""Detuning over the frequency up to which modes across are looked at together, and how many."""
_ROUND_OFF = 1e-7
"""Growth rate over the frequency, and share of the largest torque, that counts as none."""


def joint_threshold(waves: Waves, number: int, most: float) -> float:
    r"""Torque of the first motor at one longitudinal frequency from which modes across grow together [N m].

    All longitudinal modes respond, :math:`(W_k^2 - W^2) Q_k + iW\sum_l c_{kl} Q_l = \tau\theta_k`, and all
    modes across take part, averaged:

    .. math:: \dot B_a = \big(i(w_a - W/2) - \Gamma_a/2\big) B_a
              + i\sum_{bk} g_{kab} Q_k \bar B_b / (4\sqrt{w_a w_b}).

    ``number``: of the longitudinal mode; infinite if they do not grow at ``most`` [N m].
    """
    along, omega = (
        2.0 * pi * np.array([one.frequency for one in own]) for own in (waves.along, waves.across)
    )
    natural, losses = along[number], waves.losses[1]
    pumped = np.tensordot(waves.forced(number), waves.couplings, axes=1)
    off = np.abs(natural - omega[:, None] - omega) / natural
    nearest = np.where(np.abs(pumped) > 1e-9 * np.abs(pumped).max(initial=0.0), off, np.inf)
    nearest = nearest.min(axis=1, initial=np.inf)
    own = np.argsort(nearest)[: min(_MOST_TOGETHER, int((nearest <= _AROUND).sum()))]
    turn = np.diag(omega[own] - 0.5 * natural)
    pump = pumped[np.ix_(own, own)] / (4.0 * np.sqrt(np.outer(omega[own], omega[own])))
    still = np.block([[0.0 * turn, -turn], [turn, 0.0 * turn]])
    still -= 0.5 * np.diag(np.tile(losses[own], 2))
    grown = np.block([[-pump.imag, pump.real], [pump.real, pump.imag]])

    def grows(torque: float) -> bool:
        rate = np.linalg.eigvals(still + torque * grown).real.max(initial=-np.inf)
        return bool(rate > _ROUND_OFF * natural)

    if not grows(most):
        return float("inf")
    low, high = 0.0, most
    while high - low > 1e-4 * high and high > _ROUND_OFF * most:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if grows(middle) else (middle, high)
    return high


BUILD_UP = 10.0
"""How long the torque has acted on a pulley mode without damping when the verdict is given [s]."""

CLOSE = 2.0
"""Within so many half-widths of the instability region a drive is close to resonance."""

RESONANT, NEAR, SAFE = "resonant", "close", "safe"


@dataclass(frozen=True, slots=True, kw_only=True)
class InstabilityMargin:
    """Detuning of a drive from the instability region of a torque."""

    verdict: str  # {"resonant", "close", "safe"}
    mode: int  # the transverse mode, of those of the model, that decides
    # distance, half_width: detuning from the middle of the instability region and its half-width [rad/s]
    distance: float
    half_width: float
    growth: float  # growth rate of a vanishing motion [1/s]
    amplitude: float  # pulley mode's amplitude q under the torque [m]
    slack: bool  # whether that amplitude is where a span goes slack


def instability_margin(model: AutoparametricModel, torque: float) -> InstabilityMargin:
    """Relatively nearest instability region of a steady torque [N m], without damping after `BUILD_UP`."""
    c = averaged_coefficients(model, torque=torque, drift=False)
    reached = float(pulley_amplitude(c) if model.modal_damping else pulley_amplitude(c, BUILD_UP))
    amplitude = min(reached, model.slack_amplitude)  # where slack ends it
    distances = np.abs(c.transverse_detuning + (c.pump * amplitude) ** 2 / (2.0 * c.forcing))
    widths = instability_half_width(c, amplitude)
    mode = int(np.argmin(distances / np.maximum(widths, 1e-12 * model.natural)))
    distance, width = float(distances[mode]), float(widths[mode])
    return InstabilityMargin(
        verdict=RESONANT if distance < width else NEAR if distance < CLOSE * width else SAFE,
        mode=mode,
        distance=distance,
        half_width=width,
        growth=float(growth_rates(c, amplitude)[mode]),
        amplitude=float(amplitude),
        slack=bool(reached > model.slack_amplitude),
    )
