"""A controller in a file: law and filter in numbers, with the names, units and hash that make them usable."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import pi
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from cabledrive.control.numbers import BACKSTEPPING, DARC, NOMINAL, LawNumbers
from cabledrive.control.observer_numbers import KALMAN, ObserverNumbers
from cabledrive.parameters import Drive, InputRefused, content_hash
from cabledrive.parameters.files import require_regular
from cabledrive.rig.closed_loop.loop import Loop
from cabledrive.rig.closed_loop.loop_numbers import Array
from cabledrive.rig.laws.baselines import BASELINES
from cabledrive.rig.laws.controllers import Controller, DesignSpec, chain_law
from cabledrive.rig.laws.registry import CONTROLLERS
from cabledrive.rig.setting import RigOptions

ABOUT = "See cabledrive.control.numbers.LawNumbers and cabledrive.control.observer_numbers"
FILE = "controller.json"
UNITS = {"sample_time": "s", "torque_limit": "N m", "angles": "rad at the first shaft", "speeds": "rad/s"}
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


def controller_numbers(loop: Loop, drive: Drive, feedback: str) -> dict[str, Any]:
    """The law and filter of a loop as plain data, which `read_controller` takes back.

    ``drive``: that it was made for.
    """
    made, rig = loop.controller, loop.rig
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
        "law": plain_numbers(made.law._asdict()),
        "filter": plain_numbers(loop.observer._asdict() | {"gains": loop.observer.gains[-1]}),
    }


def plain_numbers(fields: Mapping[str, Any]) -> dict[str, Any]:
    """Arrays as lists; infinity as null."""

    def plain(value: Any) -> Any:
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
        if "scheduled" in str(data.get("about")) or "radius" in data:
            raise InputRefused("is the controller of a carriage, and track moves load pulleys: " + REMEDY)
        if "drive_hash" not in data:
            raise InputRefused("has no drive_hash, it was written by version 0.1: run the study again")
        seen = data["filter"]
        found = ControllerFile(
            path=str(place),
            name=str(data["name"]),
            bandwidth=data["bandwidth_hz"],
            shafts=tuple(data["shafts"]),
            encoders=tuple(data["encoders"]),
            feedback=str(data["feedback"]),
            sample_time=float(data["sample_time"]),
            torque_limit=float("inf") if data["torque_limit"] is None else float(data["torque_limit"]),
            drive_hash=str(data["drive_hash"]),
            law=_law(data["law"], 2 * len(data["shafts"])),
            observer=ObserverNumbers(
                kind=int(seen["kind"]),
                chosen=np.array(seen["chosen"], dtype=np.int64),
                places=np.array(seen["places"], dtype=np.int64),
                model=_array(seen["model"]),
                output=_array(seen["output"]),
                gains=_array(seen["gains"])[None],
                scalars=_array(seen["scalars"]),
            ),
        )
    except InputRefused as refusal:
        raise refusal.at(str(place)) from None
    except OSError as error:
        raise InputRefused(f"cannot be read ({error.strerror}): {REMEDY}").at(str(place)) from None
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise InputRefused(f"is no controller ({type(error).__name__}: {error}): {REMEDY}").at(
            str(place)
        ) from None
    _check(found)
    return found


def _array(values: Any) -> Array:
    """Numbers of a file, null for infinity."""
    array = np.array(values, dtype=np.float64)
    array[np.isnan(array)] = np.inf
    return array


def _law(data: Mapping[str, Any], states: int) -> LawNumbers:
    """The law in numbers; a list cannot say how wide an empty table is."""
    law = LawNumbers(int(data["kind"]), *(_array(data[name]) for name in LawNumbers._fields[1:]))
    return law if law.matrix.size else law._replace(matrix=np.zeros((0, states + 1)))


def _check(found: ControllerFile) -> None:
    known = (*BASELINES, *(name for name in CONTROLLERS if name.endswith("-damped")))
    size, law, seen = 2 * len(found.shafts), found.law, found.observer
    fits = law.kind in (DARC, BACKSTEPPING) or law.rows.shape[-1] == law.matrix.shape[0] + size
    fits = fits and (law.kind != DARC or law.matrix.shape == (size, size))
    whole = seen.kind == KALMAN and seen.gains.shape[1:] == seen.output.shape[::-1]
    if found.name not in known:
        raise InputRefused(f'holds the law "{found.name}": take one of {", ".join(known)}').at(found.path)
    if not (fits and whole and len(seen.chosen) == size and len(found.encoders) == len(seen.output)):
        raise InputRefused(f"holds arrays that do not fit each other: {REMEDY}").at(found.path)


def law_from_file(found: ControllerFile, spec: DesignSpec) -> Controller:
    """The law of a file with its reference along another motion.

    Raises `InputRefused` if the drive is not that of the file, or settings of a packaged law are given.
    """
    if content_hash(spec.drive) != found.drive_hash:
        raise InputRefused(
            f"was made for another drive, hash {found.drive_hash[:12]}, not {content_hash(spec.drive)[:12]}: "
            "give the drive.toml beside it, and what differs as the plant"
        ).at(found.path)
    if spec.bandwidth is not None or not spec.adapt:
        raise InputRefused("holds its own gains: leave bandwidth and adaptation out").at(found.path)
    if spec.feedforward != "damped":
        raise InputRefused("holds a law with the damped inverse: leave feedforward out").at(found.path)
    spec = replace(spec, feedback=found.feedback, best=False)
    if found.name in BASELINES:
        made = BASELINES[found.name](spec)
    else:
        number = int(found.name.split("-")[1])
        made = chain_law(replace(spec, bandwidth=found.bandwidth), number, found.name, damped=True)
    start = found.law.learning[NOMINAL] if found.law.kind == DARC else made.start
    hertz = {} if found.bandwidth is None else {"bandwidth_hz": found.bandwidth}
    rate = None if found.bandwidth is None or found.law.kind != DARC else 2.0 * pi * found.bandwidth
    return replace(made, law=found.law, start=start, gains={"file": found.path} | hertz, bandwidth=rate)


def with_filter(loop: Loop, found: ControllerFile, options: RigOptions) -> Loop:
    """A loop with the filter and the torque limit of a file.

    Raises `InputRefused` if the rig reads other encoders, or no filter is wanted.
    """
    if options.ideal_sensors or options.observer != "kalman":
        raise InputRefused("brings its own Kalman filter: leave observer and ideal_sensors out").at(
            found.path
        )
    if abs(found.sample_time - loop.rig.interval) > 1e-9 * found.sample_time:
        raise InputRefused(
            f"samples every {found.sample_time:.6g} s, the rig every {loop.rig.interval:.6g} s"
        ).at(found.path)
    if found.encoders != loop.encoder_shafts:
        raise InputRefused(f"reads the encoders of {found.encoders}, the rig {loop.encoder_shafts}").at(
            found.path
        )
    limit = min(found.torque_limit, loop.rig.torque_limit)
    return replace(loop, observer=found.observer, rig=loop.rig._replace(torque_limit=limit))
