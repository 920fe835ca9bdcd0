r"""Output error of a lumped chain, from many starts.

The chain moves by itself under the measured input; the parameters make the sum of squared differences between
measured and simulated outputs least,

.. math:: \min_p \sum_{\text{records}} \sum_{k\in\text{training}} |W (y_k - h(x_k(p)))|^2,

by bounded nonlinear least squares with the exact sensitivities of the integration. Positive parameters are
searched in the logarithm. Samples outside the training part never enter; they are for `fit_of`.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import optimize

from cabledrive.identification.chain_model import ChainModel, Record
from cabledrive.identification.regression import factor, joined, solve, suited_segments
from cabledrive.parameters import InputRefused, NotComputed

Array = NDArray[np.float64]

MOST_EVALUATIONS = 200
SEGMENTS = 240
FAR = 1e3
"""Residual, in units of the output's size, of parameters under which the motion diverges."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RowFit:
    """Parameters of a lumped chain from its records."""

    model: ChainModel
    values: dict[str, float]
    # standard errors from scores of segments of time, so that coloured residuals count
    errors: dict[str, float]
    covariance: Array  # (p, p): in the order of ``values``
    freedom: int  # degrees of freedom of intervals
    residual: float  # root mean square over the training samples, weighted as they were fitted
    evaluations: int  # of the model, until the fit had settled

    def simulated(self, record: Record) -> Array:
        """Outputs of the model under the input of a record.

        Returns shape (samples, channels).
        """
        return self.model.outputs(self.values, record)


def fit_output_error(
    records: Sequence[Record],
    model: ChainModel,
    start: Mapping[str, float],
    *,
    most_evaluations: int = MOST_EVALUATIONS,
    tolerance: float = 1e-8,
) -> RowFit:
    """Fit a lumped chain to several records at once.

    ``records``: only samples of their training part are compared; ``start``: a value for each parameter of
    the model.
    Raises `InputRefused` if no record is given, or a start value is missing or outside its bounds;
    `NotComputed` if the motion diverges at the start values, or the fit has not settled after so many
    evaluations.
    """
    if not records:
        raise InputRefused("no record given: name at least one")
    begin, low, high = model.search_bounds(start)
    size = float(np.sqrt(np.mean(np.concatenate([r.output[r.training].ravel() ** 2 for r in records]))))
    known: dict[bytes, tuple[Array, Array]] = {}

    def evaluated(place: Array) -> tuple[Array, Array]:
        key = place.tobytes()
        if key not in known:
            known.clear()
            parts = [model.compared(place, record) for record in records]
            known[key] = (np.concatenate([p[0] for p in parts]), np.vstack([p[1] for p in parts]))
        return known[key]

    def residual(place: Array) -> Array:
        try:
            return evaluated(place)[0]
        except NotComputed:
            return np.full(sum(r.compared_size for r in records), FAR * size)

    evaluated(begin)
    found = optimize.least_squares(
        residual,
        begin,
        jac=lambda place: evaluated(place)[1],
        bounds=(low, high),
        x_scale="jac",
        max_nfev=most_evaluations,
        ftol=tolerance,
    )
    if found.status == 0:
        raise NotComputed(
            f"output error has not converged after {most_evaluations} evaluations: start nearer, or allow "
            "more"
        )
    return _concluded(records, model, found)


