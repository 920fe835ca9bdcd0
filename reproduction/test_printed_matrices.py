"""The printed matrices (3.13), (3.20), (3.26), (3.38) and the certified modes have the same zeros."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import minimize_scalar

from cabledrive.modal import longitudinal_modes, natural_frequencies
from cabledrive.parameters import Carriage, InputRefused, load_drive
from reproduction.printed_matrices import (
    line_with_carriage_matrix,
    loop_matrix,
    loop_with_carriage_matrix,
    loop_with_two_carriages_matrix,
)

LOOP = load_drive("dissertation-1")
HEAVY = load_drive("dissertation-2")
RIM = LOOP.drive_pulley.rim_mass
UPPER, LOWER = Carriage(mass=5e-3, position=0.3), Carriage(mass=1e-3, position=0.45, span="lower")
MIDSPANS = (
    Carriage(mass=RIM, position=0.5),
    Carriage(mass=RIM, position=0.5, span="lower"),
)
CASES = {
    "3.13": (loop_matrix, LOOP),
    "3.13 heavy": (loop_matrix, HEAVY),
    "3.20": (loop_with_carriage_matrix, replace(LOOP, carriage=[UPPER])),
    "3.20 heavy": (loop_with_carriage_matrix, replace(HEAVY, carriage=[UPPER])),
    "3.26": (line_with_carriage_matrix, replace(HEAVY, kind="line", carriage=[UPPER])),
    "3.38": (loop_with_two_carriages_matrix, replace(HEAVY, carriage=[UPPER, LOWER])),
    "3.38 square": (loop_with_two_carriages_matrix, replace(LOOP, carriage=MIDSPANS)),
}


def singular_values(matrix, drive, frequency):
    """Singular values with the columns and rows brought to one size, ascending."""
    a = matrix(drive, 2 * np.pi * frequency)
    a = a / np.linalg.norm(a, axis=1, keepdims=True)
    return np.linalg.svd(a / np.linalg.norm(a, axis=0), compute_uv=False)[::-1]


def zeros(matrix, drive, top):
    """Zeros of the smallest singular value up to a frequency [Hz], crossing or touching, on a fine grid."""
    grid = np.linspace(0.0, top, 6001)[1:]
    smallest = np.array([singular_values(matrix, drive, f)[0] for f in grid])
    found = []
    for i in np.flatnonzero((smallest[1:-1] <= smallest[:-2]) & (smallest[1:-1] < smallest[2:])) + 1:
        middle, step = grid[i], grid[1] - grid[0]
        best = minimize_scalar(
            lambda shift, middle=middle: singular_values(matrix, drive, middle + shift)[0],
            bounds=(-step, step),
            method="bounded",
            options={"xatol": 1e-10 * step},
        )
        if best.fun < 1e-7:
            found.append(middle + best.x)
    return np.array(found)


@pytest.mark.parametrize("case", CASES)
def test_printed_matrix_is_singular_at_every_certified_frequency_as_often_as_its_multiplicity(case, measured):
    matrix, drive = CASES[case]
    modes = longitudinal_modes(drive, count=12)
    spectra = [singular_values(matrix, drive, mode.frequency) for mode in modes]
    vanishing = max(v[mode.multiplicity - 1] for v, mode in zip(spectra, modes, strict=True))
    others = min(v[mode.multiplicity] for v, mode in zip(spectra, modes, strict=True))
    measured(f"singular values below {vanishing:.1e} at {len(modes)} modes, the others above {others:.1e}")
    for mode, values in zip(modes, spectra, strict=True):
        assert values[mode.multiplicity - 1] < 1e-11, f"{mode.frequency} Hz: {values}"
        assert values[mode.multiplicity] > 1e-6, f"{mode.frequency} Hz: {values}"


@pytest.mark.parametrize("case", CASES)
def test_certified_list_holds_every_zero_of_the_printed_matrix(case, measured):
    """Crossing and touching zeros alike, up to the tenth mode."""
    matrix, drive = CASES[case]
    *listed, beyond = (mode.frequency for mode in longitudinal_modes(drive, count=12))
    found = zeros(matrix, drive, 0.5 * (listed[-1] + beyond))
    measured(f"{found.size} zeros, {len(listed)} modes listed")
    assert found.size == len(listed), f"zeros {found} Hz, listed {listed} Hz"
    np.testing.assert_allclose(found, listed, rtol=1e-8)


def test_determinant_of_3_38_touches_zero_without_a_sign_change_where_the_ring_is_square(measured):
    """Two carriages as heavy as the rims, at both midspans: the ring looks alike from four sides.

    Modes that turn by a quarter of the ring come in pairs of one frequency; the determinant has a double zero
    there and keeps its sign, so that looking for sign changes finds one mode in three.
    """
    matrix, drive = CASES["3.38 square"]
    modes = longitudinal_modes(drive, count=12)
    grid = np.linspace(0.5, 0.5 * (modes[-2].frequency + modes[-1].frequency), 20_001)
    signs = np.sign([np.linalg.det(matrix(drive, 2 * np.pi * f)) for f in grid])
    changes = grid[np.flatnonzero(signs[:-1] != signs[1:])]
    double = [mode.frequency for mode in modes[:-1] if mode.multiplicity == 2]
    simple = [mode.frequency for mode in modes[:-1] if mode.multiplicity == 1]
    measured(f"{changes.size} changes of sign, {len(simple)} simple and {len(double)} double modes")
    assert double, "the square ring has double modes"
    np.testing.assert_allclose(changes, simple, atol=grid[1] - grid[0])


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
        matrix = loop_with_carriage_matrix if kind == "loop" else line_with_carriage_matrix
        for frequency in natural_frequencies(drive, count=5):
            smallest = singular_values(matrix, drive, frequency)[0]
            found.append(smallest)
            assert smallest < 1e-10, f"{frequency} Hz: {smallest:.1e}"

    check()
    measured(f"singular values below {max(found):.1e} at {len(found)} modes")


def test_rigidly_joined_motor_turns_with_the_drive_pulley():
    """J1 of the print is whatever turns with the drive pulley: (3.13) takes the motor's inertia with it."""
    motor = load_drive("dissertation-3").motor
    drive = replace(LOOP, motor=replace(motor, joint_stiffness=None))
    first = natural_frequencies(drive, count=1)[0]
    assert singular_values(loop_matrix, drive, first)[0] < 1e-11


@pytest.mark.parametrize(
    ("matrix", "drive", "reason"),
    [
        (loop_matrix, CASES["3.20"][1], "a loop with 1 and 0"),
        (loop_with_carriage_matrix, replace(LOOP, carriage=[LOWER]), "a loop with 0 and 1"),
        (line_with_carriage_matrix, CASES["3.20"][1], "is of a line"),
        (loop_matrix, load_drive("dissertation-3"), "flexible motor joint"),
        (loop_matrix, replace(LOOP, pulley=(LOOP.pulley[0], replace(LOOP.pulley[1], fixed=True))), "fixed"),
    ],
)
def test_printed_matrix_refuses_a_machine_it_does_not_describe(matrix, drive, reason):
    with pytest.raises(InputRefused, match=reason):
        matrix(drive, 100.0)
