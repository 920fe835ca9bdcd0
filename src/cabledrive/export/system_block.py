"""A plant, or the closed loop of plant and controller, as a program in C."""

import numpy as np

from cabledrive.control.controller_kernels import new_target_state
from cabledrive.control.numbers import start_estimates
from cabledrive.export.block import Block, given, output, parameter
from cabledrive.export.controller_block import COMMANDED, needed_rise, path_state
from cabledrive.export.source import NOTE, ExportSource, plant_loop
from cabledrive.export.translation.nodes import REAL, Scalar, Value
from cabledrive.export.translation.program import Program
from cabledrive.parameters import InputRefused
from cabledrive.rig.closed_loop.loop import Loop
from cabledrive.rig.closed_loop.loop_kernels import (
    LoopTarget,
    loop_step,
    new_plant_state,
    plant_read,
    plant_step,
)
from cabledrive.rig.laws.controller_file import ControllerFile
from cabledrive.trajectories import rise_coefficients

TORQUES = [given(f"{on}_torque", "N.m", f"disturbance on the {on}") for on in ("motor", "load")]
MOTION = [
    parameter("angle", "rad", "of the load, there and back", 0.5),
    parameter("rise", "s", "time of a move", 0.5),
    parameter("dwell", "s", "rest after a move", 0.5),
    parameter("pulses", "", "how many", 1.0),
]


def new_loop(law: ControllerFile, plant: Loop) -> LoopTarget:
    """A closed loop at rest, before a motion is given."""
    if law.reference is None:
        raise InputRefused(
            "the file has no reference generator, it was written by an earlier version: study again"
        )
    target = new_target_state(law.observer, law.law, law.late_samples)
    target.datum[:] = np.nan
    start = start_estimates(law.law)
    target.controller.parameters[: len(start)] = start
    return LoopTarget(
        plant=new_plant_state(plant.plant, plant.rig),
        target=target,
        path=path_state(law, needed_rise(law)),
        row=np.zeros((1, len(law.columns))),
        sample=np.zeros(1, dtype=np.int64),
    )


def system_block(source: ExportSource, what: str) -> Block:
    """The plant, or the loop of plant and controller, translated."""
    law, plant, program = source.law, plant_loop(source), Program()
    shafts, closed = plant.chain.names, what == "loop"
    frozen = {name: program.frozen(name, getattr(plant, name)) for name in ("plant", "rig")}
    torques = [Value(one.name, Scalar(REAL)) for one in TORQUES]
    if not closed:
        inner = program.state("cd_plant", "plant", new_plant_state(plant.plant, plant.rig))
        step, step_call = program.root(
            plant_step, [*frozen.values(), inner, Value("u", Scalar(REAL)), *torques]
        )
    else:
        state = program.state("cd_loop", "loop", new_loop(law, plant))
        parts = {"observer": law.observer, "law": law.law, "reference": law.reference}
        numbers = [*frozen.values(), *(program.frozen(name, part) for name, part in parts.items())]
        limit = Value(program.precision.literal(law.torque_limit), Scalar(REAL))
        step, step_call = program.root(loop_step, [*numbers, limit, state, *torques])
        record = program.plain_record(state)
        kind = record.field("plant")
        assert kind is not None
        inner = program.field(state, record, "plant", kind)
        program.tables["START"] = (start_estimates(law.law), "estimates to begin with")
        rise = np.array(rise_coefficients(needed_rise(law)))
        program.tables["RISE"] = (rise, "rise in powers of t / rise")
    _, read_call = program.root(plant_read, [frozen["rig"], inner])
    shown = [output(f"{name}_encoder", "rad", "angle read") for name in law.encoders]
    for unit, motion in (("rad", "angle"), ("rad/s", "speed")):
        shown += [output(f"{one}_{motion}", unit, f"true {motion} of the {one}") for one in shafts]
    shown.append(output("slip", "", "1, -1: the motor slips; 0: sticks"))
    wanted = output("wanted", "rad", "wanted load angle of the last sample")
    asked = given("command", "N.m", "torque asked of the motor")
    drive = source.drive
    assert drive is not None
    return Block(
        what=what,
        drive=drive.name,
        title=f"{drive.title or drive.name}: {what}",
        interval=law.sample_time,
        program=program,
        words={
            "caution": source.c_caution if closed else "",
            "law": law,
            "encoders": law.encoders,
            "shafts": shafts,
            "order": needed_rise(law) if closed else 0,
            "step": step,
            "step_call": step_call,
            "read_call": read_call,
            "start_size": start_estimates(law.law).size,
            "at": "loop->plant." if closed else "plant->",
        },
        variables=[*MOTION, *TORQUES, *COMMANDED, wanted, *shown] if closed else [asked, *TORQUES, *shown],
        notes=[*source.notes, NOTE],
    )
