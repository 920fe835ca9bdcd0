"""A study says yes, no or unknown for the right reason, keeps what is done, and redoes only what depends."""

from dataclasses import replace

import numpy as np
import pytest

from cabledrive.identification.estimates import Fit
from cabledrive.identification.signals import difference, zero_phase
from cabledrive.modal import natural_frequencies
from cabledrive.parameters import InputRefused, load_drive
from cabledrive.reduction.network_axis import as_axis
from cabledrive.reduction.quality import model_quality
from cabledrive.report.study.results import controller_numbers, results_of
from cabledrive.rig import Motion, track
from cabledrive.rig.closed_loop.loop import run
from cabledrive.rig.experiment import experiment
from cabledrive.rig.setting import DEGREE
from cabledrive.studies.study import Goals, load_goals, run_study, sampled_plants
from cabledrive.studies.study.acceptance_stage import run_as_exported
from cabledrive.studies.study.bandwidth_cost import sensor_bound
from cabledrive.studies.study.chain_regression import NAMES, identify_chain
from cabledrive.studies.study.check_stage import goals_for
from cabledrive.studies.study.goals import SPREADS, goals_of
from cabledrive.studies.study.knowledge_stage import ESSENTIAL, know
from cabledrive.studies.study.log_replay import LogFinding
from cabledrive.studies.study.machine import LOG, UNITS, Quantity, by_datasheet, drive_with, values_of
from cabledrive.studies.study.modes_stage import find_modes, resonance_of
from cabledrive.studies.study.pipeline import StudyResult
from cabledrive.studies.study.plants import load_case
from cabledrive.studies.study.stage_cache import as_plain, revived
from cabledrive.studies.study.verdict_stage import judge
from study_drives import (
    CASES,
    FOLDER,
    LIVELY,
    datasheet_of,
    drive_of,
    goals,
    judged_with,
    log_with,
    written_log,
)


@pytest.fixture(scope="module")
def studies(tmp_path_factory):
    """Each of the five drives, studied once."""
    folder = tmp_path_factory.mktemp("studies")
    kept = {}

    def study(case):
        if case.name not in kept:
            drive = datasheet_of(drive_of(case.name)) if case.log else drive_of(case.name)
            logs = written_log(folder, case.name, case.log)
            kept[case.name] = run_study(drive, logs, case.goals, folder=folder / case.name)
        return kept[case.name]

    study.folder = folder
    return study


@pytest.mark.parametrize(
    "case",
    [
        pytest.param(case, id=case.name, marks=[pytest.mark.verify] * (case.name in ("spindle", "wrist")))
        for case in CASES
    ],
)
def test_five_drives_get_the_right_verdict_with_the_right_reason(case, studies, measured):
    verdict = studies(case).verdict
    measured(f"{verdict.answer}: {verdict.reasons[0]}")
    assert verdict.answer == case.verdict, verdict
    assert case.reason in verdict.reasons[0], verdict.reasons
    assert bool(verdict.remedies) == (case.verdict != "yes"), verdict.remedies


def judged(found, error, lasting, runs=300):
    """The verdict of a study, had its chosen law these errors on so many lumped plants."""
    chosen = replace(found.runs, peaks=tuple(sorted(lasting)), draws=runs)
    return judged_with(found, replace(found.goals, error=error), chosen)


def test_the_lower_end_of_the_confidence_interval_decides_and_nothing_else(studies, measured):
    """Of 300 runs none may miss for 99 %; of 299 none, and 298 are too few to show it."""
    found = studies(CASES[0])
    inside, beyond = [0.5] * 300, [0.5] * 299 + [1.5]
    assert judged(found, 1.0, inside).answer == "yes"
    assert judged(found, 1.0, inside[:299], 299).answer == "yes"
    few = judged(found, 1.0, inside[:298], 298)
    measured(f"298 of 298: {few.answer}; 300 of 300: yes")
    assert few.answer == "unknown"
    assert "98.9 %" in few.reasons[0], few.reasons
    assert "raise draws" in few.remedies[0]
    missed = judged(found, 1.0, beyond)
    assert missed.answer == "unknown"
    assert "goal of 57.3 deg" in missed.reasons[0]
    assert judged(found, 1.0, inside[:299]).answer == "unknown", "a run that ended early is a miss"


