"""Branches of steady motion where a steady load splits the spans, and beats beyond the Hopf point."""

from dataclasses import replace

import numpy as np
import pytest

import cabledrive as cd
from cabledrive.reduction.autoparametric import autoparametric_model
from cabledrive.reduction.averaging import averaged_coefficients
from cabledrive.reduction.branches import fold, jacobian, steady_amplitudes, steady_state
from cabledrive.reduction.threshold import threshold_torque
from cabledrive.simulation import Pluck, Recording, Scheme, Sine, Start, simulate
from cabledrive.studies.envelopes import beats
from cabledrive.studies.resonance_validation import averaged_history
from cabledrive.studies.steady_motion import steady_branches
from oracles.measured_threshold import demodulated
from resonance_samples import at_detunings, damped, one_span, settings, settings_pair

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


@pytest.mark.verify
def test_a_larger_load_leaves_one_span_at_a_time():
    """Under 1 mN m there is no steady motion of both; one of the two single-span states is stable."""
    branches = branches_of(1e-3)
    assert [branch.spans for branch in branches] == [("upper",), ("lower",)]
    growth = [branch.at(TORQUE)[0][3] for branch in branches]
    assert min(growth) < 0 < max(growth), f"{growth}"


@pytest.mark.verify
def test_just_beyond_the_hopf_point_beats_have_the_period_of_its_eigenvalues():
    """Growth below 0.1 1/s of a pair at 2 rad/s: the periods differ by less than the square of the swing."""
    c = settings(0.83, 4.12, 2.83, -4.86, 0.835e-3)
    state = steady_state(c, steady_amplitudes(c, "one")[-1], "one")
    pair = max(np.linalg.eigvals(jacobian(c, state)), key=lambda value: (value.real, value.imag))
    assert 0 < pair.real < 0.1, f"{pair}"
    found = beats(one_span(c), 1.05 * state[:2], settle=12.0, watch=16.0, second=False)
    swing = (found.most - found.least) / (found.most + found.least)
    assert found.period == pytest.approx(2 * np.pi / pair.imag, rel=swing**2), f"{found} {pair}"


@pytest.mark.verify
def test_beats_have_the_envelope_and_period_of_the_exact_loop(measured):
    """Gamma 0.83, c_q 4.12, detunings -4.86 and 2.83, 35 mN m, 100 segments: period 1 %, envelope 2 %."""
    drive, forcing = at_detunings(damped(0.83, 4.12), -4.86, 2.83)
    c = averaged_coefficients(autoparametric_model(drive), torque=0.035, forcing=forcing, drift=False)
    found = beats(c, np.array([1e-4, 1e-3, 0.0]), settle=15.0, watch=9.0)
    seen = simulate(
        drive,
        22.0,
        torque=Sine(amplitude=0.035, frequency=forcing / (2 * np.pi)),
        start=Start(plucks=(Pluck(height=1e-3, shape="half-sine"),)),
        scheme=Scheme(segments=100),
        recording=Recording(rate=2000.0),
    )
    late = seen.time > 12.0
    time, size = demodulated(seen.time[late], seen.midpoint("upper")[late, 2], 0.5 * forcing, 2)
    level = size - 0.5 * (size.max() + size.min())
    rising = np.flatnonzero((level[:-1] < 0) & (level[1:] >= 0))
    period = (time[rising[-1]] - time[rising[0]]) / (rising.size - 1)
    seen_beats = (period, size.min(), size.max())
    least, most = size.min() / found.least - 1.0, size.max() / found.most - 1.0
    apart = f"period {100 * (period / found.period - 1.0):+.2f} %"
    measured(f"loop over beats: {apart}, envelope {100 * least:+.2f} and {100 * most:+.2f} %")
    assert period == pytest.approx(found.period, rel=0.01), f"{found} {seen_beats}"
    assert size.min() == pytest.approx(found.least, rel=0.02), f"{found} {seen_beats}"
    assert size.max() == pytest.approx(found.most, rel=0.02), f"{found} {seen_beats}"


def test_a_steady_motion_has_no_beats():
    c = one_span(settings(2.0, 6.0, 1.0, -2.0, 3e-3))
    with pytest.raises(cd.NotComputed, match="steady"):
        beats(c, np.array([1e-4, 1e-3]), settle=12.0, watch=1.0)


def test_more_sections_than_two_are_not_followed():
    with pytest.raises(cd.NotComputed, match="sections"):
        steady_branches(cd.load_drive("dissertation-transporter"), 0.01, np.random.default_rng(0))
