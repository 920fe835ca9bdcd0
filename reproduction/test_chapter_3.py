"""Chapter 3: Table 3.2 and its conventions, the printed matrices, a hanging mass, modes followed."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import brentq, minimize_scalar

from cabledrive.modal import modes as natural_modes
from cabledrive.modal.natural import longitudinal_modes, natural_frequencies
from cabledrive.parameters import Carriage, InputRefused, load_drive
from cabledrive.parameters.keys import varied_together
from cabledrive.studies import frequency_against
from cabledrive.studies.following import mass_weighted_shapes
from reproduction.drives import packaged
from reproduction.expanded_equations import lateral_frequency
from reproduction.oracles import (
    DENSITY,
    DRIVES,
    EA,
    LENGTH,
    LOAD,
    PRETENSION,
    RADIUS,
    out_of_phase,
    stretched,
)
from reproduction.printed_matrices import line_with_carriage_matrix, modal_matrix

STRETCH = 1 + PRETENSION / EA
PRINTED, HALF_DIGITS = np.array([116, 766, 81.6, 757.5]), np.array([0.5, 0.5, 0.05, 0.05])


def table_3_2(length, density, c_u):
    return np.array([out_of_phase(inertia, length, density, c_u) for inertia in DRIVES.values()]).ravel()


@pytest.mark.parametrize("pretension", [0.5, 5.0, 50.0])
def test_longitudinal_modes_do_not_depend_on_the_pretension(pretension):
    """`convention-density`, `erratum-table-3-2-mixture`: 116.3293, 769.6614 Hz; 81.7421, 760.8610 Hz."""
    found = table_3_2(*stretched(pretension)[:3])
    np.testing.assert_allclose(found, [116.32932059, 769.66140323, 81.74207679, 760.86097349], rtol=1e-10)


def test_only_a_mixture_of_two_conventions_prints_table_3_2():
    """`erratum-table-3-2-mixture`: c_u of (2.31) beside Le; no consistent reading has all four."""
    c_u, kept = np.sqrt(EA / DENSITY), np.sqrt(EA * STRETCH / DENSITY)
    mixed = table_3_2(LENGTH * STRETCH, DENSITY, c_u)
    np.testing.assert_allclose(mixed, [116.06, 766.28, 81.55, 757.48], atol=5e-3)
    assert (np.abs(mixed - PRINTED) <= HALF_DIGITS).all()
    for reading in ((LENGTH * STRETCH, DENSITY, kept), (LENGTH, DENSITY, kept), stretched()[:3]):
        assert (np.abs(table_3_2(*reading) - PRINTED) > HALF_DIGITS).any(), f"{reading}"


@pytest.mark.parametrize(
    ("length_grows", "mass_kept", "tuned"),
    [(True, True, 3.28377), (False, False, 3.274), (True, False, 3.293)],
)
def test_tuned_pretension_of_configuration_2(length_grows, mass_kept, tuned):
    """`convention-density`, `number-frequency-ratio`: 3.28377 N; 3.274 unstretched, 3.293 with rho kept."""

    def detuning(pretension):
        stretch = 1 + pretension / EA if length_grows else 1.0
        density, length = DENSITY / (stretch if mass_kept else 1), LENGTH * stretch
        (first,) = out_of_phase(DRIVES[2], length, density, np.sqrt(EA * stretch / density), count=1)
        return np.sqrt(pretension / density) / (2 * length) / first - 0.5

    half_digit = 0.5 * 10 ** -len(str(tuned).partition(".")[2])
    assert brentq(detuning, 2.0, 5.0, xtol=1e-12) == pytest.approx(tuned, abs=half_digit)


# --- the printed matrices and the certified modes have the same zeros -------------------------------------

LOOP, HEAVY = packaged("dissertation-1"), packaged("dissertation-2")
RIM = LOOP.drive_pulley.rim_mass
UPPER, LOWER = Carriage(mass=5e-3, position=0.3), Carriage(mass=1e-3, position=0.45, span="lower")
MIDSPANS = (Carriage(mass=RIM, position=0.5), Carriage(mass=RIM, position=0.5, span="lower"))
SQUARE = replace(LOOP, carriage=MIDSPANS)
CASES = {
    "3.13": LOOP,
    "3.13 heavy": HEAVY,
    "3.20": replace(LOOP, carriage=[UPPER]),
    "3.20 heavy": replace(HEAVY, carriage=[UPPER]),
    "3.26": replace(HEAVY, kind="line", carriage=[UPPER]),
    "3.38": replace(HEAVY, carriage=[UPPER, LOWER]),
    "3.38 square": SQUARE,
}


def singular_values(drive, frequency):
    """Singular values with the columns and rows brought to one size, ascending."""
    a = modal_matrix(drive, 2 * np.pi * frequency)
    a = a / np.linalg.norm(a, axis=1, keepdims=True)
    return np.linalg.svd(a / np.linalg.norm(a, axis=0), compute_uv=False)[::-1]


def zeros(drive, top):
    """Zeros of the smallest singular value up to a frequency [Hz], crossing or touching, on a fine grid."""
    grid = np.linspace(0.0, top, 6001)[1:]
    smallest = np.array([singular_values(drive, f)[0] for f in grid])
    found, step = [], grid[1]
    for i in np.flatnonzero((smallest[1:-1] <= smallest[:-2]) & (smallest[1:-1] < smallest[2:])) + 1:
        best = minimize_scalar(
            lambda shift, middle=grid[i]: singular_values(drive, middle + shift)[0],
            bounds=(-step, step),
            method="bounded",
            options={"xatol": 1e-10 * step},
        )
        if best.fun < 1e-7:
            found.append(grid[i] + best.x)
    return np.array(found)


@pytest.mark.parametrize("case", CASES)
def test_printed_matrices_and_certified_modes_have_the_same_zeros(case, measured):
    """`confirmed-3-13-modal-matrices`, `erratum-3-38-inertia-entries`: as often, no more and no less."""
    drive = CASES[case]
    modes = longitudinal_modes(drive, count=12, taut=True)
    spectra = [(mode.multiplicity, singular_values(drive, mode.frequency)) for mode in modes]
    vanishing, others = max(v[n - 1] for n, v in spectra), min(v[n] for n, v in spectra)
    *listed, beyond = (mode.frequency for mode in modes)
    found = zeros(drive, 0.5 * (listed[-1] + beyond))
    measured(f"singular values below {vanishing:.1e}, others above {others:.1e}; {found.size} zeros")
    assert vanishing < 1e-11
    assert others > 1e-6
    assert found.size == len(listed), f"zeros {found} Hz, listed {listed} Hz"
    np.testing.assert_allclose(found, listed, rtol=1e-8)


def test_printed_matrices_are_singular_at_the_modes_of_any_machine(measured):
    """(3.20) and (3.26) over three decades of carriage and four of pulley."""
    found = []

    @given(
        mass=st.floats(1e-4, 1.0),
        place=st.floats(0.05, 0.95),
        inertias=st.tuples(st.floats(1e-6, 1e-2), st.floats(1e-6, 1e-2)),
        kind=st.sampled_from(["loop", "line"]),
    )
    def check(mass, place, inertias, kind):
        pulleys = [replace(pulley, inertia=j) for pulley, j in zip(LOOP.pulley, inertias, strict=True)]
        drive = replace(LOOP, kind=kind, pulley=pulleys, carriage=[Carriage(mass=mass, position=place)])
        for frequency in natural_frequencies(drive, count=5, taut=True):
            found.append(singular_values(drive, frequency)[0])
            assert found[-1] < 1e-10, f"{frequency} Hz: {found[-1]:.1e}"

    check()
    measured(f"singular values below {max(found):.1e} at {len(found)} modes")


def test_a_machine_without_a_printed_matrix_is_refused():
    held = replace(LOOP, pulley=(LOOP.pulley[0], replace(LOOP.pulley[1], fixed=True)))
    other = replace(LOOP, carriage=[LOWER]), replace(LOOP, kind="line"), packaged("dissertation-3"), held
    for drive in other:
        with pytest.raises(InputRefused, match="no matrix is printed"):
            modal_matrix(drive, 100.0)


def test_matrices_follow_from_boundary_conditions_with_the_stretched_rigidity():
    """`erratum-3-16-rigidity`: with EA, masses weigh 1 + eps0 as much, the frequency falls by eps0/2."""
    heavier = [replace(pulley, inertia=STRETCH * pulley.inertia) for pulley in HEAVY.pulley]
    first, lower = (
        natural_frequencies(replace(HEAVY, pulley=p), count=1, taut=True)[0] for p in (HEAVY.pulley, heavier)
    )
    assert lower / first == pytest.approx(1 - (STRETCH - 1) / 2, abs=2e-4)


def test_load_pulley_of_the_open_line_hangs_on_the_end_of_span_2():
    """`erratum-3-22-load-pulley`: (3.26) has it right; with the printed sign no zero is a mode."""
    modes = natural_frequencies(CASES["3.26"], count=3, taut=True)

    def determinant(frequency, sign):
        omega = 2 * np.pi * frequency
        phase = omega * np.array([0.3, 0.7]) * np.sqrt(DENSITY / EA)
        masses = omega * np.array([DRIVES[2] / RADIUS**2, UPPER.mass, sign * LOAD / RADIUS**2])
        matrix = line_with_carriage_matrix(np.sin(phase), np.cos(phase), masses / np.sqrt(EA * DENSITY))
        return np.linalg.det(matrix)

    assert abs(determinant(modes[0], 1)) < 1e-9
    grid = np.linspace(1.0, modes[2], 4001)
    signs = np.sign([determinant(f, -1) for f in grid])
    wrong = grid[np.flatnonzero(signs[:-1] != signs[1:])]
    assert np.abs(wrong[0] / modes - 1).min() > 1e-2, f"lowest zero {wrong[0]:.3f} Hz, modes {modes} Hz"


# --- a mass that hangs on the cable -----------------------------------------------------------------------


def hung(mass, position=0.25):
    still = replace(LOOP, layout=replace(LOOP.layout, gravity=0.0))
    return replace(still, carriage=[Carriage(mass=mass, position=position, guided=False)])


@pytest.mark.parametrize("position", [0.5, 0.25, 0.03])
def test_error_of_3_35_vanishes_with_the_mass_of_the_cable(position):
    """`erratum-3-29-cable-mass`, `erratum-3-35-hertz`: in Hz, high by a sixth of the mass ratio."""
    masses, pieces = np.array([0.01, 0.1, 1.0]), (position * STRETCH, (LENGTH - position) * STRETCH)
    cable, ratio = DENSITY * LENGTH, DENSITY * LENGTH / masses
    true = np.array([natural_modes(hung(mass, position), count=2).transverse[0].frequency for mass in masses])
    first, second = (
        np.array([lateral_frequency(mass, PRETENSION, *pieces, own) for mass in masses]) / true - 1
        for own in (0.0, cable)
    )
    assert np.all(np.abs(first / ratio - 1 / 6) < 0.5 * ratio), f"error / mass ratio {first / ratio}"
    assert np.polyfit(np.log(ratio), np.log(second), 1)[0] == pytest.approx(2.0, abs=0.05)


TRANSPORTER = packaged("dissertation-transporter")


def test_slopes_at_a_carriage_jump_by_its_inertia():
    """EA (u'(+) - u'(-)) = -m omega^2 u: the boundary condition (3.16a)."""
    for mode in longitudinal_modes(hung(0.01, 0.3), count=8, taut=True):
        waves = [own for own in mode.slope_waves() if own.span == "upper"]
        i = next(i for i, own in enumerate(waves) if np.isclose(own.start, 0.3))
        before, after = EA * waves[i - 1].slope_at(waves[i].start).real, EA * waves[i].slope.real
        force = -0.01 * (2 * np.pi * mode.frequency) ** 2 * mode.joints["carriage 0"][0]
        assert after - before == pytest.approx(force, abs=1e-9 * (abs(after) + abs(before)))


# --- modes followed along any figure of the drive: nothing missed, curves followed by their shapes --------


@pytest.mark.parametrize(
    ("name", "key", "values"),
    [
        ("dissertation-1", "pulley.0.inertia", np.geomspace(1e-7, 1e-2, 9)),
        ("dissertation-2", "pulley.1.inertia", np.geomspace(1e-7, 1e-2, 9)),
        ("dissertation-transporter", "carriage.0.position", np.linspace(0.02, 0.98, 11)),
        ("dissertation-transporter", "carriage.0.mass", np.geomspace(1e-5, 1.0, 9)),
        ("dissertation-3", "motor.joint_stiffness", np.geomspace(1.0, 1e5, 9)),
        ("printer-belt", "carriage.0.position", np.linspace(0.02, 0.28, 15)),
        ("camera-line", "carriage.0.position", np.linspace(2.0, 36.0, 9)),
        ("elevator", "carriage.0.mass", np.linspace(300.0, 900.0, 7)),
    ],
)
def test_curves_hold_the_lowest_modes_at_every_value(name, key, values):
    """Sorted, the followed curves are the certified list, whatever crosses on the way."""
    drive = load_drive(name)
    data = frequency_against(drive, key, values, modes=4)
    for value in values:
        listed = natural_frequencies(varied_together(drive, {key: value}), count=4, taut=True)[:4]
        np.testing.assert_allclose(np.sort(data.frequency.sel(value=value).values)[:4], listed, rtol=1e-11)


@pytest.mark.parametrize("points", [2, 3, 40])
def test_modes_of_a_symmetric_loop_cross_whatever_the_values_are(points, measured):
    """`erratum-fig-3-8-midpoint`: a mass at midspan takes the in-phase mode below the other at 2 J/r^2."""
    drive = replace(LOOP, carriage=[Carriage(mass=2 * RIM, position=0.5)])
    data = frequency_against(drive, "carriage.0.mass", np.geomspace(2e-4, 0.2, points), modes=2)
    (place,), (frequency,) = data.crossing_value.values, data.crossing_frequency.values
    measured(f"crossing at chi_m = {place / (2 * LENGTH * DENSITY):.4f}")
    assert data.crossing_kind.values == ["crossing"]
    assert place == pytest.approx(2 * RIM, rel=1e-7)
    assert place / (2 * LENGTH * DENSITY) == pytest.approx(16.59, abs=5e-3)
    assert frequency == pytest.approx(116.32932059, rel=1e-8)
    np.testing.assert_allclose(data.frequency[0], 116.32932059254597, rtol=1e-11)
    assert np.all(np.diff(data.frequency.values[1]) < 0)


def test_mass_weighted_shapes_of_one_drive_are_orthonormal():
    """Kinetic energy of two different modes does not mix; what is left is the width of the cells."""
    found = longitudinal_modes(TRANSPORTER, count=6, taut=True)
    shapes = mass_weighted_shapes(TRANSPORTER.machine, found, 512)
    assert np.abs(shapes.T @ shapes - np.eye(6)).max() < 1e-4


REFUSED = {
    "did you mean": ("pulley.0.inertai", [1e-6]),
    "numbered from 0": ("pulley.2.inertia", [1e-6]),
    r"no \[motor\]": ("motor.inertia", [1e-3]),
    "not a quantity": ("kind", [1.0]),
    "must be above 0": ("pulley.0.inertia", [1e-6, -1e-6]),
    "finite": ("pulley.0.inertia", [float("nan")]),
    "finite numbers": ("pulley.0.inertia", []),
}


@pytest.mark.parametrize("reason", REFUSED)
def test_what_cannot_be_varied_is_refused(reason):
    with pytest.raises(InputRefused, match=reason):
        frequency_against(LOOP, *REFUSED[reason])
