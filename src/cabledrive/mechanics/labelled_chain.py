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
    """A piece of a span between two neighbouring joints.

    Attributes
    ----------
    span : {"upper", "lower"}
        Of a chain that is built in Python, "segment 0" and on.
    start, end : float
        Unstretched positions from the pulley where the span starts [m].
    """

    span: str
    start: float
    end: float


@dataclass(frozen=True, eq=False, kw_only=True)
class LabelledChain:
    """A chain whose joints and segments know what they are on the machine.

    Attributes
    ----------
    chain : Chain
    joints : tuple of str
        "drive pulley", "load pulley", "carriage 3" (its number in the file); last "motor", if it has a joint.
    stretches : tuple of Stretch
        One for each segment.
    ground : {"", "motor joint", "holding stiffness", "spring to the ground"}, default ""
        What its springs to the ground are.
    """

    chain: Chain
    joints: tuple[str, ...]
    stretches: tuple[Stretch, ...]
    ground: str = ""

    @cached_property
    def carriages(self) -> NDArray[np.intp]:
        """Which of the joints are carriages."""
        carried = [number for number, name in enumerate(self.joints) if name.startswith("carriage")]
        return np.array(carried, dtype=np.intp)


def own_chain(chain: Chain) -> LabelledChain:
    """A chain built in Python: joints "joint 0", ..., and each segment a span of its own, "segment 0", ..."""
    joints = tuple(f"joint {i}" for i in range(chain.masses.size))
    stretches = tuple(
        Stretch(span=f"segment {i}", start=0.0, end=float(length)) for i, length in enumerate(chain.lengths)
    )
    pendant = ("motor",) if chain.pendant is not None else ()
    sprung = chain.pendant_ground > 0.0 or bool(np.any(chain.ground_springs))
    return LabelledChain(
        chain=chain,
        joints=joints + pendant,
        stretches=stretches,
        ground="spring to the ground" if sprung else "",
    )
