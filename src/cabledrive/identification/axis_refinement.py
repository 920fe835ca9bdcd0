r"""Output error of one rigid axis: the motion is simulated, so no regressor carries the encoder's noise.

Inverse dynamics takes speed and its sign from the encoder; their errors bias it by a fraction of a per cent,
more than its intervals where a log is long. Here the model moves by itself under the measured torque and its
speed is compared with the measured one. The parameters solve :math:`Z^T r = 0`, where :math:`r` is the
filtered difference of speeds and :math:`Z` the exact sensitivities of the model's speed. They are taken along
the motion under the torque's spectral lines alone: noise of the torque must not be in both factors.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cabledrive.identification.axis_case import Case, case_of, columns_of, simulated, weighed
from cabledrive.identification.estimates import Identification
from cabledrive.identification.finding import Finding
from cabledrive.identification.inverse_dynamics import LAG
from cabledrive.identification.logs.log import Log
from cabledrive.identification.method_error import error_of_refinement, widened
from cabledrive.identification.regression import Factors, Fit, factor, joined, solve, suited_segments
from cabledrive.identification.rigid_axis import SHORT_SEGMENTS, AxisOptions, channels_of, equation_for
from cabledrive.parameters import NotComputed

Array = NDArray[np.float64]

PASSES = 12
CONVERGED = 0.1
"""Largest step of a parameter, in standard errors, at which the iteration ends."""
HALVINGS = 5
SLACK = 1e-3
"""Growth of the residual that a step may make: near the end the sensitivities are not quite its gradient."""
LARGEST_RESIDUAL = 0.5
NOT_FOLLOWING = (
    "the model does not reproduce the log in open loop (residual {share:.0f} % of the speed): a feedback "
    "loop controls the axis, or the model is wrong"
)
NOT_FOLLOWED = "not-followed"
QUANTITIES = ("inertia", "viscous", "coulomb", "offset")


def refine_rigid_axis(
    logs: Sequence[Log], found: Identification, options: AxisOptions | None = None
) -> Identification:
    """Refine inverse dynamics by output error; several logs share the parameters.

    ``found``: from inverse dynamics, with constant or smooth Coulomb friction; ``options``: those it was
    found with.
    Returns with a finding where the model does not follow the log by itself.
    Raises `NotComputed` if what was found before is not identifiable, or has another friction.
    """
    options = options or AxisOptions()
    if options.friction.kind not in ("coulomb", "tanh") or not found.identifiable:
        raise NotComputed(
            "output error needs an identifiable rigid axis with one Coulomb friction: fit that first"
        )
    torque, position = channels_of(logs[0], options)
    equation = equation_for(logs, torque, position, options)
    cases = [case_of(log, torque, position, equation) for log in logs]
    values = np.array([estimate.value for estimate in found.parameters.values()])
    speeds = np.array([case.start for case in cases])
    values, speeds, _ = _solved(cases, values, speeds, PASSES // 4)
    cases = weighed(cases, values, speeds)
    values, speeds, fit = _solved(cases, values, speeds, PASSES)
    plain = [simulated(replace(c, weights=None), values, v)[0] for c, v in zip(cases, speeds, strict=True)]
    residual = float(np.sqrt(np.mean(np.concatenate(plain) ** 2)))
    size = float(np.sqrt(np.mean(np.concatenate([case.speed[case.inner] for case in cases]) ** 2)))
    extra = error_of_refinement(cases, values, speeds)
    return _concluded(found, values, fit, extra, residual, size)


def _solved(cases: list[Case], values: Array, speeds: Array, passes: int) -> tuple[Array, Array, Fit]:
    """Gauss-Newton steps until they are small; halved where one beyond its errors raised the residual."""
    factors, residual = _linearised(cases, values, speeds)
    for _ in range(passes):
        fit = solve(suited_segments(factors, each=True))
        step, errors = fit.values, np.sqrt(np.diag(fit.covariance))[:4]
        near = bool(np.all(np.abs(step[:4]) <= errors))
        for _ in range(HALVINGS):
            tried = _within(values, step[:4]), speeds + step[4 : 4 + len(cases)]
            new_factors, new_residual = _linearised(cases, *tried)
            if near or new_residual <= (1.0 + SLACK) * residual:
                break
            step = 0.5 * step
        (values, speeds), factors, residual = tried, new_factors, new_residual
        if np.all(np.abs(step[:4]) <= CONVERGED * errors):
            break
    return values, speeds, solve(suited_segments(factors, each=True))


def _linearised(cases: list[Case], values: Array, speeds: Array) -> tuple[Factors, float]:
    """Residuals and sensitivities of all logs; every log has its own speed at the start."""
    parts, squares, rows = [], 0.0, 0
    count = max(12, SHORT_SEGMENTS // len(cases))
    for number, case in enumerate(cases):
        residual, sensitivities = simulated(case, values, speeds[number])
        regressors = columns_of(sensitivities, number, len(cases))
        names = (*QUANTITIES, *(f"start {k}" for k in range(len(cases))), *((LAG,) if case.lag else ()))
        parts.append(factor(regressors, residual, names, min(count, residual.size // 20)))
        squares += float(residual @ residual)
        rows += residual.size
    return joined(parts), float(np.sqrt(squares / rows))


def _within(values: Array, step: Array) -> Array:
    """A step that changes no inertia or friction by more than half."""
    limit = 0.5 * np.abs(values[:3])
    step = step.copy()
    step[:3] = np.clip(step[:3], -limit, limit)
    return values + step


def _concluded(
    found: Identification, values: Array, fit: Fit, extra: Array, residual: float, size: float
) -> Identification:
    parameters = {
        name: replace(estimate, value=float(values[k]))
        for k, (name, estimate) in enumerate(found.parameters.items())
    }
    method: dict[str, Any] = dict(found.method)
    method |= {
        "name": "output error on the speed, exact sensitivities, started from inverse dynamics",
        "residual_of": "speed",
        "freedom": fit.freedom,
    }
    findings = found.findings
    if residual > LARGEST_RESIDUAL * size:
        findings += (Finding(NOT_FOLLOWED, NOT_FOLLOWING.format(share=100 * residual / size)),)
    refined = replace(
        found,
        findings=findings,
        parameters=parameters,
        residual={"rms": residual, "relative": residual / size, "rows": fit.rows},
        method=method,
        covariance=fit.covariance[:4, :4],
        freedom=fit.freedom,
    )
    return widened(refined, extra)
