"""One rigid axis with Coulomb friction: the kernel for one inertia against that for any number."""

import numpy as np
from harness import duration, side_by_side, table

from cabledrive.reduction.friction_integration import direction, integrate_chain, integrate_rigid_axis
from cabledrive.reduction.lumped_chain import LumpedChain

TITLE = "Rigid axis: motion with sensitivities"
VALUES = np.array([2e-3, 4e-3, 0.03, 1e-3])  # inertia, viscous friction, Coulomb friction, offset
INTERVAL, SAMPLES = 1e-3, 20_000
VARIED = ("inertia", "viscous", "coulomb", "offset", "speed")


def report() -> str:
    time = INTERVAL * np.arange(SAMPLES)
    torque = 0.1 * np.sin(2 * np.pi * 1.3 * time) + 0.05 * np.sin(2 * np.pi * 7.0 * time)
    inertia, viscous, coulomb, offset = ((value,) for value in VALUES)
    chain = LumpedChain(
        names=("axis",), inertias=inertia, viscous=viscous, coulomb=coulomb, offsets=offset,
        stiffness=(), damping=(), ratios=(),
    )  # fmt: skip
    directions = np.stack([direction(1, name) for name in VARIED], axis=1)
    times = side_by_side(
        {
            "one inertia": lambda: integrate_rigid_axis(VALUES, torque, INTERVAL)[0],
            "a chain of one": lambda: integrate_chain(chain, torque, INTERVAL, directions=directions).speeds[
                :, 0
            ],
        }
    )
    ours = times["one inertia"]
    rows = [
        (name, duration(timing), f"{timing.times_slower_than(ours):.1f}", f"{_apart(timing, ours):.0e}")
        for name, timing in times.items()
    ]
    note = f"{SAMPLES} samples, {len(VARIED)} sensitivities. The last column: speeds, over the largest."
    return table(["kernel", "time", "times the first", "difference"], rows) + "\n\n" + note


def _apart(one, other) -> float:
    return float(np.max(np.abs(one.result - other.result)) / np.max(np.abs(other.result)))
