"""The door to the internal resonance: summary, verdict, remedies, map, sweep, dampings from a decay."""

from dataclasses import replace

import numpy as np
import pytest
from reproduction.tension_sweep import Sweep, onset, onset_by_growth_integral, swept_amplitude

import cabledrive as cd
from cabledrive.reduction.autoparametric import autoparametric_model
from cabledrive.reduction.averaging import averaged_coefficients, fold, steady_amplitudes
from cabledrive.reduction.decay import damping_from_decay
from cabledrive.reduction.fast_simulation import COLUMN, FastScheme, simulate_fast
from cabledrive.reduction.threshold import CLOSE, growth_torque, instability_margin, threshold_torque
from cabledrive.report.map_page import resonance_map_page, spot_check_line
from cabledrive.simulation import Pluck, Recording, Scheme, Start
from cabledrive.simulation.signals import Sine
from cabledrive.studies.machine_pairs import machine_pairs
from cabledrive.studies.resonance import remedies, resonance
from cabledrive.studies.resonance_map import growth_map, spot_checks, steady_branches
from oracles.averaged_motion import Slow, averaged_history
from other_units import in_other_units
from resonance_samples import at_detunings, damped, settings_pair


def at_tension(drive, tension):
    return replace(drive, cable=replace(drive.cable, pretension=tension))


def test_pairs_that_are_alike_stand_in_one_order_in_whatever_units():
    """Two ropes of a lift with equal detunings changed places by round-off."""
    given, by = cd.load_drive("lift-2-to-1"), (0.064, 0.153, 2.9)
    own, other = machine_pairs(given).pairs, machine_pairs(in_other_units(given, by)).pairs
    places = [(pair.span, pair.numbers, pair.plane) for pair in own]
    assert [(pair.span, pair.numbers, pair.plane) for pair in other] == places
    found = [pair.threshold_amplitude for pair in other]
    assert found == pytest.approx([pair.threshold_amplitude for pair in own], rel=1e-6)


def test_off_tuning_verdicts_change_at_one_and_two_half_widths():
    drive, torque = damped(2.0, 5.0), 0.02
    seen = []
    for tension in np.linspace(3.29, 3.9, 60):
        instability = instability_margin(autoparametric_model(at_tension(drive, tension)), torque)
        share = instability.distance / instability.half_width
        seen.append(instability.verdict)
        expected = "resonant" if share < 1 else "close" if share < CLOSE else "safe"
        assert instability.verdict == expected
        assert (instability.growth > 0) == (instability.verdict == "resonant")
        if (
            instability.growth > -1.0
        ):  # (A.24): of the pumping, what the distance leaves is growth and damping
            growing = (instability.growth + 1.0) ** 2 - 1.0  # Gamma = 2 1/s
            assert instability.half_width**2 - instability.distance**2 == pytest.approx(growing, rel=1e-9)
    assert set(seen) == {"resonant", "close", "safe"}


def test_held_pulleys_give_nulls_with_reasons_and_a_safe_verdict():
    drive = cd.load_drive("dissertation-2").listed
    held = replace(drive, pulley=tuple(replace(p, fixed=True) for p in drive.pulley))
    found = resonance(held)
    assert found.verdict == "safe"
    assert found.frequency_ratio is None
    assert "no pulley turns" in found.missing["tuned_pretension"]
    assert found.reasons[0].startswith("no 1:2 pair in range")
    still = resonance(replace(drive, pulley=(held.pulley[0], drive.pulley[1])), torque=1.0)
    assert still.verdict == "safe"
    assert "drive pulley that is fixed" in still.reasons[0]


@pytest.mark.parametrize(
    ("name", "torque", "helpful"), [("", 0.01, 5), ("elevator", 90.0, 2), ("linear-axis", 2.0, 3)]
)
def test_each_remedy_makes_the_pulley_mode_safe(name, torque, helpful):
    drive = cd.load_drive(name).listed if name else damped(2.0, 5.0)

    def verdict(changed, acting=torque):
        return resonance(changed, torque=acting, details=False).verdict

    assert verdict(drive) in ("resonant", "close")
    found = {remedy.change: remedy.value for remedy in remedies(drive.machine, torque) if remedy.enough}
    assert len(found) == helpful
    load = drive.load_pulley
    for change, value in found.items():
        if change == "limit torque":
            assert verdict(drive, 0.999 * value) == "safe"
            continue
        more = {"add inertia": "inertia", "add damping": "viscous_friction"}.get(change)
        loaded = replace(load, **{more: getattr(load, more) + value}) if more else load
        changed = replace(drive, pulley=(drive.drive_pulley, loaded))
        assert verdict(changed if more else at_tension(drive, value)) == "safe", change


