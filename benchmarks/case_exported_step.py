"""One control step of Model 4 in exported C beside the same kernels in machine code by numba, on one core."""

import ctypes
import json
import shutil
import subprocess
import tempfile
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
from case_control_step import COMPARED, LAWS, made, steps
from harness import duration, side_by_side, table

import cabledrive as cd
from cabledrive.export.c99 import controller_package
from cabledrive.export.source import ExportSource
from cabledrive.rig.closed_loop.loop import loop_at_rest
from cabledrive.rig.laws.controller_file import controller_from, controller_numbers

TITLE = "One control step in exported C"
TARGET = 150e-9
COMPILERS = ("gcc -O2", "clang -O2", "clang -O3 -march=native")
REPLAY = """
#include "cabledrive_law.h"
double replay(const double *y, const double *ref, long n)
{
    static cd_law law;
    double total = 0.0, u = 0.0;
    cd_init(&law, y);
    for (long k = 0; k < n; ++k) {
        cd_step(&law, y + k * CD_READINGS, ref + k * CD_REFERENCES, &u);
        total += u;
    }
    return total;
}
"""


def report() -> str:
    rows, present = [], [one for one in COMPILERS if shutil.which(one.split()[0])]
    for label, (name, _) in (LAWS | COMPARED).items():
        loop, readings, _ = made(name, "printed")
        data = controller_numbers(loop, cd.load_drive("dissertation-3").two_pulleys, "motor")
        law = controller_from(json.loads(json.dumps(data)), name)
        files = controller_package(ExportSource(law=law, data=data, drive=None))
        contestants = {"numba": partial(by_numba, replace(loop, observer=law.observer), readings)}
        reference = np.ascontiguousarray(loop.controller.reference)
        for compiler in present:
            contestants[compiler] = partial(by_c, library(files, compiler), readings, reference)
        times = side_by_side(contestants)
        each = {one: 1e9 * timing.median / len(readings) for one, timing in times.items()}
        for one, timing in times.items():
            below = "yes" if 1e-9 * each[one] < TARGET else "no"
            rows.append((label, one, duration(timing), f"{each[one]:.0f} ns", below))
    note = (
        "The same readings and reference rows; the filter at the gain on which it settles. C: -ffp-contract=off, every "
        "sum in the order of the Python; numba may reorder them. Target: less than 150 ns. Absent here: "
        f"{', '.join(one for one in COMPILERS if one not in present) or 'no compiler'}."
    )
    return table(["law", "by", "whole motion", "one step", "below 150 ns"], rows) + "\n\n" + note


def library(files: dict[str, str], compiler: str) -> ctypes.CDLL:
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        for name in ("cabledrive_law.h", "cabledrive_law.c"):
            (place / name).write_text(files[name])
        (place / "replay.c").write_text(REPLAY)
        command = [
            *compiler.split(),
            "-std=c99",
            "-ffp-contract=off",
            "-shared",
            "-fPIC",
            "replay.c",
            "cabledrive_law.c",
        ]
        subprocess.run([*command, "-lm", "-o", "law.so"], cwd=place, check=True)
        return ctypes.CDLL(str(place / "law.so"))


def by_c(law: ctypes.CDLL, readings: np.ndarray, reference: np.ndarray) -> float:
    law.replay.restype = ctypes.c_double
    address = [ctypes.c_void_p(array.ctypes.data) for array in (readings, reference)]
    return law.replay(*address, ctypes.c_long(len(readings)))


def by_numba(loop, readings: np.ndarray) -> float:
    state, made = loop_at_rest(loop), loop.controller
    return steps(loop.observer, made.law, made.reference, readings, loop.rig.torque_limit, state)
