"""Frozen numbers of an observer as its compiled step takes them."""

from typing import NamedTuple

from cabledrive.parameters.arrays import Array, Integers

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
