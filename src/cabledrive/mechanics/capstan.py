r"""What a pulley transmits by friction before the cable slips on it."""

from math import tanh


def no_slip_torque(radius: float, pretension: float, friction: float, wrap_angle: float) -> float:
    r"""Largest torque a pulley of a loop transmits before the cable slips.

    One span gains what the other loses, :math:`T_{tight} + T_{slack} = 2 T_0`, so that with the ratio
    :math:`T_{tight}/T_{slack} \le e^{\mu\alpha}` of Euler and Eytelwein

    .. math:: \tau = r\,(T_{tight} - T_{slack}) = 2 r T_0\,\frac{e^{\mu\alpha} - 1}{e^{\mu\alpha} + 1}
                   = 2 r T_0 \tanh\frac{\mu\alpha}{2}

    It is below the slack torque 2 r T0 at any friction: a loop slips before a span goes slack.

    ``radius``: radius r of the pulley [m]; ``pretension``: pretension T0 [N]; ``friction``: coefficient of
    friction mu between cable and pulley [-]; ``wrap_angle``: angle alpha the cable wraps round the pulley
    [rad].
    Returns torque [N m].
    """
    return 2.0 * radius * pretension * tanh(friction * wrap_angle / 2.0)