def test_a_contradiction_with_the_data_sheet_makes_it_unknown(studies):
    """The same runs that hold the goal decide nothing where the log is of another machine."""
    found = studies(CASES[0])
    doubt = "joint stiffness is 48 N m/rad by the log, outside the data sheet's 94 to 142"
    contradiction = LogFinding(id="joint_stiffness", value=48.0, limit=94.0, unit="N m/rad", words=doubt)
    message = replace(found, knowledge=replace(found.knowledge, findings=(contradiction,)))
    assert judged(found, 1.0, [0.5] * 300).answer == "yes"
    verdict = judged(message, 1.0, [0.5] * 300)
    assert verdict.answer == "unknown"
    assert doubt in verdict.reasons[0]
    unasked = judged(message, None, [0.5] * 300)
    assert doubt in unasked.reasons[0], "the finding leads, not what is reached"
    assert any("follows 30 deg" in reason for reason in unasked.reasons[1:])
    assert "[uncertainty]" in verdict.remedies[0]


def test_a_log_moves_the_numbers_from_the_datasheet_to_the_truth(studies):
    found = studies(CASES[0])
    truth, sheet = values_of(drive_of("turntable")), values_of(found.drive)
    for name in ("load_inertia", "coulomb_friction", "viscous_friction"):
        known = found.knowledge.quantities[name]
        assert known.source == "log"
        assert known.low <= truth[name] <= known.high, f"{name}: {known} misses {truth[name]}"
        assert abs(known.value - truth[name]) < 0.3 * abs(sheet[name] - truth[name]), name


def test_a_result_survives_its_plain_data_and_its_file_has_its_quantiles(studies):
    found = studies(CASES[0])
    said, peaks = results_of(found)["stages"]["acceptance"]["lumped"], found.runs.peaks
    assert said["quantile_95_error"] == peaks[int(np.ceil(0.95 * found.runs.draws - 1e-9)) - 1]
    again = revived(StudyResult, as_plain(replace(found, goals=Goals())))
    assert again == replace(found, goals=Goals())


