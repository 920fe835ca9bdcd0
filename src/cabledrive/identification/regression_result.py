"""From a solved regression to an answer: numbers where there are any, words where there are none."""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cabledrive.identification import identifiability as limits
from cabledrive.identification.axis_equation import AxisEquation
from cabledrive.identification.estimates import Estimate, Identification, unit_of
from cabledrive.identification.finding import Finding
from cabledrive.identification.inverse_dynamics import LAG
from cabledrive.identification.regression import Factors, Fit, only, solve, triangle

Array = NDArray[np.float64]

LEAST_DETERMINED = 2.0
"""Standard error of the torque's instant, over its systematic error, above which it is not identifiable."""


def regression_result(
    factors: Factors,
    equation: AxisEquation,
    sizes: Array,
    method: dict[str, Any],
    findings: tuple[str, ...],
    reports: tuple[Any, ...],
    doubt: float = 0.0,
) -> Identification:
    """The identification from a solved regression: numbers where there are any, words where there are none.

    ``sizes``, shape (p,): root mean square of each regressor; ``doubt``: about the instant at which the
    torque acts, where the regression leaves that free and cannot find it beside the parameters [s].
    """
    fit = _without_lag(factors, doubt)
    sizes = sizes[: len(fit.names)]
    unidentifiable = limits.unidentifiable_parameters(fit)
    weak = set(limits.weak_parameters(fit, sizes)) - unidentifiable
    words = limits.unidentifiable_words(fit) + tuple(
        limits.weak_words(name) for name in fit.names if name in weak
    )
    half = fit.half_width()
    parameters = {
        name: _estimate(fit, k, float(half[k]), unit_of(name, equation.linear), name in unidentifiable | weak)
        for k, name in enumerate(fit.names)
    }
    relative = fit.residual / fit.scale if fit.scale > 0 else float("nan")
    return Identification(
        model=f"rigid-axis-{equation.friction.kind}",
        parameters=parameters,
        identifiable=not words,
        unidentifiable=words,
        residual={"rms": float(fit.residual), "relative": float(relative), "rows": fit.rows},
        condition_number=fit.condition,
        method=method,
        covariance=fit.covariance,
        freedom=fit.freedom,
        findings=findings + implausible(parameters),
        reports=reports,
    )


def _without_lag(factors: Factors, doubt: float) -> Fit:
    """The fit of the parameters, the instant of the torque taken out: estimated beside them, or doubted."""
    if LAG not in factors.names:
        return solve(factors)
    count = len(factors.names) - 1
    kept = factors.names[:count]
    fit = solve(factors)
    error = float(np.sqrt(fit.covariance[-1, -1]))
    plain = solve(only(factors, kept))
    if not (fit.unidentifiable.size or error > LEAST_DETERMINED * doubt):
        covariance = fit.covariance[:count, :count]
        return replace(
            fit, names=kept, values=fit.values[:count], covariance=covariance, condition=plain.condition
        )
    stacked = triangle(factors.triangles.reshape(-1, count + 2))
    moved = doubt * np.linalg.lstsq(stacked[:count, :count], stacked[:count, count], rcond=None)[0]
    return replace(plain, covariance=plain.covariance + np.outer(moved, moved))


def implausible(parameters: dict[str, Estimate]) -> tuple[str, ...]:
    """Numbers that no machine has: findings about the log, not results."""
    found = []
    against = any(parameters[name].value < 0.0 for name in ("inertia", "mass") if name in parameters)
    for name, estimate in parameters.items():
        if not estimate.reason and estimate.high < 0.0 and not name.startswith("offset"):
            hint = "are torque and angle swapped, or is one sign reversed?"
            if name not in ("inertia", "mass") and not against:
                hint = "the friction model does not fit this axis"
            size = f"{estimate.value:.4g} {estimate.unit}"
            found.append(
                Finding("negative", f"{limits.readable(name)} is identified as negative ({size}): {hint}")
            )
    return tuple(found)


def _estimate(fit: Fit, k: int, half: float, unit: str, unknown: bool) -> Estimate:
    if unknown:
        infinite = float("inf")
        return Estimate(
            value=float("nan"),
            unit=unit,
            standard_error=infinite,
            low=-infinite,
            high=infinite,
            reason="not identifiable from the log",
        )
    value = float(fit.values[k])
    error = float(np.sqrt(fit.covariance[k, k]))
    return Estimate(value=value, unit=unit, standard_error=error, low=value - half, high=value + half)
