"""A controller in a file: law and filter in numbers, with names, units and hashes, and what they mean."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from cabledrive.control.numbers import (
    BACKSTEPPING,
    BY_LOAD,
    DARC,
    KALMAN,
    LEARNING,
    LINEAR,
    OWN,
    REFERENCE_MODEL,
    SCHEDULED,
    LawNumbers,
    ObserverNumbers,
)
from cabledrive.control.own_controller import OwnController
from cabledrive.control.reference import NO_LOAD, LoadRowNumbers, ReferenceNumbers
from cabledrive.parameters import Drive, InputRefused, content_hash
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.files import require_regular
from cabledrive.reduction.network_axis import as_axis
from cabledrive.rig.closed_loop.loop import Loop
from cabledrive.rig.laws.registry import CONTROLLERS

ARRAYS = {
    "law.matrix": (
        "darc: angles and speeds to z and its derivatives; linear: next memory from memory, errors, "
        "last command; backstepping: feedback by step and error"
    ),
    "law.rows": (
        "darc: sliding surface, elastic torque, inertial acceleration in powers of s; linear: command "
        "from memory and errors; learning: the same, then what whitens the innovations; scheduled: one for "
        "each load, heaviest first; backstepping: scales of the states"
    ),
    "law.learning": (
        "rows: nominal value, lower bound, upper bound, adaptation gain, rate limit of each estimate"
    ),
    "law.scalars": (
        "sample time s; K_sigma; K of tanh(K w) s/rad; friction by reference; regressor by reference; "
        "mu; beta_n; learning: sample time s; kept share of an excited direction, gate in deviations, "
        "renewal; scheduled: sample time s, one over the heaviest load, step of it between points, Coulomb "
        "friction N m, K of tanh(K w) s/rad"
    ),
    "filter.chosen": "which filter states are the angles, then the speeds of the law's shafts",
    "filter.places": "filter states that are the motor's speed and the disturbance torque",
    "filter.model": (
        "transition; then inputs: shaft torque, command before and after the delay, friction and offset"
    ),
    "filter.output": "readings from filter states",
    "filter.gains": "correction per reading, on which the filter settles; by load: of each point",
    "filter.scalars": (
        "sample time s; unused; shaft torque from itself, older and newer command; Coulomb friction N "
        "m; K of tanh(K w) s/rad; offset torque N m; whether the disturbance is cancelled; by load: one over "
        "the heaviest load, step in one over the load between points"
    ),
    "reference.taps": "delay s and weight of each copy of the motion",
    "reference.lags": "first-order filters: share of the newest value, of the last value, fading",
    "reference.sources": "stage that each filter takes; 0: the motion",
    "reference.output": (
        "row from all stages, each the load angle and its derivatives rad/s^k at the first shaft"
    ),
    "reference.constant": "added to the row",
    "reference.friction": "Coulomb friction N m and slope s/rad of each c tanh(K w) added to a column",
    "reference.places": "that column, and the column of the speed w",
    "reference.load.sign": "weights of the sign of the speed over the samples around, for it and derivatives",
    "reference.load.lags": "filters of the chain's dampers, as reference.lags",
    "reference.load.sources": "stage that each takes; 0: the torque at the load",
    "reference.load.output": "angles, speeds, motor torque from all stages, each the torque and derivatives",
    "reference.load.transition": "of the filter's error; last column: from a torque at the load",
    "reference.load.seen": "readings from the filter's error",
    "reference.load.gains": "correction per reading",
    "reference.load.chosen": "states of the filter that the law takes",
    "reference.load.white": "what makes innovations white and of variance 1",
    "reference.load.scalars": "sample time s; K of tanh(K w / largest w)",
}

REGRESSOR = (
    "adapted_inertia [rad/s^2]",
    "adapted_viscous [rad/s]",
    "adapted_coulomb [1]",
    "adapted_offset [1]",
)
"""Functions of the reference that carry the adapted factors of a reference-model law."""

ANNOUNCED = "announced_load [1]"
"""Inertia of the load over that of the drive: what firmware writes, and the generator leaves at 1."""

LEARNT = (("friction", "/(N m)"), ("viscous", "/(N m s/rad)"), ("inertia", "/(kg m^2)"))
"""What a law learns of the load, and the unit of what goes with a unit of it."""


def reference_columns(
    law: LawNumbers, shafts: tuple[str, ...], width: int, *, motion: bool = False
) -> list[str]:
    """Names with units of the columns of a law's reference; ``motion``: load angle and derivatives alone."""
    if motion:
        return [f"load_angle_{k} [rad/s^{k}]" for k in range(width)]
    if law.kind in (LINEAR, REFERENCE_MODEL, OWN):
        angles = [f"{shaft}_angle [rad]" for shaft in shafts]
        names = [*angles, *(f"{shaft}_speed [rad/s]" for shaft in shafts), "torque [N m]"]
        return [*names, *REGRESSOR][:width]
    if law.kind == LEARNING:
        followed = 2 * len(shafts) + 1
        names, readings = reference_columns(law._replace(kind=LINEAR), shafts, followed), len(law.rows) - 1
        for learnt, unit in LEARNT:
            names += [f"{learnt}_{shaft}_angle [rad{unit}]" for shaft in shafts]
            names += [f"{learnt}_{shaft}_speed [rad/s{unit}]" for shaft in shafts]
            names.append(f"{learnt}_torque [N m{unit}]")
            names += [f"{learnt}_innovation_{i + 1} [1{unit}]" for i in range(readings)]
        return names[:width]
    if law.kind == SCHEDULED:
        own = reference_columns(law._replace(kind=LINEAR), shafts, 2 * len(shafts) + 1)
        return [*own, *(f"{name} for each further load" for name in own), ANNOUNCED]
    if law.kind == DARC:
        flat = [f"flat_output_{k} [rad/s^{k}]" for k in range(width - 2)]
        return [*flat, "motor_speed [rad/s]", "motor_acceleration [rad/s^2]"]
    n = len(shafts)
    names = [f"load_angle_{k} [rad/s^{k}]" for k in range(min(width, 2 * n + 1))]
    for j in range(1, n + 1):
        names += [f"known_acceleration_{j}_{k} [scaled]" for k in range(2 * (n - j) + 1)]
    return [*names, "motor_speed [rad/s]"][:width]


