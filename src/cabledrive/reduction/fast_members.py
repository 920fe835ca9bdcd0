"""Thousands of runs of the fast model at once, over threads: one result with labelled dimensions."""

from collections import defaultdict
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from itertools import product
from math import pi, prod
from os import cpu_count
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from cabledrive.parameters import Drive, InputRefused
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.fields import nearest
from cabledrive.parameters.version import __version__
from cabledrive.reduction.fast_simulation import FastScheme, check_band, grid_of, start_amplitudes
from cabledrive.reduction.uniform_tension import (
    STEEPEST,
    UniformTensionModel,
    coefficients,
    integrate,
    uniform_tension_model,
)
from cabledrive.simulation import Pluck, Recording, Start

if TYPE_CHECKING:
    import xarray


SPANS = ("upper", "lower")
OF_THE_CABLE = ("pretension", "transverse_damping", "axial_damping")
OF_THE_LOAD = {"load_inertia": "inertia", "load_friction": "viscous_friction"}
UNITS = {
    **dict(zip(OF_THE_CABLE, ("N", "1/s", "N s"), strict=True)),
    **{"load_inertia": "kg m^2", "load_friction": "N m s/rad"},
    **{"torque_amplitude": "N m", "torque_frequency": "Hz", "pluck_upper": "m", "pluck_lower": "m"},
}
"""What may be varied; where it is not given, the drive's own value, and no torque and no pluck."""
MOST_NUMBERS = 500_000_000
_SMALL = 1e-6  # m, height of the pluck from which all are scaled


@dataclass(frozen=True, slots=True)
class _Sharing:
    """Members of one drive: the model they share, sines per height of pluck, their numbers and settings."""

    model: UniformTensionModel
    sines: Array  # (2, m)
    offset: float
    numbers: list[int]
    settings: list[dict[str, float]]


