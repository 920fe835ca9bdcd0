"""What a ping answers: the tension of each span, with the tones it comes from."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from cabledrive.identification.estimates import Estimate
from cabledrive.identification.logs.log import DataReport


@dataclass(frozen=True, slots=True, kw_only=True)
class Partial:
    """One tone of a ping."""

    number: int  # which mode of the span, from 1
    frequency: float  # at vanishing amplitude where ``decays``, else at its own [Hz]
    standard_error: float  # [Hz]
    rise: float  # by how much the frequency was higher at its largest envelope [Hz]; 0 where not determined
    decays: bool  # whether the envelope falls enough to identify the effect of amplitude


@dataclass(frozen=True, slots=True, kw_only=True)
class SpanTension:
    """Tension of one span."""

    # the span; where labels cannot be assigned "tauter" or "looser"; "heard" for a single family of partials
    span: str
    channel: str
    tension: Estimate  # [N]
    # what the string formula, 4 rho_0 (L f_1)^2, says: length and mass of the file, no stretch, carriage [N]
    bare: float
    spread: float  # largest difference of the tensions that the partials say, over the tension; 0 with one
    line_width: float  # of its strongest partial: half-power width of its decay and of the record [Hz]
    # relative change of the tension with one of the file's mass per length; of its length, twice that;
    # neither is in the interval, unless errors of both are given
    of_mass: float
    partials: tuple[Partial, ...]
    findings: tuple[str, ...] = ()

    @property
    def bias(self) -> float:
        """What the string formula says minus the tension, over the tension."""
        return self.bare / self.tension.value - 1.0

    def as_dict(self) -> dict[str, Any]:
        """The details beside the tension as JSON has them."""
        one = 0.01 * self.of_mass * self.tension.value
        return {
            "channel": self.channel,
            "string_formula": self.bare,
            "string_formula_bias": self.bias,
            "line_width_hz": self.line_width,
            "of_length_and_mass": {
                "of_1_percent_of_length": 2.0 * one,
                "of_1_percent_of_mass_per_length": one,
            },
            "partials": [
                {
                    "number": partial.number,
                    "frequency_hz": partial.frequency,
                    "standard_error_hz": partial.standard_error,
                    "rise_with_amplitude_hz": partial.rise,
                }
                for partial in self.partials
            ],
        }


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PingTension:
    """Tension of the spans of a drive."""

    spans: Mapping[str, SpanTension]
    report: DataReport
    drive: str
    # where both spans sound in one recording: mean of both tensions [N]; torque on the drive pulley that
    # holds their difference, positive where the lower span is tauter; its size without labels [N m]
    pretension: Estimate | None = None
    standing_torque: Estimate | None = None
    unidentifiable: tuple[str, ...] = ()  # what the recording does not determine, one line each

    def __getitem__(self, span: str) -> float:
        return self.spans[span].tension.value

    @property
    def identifiable(self) -> bool:
        """Whether each tension that was asked for has a value."""
        return self.pretension is None or len(self.spans) == 2

    def as_dict(self) -> dict[str, Any]:
        """The tensions as JSON has them."""
        parameters = {f"tension_{span}": one.tension.as_dict() for span, one in self.spans.items()}
        both = {"pretension": self.pretension, "standing_torque": self.standing_torque}
        parameters |= {name: one.as_dict() for name, one in both.items() if one is not None}
        spread = max(one.spread for one in self.spans.values())
        return {
            "model": "tension-from-ping" + ("" if self.pretension is None else "-of-both-spans"),
            "parameters": parameters,
            "identifiable": self.identifiable,
            "unidentifiable": list(self.unidentifiable),
            "residual": {"relative": spread, "of": "tensions of partials"},
            "spans": {span: one.as_dict() for span, one in self.spans.items()},
            "findings": [finding for one in self.spans.values() for finding in one.findings],
            "data": [self.report.as_dict()],
        }
