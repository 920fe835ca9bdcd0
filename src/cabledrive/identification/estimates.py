"""Result of an identification: parameters with intervals, what is not identifiable, findings."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cabledrive.identification.logs.log import DataReport


class Finding(str):
    """A sentence that has a code, for programs that read the answer."""

    __slots__ = ("code",)
    code: str  # short and lasting: "model-misfit"

    def __new__(cls, code: str, message: str) -> "Finding":
        """Make one."""
        made = super().__new__(cls, message)
        made.code = code
        return made

    @property
    def message(self) -> str:
        """The sentence."""
        return str(self)

    def as_dict(self) -> dict[str, str]:
        """The finding as JSON has it."""
        return {"code": self.code, "message": str(self)}


def code_of(finding: str) -> str:
    """Code of a finding; "finding" where it is a plain sentence."""
    return finding.code if isinstance(finding, Finding) else "finding"


Array = NDArray[np.float64]

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


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Identification:
    """Parameters of a model, identified from logs."""

    model: str
    parameters: Mapping[str, Estimate]
    identifiable: bool  # whether every parameter has a number
    unidentifiable: tuple[str, ...]  # directions that the logs leave open, in words
    residual: Mapping[str, Any]  # ``rms`` [N m or N], ``relative`` to the measured torque, ``rows``
    condition_number: float  # of the regressor matrix
    method: Mapping[str, Any]  # how it was done, with every choice that was made from the data
    covariance: Array  # (p, p): of the parameters in their order
    freedom: int  # degrees of freedom of the intervals
    # faults and doubts that a reader must act on, each a `Finding` with its code
    findings: tuple[str, ...] = ()
    reports: tuple[DataReport, ...] = field(default_factory=tuple)  # of each log
    notes: tuple[str, ...] = ()  # conventions that were found in the log, as that of the torque's instant
    checked: bool = False  # whether the model was tested against the log
    check_reason: str = "not requested"  # How, or why not

    @property
    def refused(self) -> bool:
        """Whether a value has no interval: the model does not fit, or the log does not determine it."""
        return any(not np.isfinite(one.low) for one in self.parameters.values())

    @property
    def codes(self) -> tuple[str, ...]:
        """Codes of the findings."""
        return tuple(code_of(finding) for finding in self.findings)

    def __getitem__(self, name: str) -> float:
        return self.parameters[name].value

    def as_dict(self) -> dict[str, Any]:
        """The identification as JSON has it.

        Returns numbers in SI; None with a reason beside it where there is none.
        """
        return {
            "model": self.model,
            "parameters": {name: estimate_dict(estimate) for name, estimate in self.parameters.items()},
            "identifiable": self.identifiable,
            "unidentifiable": list(self.unidentifiable),
            "residual": dict(self.residual),
            "condition_number": _finite(self.condition_number),
            "findings": [{"code": code_of(one), "message": str(one)} for one in self.findings],
            "notes": list(self.notes),
            "checked": self.checked,
            "check_reason": self.check_reason,
            "method": dict(self.method),
            "data": [report_dict(report) for report in self.reports],
        }


def estimate_dict(estimate: Estimate) -> dict[str, Any]:
    """One parameter as JSON has it."""
    numbers = {name: _finite(getattr(estimate, name)) for name in ("value", "low", "high", "standard_error")}
    reason = {"reason": estimate.reason} if estimate.reason else {}
    return {"value": numbers.pop("value"), "unit": estimate.unit} | numbers | reason


def report_dict(report: DataReport) -> dict[str, Any]:
    """A data report as JSON has it."""
    return {
        "rows": report.rows,
        "duration": report.duration,
        "interval": report.interval,
        "jitter": report.jitter,
        "quantum": dict(report.quantum),
        "repaired": list(report.repaired),
        "findings": list(report.findings),
    }


def without_intervals(found: Identification, reason: str) -> Identification:
    """An identification whose model is refused: its values stay, its intervals do not.

    ``reason``: why there is no interval.
    """
    parameters = {
        name: replace(one, standard_error=np.inf, low=-np.inf, high=np.inf, reason=one.reason or reason)
        for name, one in found.parameters.items()
    }
    return replace(found, parameters=parameters)


def unit_of(name: str, linear: bool) -> str:
    """Unit of a parameter of one axis.

    ``linear``: whether the axis slides.
    """
    stem = name.removesuffix("_positive").removesuffix("_negative").rstrip(" 0123456789")
    return LINEAR_UNITS.get(stem, UNITS[stem]) if linear else UNITS[stem]


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
