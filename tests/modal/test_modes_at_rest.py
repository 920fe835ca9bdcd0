"""Transverse modes under the tension that is there, against closed forms and finite elements of the rest."""

from dataclasses import replace
from itertools import pairwise
from math import pi, radians, sqrt

import numpy as np
import pytest
from machines import by_multiplicity
from numpy.testing import assert_allclose
from scipy.optimize import brentq
from scipy.special import j0, j1, y0, y1

import cabledrive as cd
from cabledrive.modal.component import Component, Fixed
from cabledrive.modal.elements import ACROSS, Rope
from cabledrive.modal.rows import MASS
from cabledrive.parameters import Cable, Drive, InputRefused, Layout, NotComputed, Pulley, packaged_drives
from network_samples import as_routes, evenly, hanging_drive, vanishing
from oracles import hanging_machine

G = 9.81


def test_hanging_rope_has_the_waves_of_bessel(measured):
    """80 m of 0.22 kg/m with 300 N below: 0.26008, 0.52041, 0.78068 Hz, the roots of J0 Y0 - J0 Y0."""
    rope = Drive(
        name="rope between held ends",
        kind="line",
        cable=Cable(given_rigidity=1e13, mass_per_length=0.22, pretension=300.0 + 0.22 * G * 40.0),
        layout=Layout(span_length=80.0, gravity=G, inclination=radians(-90)),
        pulley=(Pulley(radius=0.1, inertia=0.01, fixed=True),) * 2,
    )
    listed = cd.modes(rope, count=12)
    found = np.array([mode.frequency for mode in listed.transverse if mode.plane == "w"][:3])
    ends = [2 * sqrt(tension / 0.22) / G for tension in (300.0, 300.0 + 0.22 * G * 80.0)]

    def determinant(omega):
        a, b = (omega * end for end in ends)
        return j0(a) * y0(b) - j0(b) * y0(a)

    exact = [brentq(determinant, 2 * pi * f * (1 - 1e-3), 2 * pi * f * (1 + 1e-3), xtol=1e-15) for f in found]
    error = np.abs(2 * pi * found / exact - 1).max()
    measured(f"{', '.join(f'{f:.5f}' for f in found)} Hz, relative error {error:.1e}")
    assert_allclose(found, [0.26008, 0.52041, 0.78068], atol=5e-6)
    assert error < 1e-10, f"relative error {error:.2e}"
    assert {mode.model for mode in listed.transverse} == {"heavy string"}


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
        Rope(
            (rows[i],),
            (rows[i + 1],),
            size,
            evenly(own, size),
            density,
            ((i, ACROSS),),
            vanishes=vanishing(own, size),
        )
        for i, (size, *own) in enumerate(stretches)
    ]
    fixed = [Fixed(MASS, mass, row) for mass, row in zip(masses, rows[1:-1], strict=True)]
    return Component(range(masses.size), [*ropes, *fixed]), determinant


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


def packaged(name):
    return cd.load_drive(name).listed


def drawn(seed):
    return hanging_drive(np.random.default_rng(1000 + seed), vertical=seed % 3 == 0)


@pytest.mark.parametrize(
    ("machines", "make"),
    [
        (range(4), drawn),
        pytest.param(range(100), drawn, marks=pytest.mark.verify),
        pytest.param(packaged_drives("loop", "line"), packaged, marks=pytest.mark.verify),
    ],
    ids=["a part", "the whole", "packaged"],
)
def test_modes_at_rest_are_those_of_finite_elements_of_the_exact_cable(machines, make, measured):
    """Random lines and loops, inclined, loaded, sagging to a fifth, and the packaged ones: both planes.

    Of elements the weight of a rope that runs round makes a mode of the motion that the list takes for rigid.
    """
    worst = 0.0
    for one in machines:
        drive = make(one)
        machine = as_routes(replace(drive, motor=drive.motor or cd.Motor(inertia=1e-24)))
        inside, out = (own[:14] for own in hanging_machine.frequencies(machine))
        found = cd.modes(drive, below=float(min(inside[8], out[8])) * 0.999)
        assert found.certified, found.certified_reason
        for truth, own in (
            (out, [m for m in found.modes if m.plane == "v"]),
            (inside[found.rigid_body_modes :], [m for m in found.modes if m.plane != "v"]),
        ):
            listed = by_multiplicity(own)
            assert np.sum(truth < found.certificate.below) == listed.size
            worst = max(worst, np.abs(listed / truth[: listed.size] - 1).max(initial=0.0))
    measured(f"{len(machines)} machines, largest deviation {worst:.1e}")
    assert worst < 1e-6, f"{worst:.1e}"


@pytest.mark.parametrize("name", ["camera-line", "ropeway", "dissertation-1"])
def test_longitudinal_frequencies_are_those_of_the_list_unless_a_straight_drive_is_asked_for(name):
    drive = cd.load_drive(name).listed
    listed = [mode.frequency for mode in cd.modes(drive, count=2).longitudinal]
    assert_allclose(cd.natural_frequencies(drive, count=2), listed, rtol=1e-12)
    straight = cd.natural_frequencies(drive, count=2, taut=True)
    weightless = replace(drive, layout=replace(drive.layout, gravity=0.0))
    if not any(not own.guided for own in drive.carriage):
        assert_allclose(straight, cd.natural_frequencies(weightless, count=2), rtol=1e-12)
    assert abs(straight[0] / listed[0] - 1.0) > 1e-6


def test_steady_torque_tunes_the_two_spans_apart():
    drive = cd.load_drive("dissertation-1", overrides=["layout.gravity=0"]).listed
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


@pytest.mark.parametrize("name, pretension", [("elevator", "12 kN"), ("linear-axis", "10 N")])
def test_slack_section_is_not_listed_and_the_word_certified_is_withdrawn(name, pretension):
    """A lower end that is slack, and a span whose mean tension would have to push."""
    steep = [f"cable.pretension={pretension}", "layout.inclination=90 deg"]
    drive = cd.load_drive(name, overrides=steep).listed
    found = cd.modes(drive, count=4)
    assert not found.certified
    assert "hangs slack at rest" in found.certified_reason
    assert any("hangs slack" in line for line in found.warnings)
