"""One control step of the laws of two motors, compiled, on one core."""

from functools import partial

import numpy as np
from harness import duration, side_by_side, table

import cabledrive as cd
from cabledrive.control.observers import FlankLaw, first_memory, preload_step
from cabledrive.control.tension_position import TensionGains, first_state, step_in_place
from cabledrive.mechanics.compiled import njit_in_place
from cabledrive.reduction.two_motors import winched_machine
from cabledrive.rig import Motion, RigOptions
from cabledrive.rig.closed_loop.chain_plant import doubled
from cabledrive.rig.closed_loop.loop import close_loop
from cabledrive.rig.laws.controllers import DesignSpec
from cabledrive.rig.tuning import design
from cabledrive.rig.winch_plan import design_tensions

TITLE = "One control step of the laws of two motors"
TARGET, SAMPLES = 1e-6, 20_000


@njit_in_place
def winch_steps(
    gains: TensionGains,
    state: np.ndarray,
    measurement: np.ndarray,
    row: np.ndarray,
    command: np.ndarray,
    space: tuple[np.ndarray, np.ndarray],
    count: int,
) -> float:
    """Step after step on one measurement; returns the sum of the torques."""
    total = 0.0
    for _ in range(count):
        step_in_place(gains, state, measurement, row, command, space)
        total += command[0]
    return total


@njit_in_place
def preload_steps(
    law: FlankLaw, memory: np.ndarray, work: np.ndarray, flanks: np.ndarray, count: int
) -> float:
    """Step after step on a reading that moves; returns the sum of the torques."""
    total = 0.0
    for k in range(count):
        total += preload_step(law, memory, (3e-3 + 1e-4 * (k % 7), 1e-4 * (k % 5), 0.1), work, flanks)
    return total


def report() -> str:
    machine = winched_machine(cd.load_drive("camera-winches"))
    gains, m = design_tensions(machine).gains, machine.numbers.mass.size
    state, measurement = first_state(gains, machine.tension), np.append(np.zeros(2), machine.tension)
    space = (np.zeros(3 * m + 2), np.zeros(2), (np.zeros((2, m)), np.zeros(3 * m + 22)))
    law = pair_law()
    cases = {
        "tension-position, camera-winches": partial(winch_steps, gains, state, measurement, *space, SAMPLES),
        "preload of a pair of motors, beside its law of position": partial(
            preload_steps, law, first_memory(law, 0), np.zeros(8), np.zeros(2), SAMPLES
        ),
    }
    rows = []
    for name, timing in side_by_side(cases).items():
        each = timing.median / SAMPLES
        rows.append((name, duration(timing), f"{1e9 * each:.0f} ns", "yes" if each < TARGET else "no"))
    return table(["law", "20,000 samples", "one step", "below 1 microsecond"], rows)


def pair_law() -> FlankLaw:
    drive = doubled(cd.load_drive("dissertation-3", overrides=["motor.backlash=1 deg"]).two_pulleys)
    options, motion = RigOptions(pair=True), Motion(order=11)
    spec = DesignSpec(drive, motion, bandwidth=15.0, options=options)
    made = close_loop(
        DesignSpec(drive, motion, options=options), design("lqg", spec), np.random.default_rng(0)
    )
    assert made.pair is not None
    return made.pair.law
