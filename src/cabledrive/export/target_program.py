"""The controller of a design as a program in C: kernels specialised to it, its frozen numbers, its state."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from cabledrive.control.reference_numbers import MotionNumbers, new_reference_state
from cabledrive.control.target_kernels import PathState, path_row
from cabledrive.export.target_kernel import target_kernel
from cabledrive.export.translation.literals import Precision
from cabledrive.export.translation.program import Program, Translated
from cabledrive.export.translation.types import REAL, Scalar, Value, View
from cabledrive.parameters import NotComputed
from cabledrive.rig.laws.controller_file import ControllerFile
from cabledrive.trajectories import rise_coefficients


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TargetProgram:
    """A translated controller.

    ``step``: its kernel; ``start_call``, ``step_call``, ``row_call``: calls in the API's own names.
    """

    program: Program
    step: Translated
    start_call: str
    step_call: str
    row_call: str
    state: Any


def columns_of(law: ControllerFile) -> int:
    """Columns of the law's reference."""
    return len(law.columns)


def target_program(law: ControllerFile, precision: Precision | None = None) -> TargetProgram:
    """Translate a file's controller and its generator; refused if a user's step leaves the subset."""
    program, kernel = Program(precision), target_kernel(law)
    readings, columns = len(law.encoders), columns_of(law)
    c = program.state("cd_law", "law", kernel.state)
    numbers = [program.frozen(name, part) for name, part in kernel.numbers.items()]
    y = Value("y", View(REAL, (readings,)))
    program.tables["START"] = (kernel.begin, "estimates or memory to begin with")
    start = Value("START", View(REAL, (len(kernel.begin),)))
    limit = Value(program.precision.literal(law.torque_limit), Scalar(REAL))
    ref = Value("ref", View(REAL, (1, columns)))
    began, start_call = program.root(kernel.start, [start, c, y])
    step, step_call = program.root(kernel.step, [*numbers, limit, c, y, ref])
    if not (began.written and step.written):
        raise NotComputed("the controller keeps no state: its kernels are not those of a target")
    row_call = ""
    if law.reference is not None:
        row_call = _generator(program, law)
    return TargetProgram(
        program=program,
        step=step,
        start_call=start_call,
        step_call=step_call,
        row_call=row_call,
        state=kernel.state,
    )


def _generator(program: Program, law: ControllerFile) -> str:
    """Translate the reference generator; returns its call."""
    assert law.reference is not None
    order = needed_rise(law)
    program.tables["RISE"] = (
        np.array(rise_coefficients(order)),
        f"rise of order {order} in powers of t / rise",
    )
    path = program.state("cd_reference", "path", path_state(law, order))
    numbers = program.frozen("reference", law.reference)
    row = Value("ref", View(REAL, (columns_of(law),)))
    _, call = program.root(path_row, [numbers, path, Value("time", Scalar(REAL)), row])
    return call


def needed_rise(law: ControllerFile) -> int:
    """Least odd order of a rise whose derivatives that the law takes do not jump, and at least 9."""
    assert law.reference is not None
    return max(9, 2 * law.reference.derivatives - 1)


def path_state(law: ControllerFile, order: int) -> PathState:
    """A motion and its generator, at rest."""
    assert law.reference is not None
    motion = MotionNumbers(coefficients=np.array(rise_coefficients(order)), scalars=np.zeros(4))
    return PathState(motion=motion, generator=new_reference_state(law.reference))
