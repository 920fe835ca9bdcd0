r"""From rows to estimates with intervals: least squares by segments of time, and the result, in words too.

A log is cut into segments. Each is reduced by QR to the triangle of :math:`[\Phi_b\ y_b]`, which keeps all
that least squares needs: a log of any length fits into memory, and no normal equations are formed.

Standard errors survive coloured residuals: with the scores :math:`g_b = \Phi_b^T r_b` of segments that are
longer than the residual's memory,

.. math:: C = \frac{G}{G-p}\, (\Phi^T\Phi)^{-1} \Big(\sum_{b=1}^{G} g_b g_b^T\Big) (\Phi^T\Phi)^{-1},

and intervals are those of Student's t with G - p degrees of freedom.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from cabledrive.answers.figures import Row
from cabledrive.answers.keys import Keys
from cabledrive.answers.result import Result
from cabledrive.identification.logs.log import DataReport
from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array

RANK_TOLERANCE = 1e-9
FEWEST_SEGMENTS = 12
MOST_SEGMENTS = 60


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Factors:
    """A regression reduced to one triangle per segment of time."""

    names: tuple[str, ...]  # parameters
    triangles: Array  # (segments, p + 1, p + 1): R of [Phi y] of each segment
    rows: int  # rows altogether


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Fit:
    """Estimate with its covariance."""

    names: tuple[str, ...]
    values: Array  # (p,): zero along directions without information; see ``unidentifiable``
    covariance: Array  # (p, p): Robust, see the module
    freedom: int  # degrees of freedom of the intervals
    condition: float  # condition number of the regressor matrix as it stands (not scaled)
    # (directions, p): directions about which the log says nothing, in units of the parameters
    unidentifiable: Array
    # residual, scale: root mean square of the residual and of the left side
    residual: float
    scale: float
    rows: int

    def half_width(self) -> Array:
        """Half of each 95 % interval, shape (p,)."""
        return float(stats.t.ppf(0.975, self.freedom)) * np.sqrt(np.diag(self.covariance))


def triangle(rows: Array) -> Array:
    """R of the QR decomposition, of a stack of matrices (..., rows, columns) too."""
    return np.asarray(np.linalg.qr(rows, mode="r"))


def factor(regressors: Array, left: Array, names: tuple[str, ...], segments: int) -> Factors:
    """Reduce rows (rows, p) to one triangle per segment of equal time, Eqs. (4.3), (4.6)."""
    rows, p = regressors.shape
    length = rows // segments
    if length < p + 1:
        raise InputRefused(f"{rows} rows are too few for {p} parameters in {segments} segments: record more")
    whole = np.column_stack([regressors, left])
    head = whole[: length * (segments - 1)].reshape(segments - 1, length, p + 1)
    last = triangle(whole[length * (segments - 1) :])
    triangles = np.concatenate([triangle(head), last[None]])
    return Factors(names=names, triangles=triangles, rows=rows)


def by_label(regressors: Array, left: Array, labels: NDArray[np.intp]) -> Factors:
    """Rows (rows, p) as one triangle per label (rows,), of however few rows."""
    whole = np.column_stack([regressors, left])
    triangles = np.zeros((np.unique(labels).size, whole.shape[1], whole.shape[1]))
    for place, label in zip(triangles, np.unique(labels), strict=True):
        own = triangle(whole[labels == label])
        place[: len(own)] = own
    names = tuple(map(str, range(regressors.shape[1])))
    return Factors(names=names, triangles=triangles, rows=len(whole))


def joined(parts: list[Factors]) -> Factors:
    """Put segments of several blocks or logs together, of the same parameters."""
    triangles = np.concatenate([part.triangles for part in parts])
    return Factors(names=parts[0].names, triangles=triangles, rows=sum(part.rows for part in parts))


def merged(factors: Factors, group: int) -> Factors:
    """Join groups of neighbouring segments into longer ones; a remainder goes to the last."""
    count = max(1, factors.triangles.shape[0] // group)
    edges = [*range(0, count * group, group), factors.triangles.shape[0]]
    size = factors.triangles.shape[2]
    triangles = [triangle(factors.triangles[a:b].reshape(-1, size)) for a, b in pairwise(edges)]
    return Factors(names=factors.names, triangles=np.array(triangles), rows=factors.rows)


def only(factors: Factors, names: tuple[str, ...], left: str = "") -> Factors:
    """The regression with fewer regressors; ``left``: the one that is to be explained instead."""
    last = factors.names.index(left) if left else len(factors.names)
    places = [*(factors.names.index(name) for name in names), last]
    triangles = triangle(factors.triangles[:, :, places])
    return Factors(names=names, triangles=triangles, rows=factors.rows)


def solve(factors: Factors) -> Fit:
    """Least squares by QR, with robust covariance and the directions that the log leaves open, Eq. (4.7)."""
    p = len(factors.names)
    r = triangle(factors.triangles.reshape(-1, p + 1))
    upper, right = r[:p, :p], r[:p, p]
    size = np.linalg.norm(upper, axis=0)
    size[size == 0.0] = 1.0
    u, s, vt = np.linalg.svd(upper / size)
    sound = s > RANK_TOLERANCE * s[0]
    inverse = (vt[sound].T / s[sound]) @ u[:, sound].T / size[:, None]
    values = inverse @ right
    residual = float(np.linalg.norm(np.append(right - upper @ values, r[p:, p])))
    moved = scores(factors, values) @ inverse @ inverse.T
    count = factors.triangles.shape[0]
    freedom = max(1, count - p)
    return Fit(
        names=factors.names,
        values=values,
        covariance=count / freedom * moved.T @ moved,
        freedom=freedom,
        condition=float(np.linalg.cond(upper)) if sound.all() else float("inf"),
        unidentifiable=vt[~sound] / size,
        residual=residual / np.sqrt(factors.rows),
        scale=float(np.linalg.norm(r[:, p])) / np.sqrt(factors.rows),
        rows=factors.rows,
    )


def scores(factors: Factors, values: Array) -> Array:
    """Products of the regressors with the residual in each segment, shape (segments, p)."""
    left, right = factors.triangles[:, :, :-1], factors.triangles[:, :, -1]
    return np.asarray(np.einsum("bij,bi->bj", left, right - left @ values))


def suited_segments(factors: Factors, *, each: bool = False) -> Factors:
    """Segments whose scores correlate by less than 0.2, on average or each, `FEWEST_SEGMENTS` at least."""
    group = max(1, -(-factors.triangles.shape[0] // MOST_SEGMENTS))
    while True:
        joint = merged(factors, group)
        if joint.triangles.shape[0] // 2 < FEWEST_SEGMENTS:
            return joint
        parts = scores(joint, solve(joint).values)
        power = (parts**2).sum(axis=0)
        power[power == 0.0] = 1.0
        if (np.max if each else np.mean)((parts[1:] * parts[:-1]).sum(axis=0) / power) < 0.2:
            return joint
        group *= 2


NOTICED = 0.05
WEAK_SHARE = 0.1
"""Share of the measured torque that a parameter's uncertainty may make before it counts as undetermined."""


