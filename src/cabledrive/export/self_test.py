"""Readings, references and the commands that the interpreted kernels give: what the self-test replays."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from cabledrive.control.controller_kernels import PathState, path_row, start_target
from cabledrive.control.numbers import HIGH, LOW, SCHEDULED
from cabledrive.control.reference import NO_LOAD, new_reference_state
from cabledrive.export.block import samples_csv
from cabledrive.export.controller_block import needed_rise, path_state, target_kernel
from cabledrive.export.translation.source import interpreted
from cabledrive.rig.laws.controller_file import ControllerFile

Array = np.ndarray
SAMPLES, SEED = 1000, 20
DROPOUT, INFINITE = slice(500, 506), 700
RIPPLE = 0.5
"""Deviation of the readings from the wanted angle, in counts: more would keep the command at its limit."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Vectors:
    """Samples: ``readings`` (n, m) [rad], ``references`` (n, columns), ``commands`` and where kept (n,)."""

    readings: Array
    references: Array
    commands: Array
    held: Array

    def csv(self, encoders: tuple[str, ...], columns: tuple[str, ...]) -> str:
        """One line a sample, 17 digits a number, the command last."""
        heads = [*(f"{name}_encoder [rad]" for name in encoders), *columns, "command [N m]"]
        return samples_csv(heads, self.readings, self.references, self.commands)


def self_test(law: ControllerFile, samples: int = SAMPLES, seed: int = SEED) -> Vectors:
    """Samples of a pulse with rounded, rippled readings, an encoder dropout and an infinite reading.

    The readings follow the wanted angle and not a plant: the commands test the arithmetic, not the machine.
    """
    readings = rippled_readings(law, samples, np.random.default_rng(seed))
    references = references_of(law, samples)
    commands, held = commands_of(law, readings, references)
    return Vectors(readings=readings, references=references, commands=commands, held=held)


def pulse_numbers(law: ControllerFile, samples: int) -> tuple[float, float, float, int]:
    """Angle at the first shaft [rad], rise, dwell [s] and count of a pulse that fills most of the samples."""
    time = samples * law.sample_time
    return 0.02 * law.load_gear, 0.4 * time, 0.1 * time, 1


def started_path(law: ControllerFile, samples: int) -> PathState:
    """The generator at the start of that pulse."""
    path = path_state(law, needed_rise(law))
    path.motion.scalars[:] = pulse_numbers(law, samples)
    return path


def references_of(law: ControllerFile, samples: int) -> Array:
    """Rows of the law's own generator, by the interpreted kernel; of noise where the file has none."""
    rows = np.zeros((samples, len(law.columns)))
    if law.reference is None:
        return 1e-3 * np.random.default_rng(SEED).standard_normal(rows.shape)
    step, path = interpreted(path_row), started_path(law, samples)
    for k in range(samples):
        step(law.reference, path, k * law.sample_time, rows[k])
    if law.law.kind == SCHEDULED:
        rows[:, -1] = announced_loads(law, samples)
    return rows


def announced_loads(law: ControllerFile, samples: int) -> Array:
    """Loads that step from below the range of the design to above it and back, shape (samples,)."""
    low, high = law.law.learning[[LOW, HIGH], 0]
    loads = np.array([1.0, 0.8 * low, 0.5 * (1.0 + high), 1.2 * high, low, 0.7 + 0.3 * high])
    return np.asarray(loads[np.arange(samples) * len(loads) // samples])


def rippled_readings(law: ControllerFile, samples: int, generator: np.random.Generator) -> Array:
    """Encoder angles about the wanted one, in whole counts, shape (samples, m) [rad]."""
    wanted = wanted_angle(law, samples)
    counts = np.array(law.counts)
    ripple = RIPPLE * np.sin(np.outer(np.arange(samples) * 0.01, 1.0 + np.arange(len(counts))))
    noise = 0.1 * generator.uniform(-1.0, 1.0, (samples, len(counts)))
    readings: Array = counts * np.rint(wanted[:, None] / counts + ripple + noise)
    if samples > INFINITE:
        readings[DROPOUT, 0], readings[INFINITE, -1] = np.nan, np.inf
    return readings


def wanted_angle(law: ControllerFile, samples: int) -> Array:
    """The wanted load angle at the first shaft, shape (samples,) [rad]."""
    if law.reference is None:
        return np.zeros(samples)
    numbers = law.reference._replace(
        lags=np.zeros((0, 3)),
        sources=np.zeros(0, dtype=np.int64),
        output=np.ones((1, 1)),
        constant=np.zeros(1),
        friction=np.zeros((0, 2)),
        places=np.zeros((0, 2), dtype=np.int64),
        taps=np.array([[0.0, 1.0]]),
        load=NO_LOAD,
    )
    step, row = interpreted(path_row), np.zeros(1)
    path = started_path(law, samples)._replace(generator=new_reference_state(numbers))
    angles = np.zeros(samples)
    for k in range(samples):
        step(numbers, path, k * law.sample_time, row)
        angles[k] = row[0]
    return angles


def as_type(numbers: Any, kind: Any) -> Any:
    """A NamedTuple with its floating-point arrays in another precision, whatever is inside it."""
    changed = {}
    for name, part in numbers._asdict().items():
        if hasattr(part, "_asdict"):
            changed[name] = as_type(part, kind)
        elif isinstance(part, np.ndarray) and part.dtype.kind == "f":
            changed[name] = part.astype(kind)
        else:
            changed[name] = part
    return numbers._replace(**changed)


def commands_of(
    law: ControllerFile, readings: Array, references: Array, kind: Any = np.float64
) -> tuple[Array, Array]:
    """Commands [N m] of the interpreted kernels and where the last was kept; ``kind``: state's precision."""
    kernel = target_kernel(law)
    state, numbers = as_type(kernel.state, kind), kernel.numbers.values()
    readings, references = readings.astype(kind), references.astype(kind)
    interpreted(start_target)(kernel.begin.astype(kind), state, readings[0])
    step, limit = interpreted(kernel.step), kind(law.torque_limit)
    commands, held = np.zeros(len(readings)), np.zeros(len(readings), dtype=bool)
    for k, (y, row) in enumerate(zip(readings, references, strict=True)):
        commands[k], valid = step(*numbers, limit, state, y, row[None])
        held[k] = not valid
    return commands, held
