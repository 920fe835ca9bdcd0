"""How far a transverse mode grows along a motion: Hill's equation, the nonlinear oscillators, the tongue."""

import numpy as np
from numpy.typing import NDArray

from cabledrive.parameters import NotComputed
from cabledrive.reduction.motion_kernels import march_from, transitions
from cabledrive.studies.planned_motion import STEPS_PER_PERIOD, Course

Array = NDArray[np.float64]

BLOCKS_PER_SECOND = 40.0


def hill_gain(course: Course, mode: int) -> tuple[float, int, int]:
    r"""Largest growth by Hill's equation from any start to any end of the motion, Eq. (A.33).

    .. math:: \ln\max_{t_0 < t_1}\sigma_{\max}\big[\Phi(t_1)\Phi(t_0)^{-1}\big]

    with the transition matrix of amplitude and rate over frequency.

    Parameters
    ----------
    course : Course
    mode : int

    Returns
    -------
    gain : float
        0 or more.
    start, end : int
        Steps.

    Raises
    ------
    NotComputed
        If the growth between two edges is beyond a double.
    """
    blocks = max(2, int(course.time.size * course.h * BLOCKS_PER_SECOND))
    edges = np.unique(np.linspace(0, course.time.size, blocks + 1).astype(np.int64))
    steps = np.empty((edges.size - 1, 2, 2))
    transitions(course.across[mode], course.lift[mode], course.q, course.gamma, course.h, edges, steps)
    if not np.isfinite(steps).all():
        raise NotComputed(
            f"the planned motion pumps a span beyond any number (q up to {np.abs(course.q).max():.3g} m): "
            "plan a smaller or a slower one"
        )
    best, where = 0.0, (0, 0)
    running = np.broadcast_to(np.eye(2), (steps.shape[0], 2, 2)).copy()
    scale = np.zeros(steps.shape[0])
    for last, step in enumerate(steps):
        running[: last + 1] = step @ running[: last + 1]
        size = np.abs(running[: last + 1]).max(axis=(1, 2))
        running[: last + 1] /= size[:, None, None]
        scale[: last + 1] += np.log(size)
        gains = np.log(np.linalg.norm(running[: last + 1], 2, axis=(1, 2))) + scale[: last + 1]
        first = int(np.argmax(gains))
        if gains[first] > best:
            best, where = float(gains[first]), (int(edges[first]), int(edges[last + 1]))
    return best, *where


def nonlinear_largest(course: Course, mode: int, start: int, floor: float) -> Array:
    """Largest amplitude of every mode when the floor stands at a step, by the oscillators, over two phases.

    Parameters
    ----------
    course : Course
    mode : int
        The one that has the floor; the others a third of it.
    start : int
        Step.
    floor : float
        [m].

    Returns
    -------
    ndarray, shape (modes,)
        [m].
    """
    modes = course.across.shape[0]
    top = np.zeros(modes)
    share = np.where(np.arange(modes) == mode, 1.0, 1.0 / 3.0)
    for phase in (0.25 * np.pi, 0.75 * np.pi):
        a = floor * share * np.cos(phase)
        b = floor * share * np.sin(phase) * course.across[:, start]
        march_from(
            start,
            course.natural,
            course.damping,
            course.force,
            course.push,
            course.across,
            course.lift,
            course.cubic,
            course.gamma,
            course.h,
            course.q[start],
            course.p[start],
            a,
            b,
            top,
        )
    return top


def tongue_dwell(course: Course, mode: int) -> float:
    """Time that the motion spends inside the tongue, by the envelope and the frequency of the pulley mode.

    Parameters
    ----------
    course : Course
    mode : int

    Returns
    -------
    float
        [s].
    """
    from scipy.ndimage import uniform_filter1d
    from scipy.signal import hilbert

    turning = hilbert(course.q - np.mean(course.q))
    omega = np.gradient(np.unwrap(np.angle(turning)), course.h)
    omega = np.maximum(uniform_filter1d(omega, 2 * STEPS_PER_PERIOD, mode="nearest"), 1e-9)
    pumping = 0.5 * np.abs(course.lift[mode] * turning) / omega
    growth = np.sqrt(np.maximum(pumping**2 - (course.across[mode] - 0.5 * omega) ** 2, 0.0))
    inside = growth > 0.5 * course.gamma
    return float(np.sum(inside) * course.h)