ABOUT = "See cabledrive.control.numbers.LawNumbers and cabledrive.control.numbers"
FILE = "controller.json"
UNITS = {
    "sample_time": "s",
    "torque_limit": "N m",
    "angles": "rad at the first shaft",
    "speeds": "rad/s",
    "counts": "rad at the first shaft",
    "torque_per_volt": "N m/V",
    "late_samples": "samples",
}
REMEDY = "give the controller.json of a study"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ControllerFile:
    """What a controller.json holds."""

    path: str
    name: str  # of the packaged law
    bandwidth: float | None  # [Hz]
    # shafts, encoders: whose motion the law takes; which encoders the filter reads
    shafts: tuple[str, ...]
    encoders: tuple[str, ...]
    feedback: str  # {"motor", "drive"}
    sample_time: float  # [s]
    torque_limit: float  # [N m]
    drive_hash: str  # content hash of the drive that it was made for
    law: LawNumbers
    observer: ObserverNumbers  # with the gain on which the filter settles
    late_samples: int  # whole samples of the delay from reading to torque
    counts: tuple[float, ...]  # one count of each encoder at the first shaft [rad]
    load_gear: float  # angle of the first shaft per angle of the load
    torque_per_volt: float | None  # [N m/V]
    # what makes the rows of the reference; None where friction needs a shaft that an own law leaves out
    reference: ReferenceNumbers | None
    columns: tuple[str, ...]  # names of the reference's columns
    own: OwnController | None = None  # A controller of the user's own, whose step no file holds
    order: int | None = None  # of the rises with which its study tested it


