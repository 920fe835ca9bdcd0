"""Transverse modes under the tension that is there, against closed forms and finite elements of the rest."""

from functools import partial
from itertools import pairwise
from math import pi, radians, sqrt

import numpy as np
import pytest
from numpy.testing import assert_allclose
from parts import by_multiplicity
from scipy.linalg import eigh
from scipy.optimize import brentq
from scipy.special import j0, j1, y0, y1

import cabledrive as cd
from cable_elements import Model, random_machine
from cabledrive.mechanics.cable_laws import cable_law
from cabledrive.mechanics.mesh import gradients, mesh_of
from cabledrive.mechanics.statics import equilibrium
from cabledrive.modal.component import Component, Fixed
from cabledrive.modal.elements import ACROSS, Rope
from cabledrive.modal.rows import MASS
from cabledrive.parameters import Cable, Drive, InputRefused, Layout, NotComputed, Pulley, packaged_drives

G = 9.81


def test_hanging_rope_has_the_waves_of_bessel(measured):
    """80 m of 0.22 kg/m with 300 N below: 0.26008, 0.52041, 0.78068 Hz, the roots of J0 Y0 - J0 Y0."""
    mean = 300.0 + 0.22 * G * 40.0
    rope = Drive(
        name="rope",
        kind="line",
        cable=Cable(given_rigidity=1e13, mass_per_length=0.22, pretension=mean),
        layout=Layout(span_length=80.0, gravity=G, inclination=radians(-90)),
        pulley=(Pulley(radius=0.1, inertia=0.01, fixed=True),) * 2,
    )
    listed = cd.modes(rope, count=12).transverse
    found = np.array([mode.frequency for mode in listed if mode.plane == "w"][:3])
    ends = [2 * sqrt(tension / 0.22) / G for tension in (300.0, 300.0 + 0.22 * G * 80.0)]

    def determinant(omega):
        a, b = (omega * end for end in ends)
        return j0(a) * y0(b) - j0(b) * y0(a)

    exact = [brentq(determinant, 2 * pi * f * (1 - 1e-3), 2 * pi * f * (1 + 1e-3), xtol=1e-15) for f in found]
    error = np.abs(2 * pi * found / exact - 1).max()
    measured(f"{', '.join(f'{f:.5f}' for f in found)} Hz, relative error {error:.1e}")
    assert_allclose(found, [0.26008, 0.52041, 0.78068], atol=5e-6)
    assert error < 1e-10, f"relative error {error:.2e}"
    assert {mode.model for mode in listed} == {"heavy string"}


def random_rope(rng):
    """A vertical rope with up to three weights, its tension by plain statics, and its exact determinant."""
    density, length, low = 10 ** rng.uniform(-2, 1), 10 ** rng.uniform(0, 3), 10 ** rng.uniform(1, 4)
    places = np.sort(rng.uniform(0.05, 0.95, rng.integers(0, 4))) * length
    masses = density * length * 10 ** rng.uniform(-2, 1, places.size)
    stops, stretches, tension = [0.0, *places, length], [], low
    for number, (a, b) in enumerate(pairwise(stops)):
        top = tension + density * G * (b - a)
        stretches.append((b - a, tension, top))
        tension = top + (masses[number] * G if number < masses.size else 0.0)

    def determinant(omega):
        """Displacement at the top end per force at the bottom: Bessel waves on every stretch."""
        z, q = np.zeros_like(omega), np.ones_like(omega)
        for number, (_, bottom, top) in enumerate(stretches):
            a, b = (2 * omega * sqrt(t / density) / G for t in (bottom, top))
            slopes = [omega * sqrt(density * t) for t in (bottom, top)]
            # z = A J0 + B Y0 and q = -slope (A J1 + B Y1); J0 Y1 - J1 Y0 = -2 / (pi a)
            amplitude = -(z * y1(a) + q / slopes[0] * y0(a)) * pi * a / 2
            other = (z * j1(a) + q / slopes[0] * j0(a)) * pi * a / 2
            z, q = amplitude * j0(b) + other * y0(b), -slopes[1] * (amplitude * j1(b) + other * y1(b))
            if number < masses.size:
                q = q - omega**2 * masses[number] * z
        return z

    rows = [(), *(((i, 1.0),) for i in range(masses.size)), ()]
    ropes = [
        Rope((rows[i],), (rows[i + 1],), size, partial(even, own, size), density, ((i, ACROSS),))
        for i, (size, *own) in enumerate(stretches)
    ]
    fixed = [Fixed(MASS, mass, row) for mass, row in zip(masses, rows[1:-1], strict=True)]
    return Component(range(masses.size), [*ropes, *fixed]), determinant


