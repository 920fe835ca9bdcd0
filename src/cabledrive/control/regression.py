r"""Learning from runs: least squares on filtered encoder readings, and a torque between repetitions.

The load's own equation is

.. math:: \ddot\theta_N = \beta(\theta_{N-1} - \theta_N) + \gamma(\dot\theta_{N-1} - \dot\theta_N)
    - \kappa\,\mathrm{sgn}\,\dot\theta_N - \nu\dot\theta_N + c,
    \qquad \beta = \frac{k}{J_N},\ \gamma = \frac{b}{J_N},\ \kappa = \frac{c_N}{J_N},\ \nu = \frac{b_N}{J_N}

with every signal through :math:`1/(1 + s/\omega)^3`; the constant c takes what unknown encoder zeros add.
Without its friction terms the equation makes friction of the load a softer cable. Samples at which the load
is slow (a count then lasts long, and a loop that follows its encoder makes the same rounding error in every
run) or has just turned are left out. A residual larger than rounding to counts leaves: nothing is learnt.

In the sum of all momenta every joint's torque cancels,

.. math::
    \frac{\sum_i J_i\ddot\theta_i}{\sum_i J_i}\,J
    = \tau - b\,\dot\theta_1 - c\,\mathrm{sgn}\,\dot\theta_1 + d .

How the whole inertia J divides among the shafts is taken as believed. Slow samples, and 0.08 s after, are
left out: near standstill the motor sticks or its law turns it to and fro.

Between repetitions, with P from added torque to the load's error in the closed loop, :math:`P = U\Sigma V^T`,
the torque is :math:`w = V_ra` in the first r directions and

.. math:: a_{j+1} = \Pi\big(a_j - g\,\Sigma_r^{-1}U_r^Te_j\big), \qquad e_j = P_{true}V_ra_j + d

with d what repeats and :math:`\Pi` the projection on a ball: a contraction by :math:`\gamma = \lVert I -
g\,\Sigma_r^{-1}U_r^TP_{true}V_r\rVert_2` wherever that is below 1, so that the torque converges to one fixed
point by :math:`\gamma` a repetition (Banach). That lies within the first correction over :math:`1 - \gamma`,
the radius of the ball. r is the most directions with which :math:`\gamma` keeps a limit on every plant that
is looked at, and rounding to counts another.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import exp, pi

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import toeplitz

from cabledrive.control.bound import lag_of_held
from cabledrive.identification.signals import lagged, zero_phase
from cabledrive.parameters.arrays import Array

REPLICATES, SMOOTHING_HZ = 20, 20.0
SUMS = 4000
"""Sums of a normal and a bounded error of which the 95 % interval is taken."""
IN_THE_LOOP = 1.1
"""Rounding that a loop reacts to spreads wider than rounding drawn anew: over 1,000 draws of a pulse at 23
and 35 Hz, set apart for this, estimates spread 1.05 to 1.15 times as far as the replicates say."""


def filtered(signal: Array, interval: float, hertz: float) -> Array:
    r"""A signal and two derivatives through :math:`1/(1 + s/\omega)^3`, from rest, (3, ..., samples)."""
    time = 1.0 / (2.0 * pi * hertz)
    one = lagged(signal, time, interval)
    two = lagged(one, time, interval)
    three = lagged(two, time, interval)
    return np.array([three, (two - three) / time, (one - 2.0 * two + three) / time**2])


def least_squares(regressors: Array, target: Array, used: NDArray[np.bool_]) -> Array:
    """Coefficients of the regressors, (p,), from samples used; all NaN where they do not span p."""
    x, y = regressors[used], target[used]
    scale = np.abs(x).max(axis=0) if len(x) else np.zeros(regressors.shape[1])
    if np.any(scale == 0.0):
        return np.full(regressors.shape[1], np.nan)
    solution, _, rank, _ = np.linalg.lstsq(x / scale, y, rcond=1e-9)
    return np.asarray(solution / scale) if rank == len(scale) else np.full(len(scale), np.nan)


def smoothed(readings: Array, interval: float) -> Array:
    """Readings through a second-order Butterworth filter forwards and backwards: no lag."""
    return np.asarray(zero_phase(readings, interval, SMOOTHING_HZ, order=2))


def rounding_replicates(
    readings: Array, counts: Array, interval: float, generator: np.random.Generator
) -> list[Array]:
    """The smoothed motion rounded to counts again, each time with other phases."""
    motion = smoothed(readings, interval)
    phases = [generator.uniform(-0.5, 0.5, len(counts)) for _ in range(REPLICATES)]
    return [counts * (np.rint(motion / counts + one) - np.rint(one)) for one in phases]


def rounding_spread(found: Array) -> Array:
    """Standard errors, (p,), of an estimate from those of the replicates, (replicates, p)."""
    return np.asarray(IN_THE_LOOP * np.std(found, axis=0, ddof=1))


def interval_factor() -> float:
    """Half width of an interval of 95 % in standard errors, as few replicates ask for: 2.09."""
    from scipy.stats import t

    return float(t.ppf(0.975, REPLICATES - 1))


FILTER_HZ, THINNING, SLOW_SHARE = 10.0, 10, 0.25
SIGN_WIDTH, SETTLED = 0.01, 0.995
"""Share of the largest speed over which the sign turns, and of itself that its filtered value must reach."""
OF_LOAD, MOVING = [0, 1, 3, 4], [0, 1, 4]
"""Beta, gamma, Coulomb and viscous friction among the coefficients, of which the third is a constant; those
that motions alone have."""
MOST_MISFIT = 2.0
"""Residual over that of rounding alone above which the equation is not believed."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Estimates:
    """Coefficients of an equation, shape (p,), NaN where the motion does not show them."""

    values: Array
    errors: Array  # (p,): standard errors by the encoders' counts
    misfit: float = 1.0  # residual over the one that rounding to counts leaves

    @property
    def intervals(self) -> Array:
        """95 % intervals, shape (2, p)."""
        half = interval_factor() * self.errors
        return np.array([self.values - half, self.values + half])

    @property
    def believed(self) -> bool:
        """Whether the residual is what rounding to counts leaves."""
        return bool(self.misfit <= MOST_MISFIT)

    def known(self, share: float, *places: int) -> bool:
        """Whether coefficients are positive and their intervals narrower than a share of them."""
        value, half = self.values[list(places)], interval_factor() * self.errors[list(places)]
        return bool(np.all((value > 0.0) & (half < share * value)))


