"""Many runs of one drive at once, over threads: one result with labelled dimensions."""

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from itertools import product
from math import prod
from os import cpu_count
from typing import TYPE_CHECKING, Any

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.parameters.drive import Drive
from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.fields import nearest
from cabledrive.simulation.case import Recording
from cabledrive.simulation.one_run import simulate
from cabledrive.simulation.result import SimulationResult
from cabledrive.simulation.scheme import Scheme
from cabledrive.simulation.signals import Constant, Signal, Sine
from cabledrive.simulation.start import Pluck, Start

if TYPE_CHECKING:
    import xarray

MOST_NUMBERS = 500_000_000


@dataclass(frozen=True, slots=True, kw_only=True)
class Setting:
    """What one member of an ensemble is; each field may be an axis of the ensemble.

    Attributes
    ----------
    pretension : float or None
        Pretension [N]; None: the drive's.
    transverse_damping : float or None
        Gamma [1/s]; None: the drive's.
    axial_damping : float or None
        Kelvin-Voigt damping [N s]; None: the drive's.
    load_inertia : float or None
        Inertia of the load pulley [kg m^2]; None: the drive's.
    load_friction : float or None
        Viscous friction of the load pulley [N m s/rad]; None: the drive's.
    torque_amplitude : float, default 0.0
        Amplitude of the torque [N m].
    torque_frequency : float, default 0.0
        Its frequency [Hz]; 0: constant.
    pluck_upper, pluck_lower : float, default 0.0
        Heights of plucks in w at midspan [m].
    """

    pretension: float | None = None
    transverse_damping: float | None = None
    axial_damping: float | None = None
    load_inertia: float | None = None
    load_friction: float | None = None
    torque_amplitude: float = 0.0
    torque_frequency: float = 0.0
    pluck_upper: float = 0.0
    pluck_lower: float = 0.0

    def drive(self, base: Drive) -> Drive:
        """The drive of this member.

        Parameters
        ----------
        base : Drive

        Returns
        -------
        Drive
        """
        names = ("pretension", "transverse_damping", "axial_damping")
        cable = {name: getattr(self, name) for name in names if getattr(self, name) is not None}
        load = base.load_pulley
        if self.load_inertia is not None:
            load = replace(load, inertia=self.load_inertia)
        if self.load_friction is not None:
            load = replace(load, viscous_friction=self.load_friction)
        return replace(base, cable=replace(base.cable, **cable), pulley=(base.drive_pulley, load))

    def torque(self) -> Signal:
        """The torque of this member.

        Returns
        -------
        Signal
        """
        if self.torque_frequency == 0.0:
            return Constant(self.torque_amplitude)
        return Sine(amplitude=self.torque_amplitude, frequency=self.torque_frequency)

    def start(self, shape: str) -> Start:
        """The start of this member.

        Parameters
        ----------
        shape : str
            Shape of the plucks.

        Returns
        -------
        Start
        """
        heights = {"upper": self.pluck_upper, "lower": self.pluck_lower}
        return Start(
            plucks=tuple(Pluck(height=h, span=s, shape=shape) for s, h in heights.items() if h != 0.0)
        )


UNITS = {
    "pretension": "N",
    "transverse_damping": "1/s",
    "axial_damping": "N s",
    "load_inertia": "kg m^2",
    "load_friction": "N m s/rad",
    "torque_amplitude": "N m",
    "torque_frequency": "Hz",
    "pluck_upper": "m",
    "pluck_lower": "m",
}


def simulate_ensemble(
    drive: Drive,
    duration: float,
    axes: Mapping[str, Sequence[float] | Array],
    *,
    common: Setting | None = None,
    pluck_shape: str = "half-sine",
    scheme: Scheme | None = None,
    rate: float = 1000.0,
    threads: int | None = None,
) -> "xarray.Dataset":
    """Nonlinear motion for every combination of some parameters.

    Parameters
    ----------
    drive : Drive
    duration : float
        Length of the runs [s].
    axes : mapping of str to sequence of float
        Values of each parameter that is varied, by its name in `Setting`.
    common : Setting, optional
        Parameters that are not varied.
    pluck_shape : str, default "half-sine"
        Shape of the plucks.
    scheme : Scheme, optional
        The same for all.
    rate : float, default 1000.0
        Least number of records per second [Hz].
    threads : int, optional
        Runs at a time; by default one per processor.

    Returns
    -------
    xarray.Dataset
        Dimensions: those of `axes` in their order, then time. Angles, midpoint displacements, energy budget
        errors; `stopped` says why a run ended early, and is empty where it did not. What a run did not reach
        is NaN.

    Raises
    ------
    InputRefused
        If an axis is unknown or empty, a member cannot be run, or the result would not fit into memory.
    """
    values, members = members_of(axes, common or Setting(), duration * rate)
    run = _runner(drive, duration, pluck_shape, scheme or Scheme(), rate)
    with ThreadPoolExecutor(max_workers=threads or cpu_count() or 1) as pool:
        results = list(pool.map(run, members))
    return _labelled(results, values)


