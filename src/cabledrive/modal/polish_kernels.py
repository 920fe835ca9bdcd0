r"""Inverse iteration for one mode, plain arithmetic: run as Python for short chains, compiled for long ones.

A chain is a row of springs (links) from joint to joint and to the ground, so elimination from one end is the
series connection of springs: what stands behind joint i acts as
:math:`s_{i+1} = g_{i+1} + s_i k_i/(s_i + k_i)`. A ring is a line between two images of its joint 0, which
is put in last. The readable oracle, for multiple modes too, is the general part of
`cabledrive.modal.refinement.inverse_iteration`.
"""

from collections.abc import Sequence
from math import nan, sqrt, tan

from cabledrive.mechanics.chain import Array

STEPS, REPEATS = 8, 6
SETTLED, CONVERGED, CLEAR = 1e-15, 1e-13, 1e-9
Floats = list[float] | Array


def polish(
    omega: float,
    low: float,
    high: float,
    times: Floats,
    masses: Floats,
    springs: Floats,
    impedance: float,
    pendant: tuple[float, float, float, int],
    closed: bool,
    first: int,
    last: int,
    x: Floats,
    work: Sequence[Floats],
) -> float:
    """Inverse iteration from omega and the load x.

    ``omega``: where to begin [rad/s]; ``low``, ``high``: interval the mode must lie in [rad/s]; ``times``,
    ``masses``, ``springs``: travel times of the segments [s], none near a pole, masses of the joints [kg] and
    their springs to the ground [N/m]; ``impedance``: wave impedance [kg/s]; ``pendant``: stiffness [N/m],
    mass [kg], stiffness to the ground [N/m] and joint of the pendant; a stiffness of 0 if there is none;
    ``closed``: whether the chain is a ring; its joint 0 is then none of `first` to `last`; ``first``,
    ``last``: the joints that move; ``x``: a load on every joint; becomes the shape of unit modal mass
    [kg^-1/2]; ``work``: scratch, as long as `masses`.
    Returns natural frequency [rad/s]; NaN if the iteration leaves the interval or loses its digits.
    """
    link, link_rate, ground, ground_rate, pivot, ratio, image = work
    n = len(masses)
    segments = len(times)
    spring, mass, held, joint = pendant
    settled = False
    fewest = 2  # solutions at one frequency; the first shape is a bad one
    for _ in range(STEPS):
        # the springs of `dynamic_stiffness`, over omega, and minus their rates
        for i in range(n):
            ground[i] = springs[i] / omega - omega * masses[i]
            ground_rate[i] = springs[i] / (omega * omega) + masses[i]
        if spring > 0.0:
            own = held / omega - omega * mass
            own_rate = held / (omega * omega) + mass
            rest = spring / omega + own
            if rest == 0.0:
                return nan
            # two springs in series, the joint's and what holds or drags the pendant's mass
            near, far = own / rest, spring / omega / rest
            ground[joint] += far * own
            ground_rate[joint] += near * near * spring / (omega * omega) + far * far * own_rate
        for i in range(segments):
            far = i + 1 if i + 1 < n else 0
            time = times[i]
            t = tan(0.5 * omega * time)
            over = 1.0 / t
            link[i] = 0.5 * impedance * (over + t)
            link_rate[i] = 0.5 * link[i] * time * (over - t)
            edge = impedance * t
            edge_rate = 0.5 * impedance * time * (1.0 + t * t)
            ground[i] -= edge
            ground[far] -= edge
            ground_rate[i] += edge_rate
            ground_rate[far] += edge_rate
        if not settled:
            # pivots, and the share of each that its successor takes
            smallest = 1.0
            behind = ground[first] + (link[first - 1] if first > 0 else 0.0)
            for i in range(first, last + 1):
                onward = link[i] if i < segments else 0.0
                pivot[i] = behind + onward
                if onward != 0.0:
                    smallest = min(smallest, abs(pivot[i]) / (abs(behind) + abs(onward)))
                if pivot[i] == 0.0:
                    pivot[i] = 1e-16 * abs(link[i if i < segments else i - 1])
                ratio[i] = onward / pivot[i]
                if i < last:
                    behind = ground[i + 1] + behind * ratio[i]
            if smallest < CLEAR:
                return nan  # elimination without exchange of rows has lost the digits
            ring_own = 1.0
            if closed:
                # the ring's answer to joint 0 moving by one, and the stiffness it meets
                for i in range(first, last + 1):
                    image[i] = 0.0
                image[first] += link[0]
                image[last] += link[last]
                for i in range(first, last):
                    image[i + 1] += ratio[i] * image[i]
                image[last] /= pivot[last]
                for i in range(last - 1, first - 1, -1):
                    image[i] = image[i] / pivot[i] + ratio[i] * image[i + 1]
                ring_own = ground[0] + link[0] * (1.0 - image[first]) + link[last] * (1.0 - image[last])
                if ring_own == 0.0:
                    ring_own = 1e-16 * abs(link[0])
        shift = rate = 0.0
        for solutions in range(1 if settled else REPEATS):
            if not settled:
                # the load of the last shape, carried forward, then the new shape backward
                start = here = x[0]
                force = link_rate[n - 1] * (start - x[n - 1]) if closed else 0.0
                for i in range(n):
                    after = x[i + 1] if i + 1 < n else start
                    onward = link_rate[i] * (here - after) if i < segments else 0.0
                    x[i] = ground_rate[i] * here + force + onward
                    force, here = -onward, after
                if not closed:
                    for i in range(first):
                        x[i] = 0.0
                    for i in range(last + 1, n):
                        x[i] = 0.0
                for i in range(first, last):
                    x[i + 1] += ratio[i] * x[i]
                x[last] /= pivot[last]
                for i in range(last - 1, first - 1, -1):
                    x[i] = x[i] / pivot[i] + ratio[i] * x[i + 1]
                if closed:
                    x[0] = (x[0] + link[0] * x[first] + link[last] * x[last]) / ring_own
                    for i in range(first, last + 1):
                        x[i] += x[0] * image[i]
                if solutions + 1 < fewest:
                    continue
                largest = 0.0
                for i in range(n):
                    size = abs(x[i])
                    if size > largest:
                        largest = size
                for i in range(n):
                    x[i] /= largest
            # Rayleigh quotient
            energy = rate = 0.0
            for i in range(n):
                square = x[i] * x[i]
                energy += ground[i] * square
                rate += ground_rate[i] * square
            for i in range(segments):
                stretch = x[i] - x[i + 1 if i + 1 < n else 0]
                square = stretch * stretch
                energy += link[i] * square
                rate += link_rate[i] * square
            shift = energy / rate
            if low <= omega + shift <= high:
                break
        if not low <= omega + shift <= high:
            return nan
        omega += shift
        if abs(shift) <= CONVERGED * omega:
            scale = sqrt(2.0 / rate)
            for i in range(n):
                x[i] *= scale
            return omega
        # other modes lie beyond the interval: their share in the shape moves the quotient by shift^2/gap
        fewest = 1
        settled = shift * shift <= SETTLED * omega * min(omega - low, high - omega)
    return nan