def estimate_load(
    readings: Array, counts: Array, interval: float, generator: np.random.Generator
) -> Estimates:
    """Beta [1/s^2], gamma [1/s], Coulomb [rad/s^2] and viscous friction [1/s] of the filtered load equation.

    ``readings``, (samples, 2): angles of the inertia before the load and of the load [rad].
    """
    motion, sign = smoothed(readings, interval), turning_sign(readings[:, 1], interval)

    def solved(angles: Array) -> Array:
        return least_squares(*_regression(angles, interval, sign))

    regressors, target, used = _regression(readings, interval, sign)
    values = least_squares(regressors, target, used)
    if not np.all(np.isfinite(values)):
        return Estimates(values=np.full(4, np.nan), errors=np.full(4, np.inf), misfit=np.inf)
    replicates = rounding_replicates(readings, counts, interval, generator)
    errors = np.nan_to_num(rounding_spread(np.array([solved(one) for one in replicates])), nan=np.inf)
    # A loop that follows its own encoder leads it through the same counts at the same times in every run, so
    # that the rounding error goes with the motion and no number of draws averages it away. Rounded where the
    # encoders stand (their readings are whole counts), the smoothed motion makes nearly the same error.
    unbiased = values - (solved(counts * np.rint(motion / counts)) - solved(motion))
    size = float(np.sqrt(np.mean((target - regressors @ values)[used] ** 2)))
    rounding = []  # residuals of the errors alone, without a constant [rad/s^2]
    for one in replicates:
        moved, accelerated, _ = _regression(one - motion, interval, sign)
        residual = accelerated - moved[:, MOVING] @ values[MOVING]
        rounding.append(np.mean((residual - np.mean(residual[used]))[used] ** 2))
    return Estimates(
        values=unbiased[OF_LOAD],
        errors=errors[OF_LOAD],
        misfit=size / max(float(np.sqrt(np.mean(rounding))), 1e-300),
    )


