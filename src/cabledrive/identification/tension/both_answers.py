"""What a ping of both spans answers: two tensions with labels or without, or a line why there are none."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from cabledrive.identification.estimates import Estimate, estimate_dict, report_dict
from cabledrive.identification.logs.log import DataReport
from cabledrive.identification.tension.answers import of_length_and_mass
from cabledrive.identification.tension.partials import Partial


@dataclass(frozen=True, slots=True, kw_only=True)
class FamilyTension:
    """One family of partials and the tension it says.

    Attributes
    ----------
    name : {"upper", "lower", "tauter", "looser", "heard"}
        The span; where the labels cannot be assigned, which of the two tensions; "heard" for a single family.
    tension : Estimate
        [N].
    spread : float
        Largest difference of the tensions that its partials say, over the tension; 0 with one partial.
    line_width : float
        Width of its strongest partial: half-power width of its decay and of the record [Hz].
    of_mass : float
        Relative change of the tension with one of the file's mass per length; of its length, twice that.
    partials : tuple of Partial
    """

    name: str
    tension: Estimate
    spread: float
    line_width: float
    of_mass: float
    partials: tuple[Partial, ...]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BothTensions:
    """Tensions of both spans from one recording.

    Attributes
    ----------
    families : mapping of str to FamilyTension
        "upper" and "lower", or "tauter" and "looser", or "heard" alone.
    pretension : Estimate
        Mean of both tensions [N].
    standing_torque : Estimate
        Torque on the drive pulley that holds the difference, positive where the lower span is tauter [N m];
        its size where there are no labels.
    labelled : bool
    unidentifiable : tuple of str
        What the recording does not determine, one line each.
    findings : tuple of str
    channel : str
    report : DataReport
    drive : str
    """

    families: Mapping[str, FamilyTension]
    pretension: Estimate
    standing_torque: Estimate
    labelled: bool
    unidentifiable: tuple[str, ...]
    findings: tuple[str, ...]
    channel: str
    report: DataReport
    drive: str

    def __getitem__(self, name: str) -> float:
        return self.families[name].tension.value

    @property
    def identifiable(self) -> bool:
        """Whether both tensions have a value."""
        return len(self.families) == 2

    def as_dict(self) -> dict[str, Any]:
        """The tensions as JSON has them, in the form of a ping of one span.

        Returns
        -------
        dict
        """
        parameters = {f"tension_{name}": estimate_dict(one.tension) for name, one in self.families.items()}
        parameters |= {
            "pretension": estimate_dict(self.pretension),
            "standing_torque": estimate_dict(self.standing_torque),
        }
        return {
            "model": "tension-from-ping-of-both-spans",
            "parameters": parameters,
            "identifiable": self.identifiable,
            "unidentifiable": list(self.unidentifiable),
            "residual": {
                "relative": max(one.spread for one in self.families.values()),
                "of": "tensions of partials",
            },
            "spans": {
                name: {
                    "channel": self.channel,
                    "line_width_hz": one.line_width,
                    "of_length_and_mass": of_length_and_mass(one.tension.value, one.of_mass),
                    "partials": [partial.as_dict() for partial in one.partials],
                }
                for name, one in self.families.items()
            },
            "findings": list(self.findings),
            "data": [report_dict(self.report)],
        }
