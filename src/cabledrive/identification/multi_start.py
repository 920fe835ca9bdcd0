"""Output error from many starts: a scout of each on part of the records, then a full fit of the best."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import optimize

from cabledrive.identification.chain_model import ChainModel
from cabledrive.identification.output_error import RowFit, fit_output_error
from cabledrive.identification.record import Record
from cabledrive.parameters import InputRefused, NotComputed

Array = NDArray[np.float64]

FAR = 1e6
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
    """The best fit of many starts.

    Attributes
    ----------
    fit : RowFit
    starts : int
        That were scouted.
    settled : int
        Full fits that were made.
    agreeing : int
        Of them, those that ended in the same minimum.
    """

    fit: RowFit
    starts: int
    settled: int
    agreeing: int


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
            return np.full(size, FAR)

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
