"""Gains that the package chooses for the damping-aware law, with the reasons."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from math import pi

import numpy as np

from cabledrive.control.darc import darc_numbers
from cabledrive.control.darc_gains import darc_gains, printed_bounds
from cabledrive.control.flat_output import flat_output
from cabledrive.control.kalman import KalmanTuning, Sampling, kalman_filter
from cabledrive.parameters import InputRefused
from cabledrive.reduction.lumped_chain import LumpedChain, natural_frequencies_of
from cabledrive.reduction.models import FLEXIBLE_JOINT, highest_model
from cabledrive.rig.circumstances import current_rate, torque_limit
from cabledrive.rig.closed_loop.linear_loop import assembled
from cabledrive.rig.closed_loop.loop_numbers import Array
from cabledrive.rig.closed_loop.plant import plant_numbers
from cabledrive.rig.draws import Spreads
from cabledrive.rig.laws.controllers import Controller, Wish, chain_law, own_filter
from cabledrive.rig.laws.fitting import fitted_encoders, law_shafts, place

TORQUE_SHARE, SIGMAS = 1.0 / 3.0, 5.0
SAMPLES_PER_PERIOD = 20.0
LOWEST_HZ, HIGHEST_HZ = 5, 120
MEMORY = 0.4


@dataclass(frozen=True, slots=True, kw_only=True)
class BestGains:
    """Bandwidth and filter, and why.

    Attributes
    ----------
    bandwidth : float
        lambda/(2 pi) [Hz].
    tuning : KalmanTuning
    torque_noise : float
        Five standard deviations of the command by rounding [N m].
    reasons : tuple of str
    """

    bandwidth: float
    tuning: KalmanTuning
    torque_noise: float
    reasons: tuple[str, ...]


def damped_law(wish: Wish, name: str, number: int = 4) -> Controller:
    """The damping-aware law at its model's printed gains or the best; its filter by what is not known.

    Parameters
    ----------
    wish : Wish
    name : str
    number : {3, 4}, default 4
        Model that it is made for.

    Returns
    -------
    Controller
    """
    if wish.best and wish.bandwidth is None:
        return best_chain_law(wish, name, number)
    counts = np.array(list(read_encoders(wish, number).values()))
    tuning = tuning_by_uncertainty(wish, filter_chain(wish, number), counts)
    return chain_law(wish, number, name, damped=True, tuning=tuning)


def filter_chain(wish: Wish, number: int) -> LumpedChain:
    """The row that the Kalman filter of a law is made for.

    Parameters
    ----------
    wish : Wish
    number : {1, 2, 3, 4}
        Model of the law.

    Returns
    -------
    LumpedChain
    """
    return wish.model(own_filter(number, wish.feedback) or highest_model(wish.drive))


def read_encoders(wish: Wish, number: int) -> dict[str, float]:
    """One count of each encoder that the filter of a law reads, at the first shaft [rad], by shaft.

    Parameters
    ----------
    wish : Wish
    number : {3, 4}

    Returns
    -------
    dict
    """
    fitted, shafts = fitted_encoders(wish.drive), law_shafts(number, wish.feedback)
    if own_filter(number, wish.feedback) is None:
        return fitted
    return {shaft: count for shaft, count in fitted.items() if shaft in shafts}


def best_chain_law(wish: Wish, name: str, number: int = 4) -> Controller:
    """The damping-aware law of a model with the gains and the filter that the package chooses.

    Parameters
    ----------
    wish : Wish
        A bandwidth that it asks for is kept, and the filter chosen for it.
    name : str
    number : {3, 4}, default 4

    Returns
    -------
    Controller
    """
    chosen = best_gains(wish, number)
    same = replace(wish, bandwidth=chosen.bandwidth)
    made = chain_law(same, number, name, damped=True, tuning=chosen.tuning)
    return replace(made, gains=made.gains | {"reasons": list(chosen.reasons)})


@lru_cache(maxsize=16)
def best_gains(wish: Wish, number: int = 4) -> BestGains:
    """Highest bandwidth whose noise leaves most of the torque, and a filter by what is not known.

    Parameters
    ----------
    wish : Wish
    number : {3, 4}, default 4
        Model of the law.

    Returns
    -------
    BestGains

    Raises
    ------
    InputRefused
        If the drive names no torque limit, or rounding alone takes a third of it at any bandwidth.
    """
    limit = torque_limit(wish.drive)
    if not np.isfinite(limit):
        raise InputRefused("motor.torque_limit is missing, the best gains are weighed by it: add it, in N m")
    chain, counts = wish.model(number), np.array(list(read_encoders(wish, number).values()))
    tuning = tuning_by_uncertainty(wish, chain, counts)
    sampled = int(1.0 / (SAMPLES_PER_PERIOD * wish.interval))
    top = min(HIGHEST_HZ, sampled)

    def noise(hertz: float) -> float:
        return torque_noise(wish, chain, hertz, tuning, number)

    if wish.bandwidth is not None:
        hertz = wish.bandwidth
    else:
        hertz = highest(noise, TORQUE_SHARE * limit, top)
    found = noise(hertz)
    return BestGains(
        bandwidth=float(hertz),
        tuning=tuning,
        torque_noise=found,
        reasons=_reasons(chain, hertz, tuning, found, limit, sampled, asked=wish.bandwidth is not None),
    )


def highest(noise: Callable[[float], float], allowed: float, top: int) -> float:
    """Highest whole bandwidth whose noise is allowed, by bisection: noise rises with the bandwidth.

    Parameters
    ----------
    noise : callable
    allowed : float
        [N m].
    top : int
        [Hz].

    Returns
    -------
    float

    Raises
    ------
    InputRefused
        If not even the lowest one is quiet enough.
    """
    low, high = LOWEST_HZ, top + 1
    if noise(low) > allowed:
        raise InputRefused(
            f"rounding moves the torque by {noise(low):.3g} N m at {low} Hz, above {allowed:.3g} N m: fit "
            "finer encoders, or give --bandwidth"
        )
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if noise(middle) <= allowed else (low, middle)
    return float(low)


def tuning_by_uncertainty(wish: Wish, chain: LumpedChain, counts: Array) -> KalmanTuning:
    """Noise of the filter from what is not known of the drive.

    The load's equation is off by the spreads of stiffness and inertia times the largest acceleration wanted,
    for a sixteenth of the rise; friction by the Coulomb torque, within a second as a walk and within a
    millisecond as noise; each encoder's zero by half a count, walking that far within some seconds.

    Parameters
    ----------
    wish : Wish
    chain : LumpedChain
    counts : ndarray, shape (m,)
        [rad].

    Returns
    -------
    KalmanTuning
    """
    spreads = Spreads()
    wanted = wish.wanted(2)
    moving = np.abs(wanted[1]) > 0.0
    rise = float(np.count_nonzero(moving)) * wish.interval / max(1, _moves(moving))
    off = (spreads.cable_stiffness + spreads.load_inertia) * float(np.abs(wanted[2]).max())
    coulomb = chain.coulomb[0]
    return KalmanTuning(
        torque=1e-3 * coulomb**2,
        disturbance=coulomb**2,
        load_acceleration=off**2 * rise / 16.0,
        offsets=tuple(float(count) ** 2 / 6.0 for count in counts[:-1]),
    )


def _moves(moving: Array) -> int:
    """How many times a motion sets out."""
    return int(np.count_nonzero(np.diff(moving.astype(int)) > 0)) + int(moving[0])


def torque_noise(
    wish: Wish, chain: LumpedChain, hertz: float, tuning: KalmanTuning, number: int = 4
) -> float:
    """Five standard deviations of the command by rounding, at a bandwidth.

    Parameters
    ----------
    wish : Wish
    chain : LumpedChain
    hertz : float
    tuning : KalmanTuning
    number : {3, 4}, default 4

    Returns
    -------
    float
        [N m].
    """
    interval, rate = wish.interval, current_rate(wish.drive)
    fitted = read_encoders(wish, number)
    encoders = np.array([place(chain, shaft) for shaft in fitted], dtype=np.int64)
    counts = np.array(list(fitted.values()))
    sampling = Sampling(interval=interval, current_rate=rate)
    chosen = range(chain.size)
    seen = kalman_filter(
        chain, list(encoders), list(counts), sampling, chosen=chosen, tuning=tuning, settled=True
    )
    flat, bounds = flat_output(chain), printed_bounds(chain, flexible_joint=FLEXIBLE_JOINT[number])
    row = np.zeros((1, 2 * chain.size + 3))
    law = darc_numbers(flat, darc_gains(number, hertz), bounds, row, interval, desired=True)
    loop = assembled(plant_numbers(chain, interval, current_rate=rate), seen, law, encoders)
    return SIGMAS * loop.noise(counts, round(MEMORY / interval))[1]


def _reasons(
    chain: LumpedChain,
    hertz: float,
    tuning: KalmanTuning,
    noise: float,
    limit: float,
    sampled: int,
    *,
    asked: bool,
) -> tuple[str, ...]:
    modes = ", ".join(f"{w / (2.0 * pi):.1f}" for w in natural_frequencies_of(chain) if w > 1.0)
    why = (
        "asked for"
        if asked
        else "the highest at which rounding to counts takes a third of the torque limit at five deviations"
    )
    return (
        f"bandwidth {hertz:.0f} Hz: {why} ({noise:.2f} of {limit:.2f} N m)",
        f"sample rate: allows {sampled} Hz, {SAMPLES_PER_PERIOD:.0f} samples in a period",
        f"modes at {modes} Hz: their poles are placed, not avoided, so that they set no limit",
        "uncertain cable and load: noise of the load's acceleration in the filter "
        f"{tuning.load_acceleration:.2g} (rad/s^2)^2 s",
        f"friction: disturbance walks by {tuning.disturbance:.2g} (N m)^2 in a second",
        "encoder zeros unknown: offsets walk by "
        + " and ".join(f"{value:.1g}" for value in tuning.offsets)
        + " rad^2 in a second",
    )
