r"""Output error of a lumped chain: several records share the parameters, each with its own start.

The chain moves by itself under the measured input; the parameters make the sum of squared differences between
measured and simulated outputs least,

.. math:: \min_p \sum_{\text{records}} \sum_{k\in\text{training}} |W (y_k - h(x_k(p)))|^2,

by bounded nonlinear least squares with the exact sensitivities of the integration. Positive parameters are
searched in the logarithm. Samples outside the training part never enter; they are for `fit_of`.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import optimize

from cabledrive.identification.chain_model import ChainModel
from cabledrive.identification.record import Record
from cabledrive.identification.regression import factor, joined, solve, suited_segments
from cabledrive.parameters import InputRefused, NotComputed

Array = NDArray[np.float64]

MOST_EVALUATIONS = 200
SEGMENTS = 240
FAR = 1e3
"""Residual, in units of the output's size, of parameters under which the motion diverges."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RowFit:
    """Parameters of a lumped chain from its records.

    Attributes
    ----------
    model : ChainModel
    values : dict of str to float
    errors : dict of str to float
        Standard errors from scores of segments of time, so that coloured residuals count.
    covariance : ndarray, shape (p, p)
        In the order of ``values``.
    freedom : int
        Degrees of freedom of intervals.
    residual : float
        Root mean square over the training samples, weighted as they were fitted.
    evaluations : int
        Of the model, until the fit had settled.
    """

    model: ChainModel
    values: dict[str, float]
    errors: dict[str, float]
    covariance: Array
    freedom: int
    residual: float
    evaluations: int

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