def fast_ensemble(
    drive: Drive,
    duration: float,
    axes: Mapping[str, Sequence[float] | Array],
    *,
    common: Mapping[str, float] | None = None,
    pluck_shape: str = "half-sine",
    scheme: FastScheme | None = None,
    rate: float = 100.0,
    threads: int | None = None,
) -> "xarray.Dataset":
    """Motion by the uniform-tension model for every combination of some parameters.

    Models are made once per drive, not once per member: vary torques and plucks at will.

    Parameters
    ----------
    drive : Drive
        As for `simulate_fast`.
    duration : float
        Length of the runs [s].
    axes : mapping of str to sequence of float
        Values of what is varied: pretension [N], transverse_damping [1/s], axial_damping [N s],
        load_inertia [kg m^2], load_friction [N m s/rad], torque_amplitude [N m], torque_frequency [Hz]
        (0: constant), pluck_upper, pluck_lower [m].
    common : mapping of str to float, optional
        The same parameters where they are not varied; by default the drive's own, no torque, no pluck.
    pluck_shape : str, default "half-sine"
        Shape of the plucks.
    scheme : FastScheme, optional
        One step serves all: the given one, or the finest that a member wants.
    rate : float, default 100.0
        Least number of records per second [Hz].
    threads : int, optional
        Drives at a time; by default one per processor.

    Returns
    -------
    xarray.Dataset
        Dimensions: those of `axes` in their order, then time. Angles and midpoint displacements; the least
        tension over all steps. `stopped` says for which members the model does not hold, and why; their
        motion is NaN.

    Raises
    ------
    InputRefused
        If an axis is unknown or empty, a member does not fit the model, or the result does not fit into
        memory.
    """
    scheme = scheme or FastScheme()
    values, members = _members(axes, common or {}, duration * rate)
    groups = _grouped(drive, members, pluck_shape, scheme.sines)
    steps, stride, step = max(grid_of(g.model, duration, scheme, Recording(rate=rate)) for g in groups)
    stride = max(1, int(1.0 / (rate * step)))
    waves = _waves(groups, members, steps, step)
    motion = np.full((4, len(members), steps // stride + 1), np.nan)
    least = np.empty((2, len(members)))
    stopped = np.full(len(members), "", dtype=object)

    def run(group: _Sharing) -> None:
        motion[:, group.numbers], least[:, group.numbers], stopped[group.numbers] = _run(
            group, waves, step, stride
        )

    with ThreadPoolExecutor(max_workers=threads or cpu_count() or 1) as pool:
        list(pool.map(run, groups))
    times = np.arange(motion.shape[2], dtype=np.float64) * (stride * step)
    return _labelled(values, times, motion, least, stopped)


def _members(
    axes: Mapping[str, Sequence[float] | Array], common: Mapping[str, float], records: float
) -> tuple[dict[str, Array], list[dict[str, float]]]:
    """Values as arrays, and every combination of them, the last axis quickest; ``records``: of each run."""
    values = {name: np.atleast_1d(np.asarray(given, dtype=np.float64)) for name, given in axes.items()}
    for name, given in (values | {name: np.array([value]) for name, value in common.items()}).items():
        if name not in UNITS:
            raise InputRefused(f'ensemble: "{name}" cannot be varied{nearest(name, UNITS)}')
        if given.ndim != 1 or given.size == 0 or not np.isfinite(given).all():
            raise InputRefused(f"ensemble: {name} needs a row of finite values in {UNITS[name]}")
    members = prod(given.size for given in values.values())
    if members * records * 4 > MOST_NUMBERS:
        raise InputRefused(
            f"ensemble: {members} runs of {records:.3g} records do not fit into memory: lower rate"
        )
    combinations = product(*(given.tolist() for given in values.values()))
    still = dict.fromkeys(list(UNITS)[5:], 0.0) | dict(common)
    return values, [still | dict(zip(values, one, strict=True)) for one in combinations]


def _varied(drive: Drive, member: Mapping[str, float]) -> Drive:
    """The drive of a member."""
    cable: dict[str, Any] = {name: member[name] for name in OF_THE_CABLE if name in member}
    load: dict[str, Any] = {own: member[name] for name, own in OF_THE_LOAD.items() if name in member}
    pulleys = (drive.drive_pulley, replace(drive.load_pulley, **load))
    return replace(drive, cable=replace(drive.cable, **cable), pulley=pulleys)


def _grouped(drive: Drive, members: list[dict[str, float]], shape: str, sines: int) -> list[_Sharing]:
    same = defaultdict(list)
    for number, member in enumerate(members):
        same[tuple(member.get(name) for name in list(UNITS)[:5])].append(number)
    groups = []
    for numbers in same.values():
        own = _varied(drive, members[numbers[0]])
        model = uniform_tension_model(own, sines)
        plucks = tuple(Pluck(height=_SMALL, span=span, shape=shape) for span in SPANS)
        plucked = start_amplitudes(own, model, Start(plucks=plucks))[2][0] / _SMALL
        offset = own.motor.offset_torque if own.motor else 0.0
        groups.append(_Sharing(model, plucked, offset, numbers, [members[n] for n in numbers]))
    return groups


def _waves(
    groups: list[_Sharing], members: list[dict[str, float]], steps: int, step: float
) -> dict[float, Array]:
    """Torque of amplitude 1 for each frequency, refused where a model has no modes."""
    times = np.arange(steps + 1, dtype=np.float64) * step
    waves = {
        f: np.sin(2 * pi * f * times) if f else np.ones_like(times)
        for f in {member["torque_frequency"] for member in members}
    }
    lowest = min((group.model for group in groups), key=lambda model: model.span_resonance)
    for wave in waves.values():
        check_band(lowest, wave, step)
    return waves


def _run(
    group: _Sharing, waves: dict[float, Array], step: float, stride: int
) -> tuple[Array, Array, NDArray[np.object_]]:
    """Motion, least tensions and reasons of the members of one drive."""
    model, numbers = group.model, coefficients(group.model, step)
    records = (next(iter(waves.values())).size - 1) // stride + 1
    along = np.empty((len(group.settings), records, model.natural.size))
    across = np.empty((len(group.settings), records, 2, model.transverse.size))
    peaks = np.empty((len(group.settings), 2, 2))
    rest = np.zeros(model.natural.size)
    for i, member in enumerate(group.settings):
        heights = np.array([[member["pluck_upper"]], [member["pluck_lower"]]])
        start = (heights * group.sines)[None]
        torque = member["torque_amplitude"] * waves[member["torque_frequency"]] + group.offset
        one = integrate(
            model, numbers, (rest.copy(), rest.copy(), start, np.zeros_like(start)), torque, stride
        )
        along[i], across[i], peaks[i] = one.along[:, 0], one.across[:, 0, 0], one.peaks
    reasons = np.full(len(peaks), "", dtype=object)
    held = peaks[:, :, 0] >= 0.0
    held &= model.wave_numbers[0] * peaks[:, :, 1] <= STEEPEST
    for i in np.flatnonzero(~held.all(axis=1)).tolist():
        reasons[i] = _reason(model, peaks[i])
    middle = np.sin(0.5 * pi * np.arange(1, model.transverse.size + 1))
    angles = np.moveaxis(along @ (model.rims / model.radii), -1, 0)
    motion = np.concatenate((angles, np.moveaxis(across @ middle, -1, 0)))
    motion[:, reasons != ""] = np.nan
    return motion, peaks[:, :, 0].T, reasons


def _reason(model: UniformTensionModel, peak: Array) -> str:
    """Why the model does not hold for a member."""
    if not np.all(np.isfinite(peak)):
        return "diverged: lower the torque or the plucks"
    for span, tension in zip(SPANS, peak[:, 0], strict=True):
        if tension < 0.0:
            return f"the {span} span goes slack"
    slope = float(model.wave_numbers[0] * peak[:, 1].max())
    return f"slope of {slope:.3g}, the fast model is valid below {STEEPEST}"


def _labelled(
    values: dict[str, Array], times: Array, motion: Array, least: Array, stopped: NDArray[np.object_]
) -> "xarray.Dataset":
    import xarray

    axes, shape = tuple(values), tuple(given.size for given in values.values())
    content: dict[str, Any] = {"stopped": (axes, stopped.reshape(shape))}
    series = (
        ("drive_angle", "rad", "angle of the drive pulley"),
        ("load_angle", "rad", "angle of the load pulley"),
        *((f"{span}_midpoint", "m", f"w of the {span} midpoint") for span in SPANS),
    )
    for (name, unit, meaning), table in zip(series, motion, strict=True):
        described = {"units": unit, "long_name": meaning}
        content[name] = (*axes, "time"), table.reshape(*shape, times.size), described
    for span, tensions in zip(SPANS, least, strict=True):
        described = {"units": "N", "long_name": f"least tension of the {span} span"}
        content[f"least_tension_{span}"] = axes, tensions.reshape(shape), described
    coordinates: dict[str, Any] = {name: (name, v, {"units": UNITS[name]}) for name, v in values.items()}
    coordinates["time"] = "time", times, {"units": "s"}
    return xarray.Dataset(content, coords=coordinates, attrs={"cabledrive": __version__})