def turning_sign(load: Array, interval: float) -> Array:
    """Sign of the load's smoothed speed, turning over a hundredth of the largest; zero: it does not move."""
    speed = np.gradient(smoothed(load[:, None], interval)[:, 0], interval)
    largest = np.abs(speed).max()
    return np.zeros(len(speed)) if largest == 0.0 else np.tanh(speed / (SIGN_WIDTH * largest))


def _regression(readings: Array, interval: float, sign: Array) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Regressors, accelerations of the load, and the samples that are used."""
    near, load = np.ascontiguousarray(readings.T)
    twist = filtered(near - load, interval, FILTER_HZ)[:, ::THINNING]
    own = filtered(load, interval, FILTER_HZ)[:, ::THINNING]
    turned = filtered(sign, interval, FILTER_HZ)[0, ::THINNING]
    speed = np.abs(own[1])
    regressors = np.column_stack((twist[0], twist[1], np.ones(len(speed)), -turned, -own[1]))
    used = (speed > SLOW_SHARE * speed.max()) & (np.abs(turned) > SETTLED)
    return regressors, own[2], used


SUM_FILTER_HZ, SUM_THINNING = 20.0, 5
SUM_SLOW_SHARE, AFTER = 0.2, 0.08


def estimate_motor(
    readings: Array,
    torque: Array,
    counts: Array,
    inertias: Array,
    interval: float,
    generator: np.random.Generator,
) -> Estimates:
    """Whole inertia, viscous and Coulomb friction and offset torque by the filtered sum of momenta, SI.

    ``readings``, (samples, n): of every inertia [rad]; ``torque``, (samples,): see `acting_torque` [N m];
    ``inertias``, (2, n): as believed [kg m^2], and the relative half widths within which they are.
    """
    believed, widths = inertias

    values = motor_coefficients(readings, torque, believed, interval)
    if not np.all(np.isfinite(values)):
        return Estimates(values=np.full(4, np.nan), errors=np.full(4, np.inf))

    replicates = rounding_replicates(readings, counts, interval, generator)
    rounded = [motor_coefficients(one, torque, believed, interval) for one in replicates]
    errors = rounding_spread(np.array(rounded))
    bounds = believed * (1.0 + np.diag(widths))
    effects = np.array([motor_coefficients(readings, torque, one, interval) - values for one in bounds])
    # What lies evenly within bounds has no tails: taken for normal it makes intervals too wide. The 95 %
    # interval is that of the sum, and the error the one of which `interval_factor` gives it.
    noise = generator.standard_t(REPLICATES - 1, (SUMS, 1)) * errors
    evenly = generator.uniform(-1.0, 1.0, (SUMS, len(effects))) @ effects
    errors = np.quantile(np.abs(noise + evenly), 0.95, axis=0) / interval_factor()
    return Estimates(values=values, errors=np.nan_to_num(errors, nan=np.inf))


def motor_coefficients(readings: Array, torque: Array, inertias: Array, interval: float) -> Array:
    """Whole inertia, viscous and Coulomb friction, offset torque by least squares, signs as above."""
    mean = filtered(readings @ (inertias / inertias.sum()), interval, SUM_FILTER_HZ)
    speed = filtered(np.ascontiguousarray(readings[:, 0]), interval, SUM_FILTER_HZ)[1]
    at_samples = 0.5 * (np.concatenate((torque[:1], torque[:-1])) + torque)  # of before and after each
    acting = filtered(at_samples, interval, SUM_FILTER_HZ)[0]
    slow = np.abs(speed) < SUM_SLOW_SHARE * np.abs(speed).max()
    lately = round(AFTER / interval)
    so_far = np.concatenate((np.zeros(lately + 1), np.cumsum(slow)))
    after = so_far[lately + 1 :] > so_far[: len(slow)]
    ones = np.ones(len(speed))
    regressors = np.column_stack((mean[2], speed, np.sign(speed), -ones))
    thin = slice(None, None, SUM_THINNING)
    return least_squares(regressors[thin], acting[thin], ~after[thin])


def acting_torque(command: Array, interval: float, *, delay: float = 0.0, current_rate: float = 0.0) -> Array:
    """Mean torque [N m] between samples of commands behind a delay [s] and a loop [rad/s], 0: none."""
    whole, part = int(delay // interval), delay % interval / interval
    padded = np.concatenate((np.zeros(whole + 1), command))
    wanted = part * padded[: len(command)] + (1.0 - part) * padded[1 : len(command) + 1]
    if current_rate == 0.0:
        return wanted
    fading = exp(-current_rate * interval)
    before = lag_of_held(wanted, fading)[:-1]
    return np.asarray(wanted + (before - wanted) * (1.0 - fading) / (current_rate * interval))


GAIN = 0.7
"""Share of the error that a repetition takes away in the nominal loop."""
MOST_CONTRACTION = 0.8
"""Of the worst plant that is looked at."""
SIGMAS = 5.0
"""Deviations of the command by rounding that keep its limit."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RepetitionLearning:
    """What is learnt between repetitions, in directions of the torque."""

    directions: Array  # (k, r): torque at the nodes of each direction, of length 1
    correction: Array  # (r, k): from mean errors between the nodes [rad] to directions [N m]
    contraction: float  # largest over the plants that were looked at

    def radius(self, error: Array) -> float:
        """Of the ball that holds the fixed point, by the first error, shape (k,) [rad]; [N m]."""
        return float(np.linalg.norm(self.correction @ error)) / (1.0 - self.contraction)

    def corrected(self, place: Array, error: Array, radius: float) -> Array:
        """Directions after a repetition [N m]; ``place``, shape (r,); ``error``, shape (k,) [rad]."""
        found = place - self.correction @ error
        size = float(np.linalg.norm(found))
        return found if size <= radius else found * (radius / size)