def test_ropes_without_damping_grow_together_from_the_torque_of_ropes_with_hardly_any():
    """Round-off is no growth: without damping the threshold is the limit of less and less of it."""
    found = []
    for damping in (0.0, 1e-4, 1e-2):
        keys = [f"cable.transverse_damping={damping}", "cable.pretension=688", "layout.gravity=0"]
        found.append(machine_pairs(cd.load_drive("linear-axis", overrides=keys)).together[0][1])
    assert found[0] == pytest.approx(4.42, rel=0.01)
    assert found[:2] == pytest.approx([found[2]] * 2, rel=1e-3)


def test_modes_that_grow_together_make_a_loop_resonant_and_grow_in_time(measured):
    """The third and fourth beside each other, from a seventh below their pair's own threshold on."""
    drive = cd.load_drive("linear-axis").listed
    drive = replace(
        drive,
        layout=replace(drive.layout, gravity=0.0),
        cable=replace(drive.cable, pretension=688.0, transverse_damping=1.8, axial_damping=55.5),
        pulley=tuple(replace(own, coulomb_friction=0.0) for own in drive.pulley),
        motor=replace(drive.motor, coulomb_friction=0.0),
    )
    known = resonance(drive, torque=7.6)
    pair = known.pairs[0]
    assert pair.threshold_torque > 1.1 * 7.6
    assert known.verdict == "resonant"
    assert resonance(drive, torque=6.5).verdict == "close"
    for torque, grows in ((6.3, False), (8.0, True)):
        run = cd.simulate(
            drive,
            3.2,
            torque=Sine(amplitude=torque, frequency=pair.longitudinal_hz),
            start=[Pluck(height=1e-7, span="upper")],
            scheme=Scheme(segments=240),
            recording=Recording(rate=2000.0),
        )
        across = np.abs(run.midpoint("upper")[:, 2])
        early, late = (across[(run.time > at) & (run.time < at + 0.2)].max() for at in (2.0, 3.0))
        measured(f"{torque} N m: {late / early:.3g} times as large after 1 s")
        assert (late > early) == grows


def belt(length, rigidity, density, tension, damping, pulleys):
    """A loop without weight; of each pulley radius, inertia and friction."""
    keys = ("radius", "inertia", "viscous_friction")
    return cd.Drive(
        name="belt",
        kind="loop",
        cable=cd.Cable(
            given_rigidity=rigidity,
            mass_per_length=density,
            pretension=tension,
            transverse_damping=damping,
        ),
        layout=cd.Layout(pulley_distance=length, gravity=0.0),
        pulley=tuple(cd.Pulley(**dict(zip(keys, own, strict=True))) for own in pulleys),
    )


