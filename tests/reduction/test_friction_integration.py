"""Kernels of cabledrive.reduction: set-valued friction against closed forms, lines between two motors."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

from cabledrive.reduction.friction_integration import (
    FrictionLaw,
    direction,
    integrate_chain,
    integrate_rigid_axis,
)
from cabledrive.reduction.lumped_chain import LumpedChain
from cabledrive.reduction.two_motors import TwoMotors, line_at, pulled

pytestmark = pytest.mark.kernel

ONE = LumpedChain(names=("axis",), inertias=(0.002,), viscous=(0.003,), coulomb=(0.04,), offsets=(0.0,))
TWO = LumpedChain(
    names=("a", "b"),
    inertias=(0.002, 0.003),
    viscous=(0.003, 0.002),
    coulomb=(0.03, 0.02),
    offsets=(0.004, 0.0),
    stiffness=(1.5,),
    damping=(0.002,),
    ratios=((1.0, 1.0),),
)


def wave(samples, interval):
    t = interval * np.arange(samples)
    return 0.16 * np.sin(2 * np.pi * 3.0 * t) + 0.12 * np.sin(2 * np.pi * 1.0 * t + 0.4)


def test_an_axis_slides_to_rest_as_the_closed_form_says():
    """J w' = -b w - c: w = (w0 + c/b) exp(-b t/J) - c/b until it reaches zero, and stays there."""
    speeds = integrate_chain(ONE, np.zeros(400), 1e-3, start=np.array([0.0, 5.0])).speeds[:, 0]
    t = 1e-3 * np.arange(400)
    exact = (5.0 + 0.04 / 0.003) * np.exp(-0.003 * t / 0.002) - 0.04 / 0.003
    assert np.abs(speeds - np.maximum(exact, 0.0)).max() < 1e-9
    assert speeds[-1] == 0.0


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_an_axis_at_rest_breaks_away_within_a_step(way):
    """Under u = r t it stands until r t = c; then J w' = r (t - c/r) - b w, whatever the steps."""
    inertia, viscous, coulomb, rise = 0.002, 0.003, 0.04, 1.7
    t = 0.01 * np.arange(12)
    speeds, _ = integrate_rigid_axis(np.array([inertia, viscous, coulomb, 0.0]), way * rise * t, 0.01)
    later, lag = np.maximum(t - coulomb / rise, 0.0), inertia / viscous
    exact = way * rise / viscous * (later - lag * (1.0 - np.exp(-later / lag)))
    np.testing.assert_allclose(speeds, exact, atol=1e-9)


def test_turning_points_do_not_lower_the_order():
    """Halving the step quarters the error or better, with sticking and turning in the run."""
    dt = 4e-3
    coarse = wave(300, dt)
    fine = integrate_chain(TWO, coarse, dt, substeps=32).angles[-1]
    error = [np.abs(integrate_chain(TWO, coarse, dt, substeps=k).angles[-1] - fine).max() for k in (1, 2, 4)]
    assert error[0] < 1e-6, f"errors {error}"
    assert error[2] < error[0] / 6.0, f"errors {error}"


@pytest.mark.parametrize(
    "quantity, number, field, step",
    [
        ("inertia", 0, "inertias", 1e-7),
        ("viscous", 1, "viscous", 1e-6),
        ("coulomb", 0, "coulomb", 1e-6),
        ("coulomb", 1, "coulomb", 1e-6),
        ("offset", 0, "offsets", 1e-6),
        ("stiffness", 0, "stiffness", 1e-4),
        ("damping", 0, "damping", 1e-6),
    ],
)
def test_sensitivities_are_the_derivatives_of_the_motion(quantity, number, field, step):
    dt = 1e-3
    u = wave(700, dt)

    def moved(sign):
        values = list(getattr(TWO, field))
        values[number] += sign * step
        return integrate_chain(replace(TWO, **{field: tuple(values)}), u, dt).speeds

    difference = (moved(1) - moved(-1)) / (2 * step)
    found = integrate_chain(
        TWO, u, dt, directions=direction(2, quantity, number)[:, None]
    ).speed_sensitivities
    error = np.abs(found[..., 0] - difference)
    scale = np.abs(difference).max()
    # Around a turn the two derivatives jump at instants that differ by the step of the difference.
    assert np.quantile(error, 0.98) < 2e-3 * scale, f"{np.quantile(error, 0.98) / scale:.2e}"


def test_friction_at_rest_holds_more_than_friction_in_motion():
    law = FrictionLaw(excess=(0.02,), fading=(0.1,), slope=(0.0,))
    assert np.all(integrate_chain(ONE, np.full(100, 0.059), 1e-3, law=law).angles == 0.0)
    assert integrate_chain(ONE, np.full(100, 0.061), 1e-3, law=law).angles[-1, 0] > 0.0


