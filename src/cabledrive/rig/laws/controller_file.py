"""A controller in a file: law and filter in numbers, with the names, units and hash that make them usable."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from cabledrive.control.numbers import BACKSTEPPING, BY_LOAD, DARC, KALMAN, OWN, LawNumbers, ObserverNumbers
from cabledrive.control.own_controller import OwnController
from cabledrive.control.reference import NO_LOAD, LoadRowNumbers, ReferenceNumbers
from cabledrive.parameters import Drive, InputRefused, content_hash
from cabledrive.parameters.files import require_regular
from cabledrive.rig.closed_loop.loop import Loop
from cabledrive.rig.closed_loop.loop_numbers import Array
from cabledrive.rig.laws.controller_words import ARRAYS, reference_columns
from cabledrive.rig.laws.registry import CONTROLLERS

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
    """What a controller.json holds.

    Attributes
    ----------
    path : str
    name : str
        Of the packaged law.
    bandwidth : float or None
        [Hz].
    shafts, encoders : tuple of str
        Whose motion the law takes; which encoders the filter reads.
    feedback : {"motor", "drive"}
    sample_time : float
        [s].
    torque_limit : float
        [N m].
    drive_hash : str
        Content hash of the drive that it was made for.
    law : LawNumbers
    observer : ObserverNumbers
        With the gain on which the filter settles.
    late_samples : int
        Whole samples of the delay from reading to torque.
    counts : tuple of float
        One count of each encoder at the first shaft [rad].
    load_gear : float
        Angle of the first shaft per angle of the load.
    torque_per_volt : float or None
        [N m/V].
    reference : ReferenceNumbers or None
        What makes the rows of the reference; None in a file of an earlier version.
    columns : tuple of str
        Names of the reference's columns.
    own : OwnController or None
        A controller of the user's own, whose step no file holds.
    """

    path: str
    name: str
    bandwidth: float | None
    shafts: tuple[str, ...]
    encoders: tuple[str, ...]
    feedback: str
    sample_time: float
    torque_limit: float
    drive_hash: str
    law: LawNumbers
    observer: ObserverNumbers
    late_samples: int = 0
    counts: tuple[float, ...] = ()
    load_gear: float = 1.0
    torque_per_volt: float | None = None
    reference: ReferenceNumbers | None = None
    columns: tuple[str, ...] = ()
    own: OwnController | None = None


def controller_numbers(loop: Loop, drive: Drive, feedback: str) -> dict[str, Any]:
    """The law and filter of a loop as plain data, which `read_controller` takes back.

    ``drive``: that it was made for.
    """
    made, rig, generator = loop.controller, loop.rig, loop.controller.generator
    along = made.own is not None and made.own.follows == "motion"
    columns = reference_columns(made.law, made.shafts, made.reference.shape[1], motion=along)
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
        "drive_hash": content_hash(drive),
        "late_samples": rig.late_samples,
        "counts": rig.counts.tolist(),
        "load_gear": loop.gear,
        "torque_per_volt": drive.motor.torque_per_volt if drive.motor else None,
        "columns": columns,
        "reference": None if generator is None else plain_numbers(generator._asdict()),
        "arrays": ARRAYS,
        "law": plain_numbers(made.law._asdict()),
        "filter": plain_numbers(loop.observer._asdict() | {"gains": kept_gains(loop.observer)}),
    }


def kept_gains(observer: ObserverNumbers) -> Array:
    """The gain on which a filter settles; of one scheduled by the load those of all points."""
    return observer.gains if observer.kind == BY_LOAD else observer.gains[-1]


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
    """A controller.json, or that of a folder.

    Raises `InputRefused` if it is none, or one that `cabledrive.track` cannot run.
    """
    place = Path(path) / FILE if Path(path).is_dir() else Path(path)
    place = require_regular(place, REMEDY)
    try:
        data = json.loads(place.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputRefused(f"cannot be read ({error.strerror}): {REMEDY}").at(str(place)) from None
    except (ValueError, RecursionError) as error:
        raise InputRefused(f"is no controller ({type(error).__name__}: {error}): {REMEDY}").at(
            str(place)
        ) from None
    return controller_from(data, str(place))


def controller_from(data: Any, place: str, own: OwnController | None = None) -> ControllerFile:
    """A controller from the content of its file; ``place``: its path; ``own``: the step that it lacks.

    Raises `InputRefused` as `read_controller`.
    """
    try:
        if "scheduled" in str(data.get("about")) or "radius" in data:
            raise InputRefused("is the controller of a carriage, and track moves load pulleys: " + REMEDY)
        if "drive_hash" not in data:
            raise InputRefused("has no drive_hash, it was written by version 0.1: run the study again")
        seen = data["filter"]
        found = ControllerFile(
            path=place,
            name=str(data["name"]),
            bandwidth=data["bandwidth_hz"],
            shafts=tuple(data["shafts"]),
            encoders=tuple(data["encoders"]),
            feedback=str(data["feedback"]),
            sample_time=float(data["sample_time"]),
            torque_limit=float("inf") if data["torque_limit"] is None else float(data["torque_limit"]),
            drive_hash=str(data["drive_hash"]),
            law=_law(data["law"], 2 * len(data["shafts"])),
            own=own,
            **_target(data),
            observer=ObserverNumbers(
                kind=int(seen["kind"]),
                chosen=np.array(seen["chosen"], dtype=np.int64),
                places=np.array(seen["places"], dtype=np.int64),
                model=_array(seen["model"]),
                output=_array(seen["output"]),
                gains=_stacked(_array(seen["gains"])),
                scalars=_array(seen["scalars"]),
            ),
        )
    except InputRefused as refusal:
        raise refusal.at(place) from None
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise InputRefused(f"is no controller ({type(error).__name__}: {error}): {REMEDY}").at(
            place
        ) from None
    _check(found)
    return found


def _target(data: Mapping[str, Any]) -> dict[str, Any]:
    """What only a target asks for, and a file of an earlier version lacks."""
    if "columns" not in data or "reference" not in data:
        return {}
    named = {
        "late_samples": int(data["late_samples"]),
        "counts": tuple(float(count) for count in data["counts"]),
        "load_gear": float(data["load_gear"]),
        "torque_per_volt": data["torque_per_volt"],
        "columns": tuple(data["columns"]),
    }
    if data["reference"] is None:
        return named
    numbers = data["reference"]
    parts = _filters(numbers, ReferenceNumbers._fields[:-1])
    parts["friction"] = parts["friction"].reshape(-1, 2)
    parts["places"] = np.array(numbers["places"], dtype=np.int64).reshape(-1, 2)
    load, seen = NO_LOAD, numbers.get("load")
    if seen is not None:
        chosen = np.array(seen["chosen"], dtype=np.int64)
        load = LoadRowNumbers(**_filters(seen, LoadRowNumbers._fields) | {"chosen": chosen})
    return named | {"reference": ReferenceNumbers(**parts, load=load)}


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


def _stacked(gains: Array) -> Array:
    return gains if gains.ndim == 3 else gains[None]


def _law(data: Mapping[str, Any], states: int) -> LawNumbers:
    """The law in numbers; a list cannot say how wide an empty table is."""
    law = LawNumbers(int(data["kind"]), *(_array(data[name]) for name in LawNumbers._fields[1:]))
    return law if law.matrix.size else law._replace(matrix=np.zeros((0, states + 1)))


def _check(found: ControllerFile) -> None:
    size, law, seen = 2 * len(found.shafts), found.law, found.observer
    fits = law.kind in (DARC, BACKSTEPPING, OWN) or law.rows.shape[-1] == law.matrix.shape[0] + size
    fits = fits and (law.kind != DARC or law.matrix.shape == (size, size))
    whole = seen.kind in (KALMAN, BY_LOAD) and seen.gains.shape[1:] == seen.output.shape[::-1]
    if law.kind == OWN and found.own is None:
        raise InputRefused(
            f'holds the filter of "{found.name}", a controller of your own, whose step is code: give that '
            "object in Python"
        ).at(found.path)
    if found.name not in CONTROLLERS and found.own is None:
        raise InputRefused(f'holds the law "{found.name}": take one of {", ".join(CONTROLLERS)}').at(
            found.path
        )
    if not (fits and whole and len(seen.chosen) == size and len(found.encoders) == len(seen.output)):
        raise InputRefused(f"holds arrays that do not fit each other: {REMEDY}").at(found.path)
