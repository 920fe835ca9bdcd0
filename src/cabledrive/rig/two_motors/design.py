r"""Gains of the law of two motors, from what the sampling and the lines allow, and the floor that they keep.

With a delay :math:`\tau` from sample to torque a loop of two equal poles :math:`\omega` crosses at
:math:`2.06\,\omega`; :math:`\omega\tau = 0.17` costs it 20 of its 76 degrees of phase.
"""

from dataclasses import dataclass
from math import isfinite, pi, sqrt

import numpy as np

from cabledrive.control.tension_position import TensionGains
from cabledrive.parameters import InputRefused, Sensors
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.two_motors import TwoMotorMachine

DELAY_SHARE = 0.17
LINE_SHARE = 0.2
"""Of the lowest frequency that the model leaves out, for the bandwidth of the tension."""
POSITION_SHARE, OBSERVER_SHARE = 1.0 / 12.0, 0.15
"""Of the bandwidth of the tension."""
TORQUE_SHARE = 0.95
"""Of the torque limit, for tension, friction and a drum that follows its line at 1 g."""
FLOOR_SHARE, GUST_SHARE = 0.2, 0.1
EARTH = 9.81
"""Acceleration that a drum can follow, and the weight of a body that lies level [m/s^2]."""
SLIDING = 0.01
"""Speed of the body below which the friction of the drums is smoothed [m/s]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class TensionDesign:
    """The law of a machine and what it promises.

    Attributes
    ----------
    gains : TensionGains
    floor : float
        Least tension allowed [N].
    gust : float
        Largest force on the body for which the floor is promised [N].
    margin : ndarray, shape (2,)
        Kept above the floor for it [N].
    """

    gains: TensionGains
    floor: float
    gust: float
    margin: Array


def design_tensions(
    machine: TwoMotorMachine,
    *,
    least_tension: float | None = None,
    gust: float | None = None,
    bandwidth: float | None = None,
) -> TensionDesign:
    """Gains and limits of the law.

    ``least_tension`` [N], default: a fifth of the smaller tension at rest; ``gust``: force on the body
    [N], default: a tenth of its weight; ``bandwidth``: of the position [Hz], default: what sampling and
    lines allow.
    Raises `InputRefused` where the tension at rest leaves no room.
    """
    numbers, drive = machine.numbers, machine.drive
    floor = FLOOR_SHARE * float(machine.tension.min()) if least_tension is None else least_tension
    gust = GUST_SHARE * EARTH * float(numbers.mass.max()) if gust is None else gust
    for name, value in (("least_tension", floor), ("gust", gust)):
        if not isfinite(value) or value < 0.0:
            raise InputRefused(f"{name} = {value:.4g} N must be finite and not negative: give a force")
    sensors = drive.sensors or Sensors()
    if sensors.sample_rate is None or sensors.motor_encoder is None or sensors.load_cell_noise is None:
        read = ("sample_rate", "motor_encoder", "load_cell_noise")
        missing = next(name for name in read if getattr(sensors, name) is None)
        raise InputRefused(
            f"sensors.{missing} is missing: the law samples the angles of both drums and the tensions "
            'of both lines: add sample_rate = "1 kHz", motor_encoder = COUNTS and load_cell_noise = "5 N"'
        )
    interval = 1.0 / sensors.sample_rate
    delay = 1.5 * interval + sensors.delay + _torque_lag(machine)
    fastest = min(DELAY_SHARE / delay, LINE_SHARE * machine.left_out)
    position = POSITION_SHARE * fastest if bandwidth is None else 2.0 * pi * bandwidth
    if not 0.0 < position <= 2.0 * POSITION_SHARE * fastest:
        raise InputRefused(
            f"bandwidth = {position / 2.0 / pi:.4g} Hz must lie above 0 and not above "
            f"{2.0 * POSITION_SHARE * fastest / 2.0 / pi:.4g} Hz, a sixth of that of the tension: lower it"
        )
    stiffness = numbers.rigidity / (numbers.fixed + _last_spans(machine))
    unexpected = gust / numbers.mass.min() + numbers.drum * numbers.turning_coulomb / numbers.inertia
    noise = 3.0 * sensors.load_cell_noise * sqrt(fastest * interval)
    margin = stiffness * unexpected / fastest**2 + noise
    following = numbers.turning_coulomb + numbers.inertia * EARTH / numbers.drum
    high = (TORQUE_SHARE * numbers.limit - following) / numbers.drum
    low = floor + margin
    for line, rest, least, most in zip(machine.lines, machine.tension, low, high, strict=True):
        if not least < rest < most:
            raise InputRefused(
                f"{line}: its tension at rest of {rest:.4g} N is not between {least:.4g} N (least tension "
                f"{floor:.4g} N and a margin for gusts of {gust:.4g} N) and {most:.4g} N "
                "(motor.torque_limit less what the drum takes): lower one, or choose another place"
            )
    gains = TensionGains(
        machine=numbers,
        low=low,
        high=high,
        preferred=machine.tension.copy(),
        position=position,
        filter=fastest,
        tension=fastest,
        observer=OBSERVER_SHARE * fastest,
        sliding=SLIDING / float(numbers.drum.max()),
        interval=interval,
    )
    return TensionDesign(gains=gains, floor=floor, gust=gust, margin=margin)


def _torque_lag(machine: TwoMotorMachine) -> float:
    """Time constant of the slower torque loop [s]."""
    rates = [motor.current_bandwidth for motor in machine.drive.motor if motor.current_bandwidth is not None]
    return 1.0 / (2.0 * pi * min(rates)) if rates else 0.0


def _last_spans(machine: TwoMotorMachine) -> Array:
    """Length of the span of each line that ends at the body, at rest, shape (2,) [m]."""
    numbers = machine.numbers
    return np.sqrt(((numbers.anchor - numbers.centre) ** 2).sum(axis=1) - numbers.radius**2)
