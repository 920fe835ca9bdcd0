"""Natural frequencies over a grid of figures of a machine: a head over its bed, a car over its travel."""

import gc
import itertools
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from cabledrive.mechanics.holding import motor_condition
from cabledrive.modal import Modes
from cabledrive.modal import modes as certified_modes
from cabledrive.parameters import Drive, InputRefused, Machine, NotComputed
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.keys import quantity_of, varied_together
from cabledrive.studies.following import stamped

if TYPE_CHECKING:
    import xarray as xr

Vary = Mapping[str, Any] | Mapping[tuple[str, ...], Any]
"""Values in SI by a key, or rows of values by keys that move together."""

MOST_POINTS = 20_000
MOST_MODES = 200
SAME = 1e-4
"""Share of a frequency below which two modes of one span or kind are one to an excitation."""
STILL = 1e-3
"""Share of the searched range below which a mode is the travel itself, held by the weight of its ropes."""
FEW = 64
"""Points below which a second process would cost more than it saves."""


class Grid(NamedTuple):
    """A machine at every point of a grid, how its motor and bodies are held, and processes that share it."""

    drive: Machine
    vary: Vary
    motor: str | None = None
    hold: Sequence[str] = ()
    workers: int = 1


class Axis(NamedTuple):
    """Keys that move together along one dimension of a map."""

    keys: tuple[str, ...]  # the first names the dimension
    values: Array  # (keys, p): in SI


def map_modes(
    drive: Machine | Drive,
    vary: Vary,
    *,
    count: int = 6,
    motor: str | None = None,
    hold: Sequence[str] = (),
    workers: int = 1,
) -> "xr.Dataset":
    """Natural frequencies over a grid of any figures of a machine.

    Parameters
    ----------
    drive : Machine or Drive
    vary : mapping
        Values by key, in SI: ``{"head.x": [...], "beam.y": [...]}`` spans a grid. A tuple of keys with a row
        of values each moves them together: ``{("car.y", "counterweight.y"): [[5, 20, 35], [35, 20, 5]]}``.
    count : int, default 6
        Modes of each kind.
    motor : {"free", "held", "holding"}, optional
        As of `cabledrive.modes`.
    hold : sequence of str, optional
        As of `cabledrive.modes`.
    workers : int, default 1
        Processes that share the points.

    Returns
    -------
    xarray.Dataset
        Over the keys: ``longitudinal_hz`` and ``transverse_hz`` (..., mode), each frequency by its
        multiplicity; ``family`` and ``span`` (..., mode), what moves in a longitudinal mode and which span in
        a transverse one; ``coordinate_hz`` (..., coordinate), on machines with routes, the frequency of the
        mode in which a body's move has its largest share; ``certified``; ``reason``, why a point has no
        modes.

    Raises
    ------
    InputRefused
        If a key names no quantity of this drive, or no point of the map is a machine.
    """
    drive = drive.machine
    if not 0 < count <= MOST_MODES:
        raise InputRefused(f"count = {count} must lie between 1 and {MOST_MODES}: list fewer at a time")
    axes, held, points = over(Grid(drive, vary, motor, hold, workers), {"count": count}, _variables)
    return _dataset(drive, axes, points, count, held)


class Mode(NamedTuple):
    """A distinct frequency of one point."""

    kind: str
    group: str
    name: str
    share: float
    hertz: float


def distinct(_: Machine, found: Modes | None, below: float) -> dict[str, Any]:
    """Every distinct mode of a point below a frequency [Hz], ascending."""
    listed: list[Mode] = []
    for mode in () if found is None else found.modes:
        if mode.frequency < STILL * below:
            continue
        shares = {key: own for key, own in mode.kinetic_shares.items() if key != "cable"}
        name, share = max(shares.items(), key=lambda own: round(own[1], 9), default=(mode.family, 0.0))
        group = (mode.span or "") if mode.kind == "transverse" else ""
        before = next((own for own in reversed(listed) if (own.kind, own.group) == (mode.kind, group)), None)
        if before is None or abs(mode.frequency - before.hertz) > SAME * mode.frequency:
            listed.append(Mode(mode.kind, group, name if share > 0.0 else mode.family, share, mode.frequency))
    return {"modes": listed}


def _checked(drive: Machine, vary: Vary) -> list[Axis]:
    if not vary:
        raise InputRefused("vary: no key is given: name at least one, with its values")
    axes = []
    for keys, values in vary.items():
        names = (keys,) if isinstance(keys, str) else tuple(keys)
        array = np.atleast_2d(np.asarray(values, dtype=float))
        if array.shape[0] != len(names) or array.ndim != 2 or not array.size or not np.isfinite(array).all():
            raise InputRefused(f"{', '.join(names)}: a row of finite numbers is needed for each key")
        axes.append(Axis(names, array))
    every = [key for axis in axes for key in axis.keys]
    for key in every:
        quantity_of(drive, key)
        if every.count(key) > 1:
            raise InputRefused(f'"{key}" is varied twice: name it once')
    points = int(np.prod([axis.values.shape[1] for axis in axes]))
    if points > MOST_POINTS:
        raise InputRefused(f"the map has {points} points, at most {MOST_POINTS} are computed: take fewer")
    return axes


