"""On a machine where numba is not to be had, every method runs in numpy and gives the same."""

from pathlib import Path

import numpy as np
import pytest

import cabledrive as cd
from cabledrive.reduction.fast_simulation import simulate_fast
from cabledrive.simulation import Pluck, Scheme, Sine, Start, simulate
from command import python

DRIVE = cd.load_drive("dissertation-2")
METHODS = ("verlet", "node-centred", "energy-conserving")
HIDDEN = """
import sys

class Hidden:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in ("numba", "llvmlite"):
            raise ImportError(name)

sys.meta_path.insert(0, Hidden())
import test_without_numba as t
for rows in t.every_run():
    sys.stdout.write(rows.tobytes().hex() + "\\n")
assert "numba" not in sys.modules
"""


def every_run():
    run = {"torque": Sine(amplitude=0.02, frequency=81.7), "start": Start(plucks=(Pluck(height=1e-3),))}
    for method in METHODS:
        yield simulate(DRIVE, 2e-3, scheme=Scheme(segments=12, method=method), **run).rows
    yield simulate_fast(DRIVE, 2e-2, **run).rows


def test_every_method_gives_the_same_without_numba(measured):
    pytest.importorskip("numba")
    lines = python(HIDDEN, paths=[Path(__file__).parent]).split()
    assert len(lines) == len(METHODS) + 1
    apart = []
    for line, rows in zip(lines, every_run(), strict=True):
        found = np.frombuffer(bytes.fromhex(line)).reshape(rows.shape)
        scale = np.max(np.abs(rows), axis=0) + 1e-12
        apart.append(np.max(np.abs(found - rows) / scale))
    measured("within " + ", ".join(f"{one:.1e}" for one in apart) + f": {', '.join(METHODS)}, fast model")
    assert max(apart) < 1e-9, apart
