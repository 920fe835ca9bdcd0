r"""Models 1 to 4 fitted to a measured response, and the choice among them.

The chain's response from torque to motor speed is matched in the complex plane, weighted by the measured
deviation,

.. math:: \min_p \sum_k \Big|\frac{H(\omega_k) - H(\omega_k; p)}{\sigma_k}\Big|^2,

by bounded nonlinear least squares in the logarithms of the parameters. Since Models 1 to 3 are limits of
Model 4, they are compared by Akaike's criterion on the same data and by cross-validation over interleaved
lines.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy import optimize, stats

from cabledrive.identification.frequency_response import FrequencyResponse
from cabledrive.identification.log_response import selected
from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.lumped_chain import LumpedChain, speed_response

LINKS = {1: (), 2: ("joint",), 3: ("cable",), 4: ("joint", "cable")}
PARAMETERS = {
    1: ("inertia", "viscous_friction"),
    2: ("motor_inertia", "load_inertia", "viscous_friction", "joint_stiffness", "joint_damping"),
    3: ("drive_inertia", "load_inertia", "viscous_friction", "cable_stiffness", "cable_damping"),
    4: (
        "motor_inertia",
        "drive_inertia",
        "load_inertia",
        "viscous_friction",
        "joint_stiffness",
        "joint_damping",
        "cable_stiffness",
        "cable_damping",
    ),
}
UNITS = {
    "viscous_friction": "N m s/rad",
    "joint_stiffness": "N m/rad",
    "joint_damping": "N m s/rad",
    "cable_stiffness": "N/m",
    "cable_damping": "N s/rad",
}
MOST_EVALUATIONS = 60
MOST_AKAIKE = 30.0
SPREAD = 1e4
"""Each parameter may move by this factor from its start, either way."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ResponseFit:
    """One model fitted to a response."""

    model: int  # {1, 2, 3, 4}
    names: tuple[str, ...]  # parameters that were fitted
    # values, errors: (p,): estimates and standard errors, scaled by the misfit where that exceeds the
    # measured deviation
    values: Array
    errors: Array
    # low, high: (p,): 95 % bounds; on the logarithm, so always positive
    low: Array
    high: Array
    fixed: dict[str, float]  # parameters that were given
    misfit: float  # root mean square of the weighted residual; 1 where the model explains all but the noise
    criterion: float  # Akaike's, smaller is better
    freedom: int

    def __getitem__(self, name: str) -> float:
        return float(self.values[self.names.index(name)]) if name in self.names else self.fixed[name]

    def bounds(self, name: str, level: float) -> tuple[float, float]:
        """Interval of one parameter at another level, as 0.999."""
        k = self.names.index(name)
        width = float(stats.t.ppf(0.5 + level / 2, self.freedom) * self.errors[k] / self.values[k])
        return float(self.values[k] * np.exp(-width)), float(self.values[k] * np.exp(width))


def chain_for(model: int, values: Mapping[str, float], radius: float) -> LumpedChain:
    """The lumped chain of a model, both radii [m] alike, two spans as in (6.11), (6.13)."""
    inertias = [values[name] for name in PARAMETERS[model] if name.endswith("inertia")]
    links = {
        "joint": lambda: (values["joint_stiffness"], values["joint_damping"]),
        "cable": lambda: (2 * values["cable_stiffness"] * radius**2, 2 * values["cable_damping"] * radius),
    }
    pairs = [links[name]() for name in LINKS[model]]
    n = len(inertias)
    return LumpedChain(
        names=tuple(f"inertia {k}" for k in range(n)),
        inertias=tuple(inertias),
        viscous=(values["viscous_friction"], *(0.0,) * (n - 1)),
        coulomb=(0.0,) * n,
        offsets=(0.0,) * n,
        stiffness=tuple(pair[0] for pair in pairs),
        damping=tuple(pair[1] for pair in pairs),
        ratios=((1.0, 1.0),) * (n - 1),
    )


def fit_response(
    measured: FrequencyResponse,
    model: int,
    start: Mapping[str, float],
    *,
    radius: float = 1.0,
    fixed: Mapping[str, float] | None = None,
    lowpass: float | None = None,
) -> ResponseFit:
    """Fit one of the Models 1 to 4 to a response from torque to motor speed [rad/(N m s)].

    ``start``: rough values of `PARAMETERS`, within a factor of a few; ``radius``: of both pulleys [m];
    ``fixed``: parameters known already, as inertias from bench tests; ``lowpass``: half a sample of delay or
    a filter between the channels [s].
    """
    fixed = dict(fixed or {})
    names = tuple(name for name in PARAMETERS[model] if name not in fixed)
    if 2 * measured.frequency.size <= len(names) + 2:
        raise InputRefused(
            f"{measured.frequency.size} lines are too few for {len(names)} parameters: widen the band"
        )
    omega = 2 * np.pi * measured.frequency
    delay = np.exp(-1j * omega * (lowpass or 0.0))
    weight = 1.0 / np.maximum(measured.deviation, 1e-3 * np.abs(measured.response).min())

    def residual(logs: Array) -> Array:
        values = fixed | dict(zip(names, np.exp(logs), strict=True))
        model_response = speed_response(chain_for(model, values, radius), omega) * delay
        off = (model_response - measured.response) * weight
        return np.concatenate([off.real, off.imag])

    begin = np.log([start[name] for name in names])
    found = optimize.least_squares(
        residual,
        begin,
        bounds=(begin - np.log(SPREAD), begin + np.log(SPREAD)),
        x_scale="jac",
        max_nfev=MOST_EVALUATIONS,
    )
    return _fit(model, names, found, fixed)


def _fit(
    model: int, names: tuple[str, ...], found: optimize.OptimizeResult, fixed: dict[str, float]
) -> ResponseFit:
    rows, p = found.jac.shape
    freedom = max(1, rows - p)
    # Weights are deviations of the complex response: each of its parts carries half the variance.
    squares = 2.0 * float(found.fun @ found.fun)
    scale = max(1.0, squares / freedom)
    upper = np.linalg.qr(found.jac, mode="r")
    inverse = np.linalg.pinv(upper, rcond=1e-12)
    errors = np.sqrt(0.5 * scale * (inverse**2).sum(axis=1))
    width = stats.t.ppf(0.975, freedom) * errors
    values = np.exp(found.x)
    return ResponseFit(
        model=model,
        names=names,
        values=values,
        errors=values * errors,
        low=values * np.exp(-np.minimum(width, 500.0)),
        high=values * np.exp(np.minimum(width, 500.0)),
        fixed=fixed,
        misfit=float(np.sqrt(squares / freedom)),
        criterion=float(rows * np.log(squares / rows) + 2 * p),
        freedom=freedom,
    )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ModelChoice:
    """Models compared on one response."""

    chosen: int
    fits: dict[int, ResponseFit]
    cross_validation: dict[int, float]  # weighted root mean square error on lines that were not fitted
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
    """Start values of a model from those of Model 4."""
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