def test_the_law_as_its_file_holds_it_is_run_on_the_plants_of_the_acceptance(studies):
    """With the filter's last gain from the first sample on: what `export` writes, and `track FOLDER` runs."""
    found = studies(CASES[0])
    tried, draws = controller_numbers(found)["study"]["as_written"], found.runs.draws
    assert tried == {"draws": found.goals.draws, "misses": 0, "holds": True}
    tight = replace(found.goals, error=0.2 * found.runs.peaks[draws // 2], draws=60)
    case = load_case(found.known, tight, found.knowledge)
    missed = run_as_exported(case, found.laws.chosen, tight)
    assert (missed.misses, missed.holds) == (60, False)
    assert any("60 of 60 lumped plants" in one for one in judge(replace(found, exported=missed)).cautions)


@pytest.mark.verify
def test_a_coarser_encoder_redoes_what_depends_on_it_and_leaves_the_mechanics_alone(studies, measured):
    """The limit of its eccentricity is a count, so that what is known changes as well.

    A finer one in the file alone would change little: the log shows the encoder that is there.
    """
    case = CASES[0]
    drive = studies(case).drive
    stages, logs = studies.folder / case.name, written_log(studies.folder, case.name, case.log)
    first = {path.name for path in stages.iterdir()}
    coarser = replace(drive, sensors=replace(drive.sensors, load_encoder=20000))
    found = run_study(coarser, logs, replace(case.goals, draws=2), folder=stages)
    fresh = {path.name.rsplit("-", 1)[0] for path in stages.iterdir() if path.name not in first}
    measured(f"done again: {', '.join(sorted(fresh))}")
    assert found.laws is not None
    laws = [score.law.controller for score in found.laws.scores]
    assert laws == ["pd", "pid", "lqg", "lqi", "darc-3-damped", "lqi-learning"]
    runs = {f"acceptance-lumped-{law}-{part}" for law in laws for part in ("00000", "worst")}
    assert fresh == {"check", "knowledge", "demand", "model", "controller", "laws", "exported"} | runs
    before = studies(case).knowledge.quantities["eccentricity"].high
    assert found.knowledge.quantities["eccentricity"].high > before


def test_an_encoder_never_costs_more_than_its_bound(measured):
    """Without friction the loop is linear: counts and phases move the error by no more than stated."""
    drive = drive_of("turntable")
    drive = replace(drive, motor=replace(drive.motor, coulomb_friction=0.0))
    motion = goals(30, 0.3).motion
    known = by_datasheet(drive, dict.fromkeys(SPREADS, 0.0))
    case = sampled_plants.LoadCase(drive=drive, motion=motion, quantities=known)
    law = case.chain_law(3, 40.0)
    loop, clean = case.loop(law), run(case.loop(law, ideal=True))
    bound, load = sensor_bound(loop), loop.chain.size - 1
    costs = []
    for seed in range(8):
        phases = np.random.default_rng(seed).uniform(-0.5, 0.5, 2)
        seen = run(replace(loop, rig=loop.rig._replace(phases=phases)))
        costs.append(np.abs(seen.log[:, load] - clean.log[:, load]).max() / loop.gear)
    within = sum(cost <= bound for cost in costs)
    measured(f"at most {max(costs) / bound:.2f} of the bound, {within} of {len(costs)} phases within")
    assert max(costs) <= bound, f"{max(costs):.3g} rad of {bound:.3g}"
    assert max(costs) > 0.05 * bound, f"a bound of {bound:.3g} rad for {max(costs):.3g} is no bound"


@pytest.mark.parametrize("name, tuned", [("dissertation-2", True), ("dissertation-3", False)])
def test_a_span_tuned_to_the_pulley_mode_is_to_be_moved_away_though_the_motion_spares_it(name, tuned):
    drive = load_drive(name).listed
    found = resonance_of(drive, goals_for(drive, Goals()).motion)
    assert found.alarm == "safe"
    assert (found.verdict == "resonant") == tuned
    assert ("tuned" in found.remedy) == tuned


def test_a_range_of_loads_is_drawn_and_designed_for_its_middle():
    drive = drive_of("turntable")
    known = know(drive, [], SPREADS, (0.015, 0.025)).quantities["load_inertia"]
    assert (known.low, known.value, known.high, known.source) == (0.015, 0.02, 0.025, "goal")
    drawn = [
        sampled_plants.sampled_plant({"load_inertia": known}, 2, 0, k)[0]["load_inertia"] for k in range(200)
    ]
    assert 0.015 <= min(drawn) < 0.016 < 0.024 < max(drawn) <= 0.025


def test_a_drive_that_carries_several_masses_gets_its_resonance_and_no_controller():
    found = run_study(load_drive("elevator").listed, [], goals(1, 0.5))
    assert found.verdict.answer == "unknown"
    said = " ".join((*found.verdict.reasons, *found.verdict.cautions))
    assert "this drive has 2" in said
    assert "inclination" in said
    assert found.modes.certified
    assert found.resonance.pulley_frequency > 0.0
    assert found.controller is None
    assert not found.carried
    assert any("acceptance was not run" in words for words in found.verdict.cautions)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ({"goals": {"eror": 1}}, 'did you mean "error"'),
        ({"error": "3 kg"}, "error ="),
        ({"goals": {"error": -0.1}}, "above 0"),
        ({"goals": {"draws": 1.5}}, "must be a whole number of at least 1"),
        ({"uncertainty": 3}, "uncertainty = 3 is no table"),
        ({"goals": {"load_inertia": [2, 1]}}, "smallest <= largest"),
        ({"uncertainty": {"stifness": 0.1}}, 'did you mean "stiffness"'),
        ({"uncertainty": {"stiffness": 1.5}}, "below 1"),
        ({"motoin": {"angle": 1}}, "unknown table"),
        ({"goals": 3}, "is no table"),
        ({"acceptance": {"seed": -1}}, "seed = -1 must be a whole number of at least 0"),
        ({"motion": {"pulses": 10**9}}, "pulses of 0.5 s last 5e\\+08 s, above 3600 s"),
        ({"acceptance": {"draws": 10**9}}, "draws = 1000000000 is above 100000: ask for fewer"),
        ({"acceptance": {"cable_draws": 10**9}}, "cable_draws = 1000000000 is above 10000"),
        ({"motion": {"duration": "1e9 s"}}, "above 3600 s: shorten the motion"),
        ({"motion": {"angle": "1e10 deg"}}, "above 1e\\+06 rad"),
    ],
)
def test_goals_that_make_no_sense_are_refused(content, words):
    with pytest.raises(InputRefused, match=words):
        goals_of(content)


