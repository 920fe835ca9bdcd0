"""Kernels of cabledrive.reduction: lines between two motors."""

import numpy as np
import pytest

from cabledrive.reduction.two_motors import TwoMotors, line_at, pulled

pytestmark = pytest.mark.kernel


def machine(radius: float) -> TwoMotors:
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
