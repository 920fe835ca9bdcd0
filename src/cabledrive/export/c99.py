"""The C99 package of a controller, plant or loop: sources, self-test with its vectors, what a user needs.

The self-test replays readings, references and the commands that the interpreted kernels give.
"""

import json
from collections.abc import Sequence
from math import isfinite
from typing import Any, NamedTuple

import numpy as np

from cabledrive.control.controller_kernels import PathState, path_row, start_target
from cabledrive.control.numbers import HIGH, LOW, SCHEDULED
from cabledrive.control.reference_kernels import set_motion
from cabledrive.export import blocks
from cabledrive.export.source import NOTE, ExportSource, plant_loop
from cabledrive.export.translation.nodes import mentions
from cabledrive.export.translation.source import interpreted
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.drive_file import drive_text
from cabledrive.rig.closed_loop.loop_kernels import loop_step, new_plant_state, plant_step
from cabledrive.rig.laws.controller_file import ControllerFile

SAMPLES, SYSTEM_SAMPLES, SEED = 1000, 500, 20
DROPOUT, INFINITE = slice(500, 506), 700
RIPPLE = 0.5
"""Deviation of the readings from the wanted angle, in counts: more would keep the command at its limit."""
MOTION = (0.5, 0.03, 0.01, 1)
"""Of a system's self-test: load angle [rad], rise, dwell [s], pulses."""


