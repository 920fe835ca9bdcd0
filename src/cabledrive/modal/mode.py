"""A natural mode of a drive, and a list of modes with the proof that it is complete."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from cabledrive.answers.figures import Row
from cabledrive.answers.result import Result
from cabledrive.modal.search import ENCLOSURE
from cabledrive.parameters.fields import described, meaning

if TYPE_CHECKING:
    from cabledrive.modal.motion import Mode


LONGITUDINAL, TRANSVERSE = "longitudinal", "transverse"
STRING, HEAVY_STRING = "string under static tension", "heavy string"
SAGGING, BEAM = "sagging rope", "tensioned beam"
BOTH = "both"

SAME = 1e-9
"""Modes closer than this, relative, have one frequency; multiple roots are known to this."""


def multiplets(modes: Iterable["Mode"]) -> list[list["Mode"]]:
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
    slope: float = meaning("largest slope of a rope at rest to its chord; it is certified as it hangs", 0.0)


@described
@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Modes(Result):
    """Natural modes of a drive, certified."""

    _table, _columns = "modes", "frequency kind family multiplicity span plane proven"
    _shown = (
        Row("certificate.below", "complete up to", "Hz", ".8g"),
        Row("certified", "certified"),
        Row("certified_reason", "not certified"),
        Row("rigid_body_modes", "rigid-body modes not listed", form="d"),
        Row("warnings", "warning"),
    )

    modes: tuple["Mode", ...] = meaning("ascending in frequency, both kinds, without the rigid-body mode")
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
    def longitudinal(self) -> tuple["Mode", ...]:
        """The longitudinal modes."""
        return tuple(mode for mode in self.modes if mode.kind == LONGITUDINAL)

    @property
    def transverse(self) -> tuple["Mode", ...]:
        """The transverse modes."""
        return tuple(mode for mode in self.modes if mode.kind == TRANSVERSE)
