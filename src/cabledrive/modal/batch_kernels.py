"""Spectra of many short chains: the search, refinement and proof of `chain_modes`, each chain in one call.

A drive with two pulleys takes about thirty counts and a few inverse iterations for each mode, all on arrays
of at most six joints: as machine code some microseconds. What round-off clouds, and modes of multiplicity
above one, are left to the search in Python; nothing is listed here that is not proven by two counts.
"""

# mypy: allow-untyped-defs

from math import cos, floor, inf, pi, sqrt

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.chain import Array
from cabledrive.mechanics.compiled import for_kernels, njit_strict
from cabledrive.modal import polish_kernels
from cabledrive.modal.batch_counting_kernels import UNCLEAR, count_below

Whole = NDArray[np.int64]

ENCLOSURE = 1e-12
START, AGAIN = 2.0**-2, 2.0**-4
DEPTH = 200
"""Brackets that wait at most; bisection from the top goes no deeper."""
LEFT = -1
"""A chain that is left to the search in Python."""
FIRST = 0.13
"""Where the search begins, in half turns round the chain; not where one of equal spans vibrates alone."""

polish = njit_strict(polish_kernels.polish)


@njit_strict
@for_kernels
def split_segments(omega, times, masses, springs, joint, out):
    """Segments longer than 2 rad cut in two, as `split_at_antinodes` does, into the three rows of `out`.

    Returns number of segments, and where the joint of the pendant is.
    """
    put, place = 0, joint
    for i in range(times.size):
        if i == joint:
            place = put
        out[1, put], out[2, put] = masses[i], springs[i]
        phase = omega * times[i]
        if phase > 2.0:
            half_turns = floor(phase / pi + 0.5)
            first = (floor((half_turns - 1) / 2) + 0.5) * pi + (phase - half_turns * pi) / 2
            share = first / phase
            out[0, put], out[0, put + 1] = times[i] * share, times[i] * (1.0 - share)
            out[1, put + 1] = out[2, put + 1] = 0.0
            put += 2
        else:
            out[0, put] = times[i]
            put += 1
    if masses.size > times.size:
        out[1, put], out[2, put] = masses[times.size], springs[times.size]
        if joint == times.size:
            place = put
    return put, place


@njit_strict
@for_kernels
def refine(low, high, times, masses, springs, impedance, pendant, closed, split, work):
    """The one mode between two frequencies by inverse iteration; NaN where it loses its digits.

    A ring begins again at its next joint where need be.
    """
    middle = 0.5 * (low + high)
    spring, mass, held, joint = pendant
    segments, place = split_segments(middle, times, masses, springs, joint, split)
    joints = segments if closed else segments + 1
    first, last = (1 if closed else 0), joints - 1
    omega = np.nan
    for turn in range(2 if closed else 1):
        if turn:
            for row in range(3):
                start = split[row, 0]
                for i in range(segments - 1):
                    split[row, i] = split[row, i + 1]
                split[row, segments - 1] = start
            place = (place - 1) % segments
        x = work[7, :joints]
        for i in range(joints):
            x[i] = cos((1.0 + sqrt(2.0)) * (i + 1))
        scratch = (
            work[0, :joints],
            work[1, :joints],
            work[2, :joints],
            work[3, :joints],
            work[4, :joints],
            work[5, :joints],
            work[6, :joints],
        )
        omega = polish(
            middle,
            low,
            high,
            split[0, :segments],
            split[1, :joints],
            split[2, :joints],
            impedance,
            (spring, mass, held, place),
            closed,
            first,
            last,
            x,
            scratch,
        )
        if omega == omega:
            break
    return omega


@njit_strict
@for_kernels
def at_rest(low, high, time):
    """The mode of two equal spans that leaves both pulleys at rest, a multiple of half a turn each.

    Elimination loses its digits there: the middle of a span between pulleys at rest meets no stiffness.
    Returns a frequency between both, still to be proven, or NaN.
    """
    half_turns = floor(high * time / pi)
    omega = half_turns * pi / time
    return omega if half_turns >= 1.0 and omega >= low else np.nan


