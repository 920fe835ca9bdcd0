"""Computations of known work for the measurements of campaigns; worker processes import them by name."""

import time
from dataclasses import dataclass

from cabledrive.campaign import Output, Row

OUTPUTS = (Output(name="y", unit="1", meaning="nothing"),)


@dataclass(frozen=True)
class Sleeping:
    """A pause [s], which takes no processor."""

    pause: float
    identity: str = "sleeping"
    outputs: tuple[Output, ...] = OUTPUTS

    def one(self, row: Row) -> dict[str, float]:
        time.sleep(self.pause)
        return {"y": 0.0}


@dataclass(frozen=True)
class Spinning:
    """So many additions in plain Python."""

    turns: int
    identity: str = "spinning"
    outputs: tuple[Output, ...] = OUTPUTS

    def one(self, row: Row) -> dict[str, float]:
        return {"y": spin(self.turns)}


def spin(turns: int) -> float:
    total = 0.0
    for i in range(turns):
        total += i
    return total
