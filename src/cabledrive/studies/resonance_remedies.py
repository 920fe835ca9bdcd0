"""Changes that bring a drive out of its internal resonance: which, and how much of each."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from cabledrive.mechanics.warnings import elastic_range, largest_pretension
from cabledrive.parameters import Drive, InputRefused, NotComputed
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.autoparametric import AutoparametricModel, at_pretension, autoparametric_model
from cabledrive.reduction.averaging import AveragedCoefficients, averaged_coefficients
from cabledrive.reduction.threshold import threshold_torque
from cabledrive.studies.resonance_detuning import CLOSE, SAFE, instability_margin

REACH = 1.0
"""Largest relative change of pretension and inertia that is tried."""

FAILED = "tried without success"

_TRIALS = 48
_HALVINGS = 24


@dataclass(frozen=True, slots=True, kw_only=True)
class Remedy:
    """One change that was tried to make the verdict safe."""

    change: str  # {"raise pretension", "lower pretension", "add inertia", "add damping", "limit torque"}
    # new pretension [N], inertia to add at the load pulley [kg m^2], viscous friction to add there
    # [N m s/rad], or largest torque [N m]; None where no value within reach is enough
    value: float | None
    relative: float | None  # change of the quantity, relative to its value
    text: str  # in words

    @property
    def enough(self) -> bool:
        """Whether this change alone makes the verdict safe."""
        return self.value is not None and (self.change != "limit torque" or self.value > 0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Sensitivity:
    """How the distance from tuning and the threshold move."""

    detuning_per_pretension: float  # of the deciding mode [rad/s per N]
    detuning_per_inertia: float  # at the load pulley [rad/s per kg m^2]
    # threshold_per_transverse_damping, threshold_per_friction: relative change of the threshold at the
    # drive's own pretension, per 1/s of Gamma, and per N m s/rad of friction at the load pulley
    threshold_per_transverse_damping: float
    threshold_per_friction: float


def remedies(drive: Drive, torque: float, load_torque: float = 0.0) -> tuple[Remedy, ...]:
    """Changes, each by itself, that make a drive that is not safe so under a torque [N m]."""
    model = autoparametric_model(drive, load_torque=load_torque, at_rest=True)

    def _safe(trial: Drive) -> bool:
        try:
            found = autoparametric_model(trial, load_torque=load_torque, at_rest=True)
            return instability_margin(found, torque).verdict == SAFE
        except (InputRefused, NotComputed):  # weights or the steady load take a span's tension away
            return False

    return (
        _pretension(drive, _safe, +1),
        _pretension(drive, _safe, -1),
        _inertia(drive, _safe),
        _damping(drive, model, torque),
        _torque(model),
    )


def sensitivity(drive: Drive, torque: float, load_torque: float = 0.0) -> Sensitivity:
    """Derivatives of detuning and threshold by what a designer can change, under a torque [N m]."""
    model = autoparametric_model(drive, load_torque=load_torque, at_rest=True)
    mode = instability_margin(model, torque).mode
    step = 1e-4 * model.pretension
    above, below = (at_pretension(model, model.pretension + sign * step) for sign in (1, -1))
    slope = (above.transverse[mode] - below.transverse[mode]) / (2 * step)
    load = drive.load_pulley

    def relative_slope(name: str) -> float:
        changed = [replace(model, **{name: getattr(model, name) + more}) for more in (0.0, 1e-3)]
        low, high = (float(threshold_torque(one)) for one in changed)
        return (high - low) / (1e-3 * high) if np.isfinite(high) and high > 0.0 else 0.0

    inertia = model.natural * (model.rims[1] / load.radius) ** 2 / (4 * model.modal_mass)
    return Sensitivity(
        detuning_per_pretension=float(slope),
        detuning_per_inertia=inertia,
        threshold_per_transverse_damping=relative_slope("transverse_damping"),
        threshold_per_friction=relative_slope("modal_damping") * _damping_per_friction(drive, model),
    )


def _damping_per_friction(drive: Drive, model: AutoparametricModel) -> float:
    """c_q per viscous friction at the load pulley [1/s / (N m s)]."""
    return (model.rims[1] / drive.load_pulley.radius) ** 2 / model.modal_mass


def _first_safe(trial: Callable[[float], Drive], safe: Callable[[Drive], bool]) -> float | None:
    """Smallest share of the reach at which the drive is safe, refined by halving."""
    shares = REACH * (np.arange(1, _TRIALS + 1) / _TRIALS) ** 2
    last = 0.0
    for share in shares:
        if safe(trial(float(share))):
            low, high = last, float(share)
            for _ in range(_HALVINGS):
                if high - low < 1e-3 * high:
                    break
                middle = 0.5 * (low + high)
                low, high = (low, middle) if safe(trial(middle)) else (middle, high)
            return high
        last = float(share)
    return None


def _pretension(drive: Drive, safe: Callable[[Drive], bool], sign: int) -> Remedy:
    cable = drive.cable

    def _trial(share: float) -> Drive:
        factor = 1.0 + share if sign > 0 else 1.0 / (1.0 + share)
        return replace(drive, cable=replace(cable, pretension=cable.pretension * factor))

    word, limit = "raise" if sign > 0 else "lower", largest_pretension(drive)
    share = _first_safe(_trial, lambda trial: trial.cable.pretension <= limit and safe(trial))
    new = relative = None
    if share is None:
        beyond = _trial(REACH).cable.pretension > limit
        reach = elastic_range(drive).rstrip(",") if beyond else f"to x{(1 + REACH) ** sign:.3g}"
        text = f"{FAILED}: {'higher' if sign > 0 else 'lower'} pretension {reach}"
    else:
        new = _trial(share).cable.pretension
        relative = new / cable.pretension - 1.0
        text = f"{word} the pretension by {abs(100 * relative):.3g} % to {new:.4g} N"
    return Remedy(change=f"{word} pretension", value=new, relative=relative, text=text)


def _inertia(drive: Drive, safe: Callable[[Drive], bool]) -> Remedy:
    load = drive.load_pulley

    def _trial(share: float) -> Drive:
        heavier = replace(load, inertia=load.inertia * (1.0 + share))
        return replace(drive, pulley=(drive.drive_pulley, heavier))

    share = None if load.fixed else _first_safe(_trial, safe)
    added = None if share is None else load.inertia * share
    text = f"{FAILED}: inertia added to the load pulley, up to x{REACH:.3g} of its own"
    if share is not None:
        text = f"add {added:.4g} kg m^2 to the load pulley (+{100 * share:.3g} %)"
    return Remedy(change="add inertia", value=added, relative=share, text=text)


def _damping(drive: Drive, model: AutoparametricModel, torque: float) -> Remedy:
    """Friction at the load pulley that lifts the safe torque at the drive's own pretension."""
    c = averaged_coefficients(model, torque=torque, drift=False)
    with np.errstate(divide="ignore"):
        needed = np.max(np.abs(c.force) * np.abs(c.pump) / _safe_pumping(c))
    if drive.load_pulley.fixed or not np.isfinite(needed):
        text = f"{FAILED}: friction at the load pulley (the cable is undamped at exact tuning)"
        return Remedy(change="add damping", value=None, relative=None, text=text)
    wanted = 2.0 * float(np.sqrt(max(needed**2 - float(c.detuning) ** 2, 0.0)))
    friction = max(0.0, wanted - model.modal_damping) / _damping_per_friction(drive, model)
    text = f"damp the load pulley by {friction:.3g} N m s/rad more"
    return Remedy(change="add damping", value=friction, relative=None, text=text)


def _torque(model: AutoparametricModel) -> Remedy:
    c = averaged_coefficients(model, torque=1.0, drift=False)
    resistance = float(np.abs(-0.5 * c.damping + 1j * c.detuning))
    limit = float(np.min(_safe_pumping(c) * resistance / (np.abs(c.force) * np.abs(c.pump))))
    text = f"keep the torque at the pulley mode's frequency below {limit:.3g} N m"
    if limit == 0.0:
        text = f"{FAILED}: a smaller torque (the threshold at the pulley mode's frequency is zero)"
    return Remedy(change="limit torque", value=limit, relative=None, text=text)


def _safe_pumping(c: AveragedCoefficients) -> Array:
    """Parametric excitation at which each mode lies just outside the margin [rad/s]."""
    return np.hypot(c.transverse_detuning / CLOSE, 0.5 * c.transverse_damping)
