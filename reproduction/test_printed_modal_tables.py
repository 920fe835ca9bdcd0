"""Tables 3.1 and 3.2 of the dissertation: the printed frequencies, their conventions, the omitted mode."""

import mpmath as mp
import numpy as np
import pytest

EA, AREA, DENSITY, LENGTH, RADIUS, PRETENSION = 2.6e9 * 4.26e-7, 4.26e-7, 4.9e-4, 1.0, 0.03, 5.0
LOAD = 7.316e-6
CONFIGURATIONS = {1: 7.316e-6, 2: 0.0011}  # J1
STRETCH = 1 + PRETENSION / EA


def out_of_phase(drive_inertia, c_u, length, density, count=2):
    """Lowest roots [Hz] of (3.13) in which the pulleys turn, to 30 digits; one in each (m pi, (m+1) pi)."""
    with mp.workdps(30):
        chi1, chi2 = (mp.mpf(J) / (2 * density * RADIUS**2 * length) for J in (drive_inertia, LOAD))

        def f(x):
            return (chi1 * chi2 * x**2 - 1) * mp.sin(x) - (chi1 + chi2) * x * mp.cos(x)

        small = mp.mpf("1e-9")
        roots = [
            mp.findroot(f, (m * mp.pi + small, (m + 1) * mp.pi - small), solver="anderson")
            for m in range(count)
        ]
        return [float(x * c_u / length / (2 * mp.pi)) for x in roots]


def conserved(pretension=PRETENSION):
    """Wave speed c_u, length and density of this project: density per unstretched metre, mass conserved."""
    stretch = 1 + pretension / EA
    return np.sqrt(EA * stretch / (DENSITY / stretch)), LENGTH * stretch, DENSITY / stretch


@pytest.mark.parametrize(
    ("configuration", "first", "third"), [(1, 116.32932059, 769.66140323), (2, 81.74207679, 760.86097349)]
)
def test_frequencies_of_configurations_1_and_2(configuration, first, third):
    """`convention-density`, `erratum-table-3-2-mixture`: 116.3293, 769.6614 Hz; 81.7421, 760.8610 Hz."""
    found = out_of_phase(CONFIGURATIONS[configuration], *conserved())
    np.testing.assert_allclose(found, [first, third], atol=6e-9, rtol=0)


@pytest.mark.parametrize("pretension", [0.5, 5.0, 50.0])
def test_longitudinal_modes_do_not_depend_on_the_pretension(pretension):
    """`convention-density`: c_u/Le = sqrt(EA/rho0)/L when the mass per unstretched metre is kept."""
    c_u, length, density = conserved(pretension)
    assert c_u / length == pytest.approx(np.sqrt(EA / DENSITY) / LENGTH, rel=1e-14)
    reference = out_of_phase(CONFIGURATIONS[2], *conserved())
    np.testing.assert_allclose(out_of_phase(CONFIGURATIONS[2], c_u, length, density), reference, rtol=1e-13)


@pytest.mark.parametrize(
    ("configuration", "computed", "printed"),
    [(1, (116.06, 766.28), ("116", "766")), (2, (81.55, 757.48), ("81.6", "757.5"))],
)
def test_printed_longitudinal_frequencies_mix_two_conventions(configuration, computed, printed):
    """`erratum-table-3-2-mixture`: c_u = sqrt(EA/rho) of (2.31) beside Le gives the printed digits."""
    found = out_of_phase(CONFIGURATIONS[configuration], np.sqrt(EA / DENSITY), LENGTH * STRETCH, DENSITY)
    np.testing.assert_allclose(found, computed, atol=5e-3)
    digits = [len(text.partition(".")[2]) for text in printed]
    rounded = [f"{value:.{n}f}" for value, n in zip(found, digits, strict=True)]
    assert tuple(rounded) == printed, f"{found} Hz"


@pytest.mark.parametrize(
    ("reading", "c_u", "length", "density"),
    [
        ("(2.15) and Le, rho kept", np.sqrt(EA * STRETCH / DENSITY), LENGTH * STRETCH, DENSITY),
        ("(2.15) and L", np.sqrt(EA * STRETCH / DENSITY), LENGTH, DENSITY),
        ("mass conserved", *conserved()),
    ],
)
def test_no_single_convention_prints_table_3_2(reading, c_u, length, density):
    """`erratum-table-3-2-mixture`: each consistent reading misses a printed longitudinal frequency."""
    found = [
        *out_of_phase(CONFIGURATIONS[1], c_u, length, density),
        *out_of_phase(CONFIGURATIONS[2], c_u, length, density),
    ]
    printed, half_digit = np.array([116, 766, 81.6, 757.5]), np.array([0.5, 0.5, 0.05, 0.05])
    assert (np.abs(np.array(found) - printed) > half_digit).any(), f"{reading}: {found}"