def lifted(impulse: Array, nodes: int, width: int) -> Array:
    """Mean errors between nodes from torques there, (nodes, nodes), by the load's impulse response."""
    hat = 1.0 - np.abs(np.arange(1 - width, width)) / width
    smooth = np.convolve(impulse, hat)[: nodes * width]
    smooth = np.pad(smooth, (0, nodes * width - len(smooth)))
    # A node's hat begins a width before it: the first mean holds its rising half alone.
    column = smooth.reshape(nodes, width).mean(axis=1)
    return np.asarray(toeplitz(column, np.zeros(nodes)))


def repetition_learning(
    nominal: Array, others: Sequence[Array], command: Array, noise: float, ripple: float
) -> RepetitionLearning | None:
    """The most directions that keep both limits, contraction on every plant; none: not one direction does.

    All plants (k, k) from `lifted`; ``noise``: of a mean error by rounding [rad]; ``ripple``: of the command
    within five deviations of it [N m].
    """
    u, sizes, v = np.linalg.svd(nominal)
    steps = [GAIN / sizes[:, None] * (u.T @ plant @ v.T) for plant in (nominal, *others)]

    def contraction(r: int) -> float:
        return max(float(np.linalg.norm(np.eye(r) - step[:r, :r], 2)) for step in steps)

    made = np.sum((command @ v.T) ** 2, axis=0) * (GAIN * noise / np.maximum(sizes, 1e-300)) ** 2
    by_rounding = SIGMAS * np.sqrt(np.cumsum(made) / len(sizes))
    low, high = 0, int(np.count_nonzero(by_rounding <= ripple)) + 1
    while high - low > 1:  # the norm of a leading block grows with its size
        middle = (low + high) // 2
        low, high = (middle, high) if contraction(middle) <= MOST_CONTRACTION else (low, middle)
    if low == 0:
        return None
    return RepetitionLearning(
        directions=v[:low].T, correction=GAIN / sizes[:low, None] * u[:, :low].T, contraction=contraction(low)
    )


def torque_along(nodes: Array, width: int, samples: int) -> Array:
    """Torque of every sample, straight lines between nodes [N m], shape (samples,)."""
    places = width * np.arange(len(nodes) + 1.0) - 1.0
    return np.asarray(np.interp(np.arange(samples), places, np.append(0.0, nodes), right=0.0))
