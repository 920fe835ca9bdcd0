"""The study's whole claims: the true plant within the bound, ten kills, intervals over many logs."""

import json
import os
import random
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import binom

from cabledrive.app.results import log_csv
from cabledrive.identification.logs.log import log_of
from cabledrive.parameters import load_drive
from cabledrive.parameters.drive_file import drive_text
from cabledrive.reduction.quality import model_quality
from cabledrive.rig.closed_loop.loop import close_loop, run
from cabledrive.rig.experiment import Excitation, experiment
from cabledrive.rig.setting import DEGREE, Motion
from cabledrive.rig.tuning import LawSetting
from cabledrive.studies.study import Goals, run_study
from cabledrive.studies.study.acceptance_stage import accept
from cabledrive.studies.study.chain_regression import identify_chain
from cabledrive.studies.study.goals import SPREADS
from cabledrive.studies.study.knowledge_stage import know
from cabledrive.studies.study.machine import values_of
from cabledrive.studies.study.plants import Plant, design_controller, load_case
from cabledrive.studies.study.sampled_plants import LoadCase
from cabledrive.studies.study.stage_cache import StageCache

TRUTH = load_drive("dissertation-3").listed
DRAWS = 1000


def datasheet(truth=TRUTH):
    """Dissertation-3 as a data sheet might have it: no fitted stiffness, everything else beside the truth."""
    first, second = truth.pulley
    motor = replace(
        truth.motor,
        inertia=0.00118,
        viscous_friction=0.0026,
        coulomb_friction=0.03,
        offset_torque=0.0,
        joint_stiffness=118.0,
        joint_damping=0.06,
    )
    pulleys = (replace(first, inertia=0.0006), replace(second, inertia=0.0026))
    stiffer = 1.9 * truth.cable.youngs_modulus  # of which the log identifies EA/L, within 5 %
    cable = replace(truth.cable, youngs_modulus=stiffer, axial_damping=3.0)
    return replace(truth, name="data sheet", motor=motor, pulley=pulleys, cable=cable, lumped=None)


MULTISINE = Excitation(kind="multisine", duration=20.0, amplitude=0.5, band=(0.25, 10.0), period=8.0)


def accepted_on_the_truth(truth, excitation, folder, draws, cable_draws, measured, **goals):
    """A study from a log alone; of both plants, how many runs of the true one leave the stated bound."""
    path = folder / "log.csv"
    path.write_text(log_csv(experiment(truth, excitation, seed=3)))
    asked = Goals(angle=45.0 * DEGREE, duration=0.5, draws=draws, cable_draws=0, **goals)
    found = run_study(datasheet(truth), [path], asked)
    control = found.controller
    case = load_case(found.known, found.goals, found.knowledge)
    law = case.chain_law(control.model, control.bandwidth)
    outside = {}
    for plant, runs in (("lumped", draws), ("cable", cable_draws)):
        spec = replace(case.spec, plant=truth)
        loop = close_loop(spec, law, np.random.default_rng(0), "cable" if plant == "cable" else None)
        peaks = []
        for seed in range(runs):
            phases = np.random.default_rng([9, seed]).uniform(-0.5, 0.5, len(loop.rig.phases))
            done = run(replace(loop, rig=loop.rig._replace(phases=phases)), log=False)
            assert done.ended == len(loop.target)
            peaks.append(done.state.summary[0] / loop.gear)
        outside[plant] = sum(peak > control.bound for peak in peaks)
        words = f"{plant}: {runs - outside[plant]} of {runs} in {control.bound / DEGREE:.3f} deg"
        measured(f"{words}; median {np.median(peaks) / DEGREE:.3f}, worst {max(peaks) / DEGREE:.3f} deg")
    assert found.knowledge.findings == (), found.knowledge.findings
    return outside


SLOWER = replace(TRUTH, sensors=replace(TRUTH.sensors, sample_rate=2000.0))
"""For time."""


@pytest.mark.parametrize(
    ("truth", "excitation", "draws", "cable_draws", "goals"),
    [
        pytest.param(SLOWER, MULTISINE, 50, 1, {"dwell": 0.1}, id="a twentieth"),
        pytest.param(TRUTH, None, DRAWS, 20, {}, marks=pytest.mark.verify, id="three sines of 70 s"),
        pytest.param(TRUTH, MULTISINE, DRAWS, 20, {}, marks=pytest.mark.verify, id="multisine of 20 s"),
    ],
)
def test_a_controller_from_virtual_logs_alone_keeps_its_bound_on_the_true_plant(
    truth, excitation, draws, cable_draws, goals, tmp_path, measured
):
    """At least 99 % of 1,000 runs of the true plant, encoders at random phases, stay in the stated bound.

    Of 50 no more leave it than one in a hundred does at a chance of 1e-3; the one with the cable: noted.
    """
    outside = accepted_on_the_truth(truth, excitation, tmp_path, draws, cable_draws, measured, **goals)
    most = 0.01 * draws if draws == DRAWS else binom.isf(1e-3, draws, 0.01)
    assert outside["lumped"] <= most
    assert draws < DRAWS or outside["cable"] <= 0.05 * cable_draws


