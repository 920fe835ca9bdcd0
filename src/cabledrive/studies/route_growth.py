"""Transverse modes of a machine with routes along a motion: parametric growth, in runs side by side."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cabledrive.studies.route_path import RoutePath

Array = NDArray[np.float64]

SAME_POSE = 2e-3
"""Way to the next pose within which the modes are taken as they are: less than 0.02 % of a frequency each
10 % between poses."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Runs:
    """How b runs differ, each of shape (b,).

    Attributes
    ----------
    floor : ndarray
        Displacement below which no mode falls [m].
    phase : ndarray
        Of what is there at the start [rad].
    detuned : ndarray
        Relative change of the transverse frequencies.
    torque : ndarray
        Factor on the torque.
    parametric : ndarray
        Factor on the coupling: 0 or 1.
    """

    floor: Array
    phase: Array
    detuned: Array
    torque: Array
    parametric: Array


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Growth:
    """What b runs left.

    Attributes
    ----------
    displacement : ndarray, shape (b,)
        Largest displacement of any span from its chord [m].
    amplitude, time : ndarray, shape (a, b)
        Largest displacement by each mode [m], and when [s].
    ended : float or None
        When a run reached the largest displacement that is followed [s].
    """

    displacement: Array
    amplitude: Array
    time: Array
    ended: float | None


def growth_along(path: RoutePath, runs: Runs, most: float) -> Growth:
    r"""Integrate :math:`\ddot a + \Gamma\dot a + \omega^2 a + \sum_q g^q Q_q a = \theta M` in every run.

    Kicks of the coupling about exact rotations; ``most``: displacement at which it ends [m].
    """
    h = float(path.time[1] - path.time[0])
    names = ("across", "across_loss", "across_turn", "coupling", "shape")
    middle = 0.5 * (path.here[1:] + path.here[:-1])
    last, driven = middle[0], path.swing
    omega, loss, turn, coupling, shape = (path.at(name, middle[:1])[0] for name in names)
    peak = np.abs(shape).max(axis=0, initial=0.0)[:, None]
    size = np.divide(runs.floor, peak, out=np.zeros((omega.size, runs.floor.size)), where=peak > 0.0)
    w = omega[:, None] * (1.0 + runs.detuned)
    a, v = size * np.cos(runs.phase), -size * w * np.sin(runs.phase)
    amplitude, when = np.zeros_like(a), np.zeros_like(a)
    displacement = np.zeros(runs.floor.size)
    ended = None
    kick = 0.5 * h * runs.torque * runs.parametric
    for i in range(middle.size):
        fresh = abs(middle[i] - last) > SAME_POSE
        if fresh:
            last = middle[i]
            omega, loss, turn, coupling, shape = (path.at(name, middle[i : i + 1])[0] for name in names)
            peak, w = np.abs(shape).max(axis=0, initial=0.0)[:, None], omega[:, None] * (1.0 + runs.detuned)
        if i == 0 or fresh:
            cosine, sine, decay = np.cos(w * h), np.sin(w * h), np.exp(-0.5 * h * loss)[:, None]
        pull = np.tensordot(driven[i], coupling, axes=1)
        rest = (turn @ path.pushed[i])[:, None] * runs.torque / w**2
        v = (v - kick * (pull @ a)) * decay
        d = a - rest
        a, v = rest + d * cosine + v / w * sine, v * cosine - d * w * sine
        v = v * decay - kick * (pull @ a)
        swing = np.sqrt((a - rest) ** 2 + (v / w) ** 2) * peak
        low = (swing < runs.floor) & (swing > 0.0)
        if low.any():
            scale = np.where(low, runs.floor / np.where(swing > 0.0, swing, 1.0), 1.0)
            a, v = rest + (a - rest) * scale, v * scale
        now = np.abs(a) * peak
        larger = now > amplitude
        amplitude[larger], when[larger] = now[larger], path.time[i + 1]
        displacement = np.maximum(displacement, np.abs(shape @ a).max(axis=0, initial=0.0))
        if displacement.max() > most:
            ended = float(path.time[i + 1])
            break
    return Growth(displacement=displacement, amplitude=amplitude, time=when, ended=ended)
