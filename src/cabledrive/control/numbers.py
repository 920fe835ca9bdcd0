"""Frozen numbers of a control law, laid out so that one compiled step serves every law."""

from typing import NamedTuple

import numpy as np

from cabledrive.parameters.arrays import Array

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


def learning_table(nominal: Array, low: Array, high: Array, gain: Array, limit: Array | None = None) -> Array:
    """What the adaptation needs of each estimate, shape (5, p); unless given, no rate is limited."""
    return np.array([nominal, low, high, gain, np.full(len(nominal), np.inf) if limit is None else limit])