def unidentifiable_parameters(fit: Fit) -> set[str]:
    """Parameters that no number is given for, because an unidentifiable direction moves them."""
    return {fit.names[k] for direction in fit.unidentifiable for k in _members(direction)}


def weak_parameters(fit: Fit, halves: Array, sizes: Array) -> set[str]:
    """Parameters with intervals wider than they are that matter; ``sizes``, (p,): rms of each regressor."""
    weak = (halves > np.abs(fit.values)) & (halves * sizes > WEAK_SHARE * fit.scale)
    return {name for name, is_weak in zip(fit.names, weak, strict=True) if is_weak}


def weak_words(name: str) -> str:
    """Say that a parameter is not determined."""
    return f"{readable(name)} is not determined: its interval is wider than its value"


def readable(name: str) -> str:
    """A parameter's name as running text."""
    for side in ("positive", "negative"):
        if name.endswith(f"_{side}"):
            return f"{name.removesuffix(f'_{side}').replace('_', ' ')} ({side} speed)"
    return "motor-side inertia" if name == "near_inertia" else name.replace("_", " ")


def _members(direction: Array) -> list[int]:
    share = np.abs(direction) / np.abs(direction).max()
    return [int(k) for k in np.argsort(-share) if share[k] > NOTICED]


def unidentifiable_words(fit: Fit) -> tuple[str, ...]:
    """Name each direction about which the log has no information."""
    found = []
    for direction in fit.unidentifiable:
        members = sorted(_members(direction))
        names = [readable(fit.names[k]) for k in members]
        if len(members) == 1:
            found.append(f"{names[0]} is not identifiable: the log does not excite it")
            continue
        signs = ["+" if direction[k] / direction[members[-1]] > 0 else "-" for k in members]
        moves = " ".join(f"{sign} {name}" for sign, name in zip(signs, names, strict=True))
        words = f"{', '.join(names)} are not identifiable separately: a joint change ({moves})"
        found.append(f"{words} has no effect on the log")
    return tuple(found)


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

    @property
    def message(self) -> str:
        """The sentence."""
        return str(self)

    def __new__(cls, code: str, message: str) -> "Finding":
        """Make one."""
        made = super().__new__(cls, message)
        made.code = code
        return made


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
        return ESTIMATE(self)


ESTIMATE = Keys(
    "value unit low high standard_error reason?",
    dict.fromkeys(("value", "low", "high", "standard_error"), ".reason"),
    of=Estimate,
)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False, repr=False)
class Identification(Result):
    """Parameters of a model, identified from logs."""

    _table = "parameters"
    _shown = (Row("model", "model"), Row("unidentifiable", "not identifiable"), Row("findings", "findings"))

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
        return IDENTIFIED(self)


IDENTIFIED = Keys(
    "model parameters identifiable unidentifiable residual condition_number findings notes checked "
    "check_reason method data=reports",
    {"condition_number": "the regressors are not independent"},
    {
        "parameters": ESTIMATE,
        "findings": Keys("code message", of=Finding),
        "data": Keys("**", of=DataReport),
        "residual": Keys("number: rms relative count: rows"),
        "method": "any",
    },
    of=Identification,
)


def unit_of(name: str, linear: bool) -> str:
    """Unit of a parameter of one axis; ``linear``: whether it slides."""
    stem = name.removesuffix("_positive").removesuffix("_negative").rstrip(" 0123456789")
    return LINEAR_UNITS.get(stem, UNITS[stem]) if linear else UNITS[stem]