def _concluded(records: Sequence[Record], model: ChainModel, found: optimize.OptimizeResult) -> RowFit:
    count = max(12, SEGMENTS // len(records))
    parts = []
    for record in records:
        residual, sensitivities = model.compared(found.x, record)
        parts.append(factor(-sensitivities, residual, model.names, min(count, residual.size // 20)))
    fit = solve(suited_segments(joined(parts)))
    by_value = model.slopes(found.x)
    covariance = fit.covariance * by_value[:, None] * by_value
    values = model.values_at(found.x)
    errors = np.sqrt(np.diag(covariance))
    return RowFit(
        model=model,
        values=values,
        errors=dict(zip(model.names, errors.tolist(), strict=True)),
        covariance=covariance,
        freedom=fit.freedom,
        residual=float(np.sqrt(np.mean(found.fun**2))),
        evaluations=int(found.nfev),
    )


def fit_of(measured: Array, simulated: Array) -> float:
    """Share of the measured variation that is explained [%]: 100 (1 - norm(y - s) / norm(y - mean y)).

    ``measured``, ``simulated``, shape (samples,).
    """
    return float(
        100.0 * (1.0 - np.linalg.norm(measured - simulated) / np.linalg.norm(measured - measured.mean()))
    )


RUN_AWAY = 1e6
"""Residual of a start from which the motion diverges."""
SCOUTED = 1000
"""Samples of each record that a scout compares."""
SETTLED = 4000
"""Samples of each record on which the fits of the best starts are compared, in twice as long steps as the
whole, to which the best is then fitted."""
SCOUT_EVALUATIONS = 12
ENOUGH = 1e-6
"""Relative change of the squares at which the fit of all rows ends: far below what chance moves."""
ALIKE = 1e-3
"""Relative distance of residuals at which two fits count as one minimum."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class StartedFit:
    """The best fit of many starts."""

    fit: RowFit
    starts: int  # that were scouted
    settled: int  # full fits that were made
    agreeing: int  # of them, those that ended in the same minimum


@np.errstate(over="ignore", invalid="ignore")  # of starts from which the motion grows beyond all bounds
def fit_from_many_starts(
    records: Sequence[Record],
    models: Sequence[ChainModel],
    starts: Sequence[Mapping[str, float]],
    *,
    full: int = 2,
    progress: Callable[[str], None] | None = None,
) -> StartedFit:
    """Fit from every start what the first samples show, the best to more of them, the best of those to all.

    ``models``: with the same parameters, as with another hold of the input; the best start is tried in each;
    ``full``: how many are fitted to more.
    Raises `NotComputed` if no start leads anywhere.
    """
    short, middle = _begun(records, SCOUTED), _begun(records, SETTLED)
    quick = [replace(model, substeps=max(1, model.substeps // 2)) for model in models]
    scouts: list[tuple[float, dict[str, float]]] = []
    say = progress or (lambda words: None)
    for k, start in enumerate(starts):
        say(f"two inertias: start {k + 1} of {len(starts)}")
        found = _tried(short, quick[0], start, SCOUT_EVALUATIONS)
        if found is not None:
            scouts.append(found)
    scouts.sort(key=lambda entry: entry[0])
    fits: list[tuple[RowFit, ChainModel]] = []
    own: list[float] = []
    for model, coarse in zip(models, quick, strict=True):
        for _, start in scouts[: full if model is models[0] else 1]:
            say(f"two inertias: fit {len(fits) + 1} of the best starts")
            begin = fits[0][0].values if model is not models[0] and fits else start
            try:
                fits.append((fit_output_error(middle, coarse, _inside(coarse, begin)), model))
            except NotComputed:
                continue
            own += [fits[-1][0].residual] if model is models[0] else []
    if not fits:
        raise NotComputed(f"none of {len(starts)} starts leads to a model that reproduces the log")
    best, model = min(fits, key=lambda entry: entry[0].residual)
    near = sum(residual < min(own) * (1.0 + ALIKE) for residual in own)
    say(f"two inertias: the best fit over all {sum(r.input.size for r in records)} rows")
    whole = fit_output_error(records, model, _inside(model, best.values), tolerance=ENOUGH)
    return StartedFit(fit=whole, starts=len(starts), settled=len(own), agreeing=near)


def _begun(records: Sequence[Record], samples: int) -> list[Record]:
    """The first samples of each record."""
    lasts = [min(r.first + samples, r.input.size if r.last is None else r.last) for r in records]
    return [
        replace(r, last=last, input=r.input[:last], output=r.output[:last])
        for r, last in zip(records, lasts, strict=True)
    ]


def _tried(
    records: Sequence[Record], model: ChainModel, start: Mapping[str, float], evaluations: int
) -> tuple[float, dict[str, float]] | None:
    """Residual and parameters after some evaluations, settled or not."""
    try:
        begin, low, high = model.search_bounds(_inside(model, start))
    except InputRefused:
        return None
    size = sum(record.compared_size for record in records)
    known: dict[bytes, tuple[Array, Array]] = {}

    def compared(place: Array) -> tuple[Array, Array]:
        key = place.tobytes()
        if key not in known:
            known.clear()
            parts = [model.compared(place, record) for record in records]
            known[key] = np.concatenate([p[0] for p in parts]), np.vstack([p[1] for p in parts])
        return known[key]

    def residual(place: Array) -> Array:
        try:
            return compared(place)[0]
        except NotComputed:
            return np.full(size, RUN_AWAY)

    try:
        found = optimize.least_squares(
            residual,
            begin,
            jac=lambda place: compared(place)[1],
            bounds=(low, high),
            x_scale="jac",
            max_nfev=evaluations,
        )
    except (NotComputed, ValueError):
        return None
    return float(found.cost), model.values_at(found.x)


def _inside(model: ChainModel, start: Mapping[str, float]) -> dict[str, float]:
    """A start strictly within the bounds."""
    inside = {}
    for s in model.free:
        margin = (1.0 + 1e-6) if s.positive else 1e-9 * (s.high - s.low)
        low, high = (s.low * margin, s.high / margin) if s.positive else (s.low + margin, s.high - margin)
        inside[s.name] = float(np.clip(start[s.name], low, high))
    return inside
