"""A chain whose joints and segments know what they are on the machine."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.chain import Chain

MOTOR_JOINT = "motor joint"
HOLDING_SPRING = "holding stiffness"


@dataclass(frozen=True, slots=True, kw_only=True)
class Stretch:
    """A piece of a span between two neighbouring joints."""

    span: str  # "upper" or "lower": of a chain that is built in Python, "segment 0" and on
    start: float  # unstretched position from the pulley where the span starts [m]
    end: float  # the same [m]


@dataclass(frozen=True, eq=False, kw_only=True)
class LabelledChain:
    """A chain whose joints and segments know what they are on the machine.

    Attributes
    ----------
    chain : Chain
    joints : tuple of str
        "drive pulley", "load pulley", "carriage 3" (its number in the file); then the
        pendants: "motor".
    stretches : tuple of Stretch
        One for each segment.
    pendant_springs : tuple of str
        Names of the springs of its pendants; by default of one, the motor's.
    ground : {"", "motor joint", "holding stiffness", "spring to the ground"}, default ""
        What its springs to the ground are.
    """

    chain: Chain
    joints: tuple[str, ...]
    stretches: tuple[Stretch, ...]
    pendant_springs: tuple[str, ...] = (MOTOR_JOINT,)
    ground: str = ""

    @cached_property
    def carriages(self) -> NDArray[np.intp]:
        """Which of the joints are carriages."""
        carried = [number for number, name in enumerate(self.joints) if name.startswith("carriage")]
        return np.array(carried, dtype=np.intp)