def test_goals_of_a_load_and_of_a_carriage_are_read_with_their_units(tmp_path):
    path = tmp_path / "study.toml"
    path.write_text(
        '[goals]\nerror = "0.1 deg"\ntorque = "1.5 N m"\nload_inertia = ["2 g m^2", "2.5 g m^2"]\n'
        '[motion]\nduration = "400 ms"\npulses = 2\n[acceptance]\ndraws = 50\n'
        '[uncertainty]\nstiffness = 0.3\n[carriage]\nhanging_mass = "250 g"\nline_length = "25 cm"\n'
    )
    found = load_goals(path)
    assert found.error == pytest.approx(np.radians(0.1))
    assert (found.torque, found.duration, found.pulses, found.draws) == (1.5, 0.4, 2, 50)
    assert found.load_inertia == pytest.approx((0.002, 0.0025))
    assert (found.spreads["stiffness"], found.spreads["friction"]) == (0.3, SPREADS["friction"])
    assert (found.hanging_mass, found.line_length) == (0.25, 0.25)
    carried = goals_of({"goals": {"error": "0.5 mm"}, "motion": {"travel": "80 cm"}})
    assert (carried.error, carried.carriage_error, carried.travel) == (None, 5e-4, 0.8)


# --- What a study learns from a log without the load's angle: the axis as one, where it moves as one
def test_with_a_stiff_cable_the_axis_is_identified_and_not_the_cable():
    """Motor and load reflected through the radii come out together, not the data sheet's."""
    stiff = load_drive(FOLDER / "turntable.toml", overrides=["cable.youngs_modulus=20 TPa"]).listed
    log, truth = experiment(stiff, LIVELY, seed=1), values_of(stiff)
    one = replace(log, channels={name: log.channels[name] for name in ("torque", "angle")})
    found = know(datasheet_of(stiff), [one], SPREADS)
    whole = found.values["near_inertia"] + found.values["load_inertia"] / 9.0
    assert whole == pytest.approx(truth["near_inertia"] + truth["load_inertia"] / 9.0, rel=0.003)
    friction = found.quantities["coulomb_friction"]
    assert friction.low < truth["coulomb_friction"] < friction.high
    assert friction.source == "log"
    assert found.quantities["cable_stiffness"].source == "datasheet"
    assert any("no load angle" in words for words in found.undetermined)


def test_an_axis_that_is_not_rigid_gives_nothing_and_the_datasheet_stays():
    found = know(drive_of("turntable"), [log_with(("torque", "angle"))], SPREADS)
    assert any("not one rigid axis" in words for words in found.undetermined)
    assert {quantity.source for quantity in found.quantities.values()} == {"datasheet"}


# --- A quantity is what it is set to in every drive, draw and bound: nothing is cut off in silence
RUBBING = load_drive("dissertation-3").listed
PULLEYS = tuple(replace(pulley, viscous_friction=0.002, coulomb_friction=0.01) for pulley in RUBBING.pulley)


