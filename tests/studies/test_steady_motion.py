"""Branches of steady motion where a steady load splits the spans, and beats beyond the Hopf point."""

from dataclasses import replace

import numpy as np
import pytest

import cabledrive as cd
from cabledrive.reduction.autoparametric import autoparametric_model
from cabledrive.reduction.averaging import averaged_coefficients
from cabledrive.reduction.branches import fold, steady_amplitudes
from cabledrive.reduction.threshold import threshold_torque
from cabledrive.studies.resonance_validation import averaged_history
from cabledrive.studies.steady_motion import steady_branches
from resonance_samples import at_detunings, damped, settings_pair

DRIVE = replace(damped(2.0, 6.0), cable=replace(damped(2.0, 6.0).cable, pretension=3.36))
TORQUE, LOAD = 0.08, 1e-4


def branches_of(load):
    return steady_branches(DRIVE, TORQUE, np.random.default_rng(0), load_torque=load)


def test_without_a_load_both_spans_move_alike():
    """The branch of both, found by continuation, lies on the closed form of Eq. (A.27): equal amplitudes."""
    branches = branches_of(0.0)
    assert [branch.spans for branch in branches] == [("upper",), ("lower",), ("upper", "lower")]
    both = branches[-1]
    np.testing.assert_allclose(both.amplitude[0], both.amplitude[1], rtol=1e-8)
    model = autoparametric_model(DRIVE)
    for torque, amplitude in zip(both.torque[::7], both.amplitude[:, ::7].T, strict=True):
        c = averaged_coefficients(model, torque=torque, drift=False)
        closed = steady_amplitudes(settings_pair(c), "both")
        found = float(np.sum(amplitude**2))
        assert np.min(np.abs(closed / found - 1)) < 1e-8, f"{found} {closed}"


def test_a_tenth_of_a_millinewton_metre_parts_the_spans_and_time_finds_them_so(measured):
    """The branch of both leaves that of the relaxed span at a torque; motion in time ends on it, unequal."""
    both = branches_of(LOAD)[-1]
    assert both.spans == ("upper", "lower")
    found = both.at(TORQUE)[0]
    assert found[3] < 0
    assert found[1] < 0.7 * found[2], f"{found}"
    assert np.min(both.amplitude[0]) < 0.1 * np.max(both.amplitude[0]), "it starts from the lower span alone"
    assert both.onset is not None
    c = averaged_coefficients(autoparametric_model(DRIVE, load_torque=LOAD), torque=TORQUE, drift=False)
    start = np.array([1e-4, 1.5e-3, 2.5e-3j])
    _, states = averaged_history(c, start, 16.0, second=False, step=4e-3)
    apart = np.max(np.abs(np.abs(states[:, -1]) / found[:3] - 1.0))
    measured(f"amplitudes in time within {apart:.1e} of the branch")
    np.testing.assert_allclose(np.abs(states[:, -1]), found[:3], rtol=2e-3)


@pytest.mark.parametrize("transverse, pulley, folds", [(3.0, 0.0, 0), (6.0, 5.0, 1)])
def test_a_branch_leaves_rest_at_the_threshold_and_folds_where_the_closed_form_does(
    transverse, pulley, folds, measured
):
    """Gamma = c_q = 2: detunings of one sign make the branch of one span turn back, Eq. (A.27)."""
    drive, forcing = at_detunings(damped(2.0, 2.0), transverse, pulley)
    upper = steady_branches(drive, TORQUE, np.random.default_rng(0), forcing=forcing)[0]
    model = autoparametric_model(drive)
    threshold = float(threshold_torque(model, forcing, second=False))
    c = settings_pair(averaged_coefficients(model, torque=TORQUE, forcing=forcing, drift=False))
    closed = fold(c, "one")
    expected = [] if closed is None else [closed[0] * TORQUE / float(np.abs(c.force))]
    apart = [abs(seen / closed - 1.0) for seen, closed in zip(upper.folds, expected, strict=False)]
    away = "".join(f", fold within {one:.1e}" for one in apart)
    measured(f"leaves rest within {abs(upper.onset / threshold - 1.0):.1e} of the threshold{away}")
    assert upper.onset == pytest.approx(threshold, rel=1e-3)
    np.testing.assert_allclose(upper.folds, expected, rtol=1e-8)
    assert len(expected) == folds


def test_more_sections_than_two_are_not_followed():
    with pytest.raises(cd.NotComputed, match="sections"):
        steady_branches(cd.load_drive("dissertation-transporter"), 0.01, np.random.default_rng(0))
