"""A controller in single precision: coordinates in which it keeps its digits, and what the closed loop loses.

The angles of a drive are nearly equal, and a law lives on their differences. In single precision a
difference of two angles of 1 rad is known to 1e-7 rad, which a law that differentiates the load's angle up
to six times multiplies by 1e6 and more. Filter and law are therefore written in the first angle and in the
differences of successive ones, which are small and keep their own seven digits.
"""

from dataclasses import replace
from typing import Any

import numpy as np

from cabledrive.control.controller_kernels import new_target_state, path_row, start_target, target_step
from cabledrive.control.numbers import DARC, LINEAR, start_estimates
from cabledrive.export.blocks import needed_rise, path_state
from cabledrive.export.c99 import as_type, commands_of, self_test
from cabledrive.export.source import ExportSource, loop_on
from cabledrive.export.translation.source import interpreted
from cabledrive.parameters import InputRefused
from cabledrive.rig.closed_loop.loop_kernels import new_plant_state, plant_read, plant_step
from cabledrive.rig.laws.controller_file import ControllerFile
from cabledrive.rig.setting import Motion

ACCEPTED = 1.1
"""Largest ratio of the peak errors of the load in single and in double precision."""
PULSE = (8.0, 0.2, 0.05)
"""Angle [deg], rise and dwell [s] of the pulse along which it is measured, half a pulse long."""
MARGIN, TESTABLE = 2.0, 0.05
"""Tolerance of the self-test over the differences seen; its largest share of the largest command."""


def single_precision(source: ExportSource) -> tuple[ExportSource, float, float]:
    """The controller for single precision, the factor of its peak error, the self-test's tolerance [N m].

    It is tried on its plant; refused: a tenth more error than in double precision, or no drive.
    """
    law = differenced(source.law)
    factor = peak_error(source, law, np.float32) / peak_error(source, source.law, np.float64)
    if not factor <= ACCEPTED:
        said = f"float32: the peak error of {law.name} grows by a factor of {factor:.3g} in single precision"
        raise InputRefused(f"{said}, above {ACCEPTED}: export it in double precision")
    gap, largest = self_test_gap(law)
    if not MARGIN * gap <= TESTABLE * largest:
        raise InputRefused(
            f"float32: {law.name} amplifies rounding: on the same readings its commands differ by {gap:.3g} "
            f"of {largest:.3g} N m in single precision, which no self-test could separate from a mistake: "
            "export it in double precision"
        )
    note = (
        f"single precision: on the lumped plant the peak error of the load is {factor:.4f} times "
        f"that in double precision (refused above {ACCEPTED}); the self-test allows "
        f"{MARGIN * gap:.2g} N m"
    )
    return replace(source, law=law, notes=(*source.notes, note)), factor, MARGIN * gap


def differenced(law: ControllerFile) -> ControllerFile:
    """The same controller in the first angle and differences; a law of another kind is unchanged."""
    if law.law.kind not in (DARC, LINEAR):
        return law
    n = len(law.shafts)
    one = np.eye(n) - np.eye(n, k=-1)  # the first, then differences
    change = np.kron(np.eye(2), one)
    back = np.linalg.inv(change)
    seen, size = law.observer, law.observer.model.shape[0]
    wide = np.eye(size)
    wide[np.ix_(seen.chosen, seen.chosen)] = change
    wide_back = np.linalg.inv(wide)
    model = np.hstack((wide @ seen.model[:, :size] @ wide_back, wide @ seen.model[:, size:]))
    observer = seen._replace(
        model=model, output=seen.output @ wide_back, gains=wide @ seen.gains, scalars=seen.scalars
    )
    if law.law.kind == DARC:
        return replace(law, law=law.law._replace(matrix=law.law.matrix @ back), observer=observer)
    m = law.law.matrix.shape[0]
    matrix, rows = law.law.matrix.copy(), law.law.rows.copy()
    matrix[:, m : m + 2 * n] = matrix[:, m : m + 2 * n] @ back
    rows[:, m : m + 2 * n] = rows[:, m : m + 2 * n] @ back
    made = replace(law, law=law.law._replace(matrix=matrix, rows=rows), observer=observer)
    if law.reference is None:
        return made
    output, constant = law.reference.output.copy(), law.reference.constant.copy()
    output[: 2 * n], constant[: 2 * n] = change @ output[: 2 * n], change @ constant[: 2 * n]
    names = list(law.columns)
    for i in (*range(1, n), *range(n + 1, 2 * n)):
        names[i] = f"{law.columns[i].partition(' ')[0]} less {law.columns[i - 1]}"
    reference = law.reference._replace(output=output, constant=constant)
    return replace(made, reference=reference, columns=tuple(names))


def in_precision(law: ControllerFile, kind: Any) -> ControllerFile:
    """The numbers of a law rounded to a precision."""
    return replace(
        law, **{name: as_type(getattr(law, name), kind) for name in ("law", "observer", "reference")}
    )


def peak_error(source: ExportSource, law: ControllerFile, kind: Any) -> float:
    """Peak error of the load over a pulse [rad], the controller in a precision, the plant in double."""
    if source.drive is None or law.reference is None:
        raise InputRefused("float32 is tried on the plant, and no drive with a reference generator is given")
    angle, rise, dwell = PULSE
    order = needed_rise(law)
    motion = Motion(angle=angle, rise=rise, dwell=dwell, order=order)
    loop = loop_on(source, source.drive, motion, slack=False)
    rounded, rig = in_precision(law, kind), loop.rig
    plant, target = (
        new_plant_state(loop.plant, rig),
        new_target_state(law.observer, law.law, law.late_samples),
    )
    target, path = as_type(target, kind), as_type(path_state(law), kind)
    path.motion.scalars[:] = (law.load_gear * np.radians(angle), rise, dwell, 1)
    step, row_of, move, read = (interpreted(one) for one in (target_step, path_row, plant_step, plant_read))
    row, time, peak = np.zeros((1, len(law.columns)), dtype=kind), kind(rig.interval), 0.0
    read(rig, plant)
    interpreted(start_target)(start_estimates(law.law).astype(kind), target, plant.readings.astype(kind))
    for k in range(round((rise + dwell) / rig.interval)):
        read(rig, plant)
        peak = max(peak, abs(plant.x[loop.chain.size - 1] - loop.target[k]))
        row_of(rounded.reference, path, kind(k) * time, row[0])
        u, _ = step(
            rounded.observer, rounded.law, kind(law.torque_limit), target, plant.readings.astype(kind), row
        )
        move(loop.plant, rig, plant, float(u), 0.0, 0.0)
    return peak if np.isfinite(plant.x).all() else float("inf")


def self_test_gap(law: ControllerFile) -> tuple[float, float]:
    """Largest difference of the self-test's commands in single precision, and largest command [N m]."""
    exact = self_test(law)
    rounded, _ = commands_of(in_precision(law, np.float32), exact.readings, exact.references, np.float32)
    return float(np.max(np.abs(exact.commands - rounded))), float(np.max(np.abs(exact.commands)))
