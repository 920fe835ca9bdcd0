"""Motions that show what the alarm distinguishes: a smooth move, ripple on it, a run-up, a slow passage."""

import numpy as np

from cabledrive.parameters import Drive
from cabledrive.reduction.autoparametric import autoparametric_model
from cabledrive.studies.planned_motion import PlannedMotion
from cabledrive.trajectories import smooth_rise

RISE, DURATION = 0.5, 2.0
ANGLE = np.pi / 4
RIPPLE, RUN_UP, PASSAGE = 2e-2, 4e-2, 1.5e-2


def example_motions(drive: Drive) -> dict[str, PlannedMotion]:
    """Motions of two seconds, by what they are.

    ``drive``: with two pulleys that turn.
    """
    time = np.linspace(0.0, DURATION, 16_001)
    model = autoparametric_model(drive)
    natural, arm = model.natural, drive.drive_pulley.radius
    acceleration = smooth_rise(time / RISE, derivatives=2)[2] * ANGLE / RISE**2
    move = model.rigid_mass * arm**2 * acceleration
    tuned = np.sin(natural * time)
    ratio = np.linspace(0.8, 1.05, time.size)
    run_up = np.sin(natural * np.cumsum(ratio) * time[1])
    drift = drive.cable.pretension * np.linspace(0.95, 1.05, time.size)
    return {
        "45 deg in 0.5 s, smooth": PlannedMotion(time=time, torque=move),
        "the same with a ripple of 20 mN m": PlannedMotion(time=time, torque=move + RIPPLE * tuned),
        "run-up through the pulley mode, 40 mN m": PlannedMotion(time=time, torque=RUN_UP * run_up),
        "tension rising through tuning, 15 mN m": PlannedMotion(
            time=time, torque=PASSAGE * tuned, pretension=drift
        ),
    }
