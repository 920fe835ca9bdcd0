"""Designs give exactly the rows that are asked for, each by its number alone."""

from itertools import pairwise

import numpy as np
import pytest

from cabledrive.campaign.design import Diagonal, Grid, LatinHypercube, Morris, Random, Saltelli, Sequence

DESIGNS = [
    Grid(shares=(np.linspace(0.0, 1.0, 4), np.array([0.25, 0.75]), np.linspace(0.0, 1.0, 5))),
    Sequence(rows=100, axes=3, seed=1, kind="sobol"),
    Sequence(rows=100, axes=3, seed=1, kind="halton"),
    LatinHypercube(rows=100, axes=3, seed=1),
    Random(rows=100, axes=3, seed=1),
    Diagonal(rows=100, axes=3),
    Saltelli(base=20, axes=3, seed=1),
    Morris(base=25, axes=3, seed=1),
]


@pytest.mark.parametrize("design", DESIGNS, ids=lambda design: design.identity)
def test_a_row_does_not_depend_on_how_rows_are_divided(design):
    whole = design.points(0, design.rows)
    assert whole.shape == (design.rows, 3)
    assert np.all((whole >= 0.0) & (whole <= 1.0))
    cuts = [0, 1, 7, 8, 33, design.rows]
    parts = [design.points(a, b) for a, b in pairwise(cuts)]
    np.testing.assert_array_equal(np.vstack(parts), whole)


def test_a_latin_hypercube_has_one_point_in_each_slice():
    points = LatinHypercube(rows=50, axes=2, seed=3).points(0, 50)
    for column in points.T:
        assert sorted(np.floor(50 * column).astype(int)) == list(range(50))


def test_groups_of_saltelli_exchange_one_column_at_a_time():
    k, base = 3, 8
    groups = Saltelli(base=base, axes=k, seed=5).points(0, base * (k + 2)).reshape(base, k + 2, k)
    a, b = groups[:, 0], groups[:, 1]
    for axis in range(k):
        expected = a.copy()
        expected[:, axis] = b[:, axis]
        np.testing.assert_array_equal(groups[:, 2 + axis], expected)
    assert not np.any(a == b)


def test_each_step_of_morris_moves_one_axis_by_half_and_each_axis_once():
    paths = Morris(base=50, axes=4, seed=2).points(0, 250).reshape(50, 5, 4)
    steps = np.abs(np.diff(paths, axis=1))
    np.testing.assert_array_equal(np.sort(steps, axis=2)[:, :, :3], 0.0)
    np.testing.assert_array_equal(steps.sum(axis=1), 0.5)
    assert set(np.unique(paths)) == {0.125, 0.375, 0.625, 0.875}
    assert len(np.unique(np.argmax(steps, axis=2), axis=0)) > 15, "the order is random"
