"""Whether longitudinal motion of a machine can excite its transverse modes, in a few words."""

from dataclasses import dataclass
from functools import lru_cache

from cabledrive.parameters import Drive, InputRefused, NotComputed
from cabledrive.report.numbers import number, quantity
from cabledrive.report.views import Badge
from cabledrive.studies.resonance import ResonanceSummary, resonance
from cabledrive.studies.resonance_detuning import NO_EXCITATION

TONES = {
    "safe": "good",
    "close": "warning",
    "resonant": "warning",
    "unknown": "remark",
    NO_EXCITATION: "remark",
}
BADGES = {
    "safe": "No internal resonance",
    "close": "Close to internal resonance",
    "resonant": "Internal resonance",
    "unknown": "Internal resonance: amplitude not given",
    NO_EXCITATION: "Internal resonance: no excitation given",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class ResonanceVerdict:
    """Verdict on the internal resonance of a machine."""

    badge: Badge
    reasons: tuple[str, ...]  # of the verdict, or why there is none


@lru_cache(maxsize=16)
def kept_resonance(drive: Drive) -> ResonanceSummary:
    """Result of `cabledrive.resonance`, computed once for the page of a machine and the chapter of all."""
    return resonance(drive)


def resonance_verdict(drive: Drive) -> ResonanceVerdict:
    """Verdict of `cabledrive.resonance`; where it cannot be computed, the reason."""
    try:
        found = kept_resonance(drive)
    except (InputRefused, NotComputed) as refusal:
        return ResonanceVerdict(
            badge=Badge(text="Internal resonance: not computed", tone="remark"), reasons=(str(refusal),)
        )
    stated = found.verdict != NO_EXCITATION
    at = f" at {quantity(found.torque, 'N m', 3)}" if stated else ""
    facts = []
    if found.frequency_ratio is not None:
        ratio = number(found.frequency_ratio, 3)
        facts.append(
            f"The lowest transverse frequency of an empty span is {ratio} times that of the pulley mode; "
            "0.5 is the principal resonance"
        )
    return ResonanceVerdict(
        badge=Badge(text=BADGES[found.verdict] + at, tone=TONES[found.verdict]),
        reasons=(*facts, *found.reasons),
    )
