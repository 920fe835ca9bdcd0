"""Strings of a thousand carriages: what round-off leaves of frequencies and counts, against sixty digits."""

import mpmath as mp
import numpy as np
import pytest

from cabledrive.mechanics.chain import Chain
from cabledrive.modes.counting import ModeCounter
from cabledrive.modes.solver import chain_modes

CARRIAGES = 1000
FIRST = 12


def chain(closed, seed):
    """Lengths and masses spread over one decade and two, a thousand carriages between two pulleys."""
    rng = np.random.default_rng(seed)
    joints = CARRIAGES + 2
    return Chain(
        rigidity=2.3,
        density=0.7,
        lengths=rng.uniform(0.2, 1.8, joints if closed else joints - 1),
        masses=rng.uniform(0.1, 10.0, joints),
        closed=closed,
    )


def first_modes(given):
    count = ModeCounter(given)
    top = np.pi / given.travel_times.sum()
    while count(top) < FIRST + 2:
        top *= 1.5
    return chain_modes(given, top, first=FIRST)


def condition(given):
    """What vanishes at the natural frequencies, by transfer matrices in sixty digits."""
    rigidity = mp.mpf(given.rigidity)
    speed = mp.sqrt(rigidity / mp.mpf(given.density))
    lengths, masses = ([mp.mpf(float(x)) for x in array] for array in (given.lengths, given.masses))

    def value(omega):
        k = omega / speed
        state = mp.matrix([[1, 0], [0, 1]]) if given.closed else mp.matrix([[1], [0]])
        for length, mass in zip(lengths, masses, strict=False):
            s, c = mp.sin(k * length), mp.cos(k * length)
            for column in range(state.cols):
                u, force = state[0, column], state[1, column] - omega**2 * mass * state[0, column]
                state[0, column] = c * u + s / (rigidity * k) * force
                state[1, column] = -rigidity * k * s * u + c * force
        if given.closed:
            return state[0, 0] + state[1, 1] - 2
        return state[1, 0] - omega**2 * masses[-1] * state[0, 0]

    return value


def refined(value, omega):
    """Secant steps from the double's value."""
    a, b = mp.mpf(omega) * (1 + mp.mpf(10) ** -11), mp.mpf(omega)
    fa, fb = value(a), value(b)
    for _ in range(4):
        a, fa, b = b, fb, b - fb * (b - a) / (fb - fa)
        if abs(b - a) < mp.mpf(10) ** -25 * b:
            break
        fb = value(b)
    return b


@pytest.mark.parametrize("closed", [False, True])
def test_frequencies_of_a_thousand_carriages_are_right_to_the_last_digits(closed):
    """Low modes of a long chain lose nothing: nothing large cancels in the form of links and grounds."""
    given = chain(closed, seed=0)
    modes = first_modes(given)
    with mp.workdps(60):
        value = condition(given)
        for mode in (modes[0], modes[-1]):
            exact = refined(value, mode.omega)
            error = float(abs(mode.omega - exact) / exact)
            assert error < 2e-14, f"relative error {error:.1e}"


@pytest.mark.parametrize(("closed", "clear"), [(False, 2e-14), (True, 2e-12)])
def test_count_of_a_thousand_carriages_is_right_so_close_to_a_mode(closed, clear):
    """On either side of each mode; elimination round the ring loses a digit or two that a line keeps."""
    for seed in range(3):
        given = chain(closed, seed)
        count = ModeCounter(given)
        below = 1
        for mode in first_modes(given):
            assert mode.proven
            for distance in np.geomspace(clear, 1e-9, 25):
                sides = count(mode.omega * (1 - distance)), count(mode.omega * (1 + distance))
                assert sides == (below, below + mode.multiplicity), f"at {distance:.1e} of {mode.omega}"
            below += mode.multiplicity
