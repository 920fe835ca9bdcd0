"""Modes followed from pose to pose: through a crossing, a veering, and where no step is small enough."""

from math import cos, pi, sin

import numpy as np
import pytest

import cabledrive as cd
from cabledrive.studies.planned_motion import PlannedMotion
from cabledrive.studies.route_path import path_of
from cabledrive.studies.route_snapshot import Snapshot
from cabledrive.studies.route_tracking import tracked

KEYS = (("left", "w", 1), ("right", "w", 1), ("right", "w", 2))


def snapshot(shape, across):
    """Three modes with these shapes, shape (points, 3), and frequencies; one longitudinal mode."""
    coupling = (shape.T @ np.diag(np.arange(1.0, len(shape) + 1.0)) @ shape)[None]
    return Snapshot(
        along=np.ones(1),
        along_loss=np.zeros(1),
        along_turn=np.ones((1, 1)),
        along_shape=np.ones((1, 1)),
        strain=np.ones((1, 1)),
        tension=np.ones(1),
        keys=KEYS,
        across=np.asarray(across, dtype=float),
        across_loss=np.arange(3.0),
        across_turn=np.arange(3.0)[:, None],
        coupling=coupling,
        shape=shape,
        certified=True,
        reach=100.0,
    )


def turned(angle):
    """Two coupled modes whose shapes have turned into each other, and one that nothing changes."""
    c, s = cos(angle), sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def test_modes_that_cross_keep_their_shapes_and_not_their_numbers():
    first, swapped = np.eye(3), np.eye(3)[:, [1, 0, 2]] * [1.0, -1.0, 1.0]

    def between(place):
        return snapshot(first if place < 0.6 else swapped, (1.0 + 0.1 * place, 2.0 - 0.1 * place, 3.0))

    found, doubts = tracked([between(0.0), between(1.0)], between)
    assert doubts == []
    assert found[1].across.tolist() == [1.9, 1.1, 3.0]
    np.testing.assert_array_equal(found[1].shape, first)  # signs as well
    np.testing.assert_allclose(found[1].coupling, found[0].coupling)
    assert found[1].across_loss.tolist() == [1.0, 0.0, 2.0]


def test_modes_that_turn_into_each_other_are_followed_in_smaller_steps():
    """A turn by 0.45 pi between two poses looks like an exchange; half-way it is none."""
    asked = []

    def between(place):
        asked.append(place)
        return snapshot(turned(0.45 * pi * place), (1.0, 2.0, 3.0))

    found, doubts = tracked([between(0.0), between(1.0)], between)
    assert doubts == []
    assert len(asked) > 2
    np.testing.assert_allclose(np.abs(np.diag(found[1].shape)), [cos(0.45 * pi)] * 2 + [1.0])


def test_modes_that_jump_are_named_as_ambiguous():
    def between(place):
        return snapshot(turned(0.0 if place < 0.5 else pi / 4.0), (1.0, 2.0, 3.0))

    _, doubts = tracked([between(0.0), between(1.0)], between)
    assert len(doubts) == 2
    assert "mode 1 of left (w) between poses 1 and 2" in doubts


HEAD = """
schema = 1
kind = "route"
name = "axes"
[cable]
axial_rigidity = "20 kN"
mass_per_length = "0.008 kg/m"
pretension = "60 N"
axial_damping = "2 N s"
transverse_damping = "4 1/s"
"""


def axis(letter, y, mass):
    """A head on a belt from a motor to an idler 1 m away, at a height y [m]."""
    return f"""
[[body]]
name = "head {letter}"
mass = "{mass} kg"
at = ["0.3 m", "{y + 0.02} m"]
moves = "x"
[[pulley]]
name = "motor {letter}"
at = ["0 m", "{y} m"]
radius = "20 mm"
inertia = "1e-4 kg m^2"
[[pulley]]
name = "idler {letter}"
at = ["1 m", "{y} m"]
radius = "20 mm"
inertia = "1e-6 kg m^2"
[[anchor]]
name = "left {letter}"
on = "head {letter}"
at = ["0.29 m", "{y - 0.02} m"]
[[anchor]]
name = "right {letter}"
on = "head {letter}"
at = ["0.31 m", "{y - 0.02} m"]
[[route]]
name = "belt {letter}"
path = ["right {letter}", "+idler {letter}", "+motor {letter}", "left {letter}"]
[[motor]]
pulley = "motor {letter}"
inertia = "1e-5 kg m^2"
"""


@pytest.fixture
def machine(tmp_path):
    """Reads the drive of some axes."""

    def read(*axes):
        (tmp_path / "axes.toml").write_text(HEAD + "".join(axes))
        return cd.load_drive(str(tmp_path / "axes.toml"))

    return read


def tensions(path):
    """Rise of the tension of each piece along a motion [N], shape (steps + 1, pieces)."""
    return np.einsum("tpq,tq->tp", path.at("strain", path.here), path.along)


def test_two_axes_in_one_file_do_what_each_does_alone_while_their_longitudinal_modes_cross(machine, measured):
    """One head moves and its mode rises from 85 to 108 Hz, through the 97 Hz of the other, which stands."""
    one, other = axis("a", 0.0, 0.8), axis("b", 1.0, 1.0)
    time = np.linspace(0.0, 1.0, 2001)
    place = 0.45 - 0.2 * (3.0 * time**2 - 2.0 * time**3)
    torques = 0.3 * np.sin(2.0 * pi * 85.0 * time), 0.2 * np.sin(2.0 * pi * 90.0 * time)
    moves = {"head a.x": place}
    both = path_of(
        machine(one, other),
        PlannedMotion(time=time, torque=torques[0], torques={"motor b": torques[1]}, places=moves),
    )
    assert both.ambiguous == ()
    ends = [[round(own / (2.0 * pi)) for own in both.snapshots[i].along] for i in (0, -1)]
    assert ends == [[97, 108], [97, 85]]  # poses by place: from 0.25 m to 0.45 m
    alone = [
        path_of(machine(one), PlannedMotion(time=time, torque=torques[0], torques={}, places=moves)),
        path_of(
            machine(other),
            PlannedMotion(time=time, torque=torques[1], torques={}, places={"head b.x": 0.3 + 0.0 * time}),
        ),
    ]
    wanted = [
        np.column_stack([np.interp(both.time, own.time, row) for row in tensions(own).T]) for own in alone
    ]
    found = np.split(tensions(both), [wanted[0].shape[1]], axis=1)
    errors = [np.abs(f - w).max() / np.abs(w).max() for f, w in zip(found, wanted, strict=True)]
    measured("relative errors of the tension " + ", ".join(f"{error:.1e}" for error in errors))
    assert errors[0] < 0.01  # the steps differ
    assert errors[1] < 1e-9
