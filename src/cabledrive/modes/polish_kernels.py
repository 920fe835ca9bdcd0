r"""Inverse iteration in machine code, for one mode of a long chain: the loops behind `inverse_iteration`.

A chain is a row of springs (links) from joint to joint and to the ground, so elimination from one end is the
series connection of springs: what stands behind joint i acts as
:math:`s_{i+1} = g_{i+1} + s_i k_i/(s_i + k_i)`. A ring is a line between two images of its joint 0, which
is put in last.
"""

from math import tan

import numpy as np

from cabledrive.mechanics.chain import Array
from cabledrive.mechanics.compiled import njit_strict

Pendant = tuple[float, float, float]
"""Spring over the joint, mass behind it, number of the joint (a float too: kernels take one kind)."""

STEPS, REPEATS = 8, 6
SETTLED, CONVERGED, CLEAR = 1e-9, 1e-13, 1e-9


@njit_strict
def springs(
    omega: float,
    times: Array,
    masses: Array,
    impedance: float,
    pendant: Pendant,
    closed: bool,
    link: Array,
    link_rate: Array,
    ground: Array,
    ground_rate: Array,
) -> None:
    """Springs of the exact stiffness over omega and minus their rates, as in `dynamic_stiffness`."""
    n = masses.size
    for i in range(n):
        ground[i] = -omega * masses[i]
        ground_rate[i] = masses[i]
    spring, mass, joint = pendant
    if spring > 0.0:
        rest = spring - omega * omega * mass
        ground[int(joint)] -= mass * spring * omega / rest
        ground_rate[int(joint)] += mass * spring * (spring + omega * omega * mass) / (rest * rest)
    for i in range(times.size):
        far = 0 if closed and i == n - 1 else i + 1
        t = tan(0.5 * omega * times[i])
        unit = impedance * (1.0 + t * t) / (2.0 * t)
        link[i] = unit
        link_rate[i] = unit * times[i] * (1.0 - t * t) / (2.0 * t)
        for j in (i, far):
            ground[j] -= impedance * t
            ground_rate[j] += 0.5 * impedance * times[i] * (1.0 + t * t)


@njit_strict
def eliminate(
    link: Array, ground: Array, first: int, last: int, closed: bool, pivot: Array, ratio: Array
) -> float:
    """Pivots of joints first..last and the shares that successors take; the smallest pivot, relative."""
    smallest = 1.0
    behind = ground[first]
    if first > 0:
        behind += link[first - 1]
    for i in range(first, last + 1):
        reaches_on = i < last or closed or last < ground.size - 1
        pivot[i] = behind + link[i] if reaches_on else behind
        if reaches_on:
            smallest = min(smallest, abs(pivot[i]) / (abs(behind) + abs(link[i])))
        if pivot[i] == 0.0:
            pivot[i] = 1e-30 * abs(link[max(i - 1, 0)])
        ratio[i] = link[i] / pivot[i] if reaches_on else 0.0
        if i < last:
            behind = ground[i + 1] + behind * ratio[i]
    return smallest


@njit_strict
def substitute(pivot: Array, ratio: Array, first: int, last: int, x: Array) -> None:
    """Solve for joints first..last in place, all others held."""
    for i in range(first, last):
        x[i + 1] += ratio[i] * x[i]
    x[last] /= pivot[last]
    for i in range(last - 1, first - 1, -1):
        x[i] = x[i] / pivot[i] + ratio[i] * x[i + 1]


@njit_strict
def close_ring(link: Array, ground: Array, pivot: Array, ratio: Array, x: Array, image: Array) -> None:
    """Put in joint 0 of a ring: x holds the load, then the solution; image is scratch."""
    last = ground.size - 1
    image[:] = 0.0
    image[1] += link[0]
    image[last] += link[last]
    substitute(pivot, ratio, 1, last, image)
    substitute(pivot, ratio, 1, last, x)
    own = ground[0] + link[0] * (1.0 - image[1]) + link[last] * (1.0 - image[last])
    if own == 0.0:
        own = 1e-30 * link[0]
    x[0] = (x[0] + link[0] * x[1] + link[last] * x[last]) / own
    for i in range(1, last + 1):
        x[i] += x[0] * image[i]


@njit_strict
def form(link: Array, ground: Array, closed: bool, x: Array) -> float:
    """Quadratic form of springs, without cancellation."""
    total = 0.0
    n = ground.size
    for i in range(n):
        total += ground[i] * x[i] * x[i]
    for i in range(link.size):
        stretch = x[i] - x[0 if closed and i == n - 1 else i + 1]
        total += link[i] * stretch * stretch
    return total


@njit_strict
def load(link: Array, ground: Array, closed: bool, x: Array, out: Array) -> None:
    """Forces of springs for displacements x."""
    n = ground.size
    for i in range(n):
        out[i] = ground[i] * x[i]
    for i in range(link.size):
        far = 0 if closed and i == n - 1 else i + 1
        force = link[i] * (x[i] - x[far])
        out[i] += force
        out[far] -= force


@njit_strict
def polish(
    omega: float,
    low: float,
    high: float,
    times: Array,
    masses: Array,
    impedance: float,
    pendant: Pendant,
    closed: bool,
    first: int,
    last: int,
    x: Array,
) -> float:
    """Inverse iteration from omega and the load x: frequency or NaN; x becomes the shape of unit modal mass.

    The solution is repeated at one frequency until its Rayleigh quotient lies between low and high.
    """
    work = np.empty((8, masses.size))
    link, link_rate, ground, ground_rate, pivot, ratio, image, force = work
    link, link_rate = link[: times.size], link_rate[: times.size]
    settled = False
    for _ in range(STEPS):
        springs(omega, times, masses, impedance, pendant, closed, link, link_rate, ground, ground_rate)
        if not settled and eliminate(link, ground, first, last, closed, pivot, ratio) < CLEAR:
            return np.nan  # elimination without exchange of rows has lost the digits
        for _ in range(0 if settled else REPEATS):
            load(link_rate, ground_rate, closed, x, force)
            x[first : last + 1] = force[first : last + 1]
            if closed:
                x[0] = force[0]
                close_ring(link, ground, pivot, ratio, x, image)
            else:
                substitute(pivot, ratio, first, last, x)
            x /= np.max(np.abs(x))
            rate = form(link_rate, ground_rate, closed, x)
            shift = form(link, ground, closed, x) / rate
            if low <= omega + shift <= high:
                break
        if settled:
            rate = form(link_rate, ground_rate, closed, x)
            shift = form(link, ground, closed, x) / rate
        if not (low <= omega + shift <= high):
            return np.nan
        omega += shift
        if abs(shift) <= CONVERGED * omega:
            x *= np.sqrt(2.0 / rate)
            return omega
        settled = abs(shift) <= SETTLED * omega
    return np.nan
