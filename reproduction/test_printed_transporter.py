"""Section 3.3 of the dissertation: the carriage at midspan of Fig. 3.8; the lateral mode (3.29)-(3.35)."""

import mpmath as mp
import numpy as np
import pytest

EA, DENSITY, LENGTH, RADIUS, INERTIA = 2.6e9 * 4.26e-7, 4.9e-4, 1.0, 0.03, 7.316e-6  # configuration 1
PRETENSION = 5.0
STRETCH = 1 + PRETENSION / EA
LE, RHO, MODULUS = LENGTH * STRETCH, DENSITY / STRETCH, EA * STRETCH
C_U = np.sqrt(MODULUS / RHO)
OUT_OF_PHASE = 116.32932059  # Hz, the fundamental without a carriage


def at_the_carriage(frequency):
    """Displacement and slope at a midspan carriage in the modes that are even about it.

    From the middle of the lower span, where the slope is zero, over half a span, the pulley and half a span.
    """
    omega = 2 * mp.pi * frequency
    k = omega / C_U
    c, s = mp.cos(k * LE / 2), mp.sin(k * LE / 2)
    u, slope = c, -k * s
    slope -= omega**2 * INERTIA / RADIUS**2 / MODULUS * u
    return u * c + slope / k * s, -k * u * s + slope * c


def in_phase_frequency(chi_m):
    """Lowest frequency [Hz] of a carriage of chi_m times the cable's mass against both pulleys."""

    def balance(frequency):
        u, slope = at_the_carriage(frequency)
        return 2 * MODULUS * slope - (2 * mp.pi * frequency) ** 2 * chi_m * 2 * LE * RHO * u

    return float(mp.findroot(balance, (82, 700), solver="anderson", tol=1e-16))


def test_carriage_at_midspan_overtakes_the_fundamental_at_16_59():
    """`erratum-fig-3-8-midpoint`: at chi_m = 16.59 the in-phase mode becomes the lowest."""
    u, slope = at_the_carriage(OUT_OF_PHASE)
    carriage = 2 * MODULUS * slope / ((2 * mp.pi * OUT_OF_PHASE) ** 2 * u)
    crossing = float(carriage / (2 * LE * RHO))
    assert crossing == pytest.approx(16.59, abs=5e-3), f"crossing at chi_m = {crossing:.5f}"
    assert in_phase_frequency(16.0) > OUT_OF_PHASE > in_phase_frequency(17.0)


def test_heavy_carriage_at_midspan_is_not_equivalent_to_none(measured):
    """`erratum-fig-3-8-midpoint`: with chi_m = 50 at midspan the fundamental is 94.5 Hz, not 116.3 Hz."""
    found = in_phase_frequency(50.0)
    measured(f"fundamental at chi_m = 50, midspan: {found:.2f} Hz")
    assert found == pytest.approx(94.5, abs=0.05), f"{found:.4f} Hz"


def lateral_frequency(mass, left, right):
    """Exact lowest lateral frequency [Hz] of a point mass on a string with fixed ends."""
    c_w = np.sqrt(PRETENSION / RHO)
    bound = c_w / (2 * max(left, right))  # the longer part alone with its ends held

    def balance(frequency):
        omega = 2 * mp.pi * frequency
        k = omega / c_w
        return PRETENSION * k * (mp.cot(k * left) + mp.cot(k * right)) - mass * omega**2

    return float(mp.findroot(balance, (1e-6, bound * (1 - 1e-9)), solver="anderson", tol=1e-20))


def printed_lateral(mass, left, right):
    """Right side of (3.35)."""
    return np.sqrt(PRETENSION / mass * (1 / left + 1 / right)) / (2 * np.pi)


def test_right_side_of_3_35_is_a_frequency_in_hertz():
    """`erratum-3-35-hertz`: for a heavy mass it tends to the frequency, not to omega."""
    mass = 1e5 * RHO * LE
    exact, printed = (
        lateral_frequency(mass, 0.25 * LE, 0.75 * LE),
        printed_lateral(mass, 0.25 * LE, 0.75 * LE),
    )
    assert printed == pytest.approx(exact, rel=1e-5), f"{printed:.6f} against {exact:.6f} Hz"


@pytest.mark.parametrize("place", [0.25, 0.5])
@pytest.mark.parametrize("ratio", [10.0, 100.0])
def test_lateral_formula_neglects_a_third_of_the_cable(ratio, place):
    """`erratum-3-29-cable-mass`: (3.35) is high by rho Le/(6 m): 1.6 % at five loop masses."""
    mass = ratio * RHO * LE
    exact, printed = (f(mass, place * LE, (1 - place) * LE) for f in (lateral_frequency, printed_lateral))
    error = printed / exact - 1
    assert error == pytest.approx(1 / (6 * ratio), rel=0.05), f"(3.35) is high by {100 * error:.3f} %"