Read = Callable[[Machine, Modes | None, Any], dict[str, Any]]
"""What a point of a map holds of its modes, up to a number or a frequency; None: it has none."""


def over(grid: Grid, most: dict[str, Any], read: Read) -> tuple[list[Axis], str, list[dict[str, Any]]]:
    """Axes of a grid, how the motor is held, and what each point holds, the last axis fastest.

    ``most``: count of modes, or below which frequency [Hz], as of `cabledrive.modes`. Beside what is read a
    point holds whether its list is certified, and why it has none.
    """
    drive, axes = grid.drive, _checked(grid.drive, grid.vary)
    held = motor_condition(drive, grid.motor)
    keys = [key for axis in axes for key in axis.keys]
    rows = (np.concatenate(place).tolist() for place in itertools.product(*(axis.values.T for axis in axes)))
    settings = (dict(zip(keys, row, strict=True)) for row in rows)
    jobs = [(drive, setting, most, held, tuple(grid.hold), read) for setting in settings]
    points = list(_solved(jobs, grid.workers))
    if all(point["reason"] for point in points):
        raise InputRefused(f"no point of the map is a machine: {points[0]['reason']}")
    return axes, held, points


def _solved(jobs: list[tuple[Any, ...]], workers: int) -> Iterable[dict[str, Any]]:
    """The points in order, by several processes where that pays."""
    if workers <= 1 or len(jobs) < FEW:
        yield from map(_point, jobs)
        return
    import multiprocessing

    # Children start from this process, its libraries loaded, where the system can do so.
    method = "fork" if "fork" in multiprocessing.get_all_start_methods() else "spawn"
    # What the children have from this process they need not search for garbage.
    with multiprocessing.get_context(method).Pool(workers, initializer=gc.freeze) as pool:
        yield from pool.imap(_point, jobs, chunksize=max(1, len(jobs) // (8 * workers)))


def _point(job: tuple[Any, ...]) -> dict[str, Any]:
    drive, setting, most, motor, hold, read = job
    found, reason = None, ""
    try:
        drive = varied_together(drive, setting)
        found = certified_modes(drive, **most, motor=motor, hold=hold)
    except (InputRefused, NotComputed) as failure:
        reason = str(failure)
    (limit,) = most.values()
    return read(drive, found, limit) | {"certified": bool(found and found.certified), "reason": reason}


def _variables(drive: Machine, found: Modes | None, count: int) -> dict[str, Any]:
    """Variables of a map at one point: frequencies [Hz], padded by NaN."""
    coordinates = coordinates_of(drive)

    def spread(kind: str, value: Callable[[Any], Any], empty: Any) -> list[Any]:
        own = [] if found is None else [m for m in found.modes if m.kind == kind]
        listed = [value(m) for m in own for _ in range(m.multiplicity)][:count]
        return listed + [empty] * (count - len(listed))

    hertz = [np.nan if found is None else frequency_of_coordinate(found, name) for name in coordinates]
    return {
        "longitudinal_hz": spread("longitudinal", lambda m: m.frequency, np.nan),
        "transverse_hz": spread("transverse", lambda m: m.frequency, np.nan),
        "family": spread("longitudinal", lambda m: m.family, ""),
        "span": spread("transverse", lambda m: m.span or "", ""),
        "coordinate_hz": hertz,
    }


def coordinates_of(drive: Machine) -> tuple[str, ...]:
    """Moves of the bodies of a machine, such as "head.x"."""
    return tuple(f"{body.name}.{move}" for body in drive.body for move in body.moves)


def frequency_of_coordinate(found: Modes, name: str) -> float:
    """Frequency of the listed mode in which a coordinate has the largest share of the energy; else NaN."""
    shares = [(round(m.kinetic_shares.get(name, 0.0), 9), -m.frequency) for m in found.modes if not m.clamped]
    share, frequency = max(shares, default=(0.0, np.nan))
    return -frequency if share > 0.0 else float("nan")


def _dataset(
    drive: Machine, axes: list[Axis], points: list[dict[str, Any]], count: int, motor: str
) -> "xr.Dataset":
    import xarray as xr

    dims = tuple(axis.keys[0] for axis in axes)
    shape = tuple(axis.values.shape[1] for axis in axes)
    coords: dict[str, Any] = {"mode": np.arange(1, count + 1)}
    for axis in axes:
        for key, values in zip(axis.keys, axis.values, strict=True):
            unit, meaning = quantity_of(drive, key)
            coords[key] = (axis.keys[0], values, {"units": unit, "long_name": meaning})
    more: dict[str, tuple[str, ...]] = dict.fromkeys(
        ("longitudinal_hz", "transverse_hz", "family", "span"), ("mode",)
    )
    more |= {"certified": (), "reason": ()}
    names = coordinates_of(drive)
    if names:
        coords["coordinate"] = list(names)
        more["coordinate_hz"] = ("coordinate",)
    data = {}
    for name, last in more.items():
        array = np.array([p[name] for p in points], object if name in ("family", "span", "reason") else None)
        attributes = {"units": "Hz"} if name.endswith("_hz") else {}
        data[name] = (*dims, *last), array.reshape(*shape, *array.shape[1:]), attributes
    found = xr.Dataset(data, coords).assign_attrs(motor=motor)
    return stamped(found, drive, "natural frequencies over figures of the machine")