def even(own, size, x):
    """Tension that grows with the weight below."""
    return own[0] + (own[1] - own[0]) * np.asarray(x) / size


@pytest.mark.parametrize(
    "ropes", [50, pytest.param(500, marks=pytest.mark.verify)], ids=["a tenth", "the whole"]
)
def test_phase_count_of_the_heavy_string_agrees_with_its_determinant(ropes, measured):
    """20 counts on each of 500 ropes with up to three weights: sign changes of J0, Y0 determinants."""
    rng, wrong, counts = np.random.default_rng(4), 0, 0
    for _ in range(ropes):
        string, determinant = random_rope(rng)
        top = 12 * pi / string.whole
        grid = np.linspace(1e-3, 1.0, 6001) * top
        changes = np.cumsum(np.abs(np.diff(np.sign(determinant(grid)))) > 1)
        for place in rng.integers(1, grid.size, 20):
            counts += 1
            wrong += string.count(float(grid[place])) != changes[place - 1]
    measured(f"{wrong} of {counts} counts wrong")
    assert wrong == 0, f"{wrong} of {counts}"


@pytest.mark.parametrize(
    "machines", [4, pytest.param(100, marks=pytest.mark.verify)], ids=["a part", "the whole"]
)
def test_modes_at_rest_are_those_of_finite_elements_of_the_exact_cable(machines, measured):
    """100 random lines and loops, inclined, loaded, sagging to a fifth: both planes."""
    worst = 0.0
    for seed in range(machines):
        drive = random_machine(np.random.default_rng(1000 + seed), vertical=seed % 3 == 0)
        inside, _, out = Model(drive, per_stretch=8, degree=9).solve().frequencies(14)
        found = cd.modes(drive, below=float(min(inside[8], out[8])) * 0.999)
        assert found.certified, found.certified_reason
        for truth, own in (
            (out, [m for m in found.modes if m.plane == "v"]),
            (inside[inside > 1e-4 * inside[-1]], [m for m in found.modes if m.plane != "v"]),
        ):
            listed = by_multiplicity(own)
            assert np.sum(truth < found.certificate.below) == listed.size
            worst = max(worst, np.abs(listed / truth[: listed.size] - 1).max(initial=0.0))
    measured(f"{machines} machines, largest deviation {worst:.1e}")
    assert worst < 1e-6, f"{worst:.1e}"


def test_steady_torque_tunes_the_two_spans_apart():
    drive = cd.load_drive("dissertation-1", overrides=["layout.gravity=0"])
    found = cd.modes(drive, count=4, at_torque=0.05).transverse
    lowest = {m.span: m.frequency for m in reversed(found) if m.plane == "v"}
    shift = 0.05 / 0.03 / 2
    for span, tension in (("upper", 5 - shift), ("lower", 5 + shift)):
        rigidity = tension / (1 + tension / drive.cable.axial_rigidity)
        expected = sqrt(rigidity / drive.cable.mass_per_length) / 2
        assert lowest[span] == pytest.approx(expected, rel=1e-12)
    with pytest.raises(NotComputed, match="slack"):
        cd.modes(drive, at_torque=0.5)
    with pytest.raises(InputRefused, match="not finite"):
        cd.modes(drive, at_torque=float("nan"))


def test_slack_section_is_not_listed_and_the_word_certified_is_withdrawn():
    drive = cd.load_drive("elevator", overrides=["cable.pretension=12 kN"])
    found = cd.modes(drive, count=4)
    assert not found.certified
    assert "hangs slack at rest" in found.certified_reason
    assert any("hangs slack" in line for line in found.warnings)


