"""Modes as people count them: what repeats in both planes and both spans stands in one row."""

from collections.abc import Iterable
from dataclasses import dataclass

from cabledrive.mechanics.holding import DRIVE_PULLEY, LOAD_PULLEY
from cabledrive.modal.certified import Modes
from cabledrive.modal.mode import BOTH, LONGITUDINAL, SAME, Mode

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
    """Modes of one kind, family and frequency.

    Attributes
    ----------
    modes : tuple of Mode
    """

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
            return _energy(self.modes[0].kinetic_shares)
        named = {mode.span or "" for mode in self.modes}
        if not named <= {"upper", "lower", BOTH}:
            ways = sorted({_OF_ROUTES[mode.plane or ""] for mode in self.modes})
            return f"{', '.join(sorted(named))}; {' and '.join(ways)}"
        spans = _SPANS[(BOTH,) if BOTH in named else tuple(sorted(named, reverse=True))]
        planes = _PLANES[tuple(sorted({mode.plane or "" for mode in self.modes}))]
        return f"{spans}{_section(self.modes)}; {planes}"


def mode_rows(found: Modes | Iterable[Mode]) -> tuple[ModeRow, ...]:
    """Gather the modes of one frequency, kind and family.

    ``found``: ascending in frequency.
    Returns ascending in frequency.
    """
    rows: list[list[Mode]] = []
    for mode in found.modes if isinstance(found, Modes) else found:
        row = next((row for row in rows[-3:] if _alike(row[0], mode)), None)
        if row is None:
            rows.append([mode])
        else:
            row.append(mode)
    return tuple(ModeRow(modes=tuple(row)) for row in rows)


def _alike(a: Mode, b: Mode) -> bool:
    near = abs(a.frequency - b.frequency) <= SAME * b.frequency
    return near and a.kind == b.kind != LONGITUDINAL and a.family == b.family


def _energy(shares: dict[str, float]) -> str:
    """The parts that hold the kinetic energy, the largest first; carriages taken together."""
    carriages = [name for name in shares if name.startswith("carriage")]
    parts = {name: share for name, share in shares.items() if name not in carriages}
    if carriages:
        parts[carriages[0] if len(carriages) == 1 else "carriages"] = sum(shares[name] for name in carriages)
    large = sorted((item for item in parts.items() if item[1] >= _WORTH_NAMING), key=lambda item: -item[1])
    return ", ".join(f"{name} {share:.0%}" for name, share in large[:3])


def _section(modes: tuple[Mode, ...]) -> str:
    """Between which joints, if guided carriages cut the span into sections."""
    ends = {(mode.joint_names[0], mode.joint_names[-1]) for mode in modes}
    first, last = ends.pop()
    whole = ends or {first, last} == {DRIVE_PULLEY, LOAD_PULLEY}
    return "" if whole else f", {first} to {last}"
