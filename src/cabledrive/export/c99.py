"""The C99 package of a controller, plant or loop: sources, self-test with its vectors, what a user needs."""

import json
from dataclasses import replace
from math import isfinite
from typing import Any

import numpy as np

from cabledrive.export.block import Block, samples_csv, templates
from cabledrive.export.controller_block import controller_block
from cabledrive.export.self_test import self_test
from cabledrive.export.single_precision import SinglePrecision
from cabledrive.export.source import NOTE, ExportSource, plant_loop
from cabledrive.export.system_block import new_loop, system_block
from cabledrive.export.translation.nodes import mentions
from cabledrive.export.translation.source import interpreted
from cabledrive.parameters.drive_file import drive_text
from cabledrive.rig.closed_loop.loop_kernels import loop_step, new_plant_state, plant_step

SAMPLES, SEED = 500, 20
MOTION = (0.5, 0.03, 0.01, 1)
"""Of a system's self-test: load angle [rad], rise, dwell [s], pulses."""


def controller_package(source: ExportSource, single: SinglePrecision | None = None) -> dict[str, str]:
    """Files of a controller in C99, by name; ``single``: written for single precision."""
    if single:
        source = replace(source, law=single.law, notes=(*source.notes, single.note))
    block, law = controller_block(source, single.tolerance if single else None), source.law
    vectors = self_test(law).csv(law.encoders, law.columns)
    code, check = block.code(), templates().get_template("check.c.jinja").render()
    return _packaged(source, code, check, vectors) | {"README.md": _readme(block, code[f"{block.file}.c"])}


def _packaged(source: ExportSource, code: dict[str, str], check: str, vectors: str) -> dict[str, str]:
    files = code | {
        "check.c": check,
        "vectors.csv": vectors,
        "controller.json": json.dumps(source.data, indent=1, allow_nan=False) + "\n",
    }
    return files if source.drive is None else files | {"drive.toml": drive_text(source.drive)}


def _readme(block: Block, code: str) -> str:
    law, program, state = block.words["law"], block.program, block.words["state"]
    size = 4 if program.precision.single else 8

    def held(array: np.ndarray) -> int:
        return array.size * (size if array.dtype.kind == "f" else 4)

    hertz = "" if law.bandwidth is None else f"Bandwidth {law.bandwidth:.4g} Hz. "
    return block.rendered(
        "README.md.jinja",
        counts=list(zip(law.encoders, law.counts, strict=True)),
        settings=hertz + f"Sample time {law.sample_time:g} s.",
        limit=f"{law.torque_limit:.6g} N m"
        if isfinite(law.torque_limit)
        else "no bound (the drive has no limit)",
        notes=block.notes,
        state_bytes=sum(held(part) for part in (*state.controller, *state[1:])),
        table_bytes=sum(held(array) for name, (array, _) in program.tables.items() if mentions(code, name)),
    )


def system_package(source: ExportSource, what: str) -> dict[str, str]:
    """Files of a plant or loop in C99, by name."""
    inputs = ("u [N m]", "motor_torque [N m]", "load_torque [N m]")[what == "loop" :]
    block = system_block(source, what)
    check = block.rendered("check_system.c.jinja", inputs=len(inputs), motion=[repr(v) for v in MOTION])
    files = _packaged(source, block.code(), check, _system_vectors(source, what, inputs))
    return files | {"README.md": block.rendered("README_system.md.jinja", note=NOTE)}


def _system_vectors(source: ExportSource, what: str, inputs: tuple[str, ...]) -> str:
    """Random torques, and the load angles that the interpreted kernels give."""
    law, plant = source.law, plant_loop(source)
    generator = np.random.default_rng(SEED)
    strength = np.array([0.3, 0.02, 0.02])[-len(inputs) :]
    given = np.repeat(strength * generator.standard_normal((SAMPLES // 10, len(inputs))), 10, axis=0)
    numbers: tuple[Any, ...] = (plant.plant, plant.rig)
    state: Any = new_plant_state(*numbers) if what == "plant" else new_loop(law, plant)
    step, moved = interpreted(plant_step), state
    if what == "loop":
        step, moved = interpreted(loop_step), state.plant
        state.path.motion.scalars[:] = (law.load_gear * MOTION[0], *MOTION[1:])
        numbers = (*numbers, law.observer, law.law, law.reference, law.torque_limit)
    angles = np.zeros(SAMPLES)
    for k, row in enumerate(given.tolist()):
        step(*numbers, state, *row)
        angles[k] = moved.x[plant.chain.size - 1]
    return samples_csv([*inputs, "load_angle [rad]"], given, angles)
