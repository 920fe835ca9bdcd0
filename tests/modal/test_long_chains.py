"""Strings of a thousand carriages: what round-off leaves of frequencies and counts, against sixty digits."""

import mpmath as mp
import numpy as np
import pytest

from cabledrive.mechanics.chain import Chain, own_chain
from cabledrive.modal.networks import network_of_chain
from cabledrive.modal.rows import lanes_at

CARRIAGES = 1000
FIRST = 12


def chain(closed, seed, carriages=CARRIAGES):
    """Lengths and masses spread over one decade and two, the carriages between two pulleys."""
    rng = np.random.default_rng(seed)
    joints = carriages + 2
    return Chain(
        rigidity=2.3,
        density=0.7,
        lengths=rng.uniform(0.2, 1.8, joints if closed else joints - 1),
        masses=rng.uniform(0.1, 10.0, joints),
        closed=closed,
    )


def first_modes(given):
    component = component_of(given)
    top = np.pi / given.travel_times.sum()
    while component.count(top) < FIRST:
        top *= 1.5
    return [own for _, own in component.modes(0.0, top)][:FIRST]


def component_of(given):
    (component,), _ = network_of_chain(own_chain(given)).components()
    return component


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


@pytest.mark.parametrize("closed", [False, True], ids=["line", "ring"])
@pytest.mark.parametrize("carriages", [CARRIAGES, pytest.param(10 * CARRIAGES, marks=pytest.mark.verify)])
def test_frequencies_of_thousands_of_carriages_are_right_to_the_last_digits(carriages, closed, measured):
    """Low modes of a long chain lose nothing: nothing large cancels in the form of links and grounds."""
    given = chain(closed, 0, carriages)
    modes = first_modes(given)
    with mp.workdps(60):
        value = condition(given)
        exact = [refined(value, mode.omega) for mode in (modes[0], modes[-1])]
        errors = [float(abs(m.omega / e - 1)) for m, e in zip((modes[0], modes[-1]), exact, strict=True)]
    measured(f"relative error {errors[0]:.1e} of the first mode, {errors[1]:.1e} of mode {len(modes)}")
    for error in errors:
        assert error < 2e-14, f"relative error {error:.1e}"


@pytest.mark.parametrize(("closed", "clear"), [(False, 1e-12), (True, 2e-12)])
def test_count_of_a_thousand_carriages_is_right_so_close_to_a_mode(closed, clear, measured):
    """On either side of each mode, as close as the enclosure; a band holds sums of links and grounds."""
    wrong, counts = [], 0
    for seed in range(1):
        given = chain(closed, seed)
        component, below = component_of(given), 1
        for mode in first_modes(given):
            assert mode.enclosure is not None
            for distance in np.geomspace(clear, 1e-9, 9):
                at = lanes_at([mode.omega * (1 - distance), mode.omega * (1 + distance)])
                sides = tuple(component.cut(2 * mode.omega).counted(at))
                counts += 2
                if sides != (below, below + mode.multiplicity):
                    wrong.append(f"{sides} at {distance:.1e} of {mode.omega}")
            below += mode.multiplicity
    measured(f"{len(wrong)} wrong of {counts} counts as close as {clear:.0e}")
    assert not wrong, "\n".join(wrong)
