"""Controllers to export, as fast as they can be had: no trial runs choose their gains."""

import json
from functools import cache

import numpy as np

import cabledrive as cd
from cabledrive.export.source import ExportSource
from cabledrive.rig import Motion, RigOptions
from cabledrive.rig.closed_loop.loop import Loop, close_loop
from cabledrive.rig.laws.controller_file import controller_from, controller_numbers
from cabledrive.rig.laws.registry import CONTROLLERS, needed_order
from cabledrive.rig.trial import spec_for


@cache
def loop_of(name: str, drive: str = "dissertation-3") -> Loop:
    loaded = cd.load_drive(drive)
    motion = Motion(order=needed_order(name, loaded))
    made = CONTROLLERS[name](spec_for(loaded, motion))
    return close_loop(loaded, loaded, made, motion, RigOptions(), np.random.default_rng(0))


@cache
def source_of(name: str, drive: str = "dissertation-3") -> ExportSource:
    loaded = cd.load_drive(drive)
    data = controller_numbers(loop_of(name, drive), loaded, "motor")
    law = controller_from(json.loads(json.dumps(data)), "controller.json")
    return ExportSource(law=law, data=data, drive=loaded)