# --- The packaged drives against small motions of the simulated loop about its rest
COUNT = 5


def frequencies_of_the_loop(drive, segments):
    """Small motions of the divided cable about the rest of ``--from-equilibrium``: in the plane, and across.

    The tangent of the exact law at rest and the masses of the nodes are what the time steps integrate.
    """
    mesh, law = mesh_of(drive, segments), cable_law(drive.cable, "exact")
    rest = equilibrium(mesh, law, hold="drive").displacement
    tangent = law.stiffness_matrix(*gradients(mesh, rest)) / mesh.spacing[:, None, None]
    nodes = mesh.nodes - mesh.closed
    springs = np.zeros((3 * nodes, 3 * nodes))
    for i, block in enumerate(tangent):
        a, b = 3 * i + np.arange(3), 3 * ((i + 1) % nodes) + np.arange(3)
        springs[np.ix_(a, a)] += block
        springs[np.ix_(b, b)] += block
        springs[np.ix_(a, b)] -= block
        springs[np.ix_(b, a)] -= block
    mass = np.repeat(mesh.mass[:nodes], 3)
    mass[::3] = mesh.axial_mass[:nodes]
    free = np.repeat(mesh.sways[:nodes], 3)
    free[::3] = True
    for rim, shaft in zip(mesh.rims, mesh.shafts, strict=False):
        free[3 * rim] = not shaft.fixed
    springs, mass, free = np.pad(springs, (0, 1)), np.append(mass, 1.0), np.append(free, False)
    if mesh.joint:
        square = mesh.shafts[0].radius ** 2
        ends = [0, 3 * nodes]
        springs[np.ix_(ends, ends)] += mesh.joint.stiffness / square * np.array([[1.0, -1.0], [-1.0, 1.0]])
        mass[-1], free[-1] = mesh.shafts[2].rim_mass, True
    motor = drive.motor
    if motor is not None and motor.holding_stiffness is not None:
        rotor = 3 * nodes if mesh.joint else 0
        springs[rotor, rotor] += motor.holding_stiffness / mesh.shafts[0].radius ** 2

    def lowest(chosen):
        chosen = chosen[free[chosen]]
        square = eigh(
            springs[np.ix_(chosen, chosen)], np.diag(mass[chosen]), eigvals_only=True, subset_by_index=[0, 39]
        )
        return np.sqrt(np.maximum(square, 0.0)) / (2 * np.pi)

    everything = np.arange(mass.size)
    across = everything[everything % 3 == 1]
    return lowest(np.setdiff1d(everything, across)), lowest(across)


@pytest.mark.verify
@pytest.mark.parametrize("name", packaged_drives("loop", "line"))
def test_every_listed_frequency_is_one_of_the_loop(name, measured):
    """By the error of the loop's own segments, halved once."""
    drive = cd.load_drive(name)
    found = cd.modes(drive, count=COUNT)
    top = min(found.modes[-1].frequency, 1.2 * found.transverse[-1].frequency)
    segments = 48
    coarse, fine = frequencies_of_the_loop(drive, segments), frequencies_of_the_loop(drive, 2 * segments)
    worst = 0.0
    for mode in found.modes:
        if mode.frequency > top:
            continue
        plane = 1 if mode.plane == "v" else 0
        place = int(np.argmin(np.abs(fine[plane] - mode.frequency)))
        limit = fine[plane][place] + (fine[plane][place] - coarse[plane][place]) / 3
        scheme = abs(fine[plane][place] - coarse[plane][place])
        error = abs(limit - mode.frequency)
        worst = max(worst, error / mode.frequency)
        allowed = scheme + 1e-6 * mode.frequency
        assert error <= allowed, f"{mode.frequency:.8g} Hz, {mode.kind} {mode.plane}: loop {limit:.8g} Hz"
    warned = f", with {len(found.warnings)} warnings" if found.warnings else ""
    measured(f"{name}: largest deviation {worst:.1e}{warned}")
