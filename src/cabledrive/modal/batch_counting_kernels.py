"""The count of modes below a frequency in machine code, a ring cut elsewhere where round-off clouds it."""

# mypy: allow-untyped-defs

import numpy as np

from cabledrive.mechanics.compiled import for_kernels, njit_strict
from cabledrive.modal import counting_kernels
from cabledrive.modal.counting import CUT_SHARES as SHARES

CLEAR = 1e-13
"""Distance of a count from round-off, as in `cabledrive.modal.counting`: below, the ring is cut elsewhere."""
CERTAIN = 1e-14
"""Where no cut is clear, the clearest count stands from here on; the search of one chain takes any."""
UNCLEAR = -1
CUT_SHARES = np.array(SHARES)

count_line = njit_strict(counting_kernels.count_line)
count_ring = njit_strict(counting_kernels.count_ring)


@njit_strict
@for_kernels
def other_cut(joints):
    """Segment of the second cut of a ring that is cut inside its segments."""
    return max(1, int(0.38 * joints + 0.5))


@njit_strict
@for_kernels
def cut_ring(times, masses, springs, joint, shares, cut):
    """The ring cut inside two segments, into the three rows of `cut`, as `cabledrive.modal.counting` does.

    Returns where the joint of the pendant is.
    """
    n, other, put = masses.size, other_cut(masses.size), 0
    cut[0, 0], cut[1, 0], cut[2, 0] = (1.0 - shares[0]) * times[0], 0.0, 0.0
    place = 0
    for i in range(1, n + 1):
        put += 1
        at = i % n
        cut[1, put], cut[2, put] = masses[at], springs[at]
        if at == joint:
            place = put
        if at == 0:
            cut[0, put] = shares[0] * times[0]
        elif i == other:
            cut[0, put] = shares[1] * times[i]
            put += 1
            cut[0, put], cut[1, put], cut[2, put] = (1.0 - shares[1]) * times[i], 0.0, 0.0
        else:
            cut[0, put] = times[i]
    return place


@njit_strict
@for_kernels
def count_below(omega, times, masses, springs, impedance, pendant, closed, cut):
    """Modes below omega, `UNCLEAR` where round-off clouds the count of a ring at every cut.

    ``pendant``: stiffness, mass, stiffness to the ground, joint; ``cut``: scratch.
    """
    spring, mass, held, joint = pendant
    if not closed:
        return count_line(omega, times, masses, springs, impedance, spring, mass, held, joint, False, False)
    second = (masses.size + 1) // 2
    best, clearest = count_ring(omega, times, masses, springs, impedance, spring, mass, held, joint, second)
    for number in range(CUT_SHARES.shape[0]):
        if clearest > CLEAR:
            return best
        place = cut_ring(times, masses, springs, joint, CUT_SHARES[number], cut)
        found, margin = count_ring(
            omega, cut[0], cut[1], cut[2], impedance, spring, mass, held, place, other_cut(masses.size) + 1
        )
        if margin > clearest:
            best, clearest = found, margin
    return best if clearest > CERTAIN else UNCLEAR
