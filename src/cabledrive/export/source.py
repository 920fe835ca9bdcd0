"""What is exported: a study's folder, a controller, a drive, or the plant of one."""

import json
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from cabledrive.control.numbers import BY_LOAD, HIGH, LOW, SCHEDULED
from cabledrive.control.own_controller import OwnController
from cabledrive.parameters import Drive, InputRefused, Machine, content_hash, load_drive
from cabledrive.reduction.lumped_chain import LumpedChain, highest_model, lumped_model
from cabledrive.reduction.network_axis import as_axis, axis_notes
from cabledrive.rig.closed_loop.loop import Loop, close_loop
from cabledrive.rig.front_door import law_for, law_from_file
from cabledrive.rig.laws.controller_file import (
    FILE,
    ControllerFile,
    controller_from,
    controller_numbers,
    is_controller_path,
    read_controller,
)
from cabledrive.rig.laws.controllers import DesignSpec
from cabledrive.rig.laws.registry import needed_order
from cabledrive.rig.setting import Motion, RigOptions
from cabledrive.rig.trial import BEST, check_motion, controller_name

DRIVE = "drive.toml"
LEARNS = (
    "darc-indirect learns after the first pulse with code that is not exported: this is the law before it "
    "has learnt"
)

ANNOUNCE = (
    "announce the load: write its inertia over that of the drive into ref[CD_REFERENCES - 1] before each "
    "cd_step; the generator leaves 1 there, and beyond {low:.4g} to {high:.4g} the nearer end is taken"
)
SETTLED = (
    "the Kalman filter uses the gain on which it settles from the first sample on: the peak error along the "
    "standard pulse was 0.73 to 1.42 times that of the schedule for the laws of dissertation-3; "
    "`cabledrive track DRIVE --controller FOLDER` runs it as it is"
)
MISSED = (
    "its study says yes of the filter's schedule; with the gain on which the filter settles, as it is "
    "exported, the law misses the goal on {misses} of {draws} lumped plants"
)


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
            tried = judged.get("as_written") or {"holds": True}
            return "" if tried["holds"] else MISSED.format(**tried)
        return f"the verdict of its study is {judged['verdict']}: {judged.get('reason', 'no reason kept')}"


def read_source(
    source: Any, controller: str | OwnController | None = None, axis: str | None = None
) -> ExportSource:
    """Read what is to be exported: machine or drive, its name or path, a study's folder or a controller.json.

    ``controller``, ``axis``: with a drive. Refused if it is none, or the law cannot be had for the drive.
    """
    if isinstance(source, Machine | Drive):
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
    drive = as_axis(load_drive(str(beside))) if beside.is_file() else None
    if drive is not None and content_hash(drive) != law.drive_hash:
        drive = None
    return ExportSource(law=law, data=data, drive=drive, notes=_notes(law))


def designed(drive: Drive, name: str | OwnController | None) -> ExportSource:
    """A law designed for a drive as `cabledrive.track` designs it, its filter at the gain it settles on.

    ``name``: of a packaged law, or a controller of the user's own.
    """
    loop = designed_loop(drive, name)
    data = controller_numbers(loop, drive, RigOptions().feedback)
    law = controller_from(json.loads(json.dumps(data)), FILE, loop.controller.own)
    notes = (*_notes(law), *axis_notes(drive))
    return ExportSource(law=law, data=data, drive=drive, notes=notes)


def designed_loop(drive: Drive, name: str | OwnController | None) -> Loop:
    """The loop of a law and a drive along the standard pulse."""
    known = controller_name(None if name == BEST else name or None, drive)
    motion = Motion(order=needed_order(known, drive))
    check_motion(drive, motion)
    spec = DesignSpec(drive, motion, best=True)
    made = law_for(name or None, spec)
    if made.field is not None:
        raise InputRefused(
            f"{made.name} is an open loop and no controller: the configuration of its shaper comes from "
            "`cabledrive shaper LOG --json -o shaper.json` and `export shaper.json --format klipper`"
        )
    return close_loop(spec, made, np.random.default_rng(0))


def _notes(law: ControllerFile) -> tuple[str, ...]:
    settled = () if law.observer.kind == BY_LOAD else (SETTLED,)
    if law.law.kind == SCHEDULED:
        low, high = law.law.learning[[LOW, HIGH], 0]
        return (*settled, ANNOUNCE.format(low=low, high=high))
    return (*settled, LEARNS) if law.name == "darc-indirect" else settled


def read_machine(source: Any) -> Machine:
    """A machine, its name or file, or a study's identified one; else refused."""
    if isinstance(source, Machine | Drive):
        return source.machine
    place = Path(str(source))
    if place.is_dir() or place.name == FILE:
        beside = (place if place.is_dir() else place.parent) / DRIVE
        if not beside.is_file():
            raise InputRefused(f"{source}: no {DRIVE} beside it, and mechanics are wanted: give the drive")
        return load_drive(str(beside))
    return load_drive(str(source))


def lumped_models(drive: Drive) -> dict[int, LumpedChain]:
    """Models 1 to 4 of a drive that its data allow, by number; refused with the highest's reason if none."""
    found = {}
    for number in (1, 2, 3, 4):
        with suppress(InputRefused):
            found[number] = lumped_model(drive, number)
    return found or {0: lumped_model(drive, highest_model(drive))}


NOTE = (
    "the plant is the highest lumped model of the drive with stick-slip friction; a slack span carries "
    "nothing; encoder phases of seed 0"
)


def plant_loop(source: ExportSource) -> Loop:
    """The loop on whose plant `cabledrive.track --tension-only` runs the law; refused where not at hand."""
    drive = source.drive
    if drive is None:
        raise InputRefused(
            "the plant needs the drive, and no drive.toml with the law's hash is beside it: give the drive"
        )
    return loop_on(source, drive, Motion(order=source.law.order or needed_order(source.law.name, drive)))


def loop_on(source: ExportSource, drive: Drive, motion: Motion, *, slack: bool = True) -> Loop:
    """The loop of a law from its file on a drive along a motion; ``slack``: whether spans may go slack."""
    options = RigOptions(forbid_slack=not slack, feedback=source.law.feedback)
    spec = DesignSpec(drive, motion, options=options)
    return close_loop(spec, law_from_file(source.law, spec), np.random.default_rng(0))
