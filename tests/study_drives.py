"""Five drives of our own and their logs, for the tests of the study."""

from dataclasses import dataclass, replace
from functools import cache
from io import StringIO
from pathlib import Path

import numpy as np

from cabledrive.app.results import log_csv
from cabledrive.identification.logs.log import log_of
from cabledrive.parameters import load_drive
from cabledrive.rig.experiment import Excitation, experiment
from cabledrive.rig.setting import DEGREE
from cabledrive.studies.study import Goals
from cabledrive.studies.study.acceptance_stage import AcceptanceResult
from cabledrive.studies.study.findings import Findings
from cabledrive.studies.study.verdict_stage import judge

FOLDER = Path(__file__).parent / "studies" / "drives"
LIVELY = Excitation(kind="multisine", duration=12.0, amplitude=0.6, band=(0.25, 10.0), period=4.0)
ONE_WAY = Excitation(kind="sines", duration=8.0, frequencies=(0.5,), amplitudes=(0.02,), bias=0.1)


@dataclass(frozen=True)
class Case:
    """A drive, what is asked of it, how it was logged, and what the study has to say."""

    name: str
    goals: Goals
    log: Excitation | None
    verdict: str
    reason: str


def goals(angle, duration, **more):
    options = {"dwell": 0.1, "draws": 20, "cable_draws": 0} | more
    return Goals(angle=angle * DEGREE, duration=duration, **options)


FOLLOWS, CLOSE = goals(30, 0.3, error=0.3 * DEGREE, draws=300), 0.5 * DEGREE
WRIST = goals(60, 0.3, error=1.0 * DEGREE, draws=300, backlash=0.0)
TORQUE = "torque: the motion needs 6.817 N m, and 0.4 N m is the limit"
CASES = (
    Case("turntable", FOLLOWS, LIVELY, "yes", "follows 30 deg in 0.3 s within the goal of 0.3 deg"),
    Case("wrist", WRIST, None, "yes", "within the goal of 1 deg"),
    Case("harp", goals(20, 0.3, error=CLOSE), None, "no", "has 0.4995 of the pulley mode's frequency"),
    Case("winch", goals(90, 0.3, error=CLOSE), None, "no", TORQUE),
    Case("spindle", goals(45, 0.3, error=CLOSE), ONE_WAY, "unknown", "but so few runs prove only"),
)


def drive_of(name):
    return load_drive(FOLDER / f"{name}.toml").listed


def datasheet_of(drive):
    """What a data sheet might say of this drive: some per cent beside the truth."""
    first, second = drive.pulley
    motor = replace(
        drive.motor,
        inertia=1.06 * drive.motor.inertia,
        coulomb_friction=0.8 * drive.motor.coulomb_friction,
        viscous_friction=1.2 * drive.motor.viscous_friction,
        offset_torque=0.0,
    )
    return replace(drive, motor=motor, pulley=(first, replace(second, inertia=0.94 * second.inertia)))


@cache
def log_text(name, excitation, seed=1):
    return log_csv(experiment(drive_of(name), excitation, seed=seed))


def written_log(folder, name, excitation):
    if excitation is None:
        return []
    path = folder / f"{name}.csv"
    path.write_text(log_text(name, excitation))
    return [path]


def log_with(names):
    """The lively log of the turntable, with some of its channels."""
    text = log_text("turntable", LIVELY)
    rows = np.loadtxt(StringIO(text), delimiter=",", skiprows=1).T
    heads = {"torque": "torque [N m]", "angle": "angle [rad]", "load_angle": "load angle [rad]"}
    listed = text.splitlines()[0].split(",")
    channels = {name: rows[listed.index(heads[name])] for name in names}
    units = {"torque": "N m", "angle": "rad", "load_angle": "rad"}
    return log_of(rows[0], channels, {name: units[name] for name in names})


def judged_with(found, goals, runs):
    """The verdict of a study, had its chosen law these runs and the study these goals."""
    error = goals.carriage_error if runs.plant == "carriage" else goals.error
    chosen = found.laws.chosen
    runs = replace(runs, law=chosen, goal=error)
    cable = AcceptanceResult(plant="cable")
    laws = replace(found.laws, scores=(runs,), cable_scores=(), runs=runs, cable=cable)
    names = ("check", "knowledge", "demand", "resonance", "model", "controller")
    parts = {name: getattr(found, name) for name in names}
    return judge(Findings(goals=goals, laws=laws, **parts))
