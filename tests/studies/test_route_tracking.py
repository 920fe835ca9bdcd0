"""Modes followed from pose to pose: through a crossing, a veering, and where no step is small enough."""

from math import cos, pi, sin

import numpy as np

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