def controller_numbers(loop: Loop, drive: Drive, feedback: str) -> dict[str, Any]:
    """The law and filter of a loop as plain data, which `read_controller` takes back."""
    made, rig, generator = loop.controller, loop.rig, loop.controller.generator
    along = made.own is not None and made.own.follows == "motion"
    columns = reference_columns(made.law, made.shafts, made.reference.shape[1], motion=along)
    # On which the filter settles; of one scheduled by the load those of all points.
    gains = loop.observer.gains if loop.observer.kind == BY_LOAD else loop.observer.gains[-1]
    if generator is not None and generator.load.columns:
        generator = generator._replace(load=generator.load._replace(gains=generator.load.gains[-1]))
    return {
        "about": ABOUT,
        "name": made.name,
        "bandwidth_hz": made.gains.get("bandwidth_hz"),
        "shafts": list(made.shafts),
        "encoders": list(loop.encoder_shafts),
        "feedback": feedback,
        "sample_time": rig.interval,
        "torque_limit": rig.torque_limit if np.isfinite(rig.torque_limit) else None,
        "units": UNITS,
        # of an axis of routes as its machine's file gives it, which is what can be read again
        "drive_hash": content_hash(as_axis(drive.axis.machine, drive.axis.load) if drive.chain_of else drive),
        "late_samples": rig.late_samples,
        "counts": rig.counts.tolist(),
        "load_gear": loop.gear,
        "torque_per_volt": drive.motor.torque_per_volt if drive.motor else None,
        "columns": columns,
        "reference": None if generator is None else plain_numbers(generator._asdict()),
        "arrays": ARRAYS,
        "law": plain_numbers(made.law._asdict()),
        "filter": plain_numbers(loop.observer._asdict() | {"gains": gains}),
    }


def plain_numbers(fields: Mapping[str, Any]) -> dict[str, Any]:
    """Arrays as lists; infinity as null; numbers inside numbers likewise, null where they hold none."""

    def plain(value: Any) -> Any:
        if hasattr(value, "_asdict"):
            return plain_numbers(value._asdict()) if any(np.size(part) for part in value) else None
        listed = value.tolist() if hasattr(value, "tolist") else value
        return json.loads(json.dumps(listed).replace("-Infinity", "null").replace("Infinity", "null"))

    return {name: plain(value) for name, value in fields.items()}


def is_controller_path(given: Any) -> bool:
    """Whether a controller is given by a path: of a JSON file, or of a folder with one."""
    if isinstance(given, PathLike):
        return True
    return (
        isinstance(given, str)
        and given not in CONTROLLERS
        and (given.endswith(".json") or "/" in given or "\\" in given or Path(given).is_dir())
    )


