"""Result of an identification: parameters with intervals, what is not identifiable, findings."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from scipy import stats

from cabledrive.identification.logs.log import DataReport
from cabledrive.parameters.arrays import Array

UNITS = {
    "inertia": "kg m^2",
    "mass": "kg",
    "viscous_friction": "N m s/rad",
    "coulomb_friction": "N m",
    "stribeck_friction": "N m",
    "offset_torque": "N m",
    "offset_force": "N",
}
LINEAR_UNITS = {"viscous_friction": "N s/m", "coulomb_friction": "N", "stribeck_friction": "N"}


class Finding(str):
    """A sentence that has a code, short and lasting, for programs that read the answer."""

    __slots__ = ("code",)
    code: str

    def __new__(cls, code: str, message: str) -> "Finding":
        """Make one."""
        made = super().__new__(cls, message)
        made.code = code
        return made

    def as_dict(self) -> dict[str, str]:
        """The finding as JSON has it."""
        return {"code": self.code, "message": str(self)}


@dataclass(frozen=True, slots=True, kw_only=True)
class Estimate:
    """One parameter."""

    value: float  # NaN where it is not identifiable
    unit: str
    standard_error: float  # infinite where it is not identifiable, as the bounds are
    # low, high: bounds of the 95 % interval
    low: float
    high: float
    reason: str = ""  # why there is no number

    @classmethod
    def of(cls, value: float, unit: str, error: float, half: float) -> "Estimate":
        """A value with its standard error and half of its interval."""
        value, half = float(value), float(half)
        return cls(value=value, unit=unit, standard_error=float(error), low=value - half, high=value + half)

    @classmethod
    def unknown(cls, unit: str, reason: str) -> "Estimate":
        """No number, and why."""
        return cls(value=np.nan, unit=unit, standard_error=np.inf, low=-np.inf, high=np.inf, reason=reason)

    def as_dict(self) -> dict[str, Any]:
        """The parameter as JSON has it."""
        numbers = {name: _finite(getattr(self, name)) for name in ("value", "low", "high", "standard_error")}
        reason = {"reason": self.reason} if self.reason else {}
        return {"value": numbers.pop("value"), "unit": self.unit} | numbers | reason


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Identification:
    """Parameters of a model, identified from logs."""

    model: str
    parameters: Mapping[str, Estimate]
    unidentifiable: tuple[str, ...]  # directions that the logs leave open, in words
    residual: Mapping[str, Any]  # ``rms`` [N m or N], ``relative`` to the measured torque, ``rows``
    condition_number: float  # of the regressor matrix
    method: Mapping[str, Any]  # how it was done, with every choice that was made from the data
    covariance: Array  # (p, p): of the parameters in their order
    freedom: int  # degrees of freedom of the intervals
    findings: tuple[Finding, ...] = ()  # faults and doubts that a reader must act on
    reports: tuple[DataReport, ...] = field(default_factory=tuple)  # of each log
    notes: tuple[str, ...] = ()  # conventions that were found in the log, as that of the torque's instant
    checked: bool = False  # whether the model was tested against the log
    check_reason: str = "not requested"  # How, or why not

    @property
    def identifiable(self) -> bool:
        """Whether every parameter has a number."""
        return not self.unidentifiable

    @property
    def refused(self) -> bool:
        """Whether a value has no interval: the model does not fit, or the log does not determine it."""
        return any(not np.isfinite(one.low) for one in self.parameters.values())

    @property
    def codes(self) -> tuple[str, ...]:
        """Codes of the findings."""
        return tuple(finding.code for finding in self.findings)

    @property
    def values(self) -> Array:
        """Of the parameters in their order, shape (p,)."""
        return np.array([estimate.value for estimate in self.parameters.values()])

    def __getitem__(self, name: str) -> float:
        return self.parameters[name].value

    def saying(self, code: str, words: str) -> "Identification":
        """The same with one more finding."""
        return replace(self, findings=(*self.findings, Finding(code, words)))

    def without(self, code: str) -> "Identification":
        """The same without the findings of a code."""
        return replace(self, findings=tuple(one for one in self.findings if one.code != code))

    def noting(self, *notes: str, **method: object) -> "Identification":
        """The same with more notes, and more on how it was made."""
        return replace(self, notes=(*self.notes, *notes), method=dict(self.method) | method)

    def widened(self, extra: Array) -> "Identification":
        """The same with more covariance, shape (p, p): what the method misses on logs of its own making."""
        return self.refitted(self.values, self.covariance + extra, self.freedom, {})

    def refitted(
        self, values: Array, covariance: Array, freedom: int, method: Mapping[str, Any]
    ) -> "Identification":
        """The same with other values and covariance, and more on the method, whose own error is in them."""
        errors = np.sqrt(np.diag(covariance))
        rows = zip(values, errors, float(stats.t.ppf(0.975, freedom)) * errors, strict=True)
        parameters = {
            name: Estimate.of(value, one.unit, error, half)
            for (name, one), (value, error, half) in zip(self.parameters.items(), rows, strict=True)
        }
        words = f"{self.method['standard_errors']}, with the method's own error on logs of its own making"
        found = replace(self, parameters=parameters, covariance=covariance, freedom=freedom)
        return found.noting(**method, standard_errors=words)

    def without_intervals(self, reason: str) -> "Identification":
        """The same where the model is refused: its values stay, its intervals do not."""
        parameters = {
            name: replace(one, standard_error=np.inf, low=-np.inf, high=np.inf, reason=one.reason or reason)
            for name, one in self.parameters.items()
        }
        return replace(self, parameters=parameters)

    def as_dict(self) -> dict[str, Any]:
        """As JSON has it: numbers in SI; None with a reason beside it where there is none."""
        return {
            "model": self.model,
            "parameters": {name: estimate.as_dict() for name, estimate in self.parameters.items()},
            "identifiable": self.identifiable,
            "unidentifiable": list(self.unidentifiable),
            "residual": dict(self.residual),
            "condition_number": _finite(self.condition_number),
            "findings": [finding.as_dict() for finding in self.findings],
            "notes": list(self.notes),
            "checked": self.checked,
            "check_reason": self.check_reason,
            "method": dict(self.method),
            "data": [report.as_dict() for report in self.reports],
        }


def unit_of(name: str, linear: bool) -> str:
    """Unit of a parameter of one axis; ``linear``: whether it slides."""
    stem = name.removesuffix("_positive").removesuffix("_negative").rstrip(" 0123456789")
    return LINEAR_UNITS.get(stem, UNITS[stem]) if linear else UNITS[stem]


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
