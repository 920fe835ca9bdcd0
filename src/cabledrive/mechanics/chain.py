"""Wave-carrying segments joined at point masses, and what joints and segments are on the machine."""

from dataclasses import dataclass, replace
from math import sqrt
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cabledrive.parameters.arrays import Array
from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.fields import described, meaning


@described
@dataclass(frozen=True, slots=True, kw_only=True)
class Pendant:
    """A mass on a spring at a joint: a motor behind a flexible joint, an absorber."""

    stiffness: float = meaning("of the spring between joint and mass [N/m]")
    mass: float = meaning("[kg]")
    joint: int = meaning("number of the joint", 0)
    ground: float = meaning("stiffness from the mass to the ground [N/m]: the motor's holding stiffness", 0.0)


@described
@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Chain:
    r"""Segments that carry waves, joined at point masses: an open line or a closed ring.

    Lengths and density are per unstretched metre, so that
    :math:`\rho_0\,\ddot u = R\,\partial^2 u/\partial s^2` with :math:`R = EA` for longitudinal motion and
    :math:`R = T_0/(1+\varepsilon_0)` for transverse motion.
    """

    rigidity: float | Array = meaning(
        "(m,): force per slope R [N]; an array where the segments are different cables"
    )
    density: float | Array = meaning("(m,): mass per length rho0 [kg/m], likewise")
    lengths: Array = meaning(
        "(m,): lengths of the segments [m]; segment i from joint i to i + 1, a ring's last one to joint 0"
    )
    masses: Array = meaning("(n,): masses at the joints [kg]; m = n of a ring, m = n - 1 of a line")
    closed: bool = meaning("whether the chain closes to a ring", False)
    fixed: tuple[bool, bool] = meaning("whether the first and last joint of a line are held", (False, False))
    pendants: tuple[Pendant, ...] = meaning("masses on springs at the joints", ())
    grounds: Array | None = meaning(
        "(n,): stiffness of a spring from each joint to the ground [N/m]; none where absent", None
    )

    def __post_init__(self) -> None:
        joints, given = len(self.masses), len(self.lengths)
        segments = joints if self.closed else joints - 1
        if given != segments or segments < 1:
            raise ValueError(f"{joints} joints need {segments} segments, {given} given")

    @property
    def pendant(self) -> Pendant | None:
        """The pendant of a chain that has no second one."""
        return self.pendants[0] if self.pendants else None

    @property
    def impedance(self) -> float:
        """Wave impedance sqrt(R rho0) [kg/s]; of a chain of one cable."""
        return sqrt(self.rigidity * self.density)

    @property
    def impedances(self) -> Array:
        """Wave impedance of each segment, shape (m,) [kg/s]."""
        return np.broadcast_to(np.sqrt(self.rigidity * self.density), self.lengths.shape)

    @property
    def travel_times(self) -> Array:
        """Time a wave takes along each segment, shape (m,) [s]."""
        return self.lengths / np.sqrt(self.rigidity / self.density)

    @property
    def cable_mass(self) -> float:
        """Mass of all segments [kg]."""
        return float(np.sum(self.density * self.lengths))

    @property
    def rigid_body_modes(self) -> int:
        """Motions that strain nothing: one of a free ring or line, none where anything is held or sprung."""
        return 0 if any(self.fixed) or self.sprung else 1

    @property
    def sprung(self) -> bool:
        """Whether a joint or a pendant has a spring to the ground."""
        return any(pendant.ground > 0.0 for pendant in self.pendants) or bool(np.any(self.ground_springs))

    @property
    def ground_springs(self) -> Array:
        """Stiffness from each joint to the ground, shape (n,) [N/m]; zeros where there is none."""
        return np.zeros(self.masses.size) if self.grounds is None else self.grounds


MOTOR_JOINT = "motor joint"
HOLDING_SPRING = "holding stiffness"


@dataclass(frozen=True, slots=True, kw_only=True)
class Stretch:
    """A piece of a span between two neighbouring joints."""

    span: str  # "upper" or "lower": of a chain that is built in Python, "segment 0" and on
    start: float  # unstretched position from the pulley where the span starts [m]
    end: float  # the same [m]


@described
@dataclass(frozen=True, eq=False, kw_only=True)
class LabelledChain:
    """A chain whose joints and segments know what they are on the machine."""

    chain: Chain = meaning("masses and segments")
    joints: tuple[str, ...] = meaning(
        '"drive pulley", "load pulley", "carriage 3" (its number in the file); then the pendants: "motor"'
    )
    stretches: tuple[Stretch, ...] = meaning("one for each segment")
    pendant_springs: tuple[str, ...] = meaning(
        "names of the springs of its pendants; by default of one, the motor's", (MOTOR_JOINT,)
    )
    ground: str = meaning("what its springs to the ground are", "")


def own_chain(chain: Chain) -> LabelledChain:
    """A chain with joints "joint 0" and on, "pendant 0" and on, and spans "segment 0" and on, checked."""
    given: dict[str, Any] = {}  # arrays of floats where lists of numbers were given
    for name in ("rigidity", "density", "lengths", "masses", "grounds"):
        value = getattr(chain, name)
        given[name] = value if np.ndim(value) == 0 else np.asarray(value, dtype=float)
    chain = replace(chain, pendants=tuple(chain.pendants), **given)
    _check(chain)
    pendants = tuple(f"pendant {i}" for i in range(len(chain.pendants)))
    return LabelledChain(
        chain=chain,
        joints=tuple(f"joint {i}" for i in range(chain.masses.size)) + pendants,
        stretches=tuple(
            Stretch(span=f"segment {i}", start=0.0, end=float(length))
            for i, length in enumerate(chain.lengths)
        ),
        pendant_springs=tuple(f"spring of {name}" for name in pendants),
        ground="spring to the ground" if chain.sprung else "",
    )


def _check(chain: Chain) -> None:
    """Refuse what is not positive, not finite, or not there once for each segment or joint."""
    quantities: list[tuple[str, str, str, ArrayLike, bool]] = [  # whether it may be zero
        ("segment", "rigidity", "N", chain.rigidity, False),
        ("segment", "density", "kg/m", chain.density, False),
        ("segment", "length", "m", chain.lengths, False),
        ("joint", "mass", "kg", chain.masses, True),
        ("joint", "grounds", "N/m", chain.ground_springs, True),
    ]
    of_pendants = (("stiffness", "N/m", False), ("mass", "kg", False), ("ground", "N/m", True))
    for number, own in enumerate(chain.pendants):
        for name, unit, zero in of_pendants:
            quantities.append((f"pendant {number}", name, unit, getattr(own, name), zero))
    for place, name, unit, values, zero in quantities:
        array = np.asarray(values, dtype=float)
        parts = chain.masses.size if place == "joint" else chain.lengths.size
        if array.shape not in ((), (parts,)):
            raise InputRefused(
                f"{name} has {array.size} values for {parts} {place}s: give one value, or one for each"
            )
        fine = np.isfinite(array) & ((array >= 0.0) if zero else (array > 0.0))
        if not fine.all():
            number = int(np.argmin(fine))
            where = f"{place} {number}" if array.ndim else place
            bound = "must not be negative" if zero else "must be positive"
            raise InputRefused(
                f"{where}: {name} = {np.ravel(array)[number]:.6g} {unit} {bound} and finite: correct it"
            )
    for number, pendant in enumerate(chain.pendants):
        if not 0 <= pendant.joint < chain.masses.size:
            raise InputRefused(
                f"pendant {number}: joint = {pendant.joint} must be one of 0 to {chain.masses.size - 1}"
            )