def test_in_phase_mode_is_a_zero_of_the_determinant():
    """`erratum-table-3-2-in-phase`: at sin(omega Le/c_u) = 0, 751.73 Hz, the pulleys are at rest.

    This mode lies between the two printed ones of both configurations; its rim amplitudes a1, a2 are zero.
    """
    c_u, length, density = conserved()
    frequency = c_u / (2 * length)
    assert frequency == pytest.approx(751.7327, abs=5e-5), f"{frequency:.5f} Hz"
    for inertia in CONFIGURATIONS.values():
        omega = 2 * np.pi * frequency
        s, c = np.sin(omega * length / c_u), np.cos(omega * length / c_u)
        m1, m2 = (J * omega / (c_u * density * RADIUS**2) for J in (inertia, LOAD))
        matrix = np.array([[m1, s, 1, -c], [s, m2, -c, 1], [1, -c, 0, -s], [-c, 1, -s, 0]])
        _, singular, rows = np.linalg.svd(matrix)
        a1, a2, b1, b2 = rows[-1]
        assert singular[-1] < 1e-13 * singular[0], f"singular values {singular}"
        assert abs(a1) + abs(a2) < 1e-12 * abs(b1), f"rim amplitudes {a1:.1e}, {a2:.1e}"
        assert b1 == pytest.approx(-b2), "in space both spans move alike: U2 is counted along -X1"
        first, third = out_of_phase(inertia, c_u, length, density)
        assert first < frequency < third


def test_rigid_support_frequency_needs_unrounded_parameters():
    """`erratum-table-3-2-rigid-supports`: the printed parameters give 751.73 or 753.43 Hz, not 751.8.

    The second is (3.14a) to the letter. sqrt(E/1150 kg/m^3)/(2 L), nylon at its usual density, is 751.81 Hz,
    and 1150 A rounds to the printed rho.
    """
    assert np.sqrt(EA / DENSITY) / (2 * LENGTH) == pytest.approx(751.7327, abs=5e-5)
    assert np.sqrt(EA * STRETCH / DENSITY) / (2 * LENGTH) == pytest.approx(753.4275, abs=5e-5)
    nylon = np.sqrt(2.6e9 / 1150.0) / (2 * LENGTH)
    assert f"{nylon:.1f}" == "751.8", f"{nylon:.4f} Hz"
    assert f"{1150.0 * AREA:.1e}" == "4.9e-04"


@pytest.mark.parametrize(
    ("stretched", "mass_kept", "tuned"), [(True, True, 3.28377), (False, False, 3.274), (True, False, 3.293)]
)
def test_tuned_pretension_of_configuration_2(stretched, mass_kept, tuned):
    """`convention-density`, `number-frequency-ratio`: 3.28377 N; 3.274 unstretched, 3.293 with rho kept."""

    def detuning(pretension):
        stretch = 1 + pretension / EA if stretched else mp.mpf(1)
        density, length = DENSITY / (stretch if mass_kept else 1), LENGTH * stretch
        first = out_of_phase(CONFIGURATIONS[2], mp.sqrt(EA * stretch / density), length, density, count=1)[0]
        return mp.sqrt(pretension / density) / (2 * length) / first - 0.5

    pretension = float(mp.findroot(detuning, (3.0, 3.5), solver="anderson", tol=1e-12))
    half_digit = 0.5 * 10 ** -len(str(tuned).partition(".")[2])
    assert abs(pretension - tuned) <= half_digit, f"{pretension:.7f} N"


def test_pulley_adds_little_to_the_motor_in_configuration_2():
    """`erratum-table-3-1-drive-inertia`: J1 = 0.0011 is J11 of Table 4.2; the 3 cm pulley would add 0.7 %."""
    motor, pulley = CONFIGURATIONS[2], CONFIGURATIONS[1]
    assert pulley / motor == pytest.approx(0.00665, abs=5e-6)
    without, with_pulley = (out_of_phase(J, *conserved(), count=1)[0] for J in (motor, motor + pulley))
    change = with_pulley - without
    assert change == pytest.approx(-0.00193, abs=5e-6), f"the first frequency moves by {change:.5f} Hz"