def test_an_axis_slows_under_friction_that_falls_with_the_square_of_speed_over_fading():
    """Time to a speed is the integral of J / (b w + c + e exp(-(w/f)^2)), by quadrature."""
    excess, fading, start, interval = 0.03, 0.4, 1.5, 2e-4
    law = FrictionLaw(excess=(excess,), fading=(fading,), slope=(0.0,))
    speeds = integrate_chain(ONE, np.zeros(200), interval, law=law, start=np.array([0.0, start])).speeds[:, 0]

    def per_speed(w):
        return 0.002 / (0.003 * w + 0.04 + excess * np.exp(-((w / fading) ** 2)))

    for k in (50, 150, 199):
        assert speeds[k] > 0.0
        time, _ = quad(per_speed, speeds[k], start, epsabs=1e-14)
        assert time == pytest.approx(k * interval, rel=1e-9)


def test_flanks_of_a_gap_push_and_never_pull():
    """Two free inertias thrown together against a heavy damper: the contact's force is never below zero.

    By another integration of the relative motion; the step misses the instant of contact, hence first order.
    """
    free = replace(TWO, viscous=(0.0, 0.0), coulomb=(0.0, 0.0), offsets=(0.0, 0.0), damping=(0.05,))
    gap, interval, start = 0.2, 1e-3, np.array([0.0, 0.0, 8.0, 0.0])
    found = integrate_chain(free, np.zeros(200), interval, gaps=(gap,), start=start, substeps=40)
    relative = found.speeds[:, 0] - found.speeds[:, 1]

    def rates(_, y):
        beyond = np.sign(y[0]) * max(abs(y[0]) - 0.5 * gap, 0.0)
        force = 1.5 * beyond + 0.05 * y[1] if beyond != 0.0 else 0.0
        force = force if force * beyond > 0.0 else 0.0
        return [y[1], -force * (1.0 / 0.002 + 1.0 / 0.003)]

    truth = solve_ivp(rates, (0.0, 0.199), [0.0, 8.0], t_eval=interval * np.arange(200), max_step=1e-5)
    assert truth.y[1].min() < -1.0, "the flanks do not throw them apart"
    np.testing.assert_allclose(relative, truth.y[1], atol=5e-3 * 8.0)


# --- Lines between two motors
def machine(radius):
    two, none = np.ones(2), np.zeros(2)
    anchor, centre = np.array([[0.1, 0.2], [-0.1, 0.2]]), np.array([[1.0, 0.9], [-1.2, 0.8]])
    x, y = (anchor - centre).T
    span = np.sqrt(x**2 + y**2 - radius**2)
    bearing = np.array([span * x - radius * y, span * y + radius * x]).T / (x**2 + y**2)[:, None]
    return TwoMotors(
        mass=two, force=none, viscous=none, coulomb=none, frame=np.array([[1.0, 0.2], [0.0, 1.0]]),
        centre=centre, radius=radius * two, anchor=anchor, bearing=bearing, fixed=np.array([0.5, 0.7]),
        unwound=none, rigidity=two, loss=none, drum=two, inertia=two, turning_viscous=none,
        turning_coulomb=none, limit=two,
    )  # fmt: skip


@pytest.mark.parametrize("radius", [0.0, 0.05, -0.05])
def test_a_line_is_as_long_as_its_tangent_and_the_arc_behind_it(radius):
    """Its derivative is the unit vector of the tangent; a point for a pulley leaves the distance."""
    lines, q = machine(radius), np.array([0.15, -0.2])
    for i in range(2):
        along, scratch = np.zeros(2), np.zeros(2)
        length, free, last = line_at(lines, i, q, along)
        step = 1e-6
        slopes = [
            (line_at(lines, i, q + d, scratch)[0] - line_at(lines, i, q - d, scratch)[0]) / (2.0 * step)
            for d in step * np.eye(2)
        ]
        np.testing.assert_allclose(along, slopes, atol=1e-9)
        at_rest = lines.anchor[i] - lines.centre[i]
        away = np.linalg.norm(at_rest + lines.frame @ q)
        assert last == pytest.approx(np.sqrt(away**2 - radius**2), rel=1e-12)
        assert free == pytest.approx(lines.fixed[i] + last, rel=1e-12)
        if radius == 0.0:
            assert length == pytest.approx(away - np.linalg.norm(at_rest), rel=1e-12)
        assert line_at(lines, i, np.zeros(2), scratch)[0] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(
    ("stretch", "speed", "tension"), [(2e-3, 0.1, 5.0), (2e-3, -3.0, 0.0), (-1e-4, 9.0, 0.0), (0.0, 9.0, 0.0)]
)
def test_a_line_only_pulls_and_only_while_it_is_stretched(stretch, speed, tension):
    assert pulled(stretch, speed, 2000.0, 10.0) == pytest.approx(tension, abs=1e-15)
