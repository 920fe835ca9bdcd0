"""Computations of the tests' own, which worker processes import by name."""

import os
import signal
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cabledrive.campaign import Output, run_sweep
from cabledrive.parameters import InputRefused


@dataclass(frozen=True)
class Ishigami:
    """sin x1 + 7 sin^2 x2 + 0.1 x3^4 sin x1, x uniform between -pi and pi; its indices are known."""

    identity: str = "ishigami"
    outputs: tuple[Output, ...] = (Output(name="y", unit="1", meaning="Ishigami's function"),)

    def one(self, row):
        x = [row.own[f"x{i}"] for i in (1, 2, 3)]
        return {"y": np.sin(x[0]) + 7.0 * np.sin(x[1]) ** 2 + 0.1 * x[2] ** 4 * np.sin(x[0])}


@dataclass(frozen=True)
class Dangerous:
    """The square of ``own.x``; its row may be refused, end the process always, or once."""

    folder: str
    poison: tuple[float, ...] = ()
    once: tuple[float, ...] = ()
    identity: str = "dangerous"
    outputs: tuple[Output, ...] = (Output(name="square", unit="1", meaning="x squared"),)

    def one(self, row):
        x = row.own["x"]
        mark = Path(self.folder) / f"killed-{x:.0f}"
        if x in self.once and not mark.exists():
            mark.touch()
            os.kill(os.getpid(), signal.SIGKILL)
        if x in self.poison:
            os.abort()
        if x == 3.0:
            raise InputRefused("x = 3 is refused: take another")
        return {"square": x * x + (row.seed % 7)}


@dataclass(frozen=True)
class Sleepy:
    """Sine of ``own.x`` after a pause [s]."""

    pause: float
    identity: str = "sleepy"
    outputs: tuple[Output, ...] = (Output(name="y", unit="1", meaning="sine of x"),)

    def one(self, row):
        time.sleep(self.pause)
        return {"y": np.sin(row.own["x"])}


def swept(folder, text, store="store.zarr", **options):
    """A campaign whose file is written into a folder and run there."""
    (folder / "spec.toml").write_text(text)
    return run_sweep(folder / "spec.toml", folder / store, progress=False, **options)
