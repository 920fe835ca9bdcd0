"""Transverse modes of a drive under the tension that is there: strings in one plane, sag in the other."""

from dataclasses import dataclass
from functools import cached_property
from math import inf, isfinite, pi

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.labelled_chain import LabelledChain
from cabledrive.mechanics.rest import RestState, rest_state
from cabledrive.mechanics.spans import transverse_chains
from cabledrive.modal.band import Band, order_of
from cabledrive.modal.mode import BOTH, HEAVY_STRING, SHALLOW_SAG, STRING, TRANSVERSE, Mode
from cabledrive.modal.plane_spectrum import MOST_SAGGING_JOINTS, InPlane, PlaneSpectrum
from cabledrive.modal.section_string import SectionMotion, SectionString
from cabledrive.parameters import Drive, InputRefused

Array = NDArray[np.float64]

MOST_COUNTED = 20_000

ALONE = 0.99
"""Share of one section in the motion across above which a mode is called its own."""


def transverse_band(drive: Drive, chains: tuple[LabelledChain, ...], at_torque: float = 0.0) -> Band:
    """All transverse modes of a drive under the tension at rest.

    ``chains``: what moves along the cable; ``at_torque``: steady torque on the drive pulley [N m].
    Returns of uniform strings where nothing weighs, else a `RestingBand`.
    Raises `InputRefused` if the torque is not finite; `NotComputed` if no state of rest is found, or a span
    without weight hangs slack.
    """
    if not isfinite(at_torque):
        raise InputRefused(f"at_torque = {at_torque} N m is not finite: give the steady torque in N m")
    if drive.layout.gravity == 0.0:
        rest = rest_state(drive, at_torque=at_torque) if at_torque else None
        return Band(transverse_chains(drive, rest=rest), TRANSVERSE)
    return RestingBand(drive, rest_state(drive, at_torque=at_torque), chains)


class RestingBand(Band):
    """All transverse modes of a drive at rest under weights.

    Parameters
    ----------
    drive : Drive
    rest : RestState
    chains : tuple of LabelledChain
        What moves along the cable.
    """

    def __init__(self, drive: Drive, rest: RestState, chains: tuple[LabelledChain, ...]) -> None:
        super().__init__((), TRANSVERSE)
        self.rest = rest
        self._labelled = transverse_chains(drive)
        density = drive.cable.mass_per_length
        self.slack = tuple(section for section in rest.sections if section.lowest_tension <= 0.0)
        self._strings = {
            number: SectionString(section, labelled.chain.masses[1:-1], density)
            for number, (section, labelled) in enumerate(zip(rest.sections, self._labelled, strict=True))
            if section.lowest_tension > 0.0
        }
        self._steep = drive.layout.gravity_along != 0.0
        joints = sum(labelled.chain.masses.size for labelled in self._labelled)
        self.too_many = drive.layout.gravity_across > 0.0 and joints > MOST_SAGGING_JOINTS
        level = drive.layout.gravity_across > 0.0 and self._strings and not self.too_many
        self.plane = PlaneSpectrum(chains, self._strings) if level else None

    @property
    def _travel_time(self) -> float:
        return sum(string.travel_time for string in self._strings.values())

    def count(self, omega: float) -> int:
        """Transverse modes below a frequency, both planes.

        ``omega`` [rad/s].
        Returns above `MOST_COUNTED` per plane an estimate: nothing is listed there.
        """
        estimate = sum(omega * string.travel_time / pi for string in self._strings.values())
        if estimate > MOST_COUNTED:
            return 2 * int(estimate)
        out = sum(string.count(omega) for string in self._strings.values())
        if self.plane is None:
            return 2 * out
        return out + sum(not mode.along for mode in self.plane.below(omega))

    def first(self, count: int) -> tuple[list[Mode], float]:
        """The first few modes; none where every section hangs slack.

        ``count``: how many.
        Returns ``clear``: frequency up to which the list is complete [rad/s].
        """
        return super().first(count) if self._strings else ([], inf)

    def first_distinct(self, count: int) -> tuple[list[Mode], float]:
        """The modes of the first few distinct frequencies; none where every section hangs slack.

        ``count``: how many frequencies.
        Returns ``clear``: frequency up to which the list is complete [rad/s].
        """
        return super().first_distinct(count) if self._strings else ([], inf)

    def _modes(self, top: float, first: int | None = None) -> list[Mode]:
        found = []
        for number, string in self._strings.items():
            for n in range(1, string.count(top) + 1):
                omega = string.frequency(n)
                found.append(self._string_mode(number, omega, "v"))
                if self.plane is None:
                    found.append(self._string_mode(number, omega, "w"))
        for mode in self.plane.below(top) if self.plane is not None else ():
            if mode.mode is None:
                found.append(self._string_mode(mode.sections[0], mode.omega, "w"))
            elif not mode.along:
                found.append(self._sagging_mode(mode))
        return sorted(found, key=order_of)

    def along_with_sag(self, top: float) -> list[float]:
        """Frequencies of the modes mainly along the cable that the plane of gravity has.

        ``top`` [rad/s].
        Returns [Hz].
        """
        if self.plane is None:
            return []
        return [mode.omega / (2 * pi) for mode in self.plane.below(top) if mode.along]

    def _string_mode(self, number: int, omega: float, plane: str) -> Mode:
        string = self._strings[number]
        section = string.section
        below, above = string.count(omega * (1 - 1e-12)), string.count(omega * (1 + 1e-12))
        return Mode(
            frequency=omega / (2 * pi),
            kind=TRANSVERSE,
            multiplicity=1,
            span=section.span,
            plane=plane,
            section=(section.start, section.end),
            model=HEAVY_STRING if self._steep else STRING,
            proven=above == below + 1,
            _motion=StringMotion((self._labelled[number],), (string,), omega, None),
        )

    def _sagging_mode(self, found: InPlane) -> Mode:
        assert found.mode is not None
        shares = found.mode.shares / found.mode.shares.sum()
        chosen = int(np.argmax(shares))
        strings = tuple(self._strings[number] for number in found.sections)
        taking = [strings[i].section for i in range(len(strings)) if shares[i] > 1.0 - ALONE]
        if shares[chosen] >= ALONE:
            taking = [strings[chosen].section]
        spans = {section.span for section in taking}
        return Mode(
            frequency=found.omega / (2 * pi),
            kind=TRANSVERSE,
            multiplicity=1,
            span=spans.pop() if len(spans) == 1 else BOTH,
            plane="w",
            section=(taking[0].start, taking[-1].end) if len({s.span for s in taking}) == 1 else None,
            model=SHALLOW_SAG,
            proven=found.mode.proven,
            _motion=StringMotion(
                tuple(self._labelled[number] for number in found.sections),
                strings,
                found.omega,
                found.mode.parts,
            ),
        )