@pytest.mark.parametrize("motor", [RUBBING.motor, None], ids=["with a motor", "without"])
@pytest.mark.parametrize("share", [0.0, 0.1, 0.9, 1.0, 2.0])
def test_a_drive_has_the_friction_that_it_is_given(motor, share):
    """Also where that is less than the drive file gives the pulleys alone."""
    drive = replace(RUBBING, motor=motor, pulley=PULLEYS)
    before = values_of(drive)
    wanted = {name: share * before[name] for name in ("viscous_friction", "coulomb_friction")}
    moved = drive_with(drive, wanted)
    found = values_of(moved)
    for name, value in wanted.items():
        assert found[name] == pytest.approx(value, rel=1e-12, abs=1e-18), f"{name}: {found[name]:.6g}"
        first, second = (getattr(pulley, name) for pulley in moved.pulley)
        if motor is not None:
            assert first == pytest.approx(second), "the pulleys rub alike, and still do"


def quantity(name, value, half):
    return Quantity(name=name, value=value, low=value - half, high=value + half, unit="", source=LOG)


def with_less_friction(log, taken):
    """The log of a drive whose viscous friction is smaller by so much."""
    speed = difference(zero_phase(log.channel("angle"), log.interval, 100.0), log.interval)
    return replace(log, channels={**log.channels, "torque": log.channel("torque") - taken * speed})


def test_a_friction_that_comes_out_negative_is_reported_and_not_cut_in_silence():
    drive, log = drive_of("turntable"), log_with(("torque", "angle", "load_angle"))
    value, low, high = identify_chain([log], drive).intervals["viscous_friction"]
    slight = know(drive, [with_less_friction(log, value + 0.3 * (high - low))], SPREADS)
    known = slight.quantities["viscous_friction"]
    assert (known.value, known.source) == (0.0, LOG)
    assert known.low < 0.0 < known.high
    assert any("taken as 0" in words for words in slight.undetermined), slight.undetermined
    wrong = know(drive, [with_less_friction(log, 3.0 * value)], SPREADS)
    assert "viscous_friction" in ESSENTIAL
    assert wrong.open_names == ("viscous_friction",)
    assert any(
        words.startswith("viscous friction") and "signs and units" in words for words in wrong.undetermined
    )


# --- Plants are drawn with the correlation that the numbers of one log have, each as wide as it is known
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
    plants = [sampled_plants.sampled_plant(known, 2, seed, draw, correlations)[0] for draw in range(DRAWS)]
    return np.array([[plant[name] for name in sorted(known)] for plant in plants])


def matrix(correlations, names):
    root = sampled_plants.root_of(correlations, names)
    return root @ root


def test_drawn_plants_have_the_regressions_correlation_where_it_is_all_there_is():
    identified = intervals()
    correlations = sampled_plants.of_intervals(FIT, identified)
    order = [NAMES.index(name) for name in sorted(NAMES)]
    np.testing.assert_allclose(matrix(correlations, sorted(NAMES)), RHO[np.ix_(order, order)], atol=1e-12)
    seen = np.corrcoef(drawn(identified, correlations).T)
    off = np.abs(seen - RHO[np.ix_(order, order)]).max()
    assert off < 4.0 / np.sqrt(DRAWS), f"observed {off:.4f} of {4.0 / np.sqrt(DRAWS):.4f}"


def test_what_an_interval_has_beyond_the_regression_takes_its_share_of_the_correlation():
    """Twice as wide: a quarter of the variance is the regression's, a quarter of the correlation is left."""
    whole = matrix(sampled_plants.of_intervals(FIT, intervals()), sorted(NAMES))
    shared = matrix(sampled_plants.of_intervals(FIT, intervals(2.0)), sorted(NAMES))
    np.testing.assert_allclose(shared - np.eye(5), 0.25 * (whole - np.eye(5)), atol=1e-12)


