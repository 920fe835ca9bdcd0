"""Torques that faults of an axis would add, up to a factor, along the motion that an observer foresees.

Each is written so that the fault makes its factor positive; where only the positive sign is that fault, a
negative factor says nothing.
"""

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from cabledrive.identification.innovation_kernels import loosen
from cabledrive.identification.innovations import Prediction, Track

Array = NDArray[np.float64]

BASE = ("inertia", "viscous", "coulomb", "offset")
"""Torques of an error of the four parameters."""
STRIBECK_SHARES = (0.03, 0.1, 0.3)
"""Fading speeds that are tried, in root mean square speeds."""
SLOPE_SHARES = (1.0, 4.0)
"""Slopes of a smooth friction that are tried, over the root mean square speed."""
WAVES = 4
"""Half waves over the stroke of a torque that depends on the position."""
RESONANCES = (25.0, 50.0, 100.0)
"""Of a joint, that are tried [Hz]."""
RESONANCE_DAMPING = 0.1
GAPS = (0.25, 1.0)
"""Backlash widths that are tried, in degrees for a rotating axis."""
LINEAR_GAPS = (0.0005, 0.005)
"""The same for a linear axis, in strokes."""
CONTACT = 0.005
"""Time in which both sides of a backlash reach one speed [s]."""


def base_torques(run: Prediction, track: Track) -> dict[str, Array]:
    """What an error of the parameters would add, and of the instant at which the torque was measured.

    Returns those of `BASE`, and "lag".
    """
    return {
        "inertia": -run.acceleration,
        "viscous": -run.speed,
        "coulomb": -run.direction,
        "offset": np.ones_like(run.speed),
        "lag": np.gradient(track.torque, track.interval),
    }


def fault_torques(run: Prediction, track: Track, gaps: tuple[float, ...]) -> dict[str, Array]:
    """What each fault would add.

    ``gaps``: backlash widths [rad or m].
    Returns by fault, and what was tried of it after a colon.
    """
    net = run.values[0] * run.acceleration
    found = friction_torques(run.speed, run.direction) | {"load": -run.direction * np.abs(net)}
    stroke = float(np.ptp(track.position))
    place = (track.position - track.position.min()) / stroke
    for k in range(1, WAVES + 1):
        found[f"position:{k}"] = np.cos(np.pi * k * place)
    for hertz in RESONANCES:
        if hertz < 0.2 / track.interval:
            found[f"flexibility:{hertz:g}"] = springy(net, 2 * np.pi * hertz, track.interval)
    for gap in gaps:
        found[f"backlash:{gap:.3g}"] = loosened(net, run.speed, gap, track.interval)
    return found


def friction_torques(speed: Array, direction: Array) -> dict[str, Array]:
    """What other laws of friction would add.

    ``speed``, shape (samples,); ``direction``, shape (samples,): 0 where the axis sticks.
    """
    size = float(np.sqrt(np.mean(speed**2)))
    found = {"asymmetry": -np.abs(speed), "quadratic": -speed * np.abs(speed) / size}
    for share in STRIBECK_SHARES:
        found[f"stribeck:{share:g}"] = -direction * np.exp(-((speed / (share * size)) ** 2))
    for share in SLOPE_SHARES:
        found[f"slope:{share:g}"] = direction - np.tanh(share * speed / size)
    return found


def springy(net: Array, resonance: float, interval: float) -> Array:
    r"""What the load's inertia behind a spring adds to the motor's acceleration.

    .. math:: \frac{s^2}{s^2 + 2\zeta\omega_r s + \omega_r^2}

    of the torque that accelerates the axis.

    ``net``, shape (samples,); ``resonance``: motor and load against each other [rad/s]; ``interval`` [s].
    Returns shape (samples,).
    """
    damping = 2 * RESONANCE_DAMPING * resonance
    numerator, denominator = signal.bilinear([1.0, 0.0, 0.0], [1.0, damping, resonance**2], 1.0 / interval)
    return np.asarray(signal.lfilter(numerator, denominator, net))


def loosened(net: Array, speed: Array, gap: float, interval: float) -> Array:
    """What backlash adds: the torque accelerates the motor alone, and contact takes the surplus back.

    ``net``, ``speed``, shape (samples,): torque that accelerates the axis, and its speed; ``gap`` [rad or m];
    ``interval`` [s].
    Returns shape (samples,).
    """
    added = np.empty_like(net)
    loosen(net, speed, gap, interval, max(1, round(CONTACT / interval)), added)
    return added