def read_controller(path: Any) -> ControllerFile:
    """A controller.json, or that of a folder."""
    place = Path(path) / FILE if Path(path).is_dir() else Path(path)
    place = require_regular(place, REMEDY)
    try:
        data = json.loads(place.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputRefused(f"cannot be read ({error.strerror}): {REMEDY}").at(str(place)) from None
    except (ValueError, RecursionError) as error:
        said = f"is no controller ({type(error).__name__}: {error}): {REMEDY}"
        raise InputRefused(said).at(str(place)) from None
    return controller_from(data, str(place))


def controller_from(data: Any, place: str, own: OwnController | None = None) -> ControllerFile:
    """A controller from the content of its file; ``place``: its path; ``own``: the step that it lacks."""
    try:
        if "scheduled" in str(data.get("about")) or "radius" in data:
            raise InputRefused("is the controller of a carriage, and track moves load pulleys: " + REMEDY)
        seen, numbers = data["filter"], data["law"]
        law = LawNumbers(int(numbers["kind"]), *(_array(numbers[name]) for name in LawNumbers._fields[1:]))
        if not law.matrix.size:  # a list cannot say how wide an empty table is
            law = law._replace(matrix=np.zeros((0, 2 * len(data["shafts"]) + 1)))
        same: dict[str, Any] = {name: str(data[name]) for name in ("name", "feedback", "drive_hash")}
        same |= {name: tuple(data[name]) for name in ("shafts", "encoders", "columns")}
        same |= {name: float(data[name]) for name in ("sample_time", "load_gear")}
        parts: dict[str, Any] = {"kind": int(seen["kind"])}
        parts |= {name: np.array(seen[name], dtype=np.int64) for name in ("chosen", "places")}
        parts |= {name: _array(seen[name]) for name in ("model", "output", "gains", "scalars")}
        if parts["gains"].ndim != 3:
            parts["gains"] = parts["gains"][None]
        found = ControllerFile(
            **same,
            path=place,
            bandwidth=data["bandwidth_hz"],
            torque_limit=float("inf") if data["torque_limit"] is None else float(data["torque_limit"]),
            law=law,
            own=own,
            order=None if data.get("order") is None else int(data["order"]),
            late_samples=int(data["late_samples"]),
            counts=tuple(float(count) for count in data["counts"]),
            torque_per_volt=data["torque_per_volt"],
            reference=None if data["reference"] is None else _reference(data["reference"]),
            observer=ObserverNumbers(**parts),
        )
    except InputRefused as refusal:
        raise refusal.at(place) from None
    except (ValueError, KeyError, TypeError, AttributeError, OverflowError) as error:
        said = f"is no controller ({type(error).__name__}: {error}): {REMEDY}"
        raise InputRefused(said).at(place) from None
    size, law, seen = 2 * len(found.shafts), found.law, found.observer
    fits = law.kind in (DARC, BACKSTEPPING, OWN) or law.rows.shape[-1] == law.matrix.shape[0] + size
    fits = fits and (law.kind != DARC or law.matrix.shape == (size, size))
    whole = seen.kind in (KALMAN, BY_LOAD) and seen.gains.shape[1:] == seen.output.shape[::-1]
    wrong = ""
    if law.kind == OWN and own is None:
        wrong = f'holds the filter of "{found.name}", a controller of your own, whose step is code: '
        wrong += "give that object in Python"
    elif found.name not in CONTROLLERS and own is None:
        wrong = f'holds the law "{found.name}": take one of {", ".join(CONTROLLERS)}'
    elif not (fits and whole and len(seen.chosen) == size and len(found.encoders) == len(seen.output)):
        wrong = f"holds arrays that do not fit each other: {REMEDY}"
    if wrong:
        raise InputRefused(wrong).at(found.path)
    return found


def _reference(numbers: Mapping[str, Any]) -> ReferenceNumbers:
    """What makes the rows of a reference."""
    parts = _filters(numbers, ReferenceNumbers._fields[:-1])
    parts["friction"] = parts["friction"].reshape(-1, 2)
    parts["places"] = np.array(numbers["places"], dtype=np.int64).reshape(-1, 2)
    load, seen = NO_LOAD, numbers["load"]
    if seen is not None:
        chosen = np.array(seen["chosen"], dtype=np.int64)
        numbers_of = _filters(seen, LoadRowNumbers._fields)
        load = LoadRowNumbers(**numbers_of | {"chosen": chosen, "gains": numbers_of["gains"][None]})
    return ReferenceNumbers(**parts, load=load)


def _filters(numbers: Mapping[str, Any], names: tuple[str, ...]) -> dict[str, Any]:
    """Arrays of a generator; an empty list has no width."""
    parts: dict[str, Any] = {name: _array(numbers[name]) for name in names}
    parts["lags"] = parts["lags"].reshape(-1, 3)
    parts["sources"] = np.array(numbers["sources"], dtype=np.int64)
    return parts


def _array(values: Any) -> Array:
    """Numbers of a file, null for infinity."""
    array = np.array(values, dtype=np.float64)
    array[np.isnan(array)] = np.inf
    return array
