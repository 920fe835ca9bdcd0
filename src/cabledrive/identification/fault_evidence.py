"""What speaks for a fault of an axis, and what is said of it."""

from collections.abc import Sequence
from dataclasses import dataclass

from cabledrive.identification.diagnosis import FAULTS as LINE_FAULTS

ONE_SIDED = ("stribeck", "slope", "quadratic", "load", "flexibility", "backlash")
"""Faults that only a positive factor indicates."""
MATERIAL = 0.7
"""Share of half an interval by which a fault must change a parameter to be stated as a fault."""
NOTABLE = 0.02
"""Share of the innovations' power from which it is stated whatever it changes."""
CLOSE = 0.8
"""Share of the best explanation from which on another fault cannot be distinguished from it."""

FAULTS = LINE_FAULTS | {
    "quadratic": "friction rises faster than in proportion to the speed",
    "load": "friction grows with the torque that is carried",
    "position": "a torque depends on the position: cogging, a screw's or guide's error, a weight",
    "backlash": "the apparent inertia is smaller while the torque changes sign: backlash",
}
SHORT = {
    "stribeck": "Stribeck friction",
    "slope": "a smooth law of friction",
    "quadratic": "friction that rises faster than the speed",
    "load": "friction that grows with the load",
    "asymmetry": "viscous friction that differs between both directions",
    "position": "a torque that depends on the position",
    "flexibility": "a flexible joint",
    "backlash": "backlash",
    "delay": "a delay of the torque channel",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Evidence:
    """One disturbance with the evidence for it."""

    name: str  # of the disturbance
    # value, error: factor and standard error
    value: float
    error: float
    critical: float  # significance that a sound log exceeds at any disturbance with the chance `FALSE_ALARMS`
    gain: float  # share of the innovations' power that it explains
    shift: tuple[float, ...] = ()  # what it would change in the four parameters

    @property
    def fault(self) -> str:
        """Key of `FAULTS`."""
        return self.name.partition(":")[0]

    @property
    def significance(self) -> float:
        """Factor over its standard error; negative where it is not of this fault's sign."""
        size = self.value if self.fault in ONE_SIDED else abs(self.value)
        return size / self.error if self.error > 0.0 else 0.0

    @property
    def alarms(self) -> bool:
        """Whether it is beyond chance."""
        return self.significance > self.critical

    def as_dict(self) -> dict[str, float]:
        """Numbers as the answer has them."""
        return {"significance": self.significance, "critical": self.critical, "value": self.value}


def material(found: Sequence[Evidence], half_widths: Sequence[float]) -> tuple[Evidence, ...]:
    """Faults beyond chance that matter: they change a parameter by a share of its interval, or explain much.

    ``half_widths``: of the intervals of the four parameters.
    """
    kept = []
    for one in found:
        moves = any(abs(shift) > MATERIAL * half for shift, half in zip(one.shift, half_widths, strict=False))
        if one.alarms and (moves or one.gain > NOTABLE):
            kept.append(one)
    return tuple(kept)


def unseen(found: Sequence[Evidence], half_widths: Sequence[float]) -> tuple[Evidence, ...]:
    """Faults that would move a parameter by more than its interval's width before they alarm."""
    hidden = []
    for one in found:
        least = one.critical * one.error / max(abs(one.value), 1e-300)
        moves = (least * abs(shift) > 2.0 * half for shift, half in zip(one.shift, half_widths, strict=False))
        if not one.alarms and any(moves):
            hidden.append(one)
    return tuple(hidden)


def named(found: Sequence[Evidence]) -> tuple[Evidence, ...]:
    """The faults that the evidence speaks for: the one that explains most, and those that explain nearly it.

    Returns empty where nothing is beyond chance.
    """
    beyond = sorted((e for e in found if e.alarms), key=lambda e: -e.gain)
    return tuple(e for e in beyond if e.gain >= CLOSE * beyond[0].gain)


def evidence_words(faults: Sequence[Evidence], first: str | None = None) -> str:
    """A verdict in a sentence.

    ``faults``: at least one; ``first``: words on the first of them, where more is known of it than its
    factor.
    """
    first = FAULTS[faults[0].fault].format(value=faults[0].value) if first is None else first
    words = f"the model does not fit: {first}"
    others = ", ".join(SHORT[one.fault] for one in faults[1:])
    return f"{words}; this log cannot distinguish it from {others}" if others else words
