"""Sixty machines within their data sheet but for a guessed friction: a log turns no right yes into unknown.

The plants of `true_plants` share no code with those of a study. The sheet's own figure is the goal, so that
its study says yes; the law of each study then runs on the machine itself, encoders at random phases. Machines
beyond the sheet are those of `test_studies_of_true_plants`: there no study by a log says a wrong yes.
"""

from functools import cache

import numpy as np
import pytest
from test_studies_of_true_plants import (
    DRIVES,
    FEWEST,
    RUNS,
    SHAKES,
    asked_for_what_it_reached,
    by_the_sheet,
    failures,
    goals,
)

from cabledrive.studies.study import run_study
from true_plants import log_text, truth_of


@cache
def asked(name):
    """Goal that the sheet's study just reaches [rad], and that study."""
    found = by_the_sheet(name, FEWEST)
    goal, answer = asked_for_what_it_reached(found)
    assert answer == "yes"
    return 1.02 * goal, found


def drawn(name, seed):
    """Inertias and springs within the sheet's tolerances; friction from half to 1.6 of what it guesses."""
    g, truth = np.random.default_rng(seed), truth_of(DRIVES[name])
    factors = {"j1": 0.08, "j3": 0.08, "kc": 0.15, "km": 0.15, "bc": 0.35, "b1": 0.25}
    changed = {key: truth[key] * g.uniform(1.0 - part, 1.0 + part) for key, part in factors.items()}
    rubs = {"c1": truth["c1"] * g.uniform(0.5, 1.6), "c3": truth["c1"] * g.uniform(0.0, 0.1)}
    return truth.but(**changed, **rubs)


@pytest.mark.parametrize(
    ("name", "seeds"),
    [
        ("rigid", range(2)),
        pytest.param("rigid", range(2, 30), marks=pytest.mark.verify),
        pytest.param("geared", range(30), marks=pytest.mark.verify),
    ],
    ids=["two", "rigid", "geared"],
)
def test_a_right_yes_of_the_sheet_stays_yes_with_a_log_and_is_right(name, seeds, tmp_path, measured):
    right = kept = 0
    for seed in seeds:
        truth, path = drawn(name, seed), tmp_path / f"{seed}.csv"
        path.write_text(log_text(truth, 12.0, SHAKES[name], seed=seed))
        goal, sheet = asked(name)
        found = run_study(DRIVES[name], [path], goals(name, draws=FEWEST, error=goal))
        if failures(sheet, truth, goal, RUNS) == 0:
            right += 1
            kept += found.verdict.answer == "yes"
        if found.verdict.answer == "yes":
            assert failures(found, truth, goal, RUNS) <= 1, seed
    measured(f"{right} of {len(seeds)} yeses of the sheet are right, {kept} of them stay with a log")
    assert kept == right
    assert right > 0