@pytest.mark.verify
def test_intervals_hold_the_truth_in_19_of_20_logs(measured):
    """They count what filters move and what the residual could hide, so they hold more than 95 %."""
    held, truth = {}, values_of(TRUTH)
    for seed in range(20):
        log = experiment(TRUTH, MULTISINE, seed=seed)
        identified = identify_chain([log_of(log.time, log.channels, log.units)], datasheet())
        for name, (_, low, high) in identified.intervals.items():
            held.setdefault(name, []).append(low <= truth[name] <= high)
    shares = {name: np.mean(hits) for name, hits in held.items()}
    measured("held by " + ", ".join(f"{name} {100 * share:.0f} %" for name, share in shares.items()))
    assert min(shares.values()) >= 0.95, shares


def study_command(out: Path, drive: Path, *options: str) -> list[str]:
    return [sys.executable, "-m", "cabledrive", "study", str(drive), *options, "-o", str(out), "--quiet"]


def without_times(out: Path) -> tuple[str, dict[str, object]]:
    """Report and results but for when they were written, and the digests of what holds that."""
    import re

    results = json.loads((out / "results.json").read_text())
    del results["sha256"], results["files"]["report.html"]
    report = re.sub(r"<time.*?</time>|Written on .*? UTC", "", (out / "report.html").read_text(), flags=re.S)
    return report, results


@pytest.mark.verify
def test_ten_kills_at_random_moments_leave_the_same_report(tmp_path, measured):
    drive, log, goals = tmp_path / "drive.toml", tmp_path / "log.csv", tmp_path / "study.toml"
    drive.write_text(drive_text(datasheet()))
    log.write_text(log_csv(experiment(TRUTH, MULTISINE, seed=3)))
    asked = '[goals]\nerror = "0.5 deg"\n[motion]\nangle = "45 deg"\nduration = "0.5 s"\n'
    goals.write_text(f"{asked}[acceptance]\ndraws = 400\ncable_draws = 0\n")
    given = ("--log", str(log), "--goals", str(goals))
    begun = time.monotonic()
    subprocess.run(study_command(tmp_path / "calm", drive, *given), check=True, capture_output=True)
    whole = time.monotonic() - begun
    dice, kills = random.Random(5), []
    disturbed = study_command(tmp_path / "killed", drive, *given)
    while len(kills) < 10:
        started = subprocess.Popen(disturbed, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        moment = dice.uniform(0.05, 0.7) * whole
        try:
            started.wait(timeout=moment)
        except subprocess.TimeoutExpired:
            os.kill(started.pid, signal.SIGKILL)
            started.wait()
            kills.append(moment)
        else:  # it came to its end between two kills: begin anew
            for path in sorted((tmp_path / "killed").rglob("*"), reverse=True):
                path.rmdir() if path.is_dir() else path.unlink()
    subprocess.run(disturbed, check=True, capture_output=True)
    calm, killed = without_times(tmp_path / "calm"), without_times(tmp_path / "killed")
    moments = ", ".join(f"{k:.1f}" for k in kills)
    measured(f"killed after {moments} s of {whole:.1f} s; same to the byte: {killed == calm}")
    assert killed == calm
    assert killed[1]["verdict"] == "yes"


@pytest.mark.verify
def test_a_second_run_is_served_in_under_three_seconds(tmp_path, measured):
    drive = tmp_path / "drive.toml"
    drive.write_text(drive_text(TRUTH))
    command = study_command(tmp_path / "out", drive)
    subprocess.run(command, check=True, capture_output=True)
    begun = time.monotonic()
    subprocess.run(command, check=True, capture_output=True)
    spent = time.monotonic() - begun
    measured(f"served in {spent:.2f} s")
    assert spent < 3.0


# --- The stated bound where all that is known is the data sheet
DRIVE = load_drive("dissertation-3").listed


@pytest.mark.parametrize("draws", [40, pytest.param(1000, marks=pytest.mark.verify)])
def test_no_plant_within_the_datasheet_leaves_the_bound(draws, measured):
    """Of the law that the bound is stated for, on plants without backlash."""
    known = know(DRIVE, [], SPREADS, backlash=0.0)
    motion = Motion()
    holds = {one.model: one.holds_5 for one in model_quality(DRIVE) if one.model in (3, 4)}
    control = design_controller(LoadCase(drive=DRIVE, motion=motion, quantities=known.quantities), holds)
    law = LawSetting(controller=control.name, model=control.model, bandwidth=control.bandwidth)
    cache, asked = (
        StageCache(folder=None, note=lambda line: None),
        Goals(angle=np.pi / 4, duration=0.5, seed=7),
    )
    plant = Plant(drive=DRIVE, goals=asked, cache=cache, known=known)
    runs = accept(plant, law, "lumped", draws, bound=control.bound)
    worst, bound = np.degrees(runs.peaks[-1]), np.degrees(control.bound)
    measured(f"bound {bound:.3f} deg, worst {worst:.3f} deg; {100 * runs.inside:.1f} % within")
    assert runs.inside == 1.0
    assert bound < 3.0 * worst
