"""Modes as people count them."""

from collections.abc import Iterable
from dataclasses import dataclass

from cabledrive.mechanics.holding import DRIVE_PULLEY, LOAD_PULLEY
from cabledrive.modal.mode import BOTH, LONGITUDINAL, SAME, Modes
from cabledrive.modal.motion import Mode

_WORTH_NAMING = 0.01
_PLANES = {("v",): "horizontal plane", ("w",): "vertical plane", ("v", "w"): "both planes"}
_OF_ROUTES = {"w": "in plane", "v": "out of plane"}
_SPANS = {
    ("upper",): "upper span",
    ("lower",): "lower span",
    ("upper", "lower"): "both spans",
    ("both",): "both spans",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class ModeRow:
    """Modes of one kind, family and frequency."""

    modes: tuple[Mode, ...]

    @property
    def frequency(self) -> float:
        """Natural frequency [Hz]."""
        return self.modes[0].frequency

    @property
    def kind(self) -> str:
        """Either "longitudinal" or "transverse"."""
        return self.modes[0].kind

    @property
    def family(self) -> str:
        """What mainly moves."""
        return self.modes[0].family

    @property
    def count(self) -> int:
        """Number of modes, multiplicities included."""
        return sum(mode.multiplicity for mode in self.modes)

    @property
    def where(self) -> str:
        """Spans and planes of a string; of a longitudinal mode where its kinetic energy is."""
        if self.kind == LONGITUDINAL:
            # the largest first; carriages taken together
            shares = self.modes[0].kinetic_shares
            carriages = [name for name in shares if name.startswith("carriage")]
            parts = {name: share for name, share in shares.items() if name not in carriages}
            if carriages:
                together = carriages[0] if len(carriages) == 1 else "carriages"
                parts[together] = sum(shares[name] for name in carriages)
            large = sorted((one for one in parts.items() if one[1] >= _WORTH_NAMING), key=lambda one: -one[1])
            return ", ".join(f"{name} {share:.0%}" for name, share in large[:3])
        named = {mode.span or "" for mode in self.modes}
        if not named <= {"upper", "lower", BOTH}:
            ways = sorted({_OF_ROUTES[mode.plane or ""] for mode in self.modes})
            return f"{', '.join(sorted(named))}; {' and '.join(ways)}"
        spans = _SPANS[(BOTH,) if BOTH in named else tuple(sorted(named, reverse=True))]
        planes = _PLANES[tuple(sorted({mode.plane or "" for mode in self.modes}))]
        return f"{spans}{_section(self.modes)}; {planes}"


def mode_rows(found: Modes | Iterable[Mode]) -> tuple[ModeRow, ...]:
    """Gather the modes of one frequency, kind and family; ``found`` ascends in frequency, as do the rows."""
    rows: list[list[Mode]] = []
    for mode in found.modes if isinstance(found, Modes) else found:
        for row in rows[-3:]:
            one = row[0]
            near = abs(one.frequency - mode.frequency) <= SAME * mode.frequency
            if near and one.kind == mode.kind != LONGITUDINAL and one.family == mode.family:
                row.append(mode)
                break
        else:
            rows.append([mode])
    return tuple(ModeRow(modes=tuple(row)) for row in rows)


def _section(modes: tuple[Mode, ...]) -> str:
    """Between which joints, if guided carriages cut the span into sections."""
    ends = {(mode.joint_names[0], mode.joint_names[-1]) for mode in modes}
    first, last = ends.pop()
    whole = ends or {first, last} == {DRIVE_PULLEY, LOAD_PULLEY}
    return "" if whole else f", {first} to {last}"
