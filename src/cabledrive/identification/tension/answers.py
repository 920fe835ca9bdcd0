"""What a ping answers: the tension of each span, with the tones it comes from."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cabledrive.identification.estimates import Estimate
from cabledrive.identification.logs.log import DataReport

Array = NDArray[np.float64]

LEAST_COUNT = 0.5
"""Counts of a pulley's encoder that a tone must have: rounding makes tones of its own."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Partial:
    """One tone of a ping."""

    number: int  # which mode of the span, from 1
    frequency: float  # at vanishing amplitude where ``decays``, else at its own [Hz]
    standard_error: float  # [Hz]
    peak: float  # where the spectrum of the whole record has its peak [Hz]
    amplitude: float  # largest envelope, in the channel's unit
    rise: float  # by how much the frequency was higher at that envelope [Hz]; 0 where it cannot be determined
    decays: bool  # whether the envelope falls enough to identify the effect of amplitude

    def as_dict(self) -> dict[str, Any]:
        """The partial as JSON has it."""
        return {
            "number": self.number,
            "frequency_hz": self.frequency,
            "standard_error_hz": self.standard_error,
            "rise_with_amplitude_hz": self.rise,
        }


def count_of(values: Array) -> float:
    """Step between the levels of a channel.

    ``values``, shape (samples,).
    Returns in the channel's unit; 0 where it has no levels.
    """
    levels = np.unique(values)
    return float(np.diff(levels).min()) if 1 < levels.size < 0.1 * values.size else 0.0


def amplitude_spectrum(values: Array, interval: float) -> tuple[Array, Array]:
    """Amplitude over frequency, Hann window, four times padded.

    ``values``, shape (samples,); ``interval`` [s].
    Returns ``frequency, amplitude`` [Hz], unit of the values.
    """
    window = np.hanning(values.size)
    padded = 4 * values.size
    spectrum = np.abs(np.fft.rfft((values - values.mean()) * window, padded)) * 2 / window.sum()
    return np.asarray(np.fft.rfftfreq(padded, interval), dtype=float), spectrum


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
        parameters = {f"tension_{span}": one.tension.as_dict() for span, one in self.spans.items()}
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
            "data": [self.report.as_dict()],
        }


def of_length_and_mass(tension: float, of_mass: float) -> dict[str, float]:
    """By how much one per cent of the file's length and of its mass per length move a tension [N]."""
    one = 0.01 * of_mass * tension
    return {"of_1_percent_of_length": 2.0 * one, "of_1_percent_of_mass_per_length": one}


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
        parameters = {f"tension_{name}": one.tension.as_dict() for name, one in self.families.items()}
        parameters |= {
            "pretension": self.pretension.as_dict(),
            "standing_torque": self.standing_torque.as_dict(),
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
            "data": [self.report.as_dict()],
        }
