"""A natural mode of a drive, and a list of modes with the proof that it is complete."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from cabledrive.modal.search import ENCLOSURE
from cabledrive.parameters.fields import described, meaning

if TYPE_CHECKING:
    from cabledrive.modal.motion import Motion


Array = NDArray[np.float64]

LONGITUDINAL, TRANSVERSE = "longitudinal", "transverse"
STRING, HEAVY_STRING = "string under static tension", "heavy string"
SAGGING, BEAM = "sagging rope", "tensioned beam"
BOTH = "both"

SAME = 1e-9
"""Modes closer than this, relative, have one frequency; multiple roots are known to this."""


@described
@dataclass(frozen=True, kw_only=True, eq=False)
class Mode:
    """One natural frequency, with as many shapes as its multiplicity."""

    frequency: float = meaning("natural frequency [Hz]")
    kind: str = meaning('"longitudinal" or "transverse"')
    multiplicity: int = meaning("number of independent shapes at this frequency")
    span: str | None = meaning(
        'transverse modes: the span that vibrates, "upper", "lower", or "both" where sag couples them', None
    )
    plane: str | None = meaning('transverse modes: "v" (horizontal) or "w" (the plane of the loop)', None)
    section: tuple[float, float] | None = meaning(
        "transverse modes: unstretched ends of the section [m], from the pulley where its span "
        "starts; None where both spans vibrate together",
        None,
    )
    model: str | None = meaning(
        "transverse modes: what the cable is taken for, one of `STRING`, `HEAVY_STRING`, `SAGGING`, `BEAM`",
        None,
    )
    clamped: bool = meaning("of a machine with routes: a wave of one rope between ends that rest", False)
    proven: bool = meaning(
        "whether counts just below and just above prove that it exists, with this multiplicity"
    )
    _motion: "Motion" = field(repr=False)

    @cached_property
    def family(self) -> str:
        """What mainly moves, see `cabledrive.modal.motion.Motion.family`."""
        return self._motion.family(self.kind)

    @property
    def kinetic_shares(self) -> dict[str, float]:
        """Share of the kinetic energy in each joint that moves and in the "cable"; mean over the shapes."""
        return self._motion.kinetic_shares

    @property
    def strain_shares(self) -> dict[str, float]:
        """Of a machine with routes: share of the strain energy by span and direction, "belt 1, along"."""
        if not self._motion.network.by_span:
            return {}
        shares = self._motion.strain_by_span
        return {f"{span}, {way}": share for (span, way), share in shares.items() if share > 0.0}

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints that take part, in order."""
        return self._motion.joint_names

    @property
    def joints(self) -> dict[str, Array]:
        """Displacement of each joint, shape (multiplicity,), of unit modal mass [kg^-1/2]; rims: r theta."""
        return self._motion.joints

    def shape(self, span: str, positions: Array) -> Array:
        """Displacement along a span, from the exact waves: Eqs. (3.11), (3.18), (3.24), (3.28).

        Parameters
        ----------
        span : {"upper", "lower"}
        positions : array_like, shape (p,)
            Unstretched positions from the pulley where the span starts [m].

        Returns
        -------
        ndarray, shape (multiplicity, p)
            Displacements of unit modal mass [kg^-1/2]; zero where this mode does not reach.
        """
        return self._motion.shape(span, np.asarray(positions, dtype=float))

    def slopes_at(self, joint: str) -> tuple[Array, Array]:
        """Slope of the displacement just before and just after a joint, along the span's direction.

        Parameters
        ----------
        joint : str
            A name among `joints`, but the motor's: "carriage 0".

        Returns
        -------
        before, after : ndarray, shape (multiplicity,)
            Derivatives by the unstretched position [kg^-1/2 / m]; zero beyond the end of an open chain.
        """
        return self._motion.slopes_at(joint)


def multiplets(modes: Iterable[Mode]) -> list[list[Mode]]:
    """Gather modes, ascending, by distinct frequencies: those of both planes, and of equal ropes, are one."""
    groups: list[list[Mode]] = []
    for mode in modes:
        if groups and mode.frequency <= groups[-1][0].frequency * (1.0 + SAME):
            groups[-1].append(mode)
        else:
            groups.append([mode])
    return groups


@described
@dataclass(frozen=True, slots=True, kw_only=True)
class Certificate:
    """Proof that a list of modes is complete."""

    below: float = meaning("every mode of both kinds below this frequency [Hz] is in the list")
    longitudinal_below: float = meaning(
        "every longitudinal mode below this frequency [Hz] is in the list; not less than `below`"
    )
    transverse_below: float = meaning(
        "every transverse mode below this frequency [Hz] is in the list; not less than `below`"
    )
    count: int = meaning(
        "how many lie below `below`, by the count of Wittrick and Williams, multiplicities and both "
        "planes included"
    )
    longitudinal: int = meaning("part of `count`")
    transverse: int = meaning("part of `count`")
    enclosure: float = meaning(
        "relative half-width of the interval in which two counts prove each mode to lie", ENCLOSURE
    )


@described
@dataclass(frozen=True, kw_only=True, eq=False)
class Modes:
    """Natural modes of a drive, certified."""

    modes: tuple[Mode, ...] = meaning("ascending in frequency, both kinds, without the rigid-body mode")
    certified: bool = meaning(
        "whether every mode is proven, the list below the certificate's bound is as long as the "
        "count, and no model of a listed mode is used outside its range"
    )
    certified_reason: str | None = meaning("why it is not certified")
    warnings: tuple[str, ...] = meaning(
        "those of the drive's warnings that touch the list, and what sag does to the longitudinal modes"
    )
    at_torque: float = meaning("steady torque on the drive pulley [N m]")
    certificate: Certificate = meaning("what is proven of the list")
    rigid_body_modes: int = meaning("motions that strain nothing")
    drive_hash: str = meaning("content hash of the drive; empty for a chain")
    motor: str = meaning('one of "free", "held", "holding"; how the rotor is held')
    hold: tuple[str, ...] = meaning("joints that are held as well")

    @property
    def longitudinal(self) -> tuple[Mode, ...]:
        """The longitudinal modes."""
        return tuple(mode for mode in self.modes if mode.kind == LONGITUDINAL)

    @property
    def transverse(self) -> tuple[Mode, ...]:
        """The transverse modes."""
        return tuple(mode for mode in self.modes if mode.kind == TRANSVERSE)
