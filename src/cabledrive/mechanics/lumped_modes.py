r"""First estimates of the two flexible modes, each as if it were alone: the cable's and the motor joint's."""

from itertools import pairwise
from math import sqrt

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.holding import HOLDING, motor_condition
from cabledrive.parameters.drive import Drive

_DENSE = 400  # masses up to which the matrix is solved as a dense one


def lumped_cable_mode(drive: Drive) -> float | None:
    r"""Lowest frequency of pulleys and carriages on a cable without mass, the motor joint taken as rigid.

    Without carriages and holding stiffness it is

    .. math:: \omega^2 = N k\,\Big(\frac{r_1^2}{J_1} + \frac{r_2^2}{J_2}\Big)

    with N spans of stiffness k, that of ``[lumped]`` where given, else EA/L. Else it is the lowest eigenvalue
    above the rigid motion of the masses on springs k L / l between neighbours; the rotor's holding stiffness
    is one to the ground.

    Returns angular frequency [rad/s]; None if nothing can move.
    """
    motor = drive.motor.inertia if drive.motor else 0.0
    first, second = drive.pulley
    if drive.carriage or motor_condition(drive) == HOLDING:
        return _lowest_of_masses(drive, (first.inertia + motor) / first.radius**2)
    inertias = ((first, first.inertia + motor), (second, second.inertia))
    inverse_mass = sum(pulley.radius**2 / inertia for pulley, inertia in inertias if not pulley.fixed)
    stiffness = len(drive.spans) * span_stiffness(drive)
    return sqrt(stiffness * inverse_mass) if inverse_mass > 0.0 else None


def _lowest_of_masses(drive: Drive, driven: float) -> float | None:
    """Lowest elastic mode of the masses on a cable without mass."""
    links, masses, grounds = _masses_on_springs(drive, driven)
    moving = np.flatnonzero(np.isfinite(masses))
    if not moving.size:
        return None
    rigid = int(moving.size == masses.size and not grounds.any())
    root = 1.0 / np.sqrt(masses[moving])
    place = np.full(masses.size, -1)
    place[moving] = np.arange(moving.size)
    rows, columns, values = [place[moving]], [place[moving]], [grounds[moving]]
    left, right, stiffness = links
    for near, far, sign in ((left, left, 1), (right, right, 1), (left, right, -1), (right, left, -1)):
        keep = (place[near] >= 0) & (place[far] >= 0)
        rows.append(place[near[keep]])
        columns.append(place[far[keep]])
        values.append(sign * stiffness[keep])
    row, column = np.concatenate(rows), np.concatenate(columns)
    value = np.concatenate(values) * root[row] * root[column]
    squares = _lowest_eigenvalues(row, column, value, moving.size, rigid + 1)
    return sqrt(max(float(squares[rigid]), 0.0)) if squares.size > rigid else None


def _masses_on_springs(
    drive: Drive, driven: float
) -> tuple[
    tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.float64]], NDArray[np.float64], NDArray[np.float64]
]:
    """Springs between neighbouring masses, masses (infinite where held) and springs to the ground."""
    first, second = drive.pulley
    masses = [np.inf if first.fixed else driven, np.inf if second.fixed else second.rim_mass]
    left, right, stiffness = [], [], []
    whole = span_stiffness(drive) * drive.span_length
    for span in drive.spans:
        carriages = drive.carriages_on(span)
        inside = list(range(len(masses), len(masses) + len(carriages)))
        masses += [carriage.mass for carriage in carriages]
        places = [0.0, *(carriage.position for carriage in carriages), drive.span_length]
        ends = (0, 1) if span == "upper" else (1, 0)
        around = [ends[0], *inside, ends[1]]
        left += around[:-1]
        right += around[1:]
        stiffness += [whole / (b - a) for a, b in pairwise(places)]
    grounds = np.zeros(len(masses))
    if motor_condition(drive) == HOLDING:
        assert drive.motor is not None
        assert drive.motor.holding_stiffness is not None
        grounds[0] = drive.motor.holding_stiffness / first.radius**2
    return (np.array(left), np.array(right), np.array(stiffness)), np.array(masses), grounds


def _lowest_eigenvalues(
    row: NDArray[np.intp], column: NDArray[np.intp], value: NDArray[np.float64], size: int, count: int
) -> NDArray[np.float64]:
    """Lowest eigenvalues of a symmetric matrix given by its entries, ascending."""
    if size <= _DENSE:
        dense = np.zeros((size, size))
        np.add.at(dense, (row, column), value)
        return np.asarray(np.linalg.eigvalsh(dense)[:count], dtype=np.float64)
    from scipy.sparse import csc_array
    from scipy.sparse.linalg import eigsh

    matrix = csc_array((value, (row, column)), shape=(size, size))
    below = -1e-6 * float(np.max(value)) / size**2  # a shift below all of them, so that it is never singular
    lowest = eigsh(matrix, k=count, sigma=below, v0=np.ones(size), return_eigenvectors=False)
    return np.sort(np.asarray(lowest, dtype=np.float64))


def lumped_joint_mode(drive: Drive) -> float | None:
    r"""Frequency of the motor against the drive pulley, the cable taken away.

    .. math:: \omega^2 = k_m\,\Big(\frac{1}{J_{11}} + \frac{1}{J_{12}}\Big)

    Returns angular frequency [rad/s]; None without a flexible joint.
    """
    if drive.motor is None or drive.motor.joint_stiffness is None:
        return None
    return sqrt(drive.motor.joint_stiffness * (1.0 / drive.motor.inertia + 1.0 / drive.drive_pulley.inertia))


def span_stiffness(drive: Drive) -> float:
    """Stiffness k of one span: as measured, ``[lumped]``, else EA / L. Returns stiffness [N/m]."""
    if drive.lumped is not None and drive.lumped.cable_stiffness is not None:
        return drive.lumped.cable_stiffness
    return drive.cable.axial_rigidity / drive.span_length
