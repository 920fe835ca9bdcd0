"""Natural frequencies against any figure of the drive, and figures fitted to measured peaks."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from cabledrive.modal import modes
from cabledrive.modal import modes as certified_modes
from cabledrive.parameters import Drive, InputRefused, NotComputed
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.route import RoutedDrive
from cabledrive.parameters.route.drive import require_two_pulleys
from cabledrive.studies.following import Follower, Station, crossings
from cabledrive.studies.mode_map import coordinates_of, frequency_of_coordinate
from cabledrive.studies.varied_drive import quantity_of, stamped, varied, varied_together

if TYPE_CHECKING:
    import xarray as xr


MOST_MODES = 200


def frequency_against(
    drive: Drive, key: str, values: Sequence[float] | Array, *, modes: int = 4
) -> "xr.Dataset":
    """Longitudinal frequencies against one quantity, each curve followed through crossings and veerings.

    A curve is one mode followed by its shape. Where two curves cross, each keeps its shape and they change
    order; where they veer, they keep their order and exchange shapes. Steps between the values are halved
    until there is no doubt which mode is which, down to gaps of 1e-9 of the frequency.

    Parameters
    ----------
    drive : Drive
    key : str
        Any quantity of the drive file: "cable.pretension", "pulley.0.inertia", "carriage.0.position".
    values : array_like, shape (p,)
        Values in SI, in any order.
    modes : int, default 4
        Every curve is given that is among the lowest so many at one value or more.

    Returns
    -------
    xarray.Dataset
        Over ``mode`` (the curves, numbered by frequency at the smallest value) and ``value``: ``frequency``
        [Hz], ``family``; over ``value``: ``lowest_transverse`` [Hz]; over ``crossing``: ``crossing_kind``
        ("crossing" or "veering"), ``crossing_value``, ``crossing_frequency`` [Hz], ``crossing_gap`` [Hz],
        ``crossing_first`` and ``crossing_second`` (the two curves).

    Raises
    ------
    InputRefused
        If the key names no quantity of this drive, or a value is not allowed.
    NotComputed
        If the modes cannot be followed.
    """
    require_two_pulleys(drive, "`frequency_against`")
    unit, meaning = quantity_of(drive, key)
    ordered, place = np.unique(_checked(values, modes), return_inverse=True)
    drives = {float(value): varied(drive, key, value) for value in ordered}
    follower = Follower(lambda value: drives.get(value) or varied(drive, key, value), cells=256 + 16 * modes)
    path = _complete_path(follower, ordered, modes)
    stations = {station.value: station for station in path}
    shown = [stations[float(value)] for value in ordered]
    ranks = [np.sum(s.frequency < s.frequency[:, None] * (1 - 1e-9), axis=1) for s in shown]
    curves = np.flatnonzero(np.min(ranks, axis=0) < modes).tolist()
    transverse = [certified_modes(drives[float(value)], count=1).transverse[0].frequency for value in ordered]
    met = [m for m in crossings(follower, path) if set(m.curves) <= set(curves)]
    import xarray as xr

    number = {curve: i for i, curve in enumerate(curves)}
    frequency = np.array([station.frequency[curves] for station in shown]).T[:, place]
    family = np.array([[station.family[curve] for curve in curves] for station in shown], dtype=object).T
    data = {
        "frequency": (("mode", "value"), frequency, {"units": "Hz", "long_name": "natural frequency"}),
        "family": (("mode", "value"), family[:, place], {"long_name": "what mainly moves"}),
        "lowest_transverse": (
            "value",
            np.array(transverse)[place],
            {"units": "Hz", "long_name": "lowest transverse frequency"},
        ),
        "crossing_kind": ("crossing", np.array([m.kind for m in met], dtype=object)),
        "crossing_value": ("crossing", np.array([m.value for m in met]), {"units": unit}),
        "crossing_frequency": ("crossing", np.array([m.frequency for m in met]), {"units": "Hz"}),
        "crossing_gap": ("crossing", np.array([m.gap for m in met]), {"units": "Hz"}),
        "crossing_first": ("crossing", np.array([number[m.curves[0]] for m in met], dtype=int)),
        "crossing_second": ("crossing", np.array([number[m.curves[1]] for m in met], dtype=int)),
    }
    coordinates = {
        "mode": np.arange(len(curves)),
        "value": ("value", ordered[place], {"units": unit, "long_name": meaning, "key": key}),
    }
    return stamped(xr.Dataset(data, coordinates), drive, f"frequency against {key}")


def _checked(values: Sequence[float] | Array, modes: int) -> Array:
    array = np.asarray(values, dtype=float)
    if array.ndim != 1 or array.size == 0 or not np.isfinite(array).all():
        raise InputRefused("values: a list of finite numbers is needed: give one or more, in SI")
    if not 0 < modes <= MOST_MODES:
        raise InputRefused(f"modes = {modes} must lie between 1 and {MOST_MODES}: follow fewer at a time")
    return array


def _complete_path(follower: Follower, values: Array, modes: int) -> list[Station]:
    """Follow so many modes that every one among the lowest, at whatever value, is one of them."""
    curves = modes

    def holds_lowest(station: Station) -> bool:
        lowest = follower.modes_at(station.value, modes).frequency[:modes]
        return np.allclose(np.sort(station.frequency)[:modes], lowest, rtol=1e-9, atol=0.0)

    while curves <= 4 * modes + 16:
        path = follower.path(values, curves)
        if all(map(holds_lowest, path)):
            return path
        curves += 1 + modes // 4
    raise NotComputed(
        f"a mode among the lowest {modes} starts above the lowest {curves} at the smallest value: "
        "narrow the range"
    )


Keys = tuple[str, ...]

COUNT = 4
"""Modes of each kind among which that of a coordinate is looked for."""
WIDEST = 3.0
"""Largest factor by which a figure may leave that of the file."""
LEAST_SINGULAR = 1e-3
"""Of the sensitivity, relative to the largest, below which the peaks do not determine the figures."""
_STEPS, _SETTLED, _STEP = 30, 1e-9, 1e-4


@dataclass(frozen=True, slots=True, kw_only=True)
class FittedFigure:
    """A figure of the machine as the peaks have it, in SI, with its 95 % interval."""

    keys: Keys
    unit: str
    value: float
    low: float
    high: float
    before: float


@dataclass(frozen=True, slots=True, kw_only=True)
class PeakFit:
    """Figures that bring computed frequencies to measured peaks."""

    figures: tuple[FittedFigure, ...]
    # measured, before, after: frequencies by coordinate [Hz]: the peaks, those of the file and those of the
    # fit
    measured: dict[str, float]
    before: dict[str, float]
    after: dict[str, float]
    drive: RoutedDrive  # the machine with the fitted figures


def fit_to_peaks(
    drive: RoutedDrive,
    peaks: Mapping[str, tuple[float, float]],
    keys: Sequence[str | Keys],
    *,
    motor: str | None = None,
) -> PeakFit:
    """Fit figures of a machine to measured peaks, by Gauss-Newton on their logarithms.

    ``peaks``: frequency and its standard error [Hz] by the coordinate that moves in that mode, such as
    ``{"head.x": (86.2, 0.4)}``; ``keys``: figures that are fitted, of a tuple those that are alike. The
    interval holds the errors of the peaks alone, not those of the other figures of the file.
    """
    groups = [(one,) if isinstance(one, str) else tuple(one) for one in keys]
    names = tuple(peaks)
    _check(drive, names, groups)
    wanted = np.array([np.log(peaks[name][0]) for name in names])
    errors = np.array([peaks[name][1] / peaks[name][0] for name in names])
    start = np.array([_figure(drive, group[0]) for group in groups])

    def _at(factors: Array) -> RoutedDrive:
        values = zip(groups, start * np.exp(factors), strict=True)
        return varied_together(drive, {key: float(v) for group, v in values for key in group})

    def _logs(factors: Array) -> Array:
        return np.log(_frequencies(_at(factors), names, motor))

    factors = np.zeros(len(groups))
    for _ in range(_STEPS):
        own = _logs(factors)
        columns = [(_logs(factors + _STEP * unit) - own) / _STEP for unit in np.eye(factors.size)]
        slope = np.array(columns).T / errors[:, None]
        values = np.linalg.svd(slope, compute_uv=False)
        if values[-1] < LEAST_SINGULAR * values[0]:
            shown = " and ".join(group[0] for group in groups)
            raise NotComputed(f"the peaks do not determine {shown}: fit fewer figures, or give more peaks")
        step = np.linalg.lstsq(slope, (wanted - own) / errors, rcond=None)[0]
        factors = factors + np.clip(step, -0.3, 0.3)
        if np.abs(factors).max() > np.log(WIDEST):
            raise NotComputed(
                f"the peaks need a figure more than {WIDEST:g} times off that of the file: check which mode "
                "each peak is"
            )
        if np.abs(step).max() < _SETTLED:
            break
    else:
        raise NotComputed(f"the fit to the peaks has not settled in {_STEPS} steps")
    half = 1.959964 * np.sqrt(np.diag(np.linalg.inv(slope.T @ slope)))
    found = _at(factors)
    return PeakFit(
        figures=tuple(
            FittedFigure(
                keys=group,
                unit=quantity_of(drive, group[0])[0],
                value=float(first * np.exp(f)),
                low=float(first * np.exp(f - h)),
                high=float(first * np.exp(f + h)),
                before=float(first),
            )
            for group, first, f, h in zip(groups, start, factors, half, strict=True)
        ),
        measured={name: peaks[name][0] for name in names},
        before=dict(zip(names, _frequencies(drive, names, motor).tolist(), strict=True)),
        after=dict(zip(names, _frequencies(found, names, motor).tolist(), strict=True)),
        drive=found,
    )


def _check(drive: RoutedDrive | Drive, names: Keys, groups: Sequence[Keys]) -> None:
    if not isinstance(drive, RoutedDrive):
        raise InputRefused('peaks are fitted on machines of kind "route", whose coordinates have names')
    known = coordinates_of(drive)
    for name in names:
        if name not in known:
            raise InputRefused(f'peak "{name[:60]}" is no coordinate: take {", ".join(known)}')
    if not groups or len(groups) > len(names):
        raise InputRefused(f"{len(names)} peaks for {len(groups)} figures: give as many peaks at least")


def _figure(drive: RoutedDrive, key: str) -> float:
    """Value of a figure in the file, in SI."""
    table: object = drive
    for step in key.split("."):
        if isinstance(table, tuple):
            named = [getattr(part, "name", "") or getattr(part, "pulley", "") for part in table]
            table = table[int(step) if step.isdecimal() else named.index(step)]
        else:
            table = getattr(table, {"axial_rigidity": "given_rigidity"}.get(step, step))
    if not isinstance(table, int | float):
        raise InputRefused(f'"{key}" has no value in the file to begin with: state it')
    return float(table)


def _frequencies(drive: RoutedDrive, names: Keys, motor: str | None) -> Array:
    """Frequencies of the modes of some coordinates [Hz]."""
    found = modes(drive, count=COUNT, motor=motor)
    values = np.array([frequency_of_coordinate(found, name) for name in names])
    if np.isnan(values).any():
        missing = names[int(np.argmax(np.isnan(values)))]
        raise NotComputed(f"none of the first {COUNT} modes of each kind moves {missing}")
    return values