@dataclass(frozen=True, eq=False)
class StringMotion:
    """Shape of a transverse mode.

    Attributes
    ----------
    labelled : tuple of LabelledChain
        Sections, for the names of their joints.
    strings : tuple of SectionString
    omega : float
        [rad/s].
    given : tuple of SectionMotion or None
        Their motions; of one string alone they are computed.
    """

    labelled: tuple[LabelledChain, ...]
    strings: tuple[SectionString, ...]
    omega: float
    given: tuple[SectionMotion, ...] | None

    @cached_property
    def _parts(self) -> tuple[SectionMotion, ...]:
        return self.given if self.given is not None else (self.strings[0].motion(self.omega),)

    @cached_property
    def _taking_part(self) -> tuple[int, ...]:
        """Sections that move."""
        if len(self.strings) == 1:
            return (0,)
        sizes = [part.mass for part in self._parts]
        return tuple(i for i, size in enumerate(sizes) if size >= (1.0 - ALONE) * max(sizes))

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints that take part, in order."""
        return tuple(dict.fromkeys(name for i in self._taking_part for name in self.labelled[i].joints))

    @cached_property
    def joints(self) -> dict[str, Array]:
        """Displacement of each joint that takes part, shape (1,)."""
        moved = {name: np.zeros(1) for name in self.joint_names}
        for i in self._taking_part:
            inner = self.labelled[i].joints[1:-1]
            places = np.array([stretch.end for stretch in self.strings[i].section.stretches[:-1]])
            for name, value in zip(inner, self._parts[i].at(places), strict=True):
                moved[name] = np.array([value])
        return moved

    @property
    def kinetic_shares(self) -> dict[str, float]:
        """Share of the kinetic energy in each hanging carriage, and in the "cable"."""
        shares = {}
        for labelled in self.labelled:
            for name, mass in zip(labelled.joints[1:-1], labelled.chain.masses[1:-1], strict=True):
                if name in self.joints:
                    shares[name] = float(mass * self.joints[name][0] ** 2)
        return shares | {"cable": 1.0 - sum(shares.values())}

    def family(self, kind: str) -> str:
        """Whether carriages hold half of the kinetic energy or more: "carriage-dominated", else "string"."""
        return "carriage-dominated" if self.kinetic_shares["cable"] <= 0.5 else "string"

    def shape(self, span: str, positions: Array) -> Array:
        """Displacement along a span, shape (1, p); downwards is positive in the plane of gravity."""
        out = np.zeros((1, positions.size))
        for string, part in zip(self.strings, self._parts, strict=True):
            section = string.section
            here = (positions >= section.start) & (positions <= section.end)
            if section.span == span and here.any():
                out[0, here] = part.at(positions[here])
        return out

    def slopes_at(self, joint: str) -> tuple[Array, Array]:
        """Slopes are given of longitudinal modes only."""
        raise InputRefused(
            f"slopes at {joint}: of a transverse mode none are computed: take a longitudinal mode"
        )
