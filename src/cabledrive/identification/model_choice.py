"""Which of Models 1 to 4 a measured response shows: cross-validation and an information criterion."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from cabledrive.identification.frequency_response import FrequencyResponse
from cabledrive.identification.response_lines import selected
from cabledrive.identification.response_models import (
    MOST_AKAIKE,
    PARAMETERS,
    ResponseFit,
    chain_for,
    fit_response,
)
from cabledrive.reduction.lumped_chain import speed_response


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ModelChoice:
    """Models compared on one response.

    Attributes
    ----------
    chosen : int
    fits : dict of int to ResponseFit
    cross_validation : dict of int to float
        Weighted root mean square error on lines that were not fitted.
    reason : str
    """

    chosen: int
    fits: dict[int, ResponseFit]
    cross_validation: dict[int, float]
    reason: str


def choose_model(
    measured: FrequencyResponse,
    start: Mapping[str, float],
    *,
    radius: float = 1.0,
    inertias_known: bool = False,
    folds: int = 5,
) -> ModelChoice:
    """Which of the Models 1 to 4 a response calls for.

    From the motor's side Models 2 and 3 are one and the same two inertias; only known inertias distinguish
    them.

    Parameters
    ----------
    measured : FrequencyResponse
    start : mapping of str to float
        Rough values for Model 4; the others lump them.
    radius : float, default 1.0
        [m].
    inertias_known : bool, default False
        Whether the inertias of ``start`` are known, from bench tests, and held.
    folds : int, default 5
        Of the cross-validation.

    Returns
    -------
    ModelChoice
        The simplest model whose cross-validation error is within 2 % of the best, if Akaike's criterion
        does not prefer a higher one by more than 10.
    """
    fits, errors = {}, {}
    for model in PARAMETERS:
        rough = lumped_start(start, model)
        fixed = {name: rough[name] for name in rough if inertias_known and name.endswith("inertia")}
        fits[model] = fit_response(measured, model, rough, radius=radius, fixed=fixed)
        errors[model] = _cross_validated(measured, fits[model], radius, folds)
    best = min(errors.values())
    least = min(fit.criterion for fit in fits.values())
    # The mean of n squared errors of complex numbers has the relative standard error 1/sqrt(n).
    within = best * (1.0 + 0.5 / np.sqrt(measured.frequency.size))
    near = [m for m in fits if errors[m] <= within and fits[m].criterion <= least + MOST_AKAIKE]
    chosen = min(near or [min(errors, key=lambda m: errors[m])], key=lambda m: len(fits[m].names))
    listed = ", ".join(f"Model {m}: {errors[m]:.3g}" for m in sorted(errors))
    alike = chosen in (2, 3) and not inertias_known
    doubt = "; from the motor side Models 2 and 3 are equivalent unless inertias are known" if alike else ""
    return ModelChoice(
        chosen=chosen, fits=fits, cross_validation=errors, reason=f"errors on unseen lines: {listed}{doubt}"
    )


def lumped_start(start: Mapping[str, float], model: int) -> dict[str, float]:
    """Start values of a model from those of Model 4.

    ``model``, {1, 2, 3, 4}.
    """
    motor, drive, load = (start[f"{name}_inertia"] for name in ("motor", "drive", "load"))
    values = dict(start)
    if model == 1:
        values["inertia"] = motor + drive + load
    elif model == 2:
        values["load_inertia"] = drive + load
    elif model == 3:
        values["drive_inertia"] = motor + drive
    return {name: values[name] for name in PARAMETERS[model]}


def _cross_validated(measured: FrequencyResponse, fit: ResponseFit, radius: float, folds: int) -> float:
    squares, count = 0.0, 0
    start = dict(zip(fit.names, fit.values, strict=True))
    for fold in range(folds):
        out = np.arange(measured.frequency.size) % folds == fold
        kept, left = selected(measured, ~out), selected(measured, out)
        part = fit_response(kept, fit.model, start, radius=radius, fixed=fit.fixed)
        values = fit.fixed | dict(zip(part.names, part.values, strict=True))
        chain = chain_for(fit.model, values, radius)
        off = (speed_response(chain, 2 * np.pi * left.frequency) - left.response) / left.deviation
        squares += float(np.sum(np.abs(off) ** 2))
        count += off.size
    return float(np.sqrt(squares / count))
