"""The threshold torque measured on the exact loop: where a vanishing motion neither grows nor dies."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from cabledrive.parameters import Drive, NotComputed
from cabledrive.reduction.autoparametric import autoparametric_model
from cabledrive.simulation import Pluck, Recording, Scheme, Sine, Start, simulate

Array = NDArray[np.float64]

SEED = 1e-9
"""Pluck of the upper span [m]: small enough to act back on nothing."""

SETTLED, MEASURED = 7.0, 12.0
"""Growth is fitted between so many decay times 1 / Gamma."""


def measured_growth(drive: Drive, torque: float, forcing: float, segments: int = 200) -> float:
    """Growth rate of a vanishing transverse motion on the exact loop under a steady torque.

    The pulleys start with the speed that leaves no mean drift. The midpoint's motion is demodulated at half
    the forcing frequency; window peaks would mislead by some per cent.

    ``drive``: with transverse damping; ``torque`` [N m]; ``forcing``: omega [rad/s]; ``segments``: per span.
    Returns [1/s].
    Raises `NotComputed` if the cable is undamped: there is nothing to wait for.
    """
    gamma = drive.cable.transverse_damping
    if gamma == 0.0:
        raise NotComputed("the growth needs transverse damping: without it the transients do not decay")
    model = autoparametric_model(drive)
    rim_speed = -torque * model.rigid_arm / (model.rigid_mass * forcing)
    result = simulate(
        drive,
        MEASURED / gamma + 8.0 / max(model.modal_damping, 1.0),
        torque=Sine(amplitude=torque, frequency=forcing / (2 * np.pi)),
        start=Start(
            plucks=(Pluck(height=SEED, shape="half-sine"),),
            drive_speed=rim_speed / drive.drive_pulley.radius,
            load_speed=rim_speed / drive.load_pulley.radius,
        ),
        scheme=Scheme(segments=segments),
        recording=Recording(rate=16 * forcing / (2 * np.pi)),
    )
    time, motion = result.time, result.midpoint("upper")[:, 2]
    centres, sizes = demodulated(time, motion, 0.5 * forcing)
    late = centres > time[-1] - (MEASURED - SETTLED) / gamma
    return float(np.polyfit(centres[late], np.log(sizes[late]), 1)[0])


def demodulated(time: Array, signal: Array, omega: float, periods: int = 4) -> tuple[Array, Array]:
    """Amplitude of a signal at one frequency, over windows of some periods with smooth edges.

    ``time``, ``signal``, shape (n,): at equal intervals; ``omega`` [rad/s].
    Returns ``centre, amplitude``, shape (windows,): windows overlap by half.
    """
    interval = time[1] - time[0]
    length = round(periods * 2 * np.pi / omega / interval)
    weight = np.hanning(length + 1)[:-1]
    starts = np.arange(0, time.size - length, length // 2)
    rows = starts[:, None] + np.arange(length)
    turned = signal[rows] * np.exp(-1j * omega * time[rows]) * weight
    return time[starts] + 0.5 * length * interval, 2.0 * np.abs(turned.sum(axis=1)) / weight.sum()


def measured_threshold(
    drive: Drive,
    predicted: float,
    forcing: float,
    shares: Sequence[float] = (1.01, 1.03),
    segments: int = 200,
) -> float:
    r"""Torque at which the growth on the exact loop changes sign, from two torques above a prediction.

    The growth rate :math:`\lambda` obeys :math:`(\lambda + \Gamma/2)^2 = \mu^2 - D^2` with :math:`\mu`
    proportional to the torque: a straight line over its square, while the rate itself has a corner just
    below the threshold.

    ``predicted`` [N m]; ``forcing``: omega [rad/s]; ``shares``: of the predicted torque, where growth is
    measured; ``segments``: per span.
    Returns [N m].
    """
    half = 0.5 * drive.cable.transverse_damping
    low, high = ((measured_growth(drive, x * predicted, forcing, segments) + half) ** 2 for x in shares)
    first, second = (x**2 for x in shares)
    return float(predicted * np.sqrt(first + (half**2 - low) * (second - first) / (high - low)))
