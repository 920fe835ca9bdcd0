"""Growth over pretension and torque: the map of the internal resonance, and how far it is off."""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cabledrive.modal.tuning import resonant_pairs
from cabledrive.parameters import Drive, InputRefused, content_hash
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.autoparametric import AutoparametricModel, at_pretension, autoparametric_model
from cabledrive.reduction.averaging import averaged_coefficients
from cabledrive.reduction.oscillators import oscillator_coefficients, oscillator_ensemble
from cabledrive.reduction.threshold import threshold_torque
from cabledrive.simulation import Pluck, Recording, Scheme, Sine, Start, simulate

POINTS = 100
STEPS_PER_PERIOD = 12
SPREAD = 0.25
"""Pretensions of the map reach so far beyond the drive's own and the tuned one."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class GrowthMap:
    """Largest transverse amplitude after a time, over pretension and torque."""

    drive: str  # name
    drive_hash: str
    pretension: Array  # (p,): [N]
    torque: Array  # (t,): [N m]
    growth: Array  # (t, p): largest amplitude of any section over the pluck [-]; NaN where a span went slack
    pulley: Array  # (t, p): largest q [m]; NaN likewise
    slack: NDArray[np.bool_]  # (t, p): where a span went slack on the way: the model ends there
    threshold: Array  # (p,): threshold torque [N m]
    # own_pretension, own_torque: the drive's point
    own_pretension: float
    own_torque: float
    tuned: tuple[float, ...]  # tuned pretensions within the map [N]
    # pluck, duration: Half-sine pluck of the first section [m], half of it on the next; time of the map [s]
    pluck: float
    duration: float


def growth_map(
    drive: Drive,
    *,
    torque: float,
    load_torque: float = 0.0,
    pretensions: ArrayLike | None = None,
    torques: ArrayLike | None = None,
    duration: float = 1.0,
    pluck: float | None = None,
    threads: int = 2,
) -> GrowthMap:
    """Largest motion over pretension and torque at the pulley mode's frequency, from a small unequal pluck.

    ``torque``: the drive's own, the map goes to three times it; 1e-4 of the span is plucked unless told. The
    unstretched lengths are kept; of more sections the two that come nearest to resonance are taken.
    """
    tuned = tuple(sorted({pair.tuned_pretension for pair in resonant_pairs(drive) if pair.tuned_pretension}))
    own = drive.cable.pretension
    closest = min(tuned, key=lambda value: abs(np.log(value / own)), default=own)
    reach = min(own, closest) / (1 + SPREAD), max(own, closest) * (1 + SPREAD)
    tension = _axis(pretensions, reach, "pretensions", positive=True)
    taus = _axis(torques, (0.0, 3.0 * torque if torque > 0.0 else 1.0), "torques", positive=False)
    height = 1e-4 * drive.span_length if pluck is None else pluck
    nearest = min(tuned, key=lambda value: abs(value - own), default=own)
    near = replace(drive, cable=replace(drive.cable, pretension=nearest))
    model = _nearest_two(autoparametric_model(near, load_torque=load_torque))
    lanes = at_pretension(model, np.repeat(tension[None], taus.size, axis=0).ravel())
    amplitude = np.repeat(taus, tension.size)
    plucks = np.outer(height * np.array([1.0, 0.5])[: model.coupling.size], np.ones(amplitude.size))
    step = 2 * np.pi / model.natural / STEPS_PER_PERIOD
    oscillators = oscillator_coefficients(lanes, step, torque=amplitude)
    largest = oscillator_ensemble(oscillators, plucks, int(np.ceil(duration / step)), threads=threads)
    shape = (taus.size, tension.size)
    pulley = largest.pulley.reshape(shape)
    slack = ~(pulley <= np.asarray(at_pretension(model, tension).slack_amplitude)[None])
    return GrowthMap(
        drive=drive.name,
        drive_hash=content_hash(drive),
        pretension=tension,
        torque=taus,
        growth=np.where(slack, np.nan, np.max(largest.spans, axis=0).reshape(shape) / height),
        pulley=np.where(slack, np.nan, pulley),
        slack=slack,
        threshold=threshold_torque(at_pretension(model, tension)),
        own_pretension=drive.cable.pretension,
        own_torque=torque,
        tuned=tuple(value for value in tuned if tension[0] <= value <= tension[-1]),
        pluck=height,
        duration=duration,
    )


def _axis(given: ArrayLike | None, span: tuple[float, float], name: str, *, positive: bool) -> Array:
    axis = np.linspace(*span, POINTS) if given is None else np.asarray(given, dtype=float)
    good = axis.ndim == 1 and axis.size > 0 and bool(np.all(np.isfinite(axis)))
    if not good or np.any(axis < 0.0) or (positive and np.any(axis <= 0.0)):
        bound = "positive" if positive else "not negative"
        raise InputRefused(f"{name}: a list of finite numbers, {bound}, is needed: give one or more")
    return np.sort(axis)


def _nearest_two(model: AutoparametricModel) -> AutoparametricModel:
    """The two sections that a torque reaches first."""
    if model.coupling.size <= 2:
        return model
    c = averaged_coefficients(model, torque=1.0, drift=False)
    order = np.argsort(np.abs(c.transverse_detuning) / np.abs(c.pump))[:2]
    names = ("transverse", "transverse_mass", "coupling", "uneven", "tension_offset")
    return replace(
        model,
        modes=tuple(model.modes[i] for i in order),
        stiffening=model.stiffening[np.ix_(order, order)],
        **{name: getattr(model, name)[order] for name in names},
    )


SPOTS = 3
GROWN = 2.0
"""Where a motion has grown so many times a check says something: such points come first."""


class SpotCheck(NamedTuple):
    """One point of a map by the exact loop."""

    pretension: float  # [N]
    torque: float  # [N m]
    growth: float  # of the map [-]
    exact: float | None  # of the exact loop [-]; None where a span went slack there


def spot_checks(
    drive: Drive, growth: GrowthMap, rng: np.random.Generator, points: int = SPOTS
) -> tuple[SpotCheck, ...]:
    """Run the exact loop at random taut points of a map, most of them inside the instability region.

    Without weight and Coulomb friction; none where spans do not vibrate in their first mode.
    """
    model = autoparametric_model(drive)
    plain = drive.kind == "loop" and not drive.carriage and all(mode.number == 1 for mode in model.modes)
    taut = np.argwhere(~growth.slack)
    if not plain or taut.size == 0:
        return ()
    shuffled = rng.permutation(taut)
    grown = growth.growth[tuple(shuffled.T)] > GROWN
    inside = shuffled[grown][: points - points // 3]
    chosen = np.concatenate((inside, shuffled[~grown]))[:points]
    return tuple(_checked(drive, growth, model.natural, int(t), int(p)) for t, p in chosen)


def _checked(drive: Drive, growth: GrowthMap, natural: float, row: int, column: int) -> SpotCheck:
    tension, torque = float(growth.pretension[column]), float(growth.torque[row])
    smooth = tuple(replace(pulley, coulomb_friction=0.0) for pulley in drive.pulley)
    motor = drive.motor and replace(drive.motor, coulomb_friction=0.0, offset_torque=0.0)
    bare = replace(
        drive,
        cable=replace(drive.cable, pretension=tension),
        layout=replace(drive.layout, gravity=0.0),
        pulley=smooth,
        motor=motor,
    )
    heights = {"upper": growth.pluck, "lower": 0.5 * growth.pluck}
    plucks = tuple(Pluck(height=height, span=span, shape="half-sine") for span, height in heights.items())
    result = simulate(
        bare,
        growth.duration,
        torque=Sine(amplitude=torque, frequency=natural / (2 * np.pi)),
        start=Start(plucks=plucks),
        scheme=Scheme(segments=100),
        recording=Recording(rate=8 * natural / (2 * np.pi)),
    )
    exact = None
    if result.stopped is None:
        largest = max(float(np.max(np.abs(result.midpoint(span)[:, 2]))) for span in heights)
        exact = largest / growth.pluck
    return SpotCheck(tension, torque, float(growth.growth[row, column]), exact)


def spot_check_line(checks: tuple[SpotCheck, ...]) -> str:
    """What the spot checks say, for a caption."""
    if not checks:
        needs = "needs spans without carriages that vibrate in their first mode"
        return f"No spot check: the comparison with the full nonlinear model {needs}."
    taut = [check for check in checks if check.exact is not None]
    worst = max((abs(check.growth / check.exact - 1.0) for check in taut if check.exact), default=0.0)
    slack = f", {len(checks) - len(taut)} of them slack there" if len(taut) < len(checks) else ""
    grown = sum(check.growth > GROWN for check in checks)
    return (
        f"Full nonlinear model at {len(checks)} random points, {grown} of them inside the instability "
        f"region{slack}: the growth differs by up to {100 * worst:.2g} %."
    )
