"""What is exported: a study's folder, a controller.json, or a drive with the name of a law."""

import json
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from cabledrive.control.numbers import HIGH, LOW, SCHEDULED
from cabledrive.control.own_controller import ControllerProtocol, checked_controller
from cabledrive.control.reference_numbers import MotionNumbers
from cabledrive.export.gain_cut import gain_cut
from cabledrive.parameters import Drive, InputRefused, content_hash, load_drive
from cabledrive.parameters.route.drive import RoutedDrive
from cabledrive.reduction.network_axis import as_axis, axis_notes
from cabledrive.rig.closed_loop.loop import Loop, close_loop
from cabledrive.rig.laws.controller_file import (
    FILE,
    ControllerFile,
    controller_from,
    controller_numbers,
    is_controller_path,
    read_controller,
)
from cabledrive.rig.laws.controllers import motion_numbers
from cabledrive.rig.laws.own_law import own_law
from cabledrive.rig.laws.registry import known_name, needed_order
from cabledrive.rig.ranking.best import BEST, best_controller
from cabledrive.rig.setting import Motion, RigOptions
from cabledrive.rig.trial import check_motion, spec_for
from cabledrive.rig.tuning import design

DRIVE = "drive.toml"
LEARNS = (
    "darc-indirect learns after the first pulse with code that is not exported: this is the law before it "
    "has learnt"
)

ANNOUNCE = (
    "announce the load: write its inertia over that of the drive into ref[CD_REFERENCES - 1] before each "
    "cd_step; the generator leaves 1 there, and beyond {low:.4g} to {high:.4g} the nearer end is taken"
)
NOT_TRIED = "what leaving out the filter's schedule of gains costs is not known: a run did not reach its end"
NO_SCHEDULE = "what leaving out the filter's schedule of gains costs is not known: the file has the last gain"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ExportSource:
    """A controller with its numbers, and the drive where it is known."""

    law: ControllerFile
    data: dict[str, Any]
    drive: Drive | None
    notes: tuple[str, ...] = ()

    @property
    def caution(self) -> str:
        """Why the study behind the law does not say yes; empty where it does, or where there is none."""
        judged = self.data.get("study") or {}
        if judged.get("verdict", "yes") == "yes":
            return ""
        return f"the verdict of its study is {judged['verdict']}: {judged.get('reason', 'no reason kept')}"

    @property
    def c_caution(self) -> str:
        """The same as it may stand in a comment of C."""
        return " ".join(self.caution.replace("*/", "* /").replace("/*", "/ *").split())


def read_source(
    source: Any, controller: str | ControllerProtocol | None = None, axis: str | None = None
) -> ExportSource:
    """Read what is to be exported: Drive, its name or path, a study's folder or a controller.json.

    ``controller``, ``axis``: with a drive. Refused if it is none, or the law cannot be had for the drive.
    """
    if isinstance(source, Drive | RoutedDrive):
        return designed(as_axis(source, axis), controller)
    folder = Path(str(source)).is_dir()
    if (is_controller_path(str(source)) or folder) and not str(source).endswith(".toml"):
        if controller is not None:
            given = controller if isinstance(controller, str) else "of your own"
            raise InputRefused(f"{source}: holds its own law: leave --controller {given} out")
        if axis is not None:
            raise InputRefused(f"{source}: holds the law of its own axis: leave --axis {axis} out")
        return _from_file(Path(source))
    return designed(as_axis(load_drive(str(source)), axis), controller)


def _from_file(path: Path) -> ExportSource:
    place = path / FILE if path.is_dir() else path
    if path.is_dir() and not place.exists():
        raise InputRefused(f"{path}: holds no {FILE}: the study is not finished, or found no controller")
    law = read_controller(place)
    if not law.columns:
        raise InputRefused(
            "has no names of its reference's columns, an earlier version wrote it: run the study again"
        ).at(str(place))
    data = json.loads(place.read_text(encoding="utf-8"))
    beside = place.parent / DRIVE
    drive = load_drive(str(beside)) if beside.is_file() else None
    if drive is not None and content_hash(drive) != law.drive_hash:
        drive = None
    notes = (*_notes(law), *(() if data.get("gain_cut") else (NO_SCHEDULE,)))
    return ExportSource(law=law, data=data, drive=drive, notes=notes)


def designed(drive: Drive, name: str | ControllerProtocol | None) -> ExportSource:
    """A law designed for a drive as `cabledrive.track` designs it, its filter at the gain it settles on.

    ``name``: of a packaged law, or a controller of the user's own.
    """
    loop, motion = designed_loop(drive, name)
    data = controller_numbers(loop, drive, RigOptions().feedback)
    cut = gain_cut(loop, motion)
    data |= {"gain_cut": None if cut is None else cut.data}
    law = controller_from(json.loads(json.dumps(data)), FILE, loop.controller.own)
    notes = (*_notes(law), NOT_TRIED if cut is None else cut.note, *axis_notes(drive))
    return ExportSource(law=law, data=data, drive=drive, notes=notes)


def designed_loop(drive: Drive, name: str | ControllerProtocol | None) -> tuple[Loop, MotionNumbers]:
    """The loop of a law and a drive along the standard pulse, and that."""
    own = checked_controller(name) if name is not None and not isinstance(name, str) else None
    best = name == BEST
    known = own.name if own else known_name(None if best else str(name) if name else None, drive)
    motion, options = Motion(order=needed_order(known, drive)), RigOptions()
    check_motion(drive, motion)
    spec = spec_for(drive, motion, best=own is None, options=options)
    spec = replace(spec, feedback=options.feedback)
    made = own_law(own, spec) if own else best_controller(spec) if best else design(known, spec)
    if made.field is not None:
        raise InputRefused(
            f"{made.name} is an open loop and no controller: the configuration of its shaper comes from "
            "`cabledrive shaper LOG --json -o shaper.json` and `export shaper.json --format klipper`"
        )
    loop = close_loop(drive, drive, made, motion, options, np.random.default_rng(0))
    return loop, motion_numbers(drive, motion)


def _notes(law: ControllerFile) -> tuple[str, ...]:
    if law.law.kind == SCHEDULED:
        low, high = law.law.learning[[LOW, HIGH], 0]
        return (ANNOUNCE.format(low=low, high=high),)
    return (LEARNS,) if law.name == "darc-indirect" else ()
