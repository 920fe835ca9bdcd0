"""A motor, two spans and a load as two turning masses on springs: plain Newton, integrated by scipy."""

import numpy as np
from scipy.integrate import solve_ivp


def span_tensions(time, torque, radius, motor, load, stiffness, pretension):
    """Tensions of both spans at the times, shape (2, t), from rest; torque on straight lines between them."""

    def rates(t, state):
        turn_motor, turn_load, speed_motor, speed_load = state
        pull = 2.0 * stiffness * radius**2 * (turn_motor - turn_load)
        push = np.interp(t, time, torque)
        return [speed_motor, speed_load, (push - pull) / motor, pull / load]

    found = solve_ivp(
        rates,
        (time[0], time[-1]),
        np.zeros(4),
        t_eval=time,
        rtol=1e-10,
        atol=1e-14,
        max_step=time[1] - time[0],
    )
    rise = stiffness * radius * (found.y[0] - found.y[1])
    return np.array([pretension + rise, pretension - rise])