def test_a_log_gives_how_its_numbers_err_together():
    """The load's own equation knows stiffness over inertia best; its errors hardly reach the motor's."""
    identified = identify_chain([log_with(("torque", "angle", "load_angle"))], drive_of("turntable"))
    found = {(one.first, one.second): one.value for one in identified.correlations}
    assert abs(found["load_inertia", "near_inertia"]) < 0.2, found
    assert found["cable_stiffness", "load_inertia"] > 0.5, found
    sizes = np.linalg.eigvalsh(matrix(identified.correlations, sorted(identified.intervals)))
    assert sizes[0] > 0.0, f"observed {sizes}"


# --- A study of an axis of a machine with routes: its units, its reduced models, its resonance, its verdi
RADIUS = 6.366e-3
"""Of the printer's motor pulley [m]."""


@pytest.fixture(scope="module")
def printer():
    return load_drive("printer-idlers", overrides=["sensors.load_encoder=40000"])


def test_the_chain_of_an_axis_holds_beyond_its_first_mode(printer, measured):
    one, three = model_quality(as_axis(printer))
    measured(f"rigid {one.holds_5:.0f} Hz, chain {three.holds_5:.0f} Hz, mode {three.exact[0]:.1f} Hz")
    assert three.frequencies == pytest.approx(three.exact, rel=1e-9)
    assert one.holds_5 < 0.5 * three.exact[0] < 1.5 * three.exact[0] < three.holds_5


def test_modes_of_an_axis_under_study_are_those_of_free_motors(printer):
    """Torque control leaves out the stepper's spring, which the file gives."""
    found = [row.frequency for row in find_modes(as_axis(printer), "").rows if row.kind == "longitudinal"]
    np.testing.assert_allclose(found, natural_frequencies(printer, count=len(found), motor="free"))


@pytest.mark.verify
def test_a_study_of_the_printer_ends_in_millimetres_that_track_confirms(printer, measured):
    goals = Goals(travel=0.02, duration=0.15, carriage_error=5e-4, draws=300, cable_draws=0)
    found = run_study(printer, (), goals)
    data = results_of(found)
    measured(data["headline"])
    assert data["verdict"] == "yes", data["headline"]
    assert data["axis"]["load"] == "head.x"
    assert "lumped plants only" in data["headline"]
    chosen = next(one for one in data["candidates"] if one["holds"])
    motion = Motion(angle=0.02 / RADIUS / DEGREE, rise=0.15, pulses=1)
    run = track(printer, controller=chosen["controller"], motion=motion, plant="model-3")
    assert run.summary["axis"]["peak_error_mm"] < chosen["worst_mm"]
    harder = run_study(printer, (), replace(goals, carriage_error=1e-6, draws=50))
    assert results_of(harder)["verdict"] != "yes"


def test_a_friction_that_the_log_finds_replaces_the_guess_and_decides_nothing():
    sheet = drive_of("turntable")
    truth = values_of(sheet)["coulomb_friction"]
    guessed = replace(sheet, motor=replace(sheet.motor, coulomb_friction=4.0 * truth))
    found = know(guessed, [log_with(("torque", "angle", "load_angle"))], SPREADS)
    friction = found.quantities["coulomb_friction"]
    assert (friction.source, friction.low <= truth <= friction.high) == (LOG, True)
    assert [(one.id, one.decides) for one in found.findings] == [("coulomb_friction", False)]
    assert found.open_names == ()


def test_ripple_of_a_drawn_motor_goes_with_the_wanted_angle_from_its_own_phase():
    drive, motion = drive_of("turntable"), goals(30, 0.3).motion
    known = by_datasheet(drive, dict.fromkeys(SPREADS, 0.0))
    case = sampled_plants.LoadCase(drive=drive, motion=motion, quantities=known)
    loop = case.loop(case.chain_law(3, 40.0))
    ripple = {"ripple_torque": 0.1, "ripple_order": 3.0, "ripple_phase": 1.0}
    more = sampled_plants.with_values(loop, ripple, None).rig.forces - loop.rig.forces
    np.testing.assert_allclose(more[:, 0], 0.1 * np.sin(3.0 * loop.target[: len(more)] + 1.0), atol=1e-12)