def controller_package(source: ExportSource, tolerance: float | None = None) -> dict[str, str]:
    """Files of a controller in C99, by name; ``tolerance``: of one written for single precision [N m]."""
    block, law = blocks.controller_block(source, tolerance), source.law
    files = _packaged(source, block, "check.c.jinja", self_test(law).csv(law.encoders, law.columns))
    program, state, code = block.program, block.program.records["cd_law"], files[f"{block.file}.c"]
    size = 4 if program.precision.single else 8

    def held(array: Array) -> int:
        return array.size * (size if array.dtype.kind == "f" else 4)

    hertz = "" if law.bandwidth is None else f"Bandwidth {law.bandwidth:.4g} Hz. "
    readme = block.rendered(
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
    return files | {"README.md": readme}


def system_package(source: ExportSource, what: str) -> dict[str, str]:
    """Files of a plant or loop in C99, by name; its self-test pushes it by random torques."""
    inputs = ("u [N m]", "motor_torque [N m]", "load_torque [N m]")[what == "loop" :]
    block, law, plant = blocks.system_block(source, what), source.law, plant_loop(source)
    strength = np.array([0.3, 0.02, 0.02])[-len(inputs) :]
    noise = np.random.default_rng(SEED).standard_normal((SYSTEM_SAMPLES // 10, len(inputs)))
    torques = np.repeat(strength * noise, 10, axis=0)
    numbers: tuple[Any, ...] = (plant.plant, plant.rig)
    state: Any = new_plant_state(*numbers) if what == "plant" else blocks.new_loop(law, plant)
    step, moved = interpreted(plant_step), state
    if what == "loop":
        step, moved = interpreted(loop_step), state.plant
        state.path.motion.scalars[:] = (law.load_gear * MOTION[0], *MOTION[1:])
        numbers = (*numbers, law.observer, law.law, law.reference, law.torque_limit)
    angles = np.zeros(SYSTEM_SAMPLES)
    for k, row in enumerate(torques.tolist()):
        step(*numbers, state, *row)
        angles[k] = moved.x[plant.chain.size - 1]
    vectors = samples_csv([*inputs, "load_angle [rad]"], torques, angles)
    words = {"inputs": len(inputs), "motion": [repr(v) for v in MOTION]}
    files = _packaged(source, block, "check_system.c.jinja", vectors, **words)
    return files | {"README.md": block.rendered("README_system.md.jinja", note=NOTE)}


def _packaged(
    source: ExportSource, block: blocks.Block, check: str, vectors: str, **words: Any
) -> dict[str, str]:
    files = block.code() | {
        "check.c": block.rendered(check, **words),
        "vectors.csv": vectors,
        "controller.json": json.dumps(source.data, indent=1, allow_nan=False) + "\n",
    }
    return files if source.drive is None else files | {"drive.toml": drive_text(source.drive.axis.machine)}


def samples_csv(heads: Sequence[str], *columns: Array) -> str:
    """One line a sample, 17 digits a number."""
    rows = np.column_stack(columns).tolist()
    lines = [",".join(f"{value:.17g}" for value in row) for row in rows]
    return "\n".join([",".join(heads), *lines]) + "\n"


class Vectors(NamedTuple):
    """Samples: ``readings`` (n, m) [rad], ``references`` (n, columns), ``commands`` (n,) [N m]."""

    readings: Array
    references: Array
    commands: Array

    def csv(self, encoders: tuple[str, ...], columns: tuple[str, ...]) -> str:
        """One line a sample, 17 digits a number, the command last."""
        heads = [*(f"{name}_encoder [rad]" for name in encoders), *columns, "command [N m]"]
        return samples_csv(heads, *self)


def self_test(law: ControllerFile, samples: int = SAMPLES) -> Vectors:
    """Samples of a pulse with rounded, rippled readings, an encoder dropout and an infinite reading.

    The readings follow the wanted angle and not a plant: the commands test the arithmetic, not the machine.
    """
    readings = rippled_readings(law, samples, np.random.default_rng(SEED))
    references = references_of(law, samples)
    return Vectors(readings, references, commands_of(law, readings, references)[0])


def started_path(law: ControllerFile, samples: int) -> PathState:
    """The generator at the start of a pulse that fills most of the samples."""
    path, time = blocks.path_state(law), samples * law.sample_time
    path.motion.scalars[:] = (0.02 * law.load_gear, 0.4 * time, 0.1 * time, 1)
    return path


def references_of(law: ControllerFile, samples: int) -> Array:
    """Rows of the law's own generator, by the interpreted kernel; of noise where the file has none."""
    rows = np.zeros((samples, len(law.columns)))
    if law.reference is None:
        return 1e-3 * np.random.default_rng(SEED).standard_normal(rows.shape)
    step, path = interpreted(path_row), started_path(law, samples)
    for k in range(samples):
        step(law.reference, path, k * law.sample_time, rows[k])
    if law.law.kind == SCHEDULED:  # loads from below the range of the design to above it and back
        low, high = law.law.learning[[LOW, HIGH], 0]
        loads = np.array([1.0, 0.8 * low, 0.5 * (1.0 + high), 1.2 * high, low, 0.7 + 0.3 * high])
        rows[:, -1] = loads[np.arange(samples) * len(loads) // samples]
    return rows


def rippled_readings(law: ControllerFile, samples: int, generator: np.random.Generator) -> Array:
    """Encoder angles about the wanted one, in whole counts, shape (samples, m) [rad]."""
    wanted = np.zeros((samples, 1))  # load angle at the first shaft [rad]
    if law.reference is not None:
        move, motion = interpreted(set_motion), started_path(law, samples).motion
        for k in range(samples):
            move(motion.coefficients, motion.scalars, k * law.sample_time, wanted[k])
    counts = np.array(law.counts)
    ripple = RIPPLE * np.sin(np.outer(np.arange(samples) * 0.01, 1.0 + np.arange(len(counts))))
    noise = 0.1 * generator.uniform(-1.0, 1.0, (samples, len(counts)))
    readings: Array = counts * np.rint(wanted / counts + ripple + noise)
    if samples > INFINITE:
        readings[DROPOUT, 0], readings[INFINITE, -1] = np.nan, np.inf
    return readings


def as_type(numbers: Any, kind: Any) -> Any:
    """A NamedTuple with its floating-point arrays in another precision, whatever is inside it."""
    if hasattr(numbers, "_asdict"):
        return numbers._make(as_type(part, kind) for part in numbers)
    floating = isinstance(numbers, np.ndarray) and numbers.dtype.kind == "f"
    return numbers.astype(kind) if floating else numbers


def commands_of(
    law: ControllerFile, readings: Array, references: Array, kind: Any = np.float64
) -> tuple[Array, Array]:
    """Commands [N m] of the interpreted kernels and where the last was kept; ``kind``: state's precision."""
    kernel = blocks.target_kernel(law)
    state, numbers = as_type(kernel.state, kind), kernel.numbers.values()
    readings, references = readings.astype(kind), references.astype(kind)
    interpreted(start_target)(kernel.begin.astype(kind), state, readings[0])
    step, limit = interpreted(kernel.step), kind(law.torque_limit)
    commands, held = np.zeros(len(readings)), np.zeros(len(readings), dtype=bool)
    for k, (y, row) in enumerate(zip(readings, references, strict=True)):
        commands[k], valid = step(*numbers, limit, state, y, row[None])
        held[k] = not valid
    return commands, held
