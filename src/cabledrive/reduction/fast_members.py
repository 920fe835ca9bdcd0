"""Thousands of runs of the fast model at once, over threads: one result with labelled dimensions."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import product
from math import pi, prod
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from cabledrive.parameters import Drive, InputRefused, Machine
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.fields import nearest
from cabledrive.parameters.route.two_pulleys import two_pulleys_of
from cabledrive.parameters.version import __version__
from cabledrive.reduction import fast_simulation as fast
from cabledrive.reduction.stretch_runs import ensemble_run
from cabledrive.reduction.stretches import StretchModel, in_lanes, numbers_of
from cabledrive.reduction.uniform_tension import uniform_tension_model
from cabledrive.simulation import Pluck, Recording, Start

if TYPE_CHECKING:
    import xarray


OF_THE_CABLE = ("pretension", "transverse_damping", "axial_damping")
OF_THE_LOAD = {"load_inertia": "inertia", "load_friction": "viscous_friction"}
UNITS = {
    **dict(zip(OF_THE_CABLE, ("N", "1/s", "N s"), strict=True)),
    **{"load_inertia": "kg m^2", "load_friction": "N m s/rad"},
    **{"torque_amplitude": "N m", "torque_frequency": "Hz", "pluck_upper": "m", "pluck_lower": "m"},
}
"""What may be varied; where it is not given, the drive's own value, and no torque and no pluck."""
OF_THE_DRIVE = (*OF_THE_CABLE, *OF_THE_LOAD)
OF_THE_RUN = ("torque_amplitude", "pluck_upper", "pluck_lower")
MOST_NUMBERS = 500_000_000
_SMALL = 1e-6  # m, height of the pluck from which all are scaled


def fast_ensemble(
    drive: Machine | Drive,
    duration: float,
    axes: Mapping[str, Sequence[float] | Array],
    *,
    common: Mapping[str, float] | None = None,
    pluck_shape: str = "half-sine",
    scheme: fast.FastScheme | None = None,
    rate: float = 100.0,
    threads: int | None = None,
) -> "xarray.Dataset":
    """Motion by the uniform-tension model for every combination of some parameters.

    Models are made once per drive, not once per member: vary torques and plucks at will.

    Parameters
    ----------
    drive : Machine or Drive
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
    drive = two_pulleys_of(drive, "the fast model, unlike --model exact,")
    scheme = scheme or fast.FastScheme()
    values, members = _members(axes, common or {}, duration * rate)
    keys = [tuple(member.get(name) for name in OF_THE_DRIVE) for member in members]
    drives = {key: _varied(drive, member) for key, member in zip(keys, members, strict=True)}
    models = {key: uniform_tension_model(own, scheme.sines) for key, own in drives.items()}
    grids = (fast.grid_of(model, duration, scheme, Recording(rate=rate)) for model in models.values())
    steps, _, step = max(grids)
    stride = max(1, int(1.0 / (rate * step)))
    waves = _waves(list(models.values()), members, steps, step)
    plucks = tuple(Pluck(height=_SMALL, span=span, shape=pluck_shape) for span in fast.SPANS)
    plucked = {
        key: fast.start_amplitudes(drives[key], model, Start(plucks=plucks))[2] / _SMALL
        for key, model in models.items()
    }
    numbers = {key: numbers_of(model, step) for key, model in models.items()}
    motion = np.full((4, len(members), steps // stride + 1), np.nan)
    least, stopped = np.empty((2, len(members))), np.full(len(members), "", dtype=object)
    amplitude, *heights = np.array([[member[name] for member in members] for name in OF_THE_RUN])
    together: dict[tuple[tuple[float | None, ...], float], list[int]] = {}
    for i, (key, member) in enumerate(zip(keys, members, strict=True)):
        together.setdefault((key, member["torque_frequency"]), []).append(i)

    def run(which: tuple[tuple[float | None, ...], float], own: list[int]) -> None:
        """Members of one drive and frequency: angles and midpoints, least tensions, why it does not hold."""
        key, frequency = which
        motor = drives[key].motor
        offset = motor.offset_torque if motor else 0.0
        start = plucked[key][:, :, None] * np.array(heights)[:, None, own]
        given = waves[frequency], amplitude[own], offset
        angles, middles, _, reach, least[:, own] = ensemble_run(numbers[key], start, given, stride)
        motion[:2, own], motion[2:, own] = angles[:, :2].transpose(1, 2, 0), middles.transpose(1, 2, 0)
        for lane, i in enumerate(own):
            stopped[i] = fast.why_not(models[key], np.column_stack((least[:, i], reach[:, lane]))) or ""

    in_lanes(run, together.items(), threads)
    motion[:, stopped != ""] = np.nan
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


def _waves(
    models: list[StretchModel], members: list[dict[str, float]], steps: int, step: float
) -> dict[float, Array]:
    """Torque of amplitude 1 for each frequency, refused where a model has no modes."""
    times = np.arange(steps + 1, dtype=np.float64) * step
    waves = {
        f: np.sin(2 * pi * f * times) if f else np.ones_like(times)
        for f in {member["torque_frequency"] for member in members}
    }
    lowest = min(models, key=lambda model: model.highest)
    for wave in waves.values():
        fast.check_band(lowest, wave, step)
    return waves


def _labelled(
    values: dict[str, Array], times: Array, motion: Array, least: Array, stopped: NDArray[np.object_]
) -> "xarray.Dataset":
    import xarray

    axes, shape = tuple(values), tuple(given.size for given in values.values())
    content: dict[str, Any] = {"stopped": (axes, stopped.reshape(shape))}
    series = (
        ("drive_angle", "rad", "angle of the drive pulley"),
        ("load_angle", "rad", "angle of the load pulley"),
        *((f"{span}_midpoint", "m", f"w of the {span} midpoint") for span in fast.SPANS),
    )
    for (name, unit, meaning), table in zip(series, motion, strict=True):
        described = {"units": unit, "long_name": meaning}
        content[name] = (*axes, "time"), table.reshape(*shape, times.size), described
    for span, tensions in zip(fast.SPANS, least, strict=True):
        described = {"units": "N", "long_name": f"least tension of the {span} span"}
        content[f"least_tension_{span}"] = axes, tensions.reshape(shape), described
    coordinates: dict[str, Any] = {name: (name, v, {"units": UNITS[name]}) for name, v in values.items()}
    coordinates["time"] = "time", times, {"units": "s"}
    return xarray.Dataset(content, coords=coordinates, attrs={"cabledrive": __version__})
