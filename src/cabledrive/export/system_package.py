"""A plant or a closed loop in C99: sources, self-test, vectors."""

import json
from typing import Any

import numpy as np

from cabledrive.control.controller_kernels import new_target_state
from cabledrive.control.numbers import start_estimates
from cabledrive.export.source import NOTE, ExportSource, plant_loop
from cabledrive.export.target_program import needed_rise, path_state, runtime_text, templates
from cabledrive.export.translation.nodes import REAL, Scalar, Value
from cabledrive.export.translation.program import Program
from cabledrive.export.translation.source import interpreted
from cabledrive.parameters import InputRefused
from cabledrive.parameters.drive_file import drive_text
from cabledrive.parameters.version import __version__
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

SAMPLES, SEED = 500, 20
MOTION = (0.5, 0.03, 0.01, 1)
"""Of the loop's self-test: load angle [rad], rise, dwell [s], pulses."""


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


def system_code(source: ExportSource, what: str) -> dict[str, str]:
    """Header and source of the plant, or of the loop of plant and controller."""
    law, plant, program = source.law, plant_loop(source), Program()
    frozen = {name: program.frozen(name, getattr(plant, name)) for name in ("plant", "rig")}
    torques = [Value(name, Scalar(REAL)) for name in ("motor_torque", "load_torque")]
    if what == "plant":
        inner = program.state("cd_plant", "plant", new_plant_state(plant.plant, plant.rig))
        given = [*frozen.values(), inner, Value("u", Scalar(REAL)), *torques]
        step, step_call = program.root(plant_step, given)
    else:
        state = program.state("cd_loop", "loop", new_loop(law, plant))
        numbers = {"observer": law.observer, "law": law.law, "reference": law.reference}
        given = [*frozen.values(), *(program.frozen(name, one) for name, one in numbers.items())]
        limit = Value(program.precision.literal(law.torque_limit), Scalar(REAL))
        step, step_call = program.root(loop_step, [*given, limit, state, *torques])
        record = program.plain_record(state)
        kind = record.field("plant")
        assert kind is not None
        inner = program.field(state, record, "plant", kind)
        program.tables["START"] = (start_estimates(law.law), "estimates to begin with")
        rise = np.array(rise_coefficients(needed_rise(law)))
        program.tables["RISE"] = (rise, "rise in powers of t / rise")
    _, read_call = program.root(plant_read, [frozen["rig"], inner])
    functions = program.functions()
    extra = " START RISE" if what == "loop" else ""
    words: dict[str, Any] = {
        "title": f"{source.drive.title or source.drive.name if source.drive else ''}: {what}",
        "version": __version__,
        "caution": source.c_caution if what == "loop" else "",
        "law": source.law,
        "what": what,
        "literal": program.precision.literal,
        "encoders": source.law.encoders,
        "shafts": plant.chain.names,
        "structs": program.structs(),
        "order": needed_rise(source.law) if what == "loop" else 0,
        "step": step,
        "step_call": step_call,
        "read_call": read_call,
        "start_size": start_estimates(source.law.law).size,
        "at": "plant->" if what == "plant" else "loop->plant.",
        "functions": functions,
        "tables": program.used_tables(functions + step_call + read_call + extra),
        "runtime": runtime_text(program.precision, functions),
    }
    return {
        f"cabledrive_{what}.h": templates().get_template("system.h.jinja").render(**words),
        f"cabledrive_{what}.c": templates().get_template("system.c.jinja").render(**words),
    }


def system_package(source: ExportSource, what: str) -> dict[str, str]:
    """Files of a plant or loop in C99, by name."""
    inputs = ("u [N m]", "motor_torque [N m]", "load_torque [N m]")[what == "loop" :]
    motion = [repr(value) for value in MOTION]
    check = templates().get_template("check_system.c.jinja")
    files = system_code(source, what) | {
        "check.c": check.render(what=what, inputs=len(inputs), motion=motion),
        "vectors.csv": vectors(source, what, inputs),
        "controller.json": json.dumps(source.data, indent=1, allow_nan=False) + "\n",
    }
    if source.drive is not None:
        files["drive.toml"] = drive_text(source.drive)
    words = {"what": what, "law": source.law, "version": __version__, "note": NOTE}
    words["caution"] = source.c_caution if what == "loop" else ""
    readme = templates().get_template("README_system.md.jinja")
    return files | {"README.md": readme.render(**words)}


def vectors(source: ExportSource, what: str, inputs: tuple[str, ...]) -> str:
    """Random torques, and the load angles that the interpreted kernels give."""
    law, plant = source.law, plant_loop(source)
    generator = np.random.default_rng(SEED)
    strength = np.array([0.3, 0.02, 0.02])[-len(inputs) :]
    given = np.repeat(strength * generator.standard_normal((SAMPLES // 10, len(inputs))), 10, axis=0)
    angles, n = np.zeros(SAMPLES), len(plant.chain.names)
    if what == "plant":
        state, step = new_plant_state(plant.plant, plant.rig), interpreted(plant_step)
        for k, row in enumerate(given.tolist()):
            step(plant.plant, plant.rig, state, *row)
            angles[k] = state.x[n - 1]
    else:
        loop, step = new_loop(law, plant), interpreted(loop_step)
        loop.path.motion.scalars[:] = (law.load_gear * MOTION[0], *MOTION[1:])
        numbers = (law.observer, law.law, law.reference, law.torque_limit)
        for k, row in enumerate(given.tolist()):
            step(plant.plant, plant.rig, *numbers, loop, *row)
            angles[k] = loop.plant.x[n - 1]
    lines = [",".join([*inputs, "load_angle [rad]"])]
    lines += [",".join(f"{value:.17g}" for value in (*row, a)) for row, a in zip(given, angles, strict=True)]
    return "\n".join(lines) + "\n"
