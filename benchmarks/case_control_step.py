"""One control step of Model 4: law and observer, compiled, on one core."""

from functools import partial

import numpy as np
from harness import duration, side_by_side, table

import cabledrive as cd
from cabledrive.control.controller_kernels import controller_step
from cabledrive.control.numbers import LawNumbers, ObserverNumbers
from cabledrive.mechanics.compiled import njit_in_place
from cabledrive.rig import Motion
from cabledrive.rig.closed_loop.chain_kernels import LoopState
from cabledrive.rig.closed_loop.loop import close_loop, loop_at_rest, run
from cabledrive.rig.laws.controllers import DesignSpec
from cabledrive.rig.tuning import design

TITLE = "One control step: law and observer of Model 4"
TARGET = 1e-6
LAWS = {
    "darc-4, filter with two offsets": ("darc-4", "printed"),
    "darc-4-damped, filter with two offsets": ("darc-4-damped", "best"),
    "backstepping-6, ten estimates, the same filter": ("backstepping-6", "printed"),
}
COMPARED = {
    "lqi": ("lqi", "printed"),
    "l1": ("l1", "printed"),
    "mrac, four estimates": ("mrac", "printed"),
    "lqi-scheduled, designs for 12 loads": ("lqi-scheduled", "printed"),
    "lqi-learning, three estimates and their covariance": ("lqi-learning", "printed"),
}
"""Further laws."""


@njit_in_place
def steps(
    observer: ObserverNumbers,
    law: LawNumbers,
    reference: np.ndarray,
    readings: np.ndarray,
    limit: float,
    s: LoopState,
) -> float:
    """Command after command from recorded readings: correct, law, limit, predict; returns their sum."""
    total = 0.0
    for k in range(readings.shape[0]):
        for j in range(s.readings.size):
            s.readings[j] = readings[k, j]
        _, command, _, _ = controller_step(observer, law, limit, s.controller, s.readings, reference, k)
        total += command
    return total


def report() -> str:
    prepared = {name: made(*choice) for name, choice in (LAWS | COMPARED).items()}
    times = side_by_side({name: partial(once, *parts) for name, parts in prepared.items()})
    rows = []
    for name, timing in times.items():
        samples = len(prepared[name][1])
        each = timing.median / samples
        rows.append((name, duration(timing), f"{1e9 * each:.0f} ns", "yes" if each < TARGET else "no"))
    note = (
        "Three encoder readings in, one limited torque out: correction and prediction of nine filter states, flat "
        "output, sliding variable, projection of four estimates (of ten). Readings are those of a pulse on the rig; their "
        "copying is counted, the rig is not. Target: less than 1 microsecond."
    )
    return table(["law", "5,001 samples", "one step", "below 1 microsecond"], rows) + "\n\n" + note


def made(name: str, gains: str) -> tuple:
    drive, motion = cd.load_drive("dissertation-3").two_pulleys, Motion()
    spec = DesignSpec(drive, motion, best=gains == "best")
    loop = close_loop(DesignSpec(drive, motion), design(name, spec), np.random.default_rng(0))
    first = 2 * loop.chain.size + 1
    log = run(loop).log
    readings = np.ascontiguousarray(log[:, first : first + 3])
    return loop, readings, log[:, first + 3]


def once(loop, readings: np.ndarray, commands: np.ndarray) -> float:
    state, made = loop_at_rest(loop), loop.controller
    total = steps(loop.observer, made.law, made.reference, readings, loop.rig.torque_limit, state)
    assert abs(total - commands.sum()) < 1e-6 * np.abs(commands).sum(), "not the commands of the rig"
    return total
