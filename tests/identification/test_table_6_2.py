"""Joint and cable of Table 6.2 from a virtual multisine through the motor encoder, and their model."""

import numpy as np
import pytest

from cabledrive import load_drive
from cabledrive.identification.excitation import low_crest_multisine, multisine_lines
from cabledrive.identification.filters import difference
from cabledrive.identification.frequency_response import response_by_periods
from cabledrive.identification.model_choice import choose_model
from cabledrive.identification.response_models import fit_response
from cabledrive.rig.bench.chapter_4 import rig_of
from cabledrive.rig.bench.virtual_rig import run_rig

SEED, RATE, PERIOD, RADIUS = 2015, 5000.0, 10_000, 0.04
PRINTED = {"cable_stiffness": 850.0, "cable_damping": 0.18, "joint_stiffness": 135.0, "joint_damping": 0.075}
INERTIAS = {"motor_inertia": 0.0011, "drive_inertia": 0.000642, "load_inertia": 0.00235}
ROUGH = {
    **{name: 0.7 * value for name, value in PRINTED.items()},
    **INERTIAS,
    "viscous_friction": 0.004,
}


def measured_response(periods):
    """Odd lines of 0.5 Hz spacing up to 250 Hz; a constant part keeps the shaft turning one way."""
    rng = np.random.default_rng(SEED)
    lines = multisine_lines(PERIOD, RATE, 1.0, 250.0, odd=True)
    command = 0.12 + 0.3 * np.tile(low_crest_multisine(PERIOD, RATE, lines).values, periods)
    log = run_rig(rig_of(load_drive("dissertation-3"), 4), command, rng)
    speed = difference(log.channel("angle"), log.interval)
    # The log holds the mean of the torque over each interval, which lowers a line by its sinc.
    mean = np.sinc(np.arange(PERIOD // 2 + 1) / PERIOD)
    torque = log.channel("torque").reshape(periods, PERIOD)
    torque = np.fft.irfft(np.fft.rfft(torque, axis=1) / mean, PERIOD, axis=1).ravel()
    return response_by_periods(torque, speed, log.interval, PERIOD, lines, skipped=5)


@pytest.fixture(scope="module")
def response():
    return measured_response(13)


def test_table_6_2_lies_inside_its_intervals(response, measured):
    """Every printed value inside its 99.9 % interval, at seed 2015; inertias known from the bench tests."""
    fit = fit_response(response, 4, ROUGH, radius=RADIUS, fixed=INERTIAS)
    bounds = {name: fit.bounds(name, 0.999) for name in PRINTED}
    measured(", ".join(f"{n} {fit[n]:.5g} ({low:.5g} to {high:.5g})" for n, (low, high) in bounds.items()))
    assert 0.8 < fit.misfit < 1.5, f"{fit.misfit:.3f}"
    for name, value in PRINTED.items():
        low, high = bounds[name]
        assert low < value < high, f"{name}: {low:.6g} to {high:.6g}, printed {value}"
        assert high - low < 0.1 * value, f"{name}: {low:.6g} to {high:.6g}"


def test_model_4_is_chosen_over_1_to_3(response, measured):
    choice = choose_model(response, ROUGH, radius=RADIUS, inertias_known=True)
    measured(f"Model {choice.chosen} chosen, {choice.reason}")
    assert choice.chosen == 4, choice.reason
