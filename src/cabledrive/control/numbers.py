"""Frozen numbers of a law and an observer, and what a controller keeps from sample to sample."""

from typing import NamedTuple

import numpy as np

from cabledrive.control.backstepping_recursion import work_shape
from cabledrive.parameters.arrays import Array, Integers

DARC, LINEAR, BACKSTEPPING, OWN, LEARNING, REFERENCE_MODEL, SCHEDULED = 0, 1, 2, 3, 4, 5, 6
SURFACE, ELASTIC, INERTIAL = 0, 1, 2
NOMINAL, LOW, HIGH, GAIN, LIMIT = 0, 1, 2, 3, 4
INTERVAL, K_SIGMA, SLOPE, BY_REFERENCE, DESIRED, MU, BETA = 0, 1, 2, 3, 4, 5, 6


class LawNumbers(NamedTuple):
    """One control law."""

    kind: int
    """DARC, LINEAR, BACKSTEPPING, LEARNING, REFERENCE_MODEL or SCHEDULED; OWN: a controller of the user's
    own, whose numbers are elsewhere."""
    matrix: Array
    """DARC: (2n, 2n), from angles and speeds to z and its derivatives. Linear: (m, m + 2n + 1), the memory's
    next value from itself, the errors of angles and speeds, and the last command; learning: the same.
    Backstepping: (2n, 2n), feedback by step and error."""
    rows: Array
    """DARC: (3, 2n + 1), the sliding surface, elastic torque and inertial acceleration in powers of s.
    Linear: (1, m + 2n), the command from memory and errors. Backstepping: (1, n - 1), the scales of the
    states. Reference model: (1, 2n), the feedback. Learning: (1 + encoders, columns), the command as that of
    a linear law, then what makes the filter's innovations white and of variance 1. Scheduled: (points, 1 +
    2n), that of a linear law for each point of the grid of loads."""
    learning: Array
    """(5, p): of each estimate: nominal value, lower and upper bound, adaptation gain, rate limit; scheduled:
    of the announced load, as a factor."""
    scalars: Array
    """(7,): interval [s], K_sigma, K of tanh(K w) [s/rad], whether friction goes by the reference, whether
    the regressor does, mu, beta_n. Scheduled: interval, one over the heaviest load, step between points,
    Coulomb friction of the motor, K of tanh(K w)."""

    @property
    def mu(self) -> float:
        """Inertia of the sliding variable."""
        return float(self.scalars[MU])

    @property
    def k_sigma(self) -> float:
        """K_sigma."""
        return float(self.scalars[K_SIGMA])


def start_estimates(law: LawNumbers) -> Array:
    """Estimates to begin with, and their covariance by rows where the law keeps one; none of a linear law."""
    if law.kind == LINEAR:
        return np.zeros(0)
    nominal = law.learning[NOMINAL]
    return np.concatenate((nominal, np.diag(law.learning[GAIN]).ravel())) if law.kind == LEARNING else nominal


def learning_table(nominal: Array, low: Array, high: Array, gain: Array) -> Array:
    """What the adaptation needs of each estimate, shape (5, p), its rate without a limit."""
    return np.array([nominal, low, high, gain, np.full(len(nominal), np.inf)])


IDEAL, DIFFERENCE, KALMAN, BY_LOAD = 0, 1, 2, 3


class ObserverNumbers(NamedTuple):
    """What turns m readings into the 2n angles and speeds of a law."""

    kind: int  # IDEAL, DIFFERENCE, KALMAN or BY_LOAD: a Kalman filter scheduled by an announced load
    chosen: Integers  # (2n,): which of the estimated quantities the law takes
    places: Integers  # (2,): of the Kalman filter's states, the motor's speed and the disturbance
    model: Array
    """(states, states + 4): Kalman: transition, then inputs: shaft torque at the sample, the commands before
    and after the delay has passed, friction and offset. By load: that of each point of the grid below the
    other."""
    output: Array  # (m, states)
    gains: Array  # (samples, states, m): of which the last one stays. By load: of the points of the grid
    scalars: Array
    """(9,): interval [s]; share of the newest slope in a filtered difference; the current loop's factors of
    torque, older and newer command; Coulomb friction, K of tanh(K w), offset torque; whether the law is to
    cancel the disturbance. By load (11,): then one over the heaviest load, and the step between points."""


ESTIMATES = 12


class ControllerState(NamedTuple):
    """Everything that a controller keeps from sample to sample, and scratch."""

    sample: Integers  # (1,): of the filter's schedule
    estimate: Array
    held: Array  # torque of the observer's shaft, last command before the limit
    parameters: Array
    memory: Array  # of a linear law, or of a controller of the user's own
    commands: Array  # limited, those not yet at the motor, oldest first
    states: Array  # angles and speeds that the law takes
    regressor: Array
    work: Array
    table: Array


def new_controller_state(
    observer: ObserverNumbers, law: LawNumbers, readings: int, late_samples: int, start: Array, memory: Array
) -> ControllerState:
    """A controller at rest with some ``readings``, whole samples of delay, estimates, and own memory (m,)."""
    size = law.matrix.shape[0] if law.kind in (LINEAR, LEARNING, SCHEDULED) else 0
    parameters = np.zeros(ESTIMATES)
    parameters[: len(start)] = start
    observed = max(observer.output.shape[1], 2 * readings if observer.kind == DIFFERENCE else 0)
    return ControllerState(
        sample=np.zeros(1, dtype=np.int64),
        estimate=np.zeros(observed),
        held=np.zeros(2),
        parameters=parameters,
        memory=np.concatenate((np.zeros(size), memory)),
        commands=np.zeros(late_samples + 2),
        states=np.zeros(len(observer.chosen)),
        regressor=np.zeros(ESTIMATES),
        work=np.zeros(max(observed, size, ESTIMATES)),
        table=np.zeros(work_shape(len(law.matrix) // 2) if law.kind == BACKSTEPPING else (0, 0)),
    )
