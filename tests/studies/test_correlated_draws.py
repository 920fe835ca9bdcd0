"""Plants are drawn with the correlation that the numbers of one log have, each as wide as it is known."""

import numpy as np

from cabledrive.identification.regression import Fit
from cabledrive.studies.study.chain_regression import NAMES, identify_chain
from cabledrive.studies.study.correlations import of_intervals, root_of
from cabledrive.studies.study.machine import LOG, UNITS, Quantity
from cabledrive.studies.study.sampled_plants import sampled_plant
from study_drives import drive_of, log_with

VALUES = np.array([4e-4, 0.02, 1e-3, 0.02, 1e-3])
RHO = np.eye(5)
RHO[0, 1] = RHO[1, 0] = -0.8
RHO[2, 3] = RHO[3, 2] = -0.5
RHO[0, 4] = RHO[4, 0] = 0.3
ERRORS = 0.02 * VALUES
FIT = Fit(
    names=NAMES,
    values=VALUES,
    covariance=RHO * np.outer(ERRORS, ERRORS),
    freedom=60,
    condition=1.0,
    unidentifiable=np.zeros((0, 5)),
    residual=0.0,
    scale=1.0,
    rows=1000,
)
DRAWS = 4000


def intervals(wider=1.0):
    """Identified from a log that leaves nothing but the regression's own width, or a multiple of it."""
    halves = wider * FIT.half_width()
    return {n: (v, v - h, v + h) for n, v, h in zip(NAMES, VALUES, halves, strict=True)}


def quantities(identified):
    return {
        name: Quantity(name=name, value=value, low=low, high=high, unit=UNITS[name], source=LOG)
        for name, (value, low, high) in identified.items()
    }


def drawn(identified, correlations, seed=5):
    """Plants as rows of numbers, in the order of the alphabet."""
    known = quantities(identified)
    plants = [sampled_plant(known, 2, seed, draw, correlations)[0] for draw in range(DRAWS)]
    return np.array([[plant[name] for name in sorted(known)] for plant in plants])


def matrix(correlations, names):
    root = root_of(correlations, names)
    return root @ root


def test_drawn_plants_have_the_regressions_correlation_where_it_is_all_there_is():
    identified = intervals()
    correlations = of_intervals(FIT, identified)
    order = [NAMES.index(name) for name in sorted(NAMES)]
    np.testing.assert_allclose(matrix(correlations, sorted(NAMES)), RHO[np.ix_(order, order)], atol=1e-12)
    seen = np.corrcoef(drawn(identified, correlations).T)
    off = np.abs(seen - RHO[np.ix_(order, order)]).max()
    assert off < 4.0 / np.sqrt(DRAWS), f"observed {off:.4f} of {4.0 / np.sqrt(DRAWS):.4f}"


def test_what_an_interval_has_beyond_the_regression_takes_its_share_of_the_correlation():
    """Twice as wide: a quarter of the variance is the regression's, a quarter of the correlation is left."""
    whole = matrix(of_intervals(FIT, intervals()), sorted(NAMES))
    shared = matrix(of_intervals(FIT, intervals(2.0)), sorted(NAMES))
    np.testing.assert_allclose(shared - np.eye(5), 0.25 * (whole - np.eye(5)), atol=1e-12)


def test_a_log_gives_how_its_numbers_err_together():
    """More inertia at the motor is less at the load; the rest of the log's matrix makes sense as well."""
    identified = identify_chain([log_with(("torque", "angle", "load_angle"))], drive_of("turntable"))
    found = {(one.first, one.second): one.value for one in identified.correlations}
    assert found["load_inertia", "near_inertia"] < -0.3, found
    assert found["cable_stiffness", "load_inertia"] > 0.5, found
    sizes = np.linalg.eigvalsh(matrix(identified.correlations, sorted(identified.intervals)))
    assert sizes[0] > 0.0, f"observed {sizes}"