def members_of(
    axes: Mapping[str, Sequence[float] | Array], common: Setting, records: float
) -> tuple[dict[str, Array], list[Setting]]:
    """Every combination of the values of some parameters, the last axis quickest.

    ``axes``: values of each parameter that is varied, by its name in `Setting`; ``common``: parameters that
    are not varied; ``records``: records of each run.
    Returns ``values``: the axes as arrays.
    Raises `InputRefused` if an axis is unknown or empty, or the result would not fit into memory.
    """
    values = {name: np.atleast_1d(np.asarray(given, dtype=np.float64)) for name, given in axes.items()}
    _check_axes(values, records)
    combinations = product(*(given.tolist() for given in values.values()))
    return values, [replace(common, **dict(zip(values, one, strict=True))) for one in combinations]


def _check_axes(values: dict[str, Array], records: float) -> None:
    for name, given in values.items():
        if name not in UNITS:
            raise InputRefused(f'ensemble: "{name}" cannot be varied{nearest(name, UNITS)}')
        if given.ndim != 1 or given.size == 0 or not np.isfinite(given).all():
            raise InputRefused(f"ensemble: {name} needs a row of finite values in {UNITS[name]}")
    members = prod(given.size for given in values.values())
    if members * records * 4 > MOST_NUMBERS:
        raise InputRefused(
            f"ensemble: {members} runs of {records:.3g} records do not fit into memory: lower rate"
        )


def _runner(
    drive: Drive, duration: float, shape: str, scheme: Scheme, rate: float
) -> Callable[[Setting], SimulationResult]:
    def run(member: Setting) -> SimulationResult:
        return simulate(
            member.drive(drive),
            duration,
            torque=member.torque(),
            start=member.start(shape),
            scheme=scheme,
            recording=Recording(rate=rate),
        )

    return run


def _labelled(results: list[SimulationResult], values: dict[str, Array]) -> "xarray.Dataset":
    import xarray

    shape, axes = tuple(given.size for given in values.values()), tuple(values)
    time = max((result.time for result in results), key=len)

    def filled(pick: Callable[[SimulationResult], Array]) -> Array:
        table = np.full((len(results), time.size), np.nan)
        for row, result in zip(table, results, strict=True):
            row[: result.time.size] = pick(result)
        return table.reshape(*shape, time.size)

    series: dict[str, tuple[str, str, Callable[[SimulationResult], Array]]] = {
        "drive_angle": ("rad", "angle of the drive pulley", lambda r: r.drive_angle),
        "load_angle": ("rad", "angle of the load pulley", lambda r: r.load_angle),
    }
    for span in results[0].spans:
        series[f"{span}_midpoint"] = "m", f"w of the {span} midpoint", _midpoint_of(span)
    content: dict[str, Any] = {
        name: ((*axes, "time"), filled(pick), {"units": unit, "long_name": meaning})
        for name, (unit, meaning, pick) in series.items()
    }
    errors = np.array([result.energy_budget_error for result in results]).reshape(shape)
    content["energy_budget_error"] = axes, errors, {"units": "1", "long_name": "over the energy handled"}
    content["stopped"] = axes, np.array([r.stopped or "" for r in results], dtype=object).reshape(shape)
    coordinates: dict[str, Any] = {
        name: (name, given, {"units": UNITS[name]}) for name, given in values.items()
    }
    coordinates["time"] = "time", time, {"units": "s"}
    return xarray.Dataset(
        content,
        coords=coordinates,
        attrs={
            "cabledrive": results[0].provenance["cabledrive"],
            "model": results[0].provenance["method"]["model"],
            "interpreted": results[0].interpreted or "",
        },
    )


def _midpoint_of(span: str) -> Callable[[SimulationResult], Array]:
    return lambda result: result.midpoint(span)[:, 2]