def last_of(drive, torque, hertz, number, sines=8):
    """Largest motion of a pluck in one sine at the end of 2 s of the fast model, over its start."""
    plucked = Start(plucks=(Pluck(span="upper", height=1e-6, shape=f"sine-{number}"),))
    push = Sine(amplitude=torque, frequency=hertz)
    run = simulate_fast(drive, 2.0, torque=push, start=plucked, scheme=FastScheme(sines=sines))
    size = np.abs(run.rows[:, COLUMN["w at the middle of upper"]])
    return size[-size.size // 8 :].max() / 1e-6


def test_far_from_tuning_the_mode_that_grows_first_decides_and_grows_in_time(measured):
    """Above half the pulley mode less swing of tension is enough; of four sines, without the fifth."""
    drive = belt(0.8, 21e3, 18e-3, 60.0, 4.0, ((0.01, 3e-5, 1e-4), (0.01, 4e-6, 1e-4)))
    found = resonance(drive, torque=0.0)
    least = found.threshold_here
    assert {pair.numbers for pair in found.pairs if pair.least < 1.001 * least} == {(3, 3)}
    assert [resonance(drive, torque=share * least).verdict for share in (0.99, 1.01)] == ["close", "resonant"]
    for share, grows in ((0.93, False), (1.07, True)):
        last = last_of(drive, share * least, found.pulley_frequency, 3, sines=4)
        measured(f"{share:g} of the threshold: {last:.3g} times the pluck after 2 s")
        assert (last > 10.0) if grows else (last < 0.5)


def test_a_hanging_carriage_that_parts_two_tensions_has_the_pairs_of_the_exact_modes():
    """On end, 1.7 N hang in a span at 7 N: as one string its tenth mode was 2.4 % too high."""
    drive = belt(4.3442, 25e3, 30.6e-3, 7.02, 1.0, ((0.0447, 4.5e-4, 1e-5), (0.0274, 6.9e-4, 1e-5)))
    upright = replace(drive.layout, gravity=9.81, inclination=np.pi / 2)
    carriage = cd.Carriage(mass=0.173, position=2.53, span="lower", guided=False)
    drive = replace(drive, layout=upright, carriage=(carriage,))
    found = resonance(drive, torque=1e-5)
    listed = np.array([mode.frequency for mode in cd.modes(drive, below=60.0).modes])
    assert found.pairs
    for pair in found.pairs:
        for hertz in pair.transverse_hz:
            assert np.min(np.abs(listed / hertz - 1.0)) < 1e-9
    assert all(pair.tuning is None for pair in found.pairs)
    assert any("hanging carriages part two" in line for line in found.left_out)
    with pytest.raises(cd.InputRefused, match="parts two tensions"):
        resonance(drive, load_torque=1e-3)


def test_where_a_threshold_needs_most_of_the_tension_modes_near_the_frequency_itself_may_grow(measured):
    """The fifth, from half of the third's threshold on, of which a line warns."""
    pulleys = (0.021517, 5.8276e-5, 1.2542e-3), (0.014592, 3.6449e-5, 7.8444e-4)
    drive = belt(2.6667, 164.53e3, 3.2407e-3, 162.35, 10.761, pulleys)
    found = resonance(drive, torque=0.0)
    assert any("near that frequency may grow earlier" in line for line in found.reasons)
    assert found.pairs[0].numbers == (3, 3)
    for share, grows in ((0.4, False), (0.5, True)):
        last = last_of(drive, share * found.threshold_here, found.pulley_frequency, 5)
        measured(f"{share:g} of the threshold: {last:.3g} times the pluck of the fifth after 2 s")
        assert (last > 10.0) if grows else (last < 0.5)


def test_more_torque_never_makes_a_verdict_better():
    """One mode far away is close, another at resonance: the one that grows decides."""
    drive, order = cd.load_drive("linear-axis").listed, ("safe", "close", "resonant")
    torques = np.geomspace(1e-2, 1e2, 17)
    seen = [order.index(resonance(drive, torque=torque, details=False).verdict) for torque in torques]
    assert seen == sorted(seen)
    assert seen[-1] == 2


def test_a_map_reaches_a_quarter_beyond_the_pretension_of_tuning_and_the_own_one():
    drive = replace(damped(2.0, 5.0), cable=replace(damped(2.0, 5.0).cable, pretension=5.0))
    found = growth_map(drive, torque=0.02, torques=[0.02], duration=0.05)
    assert found.pretension[[0, -1]] == pytest.approx([3.28377 / 1.25, 5.0 * 1.25], rel=1e-5)


@pytest.mark.parametrize("name, tuned", [("linear-axis", 987.189), ("printer-belt", 9.52219)])
def test_a_map_of_three_sections_grows_above_the_threshold_of_the_nearest(name, tuned):
    """A carriage parts a span; the map of such a drive ended in a traceback."""
    drive = cd.load_drive(name).listed
    model = autoparametric_model(replace(drive, cable=replace(drive.cable, pretension=tuned)))
    assert model.coupling.size == 3
    threshold = float(threshold_torque(model))
    found = growth_map(drive, torque=1.0, pretensions=[tuned], torques=[0.5 * threshold, 2.0 * threshold])
    assert found.threshold == pytest.approx([threshold], rel=1e-3)
    assert found.growth[0, 0] == pytest.approx(1.0, abs=1e-3)
    assert found.growth[1, 0] > 2.0


@pytest.mark.parametrize(
    "name, factor",
    [
        ("elevator", 0.6),
        ("ropeway", 1.9),
        pytest.param("elevator", 2.3, marks=pytest.mark.verify),
        pytest.param("ropeway", 1.0, marks=pytest.mark.verify),
    ],
)
def test_a_map_of_slow_machines_grows_above_the_threshold_that_resonance_states(name, factor):
    """Modes of 0.3 to 4 Hz did not grow within the second that every map lasted."""
    drive = cd.load_drive(name).listed
    bare = replace(drive, layout=replace(drive.layout, gravity=0.0))
    bare = at_tension(bare, factor * drive.cable.pretension)
    least = resonance(bare).threshold_here
    tension, torques = [bare.cable.pretension], [0.5 * least, 1.6 * least]
    found = growth_map(bare, torque=1.0, pretensions=tension, torques=torques)
    assert found.threshold == pytest.approx([least], rel=1e-9)
    assert found.growth[0, 0] < 1.3
    assert found.growth[1, 0] > 2.0, f"{found.growth[1, 0]:.4g} in {found.duration:.4g} s"
    assert not found.weighs
    assert "without weight" in resonance_map_page(growth_map(drive, torque=1.0, torques=[1.0], duration=1.0))


def test_a_map_states_the_torque_from_which_its_duration_shows_growth():
    """2 and 5 1/s at tuning: the exponent of (A.25), integrated, says what doubles."""
    drive = damped(2.0, 5.0)
    tuned = resonance(drive).tuned_pretension
    model = autoparametric_model(at_tension(drive, tuned))
    for duration in (0.7, 2.0):
        found = growth_map(drive, torque=0.02, pretensions=[tuned], torques=[0.02], duration=duration)
        exact = growth_torque(model, 2.0 / 0.7, duration) / float(threshold_torque(model))
        assert found.duration == duration
        assert found.seen_from == pytest.approx(exact, rel=0.02)


def test_far_above_the_pulley_mode_no_span_grows_on_a_map():
    """Transverse modes at 17 times the pulley mode: in steps longer than theirs, 30000-fold."""
    found = growth_map(cd.load_drive("dissertation-3").listed, torque=2.1, torques=[0.01])
    assert not found.slack.any()
    assert np.nanmax(found.growth) < 1.01, f"{np.nanmax(found.growth):.4g}"


def test_exact_loop_agrees_with_the_map_at_random_points():
    drive = damped(2.0, 5.0)
    axes = dict(pretensions=np.linspace(3.2, 3.4, 9), torques=np.linspace(0.0, 0.03, 9))
    checks = spot_checks(drive, growth_map(drive, torque=0.02, **axes), np.random.default_rng(1))
    for check in checks:
        assert check.growth == pytest.approx(check.exact, rel=0.03), f"{check}"
    assert "3 random points" in spot_check_line(checks)
    assert (
        spot_checks(cd.load_drive("linear-axis").listed, growth_map(drive, torque=0.02, **axes), None) == ()
    )


def test_slack_is_marked_on_the_map_and_not_interpolated():
    found = growth_map(damped(0.0, 0.0), torque=0.2, pretensions=[3.28], torques=[1e-3, 0.6])
    assert not found.slack[0, 0]
    assert found.slack[1, 0]
    assert np.isnan(found.growth[1, 0])
    page = resonance_map_page(found)
    assert "null" in page
    assert "NaN" not in page


@pytest.mark.parametrize("rate, share", [(0.2, 0.02), (1.0, 0.02), (5.0, 0.05)])
@pytest.mark.parametrize("pumping, damping", [(8.0, 2.0), (12.0, 1.0)])
def test_growth_integral_finds_the_onset_of_a_sweep(pumping, damping, rate, share, measured):
    """10 um to 1 mm: within 2 % of the half-width up to 1 rad/s^2, 5 % at 5, against Hill's equation."""
    sweep = Sweep(
        pumping=pumping, damping=damping, rate=rate, floor=1e-5, level=1e-3, half_forcing=np.pi * 81.742
    )
    error = onset(*swept_amplitude(sweep), sweep.level) - onset_by_growth_integral(sweep)
    part = 100 * abs(error) / sweep.half_width
    measured(f"{rate:g} rad/s^2, pumping {pumping:g} rad/s: onset within {part:.2g} % of the half-width")
    assert abs(error) < share * sweep.half_width, f"{error / sweep.half_width:.4f}"


def test_damping_from_a_decay():
    """Gamma 2 1/s at 40.9 Hz, a thousandth of noise."""
    rng = np.random.default_rng(3)
    time = np.arange(0, 2.5, 1 / 2000)
    signal = np.exp(-time) * np.cos(2 * np.pi * 40.9 * time + 0.3) + 1e-3 * rng.standard_normal(time.size)
    found = damping_from_decay(time, signal, 41.0)
    assert found.damping == pytest.approx(2.0, rel=5e-3)
    assert found.frequency == pytest.approx(40.9, abs=2e-3)
    assert abs(found.curvature) < 0.05


# --- No advice asks for a pretension that the cable cannot bear
TORQUE = 0.01


def with_strain_limit(drive, limit):
    return replace(drive, cable=replace(drive.cable, strain_limit=limit))


def raised(drive):
    return next(one for one in remedies(drive.machine, TORQUE) if one.change == "raise pretension")


def test_a_pretension_is_raised_within_the_elastic_range_only():
    """A drive that a higher pretension makes safe, with a range that ends above it, and just below it."""
    drive = damped(2.0, 5.0)
    free = raised(drive).value
    strain = free / drive.cable.axial_rigidity
    assert raised(with_strain_limit(drive, 1.01 * strain)).value == pytest.approx(free, rel=1e-3)
    short = raised(with_strain_limit(drive, 0.99 * strain))
    assert short.value is None
    assert f"elastic range, up to {0.99 * free:.4g} N" in short.text


# --- Branches of steady motion where a steady load splits the spans, and beats beyond the Hopf point
DRIVE = replace(damped(2.0, 6.0), cable=replace(damped(2.0, 6.0).cable, pretension=3.36))
PUSHED, LOAD = 0.08, 1e-4


def branches_of(load):
    return steady_branches(DRIVE, PUSHED, np.random.default_rng(0), load_torque=load)


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
    found = both.at(PUSHED)[0]
    assert found[3] < 0
    assert found[1] < 0.7 * found[2], f"{found}"
    assert np.min(both.amplitude[0]) < 0.1 * np.max(both.amplitude[0]), "it starts from the lower span alone"
    assert both.onset is not None
    c = averaged_coefficients(autoparametric_model(DRIVE, load_torque=LOAD), torque=PUSHED, drift=False)
    start = np.array([1e-4, 1.5e-3, 2.5e-3j])
    states = averaged_history(Slow(c, second=False), start, np.array([0.0, 16.0]))
    apart = np.max(np.abs(np.abs(states[:, -1]) / found[:3] - 1.0))
    measured(f"amplitudes in time within {apart:.1e} of the branch")
    np.testing.assert_allclose(np.abs(states[:, -1]), found[:3], rtol=2e-3)


@pytest.mark.parametrize("transverse, pulley, folds", [(3.0, 0.0, 0), (6.0, 5.0, 1)])
def test_a_branch_leaves_rest_at_the_threshold_and_folds_where_the_closed_form_does(
    transverse, pulley, folds, measured
):
    """Gamma = c_q = 2: detunings of one sign make the branch of one span turn back, Eq. (A.27)."""
    drive, forcing = at_detunings(damped(2.0, 2.0), transverse, pulley)
    upper = steady_branches(drive, PUSHED, np.random.default_rng(0), forcing=forcing)[0]
    model = autoparametric_model(drive)
    c = settings_pair(averaged_coefficients(model, torque=PUSHED, forcing=forcing, drift=False))
    pumping = np.hypot(0.5 * c.transverse_damping, c.transverse_detuning) / np.abs(c.pump)  # to first order
    threshold = PUSHED * float(np.min(pumping) * abs(-0.5 * c.damping + 1j * c.detuning) / np.abs(c.force))
    closed = fold(c, "one")
    expected = [] if closed is None else [closed[0] * PUSHED / float(np.abs(c.force))]
    apart = [abs(seen / closed - 1.0) for seen, closed in zip(upper.folds, expected, strict=False)]
    away = "".join(f", fold within {one:.1e}" for one in apart)
    measured(f"leaves rest within {abs(upper.onset / threshold - 1.0):.1e} of the threshold{away}")
    assert upper.onset == pytest.approx(threshold, rel=1e-3)
    np.testing.assert_allclose(upper.folds, expected, rtol=1e-8)
    assert len(expected) == folds


def test_more_sections_than_two_are_not_followed():
    with pytest.raises(cd.NotComputed, match="sections"):
        steady_branches(cd.load_drive("dissertation-transporter").listed, 0.01, np.random.default_rng(0))


@pytest.mark.parametrize("routed", [False, True])
def test_a_torque_that_slackens_a_span_is_not_safe(routed):
    """Two inertias on the springs of both spans, by hand: the swing of tension at resonance, to 5 %."""
    drive = cd.load_drive("dissertation-3").listed
    motor = replace(drive.motor, joint_stiffness=None, joint_damping=0.0, coulomb_friction=0.0)
    drive = replace(drive, lumped=None, motor=motor)
    cable, (first, last) = drive.cable, drive.pulley
    spring = cable.axial_rigidity / drive.span_length
    omega = 2 * np.pi * cd.resonance(drive, torque=1e-3).pulley_frequency
    both = 2 * (spring + 1j * omega * cable.axial_damping / drive.span_length)
    rims = np.array([first.radius, -last.radius])
    inertias = np.diag([motor.inertia + first.inertia, last.inertia])
    losses = np.diag([motor.viscous_friction + first.viscous_friction, last.viscous_friction])
    stiffness = both * np.outer(rims, rims) - omega**2 * inertias + 1j * omega * losses
    swing = spring * abs(rims @ np.linalg.solve(stiffness, [1.0, 0.0]))
    machine = drive.machine.plain if routed else drive
    for share, verdict in ((0.95, "safe"), (1.05, "close")):
        assert cd.resonance(machine, torque=share * cable.pretension / swing).verdict == verdict
