"""What a ping answers: the tension of each span, with the tones it comes from."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from cabledrive.identification.estimates import Estimate, estimate_dict, report_dict
from cabledrive.identification.logs.log import DataReport
from cabledrive.identification.tension.partials import Partial


@dataclass(frozen=True, slots=True, kw_only=True)
class SpanTension:
    """Tension of one span.

    Attributes
    ----------
    span : {"upper", "lower"}
    channel : str
    tension : Estimate
        [N].
    bare : float
        What the string formula, 4 rho_0 (L f_1)^2, says: length and mass of the file, peak of the spectrum;
        no stretch, no carriage, no amplitude [N].
    bias : float
        That minus the tension, over the tension.
    spread : float
        Largest difference of the tensions that the partials say, over the tension; 0 with one partial.
    of_mass : float
        Relative change of the tension with one of the file's mass per length; of its length, twice that.
        Neither is in the interval, unless errors of both are given.
    partials : tuple of Partial
    findings : tuple of str
    """

    span: str
    channel: str
    tension: Estimate
    bare: float
    bias: float
    spread: float
    of_mass: float
    partials: tuple[Partial, ...]
    findings: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PingTension:
    """Tension of the spans of a drive.

    Attributes
    ----------
    spans : mapping of str to SpanTension
    report : DataReport
    drive : str
    """

    spans: Mapping[str, SpanTension]
    report: DataReport
    drive: str

    def __getitem__(self, span: str) -> float:
        return self.spans[span].tension.value

    def as_dict(self) -> dict[str, Any]:
        """The tensions as JSON has them.

        Returns
        -------
        dict
        """
        parameters = {f"tension_{span}": estimate_dict(one.tension) for span, one in self.spans.items()}
        details = {
            span: {
                "channel": one.channel,
                "string_formula": one.bare,
                "string_formula_bias": one.bias,
                "of_length_and_mass": of_length_and_mass(one.tension.value, one.of_mass),
                "partials": [partial.as_dict() for partial in one.partials],
            }
            for span, one in self.spans.items()
        }
        return {
            "model": "tension-from-ping",
            "parameters": parameters,
            "identifiable": True,
            "residual": {
                "relative": max(one.spread for one in self.spans.values()),
                "of": "tensions of partials",
            },
            "spans": details,
            "findings": [finding for one in self.spans.values() for finding in one.findings],
            "data": [report_dict(self.report)],
        }


def of_length_and_mass(tension: float, of_mass: float) -> dict[str, float]:
    """By how much one per cent of the file's length and of its mass per length move a tension [N]."""
    one = 0.01 * of_mass * tension
    return {"of_1_percent_of_length": 2.0 * one, "of_1_percent_of_mass_per_length": one}
