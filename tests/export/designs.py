"""Controllers to export, as fast as they can be had: no trial runs choose their gains; and C compilers."""

import json
import shutil
import subprocess
from dataclasses import replace
from functools import cache
from typing import NamedTuple

import numpy as np
import pytest

import cabledrive as cd
from cabledrive.export.source import ExportSource
from cabledrive.rig import Motion
from cabledrive.rig.closed_loop.loop import Loop, close_loop, run
from cabledrive.rig.laws.controller_file import controller_from, controller_numbers
from cabledrive.rig.laws.controllers import DesignSpec
from cabledrive.rig.laws.registry import CONTROLLERS, needed_order

DRIVE = cd.load_drive("dissertation-3").listed


@cache
def loop_of(name: str, drive: str = "dissertation-3") -> Loop:
    loaded = cd.load_drive(drive).listed
    motion = Motion(order=needed_order(name, loaded))
    made = CONTROLLERS[name](DesignSpec(loaded, motion))
    return close_loop(DesignSpec(loaded, motion), made, np.random.default_rng(0))


@cache
def source_of(name: str, drive: str = "dissertation-3") -> ExportSource:
    loaded = cd.load_drive(drive).listed
    data = controller_numbers(loop_of(name, drive), loaded, "motor")
    law = controller_from(json.loads(json.dumps(data)), "controller.json")
    return ExportSource(law=law, data=data, drive=loaded)


def replayed(loop: Loop, law, start, step, samples: int):
    """Commands of a target on the readings of a run of the rig with its settled filter, and the rig's."""
    log = run(replace(loop, observer=law.observer), last=samples).log[:samples]
    first, m = 2 * loop.chain.size + 1, len(law.encoders)
    start(log[0, first : first + m].copy())
    found = []
    for k in range(samples):
        command, valid = step(log[k, first : first + m].copy(), loop.controller.reference[k : k + 1])
        assert valid
        found.append(command)
    return found, log[:, first + m]


class Gains(NamedTuple):
    row: np.ndarray
    integral: float
    limit: int


def clipped(value: float, limit: float) -> float:
    return min(max(value, -limit), limit)


def step(gains, state, measurement, reference):
    state[0] = clipped(state[0] + 2e-4 * (reference[1] - measurement[1]), gains.limit)
    total = reference[-1] + gains.integral * state[0]
    for i in range(measurement.size):
        total += gains.row[i] * (reference[i] - measurement[i])
    return state, total


OWN = cd.OwnController(
    step=step,
    gains=Gains(np.array([8.0, 0.5, 0.3, 0.02]), 20.0, 3),
    initial_state=[1e-3],
    name="mine",
    shafts=("motor", "load"),
)


# --- Compile and run what was exported
needs_cc = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
WARNINGS = ("-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wshadow", "-Werror")
COMPILERS = [one for one in ("gcc", "clang") if shutil.which(one)]


def built(folder, *flags, compiler="cc", name="check"):
    """Compile every C file of a folder."""
    if shutil.which(compiler) is None:
        pytest.skip(f"{compiler} is not installed")
    files = [path.name for path in sorted(folder.glob("*.c"))]
    command = [compiler, "-std=c99", "-ffp-contract=off", *flags, *files, "-lm", "-o", name]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)


def checked(folder, *flags, compiler="cc"):
    """Compile and run the self-test."""
    done = built(folder, *flags, compiler=compiler)
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    return subprocess.run(["./check"], cwd=folder, capture_output=True, text=True, check=False)