@njit_strict
@for_kernels
def first_modes(times, masses, springs, impedance, pendant, closed, rigid, omegas, cut, stack, split, work):
    """The first natural frequencies of one chain, each proven by counts at both sides [rad/s].

    ``omegas``, shape (wanted,): filled; ``stack``, shape (DEPTH, 4), ``split``, ``work``: scratch.
    Returns how many there are, or `LEFT`.
    """
    wanted, longest, total = omegas.size, 0.0, 0.0
    for i in range(times.size):
        total += times[i]
        longest = max(longest, times[i])
    top = FIRST * pi / total
    above = count_below(top, times, masses, springs, impedance, pendant, closed, cut)
    while above < rigid + wanted:
        if not top < inf:
            return LEFT
        top *= 2.0
        above = count_below(top, times, masses, springs, impedance, pendant, closed, cut)
    stack[0, 0], stack[0, 1], stack[0, 2], stack[0, 3] = 0.0, top, rigid, max(above, rigid)
    waiting, found = 1, 0
    while waiting and found < wanted:
        waiting -= 1
        low, high, below, beyond = stack[waiting, 0], stack[waiting, 1], stack[waiting, 2], stack[waiting, 3]
        if beyond == below:
            continue
        narrow = (high - low) * longest <= 0.5 or high * longest <= 2.0
        if narrow and beyond - below == 1.0:
            omega = proven_mode(
                low, high, below, times, masses, springs, impedance, pendant, closed, cut, split, work
            )
            if omega != omega:
                return LEFT
            omegas[found] = omega
            found += 1
            continue
        middle = 0.5 * (low + high)
        count = count_below(middle, times, masses, springs, impedance, pendant, closed, cut)
        if count == UNCLEAR or waiting + 2 > DEPTH or high - low <= 1e-9 * high:
            return LEFT  # two modes of one frequency, or nearly so
        here = min(max(float(count), below), beyond)
        stack[waiting, 0], stack[waiting, 1], stack[waiting, 2], stack[waiting, 3] = (
            middle,
            high,
            here,
            beyond,
        )
        waiting += 1
        stack[waiting, 0], stack[waiting, 1], stack[waiting, 2], stack[waiting, 3] = low, middle, below, here
        waiting += 1
    return found


@njit_strict
@for_kernels
def proven_mode(low, high, below, times, masses, springs, impedance, pendant, closed, cut, split, work):
    """The one mode of a bracket, proven by two counts; NaN where that does not succeed [rad/s]."""
    share = START
    while high - low > 1e-15 * high:
        width = share * (high - low)
        while high - low > max(min(width, 0.5 * high), 1e-15 * high):
            middle = 0.5 * (low + high)
            count = count_below(middle, times, masses, springs, impedance, pendant, closed, cut)
            if count == UNCLEAR:
                return np.nan
            if count > below:
                high = middle
            else:
                low = middle
        omega = refine(low, high, times, masses, springs, impedance, pendant, closed, split, work)
        if omega != omega and closed and times.size == 2 and times[0] == times[1]:
            omega = at_rest(low, high, times[0])
        if omega == omega:
            under = count_below(
                omega * (1.0 - ENCLOSURE), times, masses, springs, impedance, pendant, closed, cut
            )
            over = count_below(
                omega * (1.0 + ENCLOSURE), times, masses, springs, impedance, pendant, closed, cut
            )
            if under != UNCLEAR and under <= below and over >= below + 1:
                return omega
        share = AGAIN
    return np.nan


@njit_strict
def spectra(
    times: Array,
    masses: Array,
    springs: Array,
    impedance: Array,
    pendant: Array,
    joint: int,
    closed: bool,
    rigid: Whole,
    omegas: Array,
    found: Whole,
) -> None:
    """First modes of many chains.

    ``times``, shape (n, m) [s]; ``masses``, ``springs``, shape (n, j) [kg], [N/m]; ``impedance``, shape (n,)
    [kg/s]; ``pendant``, shape (n, 3): stiffness [N/m], mass [kg], stiffness to the ground [N/m]; ``joint``:
    where it hangs; ``rigid``, shape (n,): rigid-body modes; ``omegas``, shape (n, wanted): filled [rad/s];
    ``found``, shape (n,): how many modes are proven, or `LEFT`.
    """
    joints = 2 * masses.shape[1] + 1
    stack, split, work = np.empty((DEPTH, 4)), np.empty((3, joints)), np.empty((8, joints))
    cut = np.empty((3, masses.shape[1] + 2))
    for d in range(times.shape[0]):
        found[d] = first_modes(
            times[d],
            masses[d],
            springs[d],
            impedance[d],
            (pendant[d, 0], pendant[d, 1], pendant[d, 2], joint),
            closed,
            rigid[d],
            omegas[d],
            cut,
            stack,
            split,
            work,
        )
