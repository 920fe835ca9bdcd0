"""How does a controller of your own become C? PD at the motor, integral at the load, in translated Python."""

import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import NamedTuple

import numba

import cabledrive as cd


class Gains(NamedTuple):
    position: float  # [N m/rad]
    speed: float  # [N m s/rad]
    integral: float  # [N m/(rad s)]
    interval: float  # [s]


@numba.njit
def step(gains, state, measurement, reference):
    """PD and integral, element by element; the state is changed in place."""
    state[0] += gains.interval * (reference[1] - measurement[1])
    feedback = gains.position * (reference[0] - measurement[0]) + gains.speed * (
        reference[2] - measurement[2]
    )
    return state, reference[4] + feedback + gains.integral * state[0]


mine = cd.OwnController(
    step=step,
    gains=Gains(position=8.0, speed=0.3, integral=20.0, interval=2e-4),
    initial_state=[0.0],
    name="mine",
    sample_time=2e-4,
    shafts=("motor", "load"),
)
with tempfile.TemporaryDirectory() as place:
    folder = Path(place) / "firmware"
    made = cd.export_to(folder, "dissertation-3", "c99", controller=mine)
    print(", ".join(made["files"]))
    assert abs(made["sample_time"] - 2e-4) < 1e-12
    if shutil.which("cc"):
        compile_it = "cc -std=c99 -ffp-contract=off *.c -lm -o check && ./check"
        done = subprocess.run(compile_it, shell=True, cwd=folder, capture_output=True, text=True, check=True)
        print(done.stdout)
        assert "largest difference 0 N m" in done.stdout
