"""Compiled command of the backstepping laws, by the number of states."""

from cabledrive.control.backstepping_four import backstepping_four
from cabledrive.control.backstepping_six import backstepping_six
from cabledrive.control.numbers import Array
from cabledrive.mechanics.compiled import njit


@njit
def backstepping_command(
    gains: Array, scalars: Array, estimate: Array, states: Array, reference: Array, k: int, tau: Array
) -> tuple[float, float]:
    """Command and first error; writes the adaptation function tau of (6.95).

    ``gains[0]``: the feedback gains, then the scales of the states; ``states``: angles, then speeds, from the
    motor to the load; ``scalars`` as in `LawNumbers`.
    """
    if states.size == 4:
        return backstepping_four(gains, scalars, estimate, states, reference, k, tau)
    return backstepping_six(gains, scalars, estimate, states, reference, k, tau)
