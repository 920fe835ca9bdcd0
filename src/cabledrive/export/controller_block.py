"""The controller of a design as a program in C, specialised to it."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cabledrive.control.controller_kernels import (
    PathState,
    new_target_state,
    own_target_step,
    path_row,
    start_target,
    target_step,
)
from cabledrive.control.numbers import start_estimates
from cabledrive.control.own_controller import stepped
from cabledrive.control.reference import MotionNumbers, new_reference_state
from cabledrive.export.block import Block, given, output
from cabledrive.export.source import ExportSource
from cabledrive.export.translation.nodes import REAL, Precision, Scalar, Value, View
from cabledrive.export.translation.program import Program
from cabledrive.parameters import InputRefused, NotComputed
from cabledrive.rig.laws.controller_file import ControllerFile
from cabledrive.trajectories import rise_coefficients

Array = np.ndarray
GAINS = "numbers, arrays, or a tuple or NamedTuple of them"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TargetKernel:
    """Step of a controller, frozen numbers by name, a state before the start, values to begin with."""

    step: Callable[..., tuple[float, bool]]
    numbers: dict[str, Any]
    state: Any
    begin: Array


def target_kernel(law: ControllerFile) -> TargetKernel:
    """The kernels of a controller; refused: a user's gains that are no numbers, a step that returns none."""
    if law.own is None:
        return TargetKernel(
            step=target_step,
            numbers={"observer": law.observer, "law": law.law},
            state=new_target_state(law.observer, law.law, law.late_samples),
            begin=start_estimates(law.law),
        )
    begin, filtered = np.array(law.own.initial_state, dtype=np.float64), law.own.measures == "states"
    gains = as_numbers(law.own.gains, law.name)
    seen = len(law.observer.chosen if filtered else law.observer.output)
    tried = replace(law.own, gains=gains)
    stepped(tried, begin.copy(), np.zeros(seen), np.zeros(len(law.columns)), "when it was tried on zeros")
    return TargetKernel(
        step=own_target_step(law.own.step, filtered),
        numbers={"observer": law.observer, "own_numbers": gains},
        state=new_target_state(law.observer, law.law, law.late_samples, (len(begin), seen, len(law.columns))),
        begin=begin,
    )


def as_numbers(gains: Any, name: str) -> Any:
    """Gains of a controller of the user's own as a number, an array, or a NamedTuple of them."""
    if hasattr(gains, "_asdict"):
        return gains._replace(**{key: as_numbers(part, name) for key, part in gains._asdict().items()})
    if isinstance(gains, bool | int):
        return gains
    try:
        array = np.array(gains)
    except (TypeError, ValueError):
        array = np.array(None)
    if array.dtype.kind not in "iuf":
        raise InputRefused(f'controller "{name}": its gains cannot be exported: give {GAINS}')
    if array.dtype.kind == "f" and array.ndim == 0:
        return float(array)
    return array.astype(np.float64) if isinstance(gains, tuple | list) or array.dtype.kind == "f" else array


def controller_block(source: ExportSource, tolerance: float | None = None) -> Block:
    """Translate a controller and its generator; refused if a user's step leaves the subset.

    ``tolerance``: of the self-test of one in single precision [N m].
    """
    law, program = source.law, Program(Precision(single=tolerance is not None))
    kernel, literal = target_kernel(law), program.precision.literal
    c = program.state("cd_law", "law", kernel.state)
    numbers = [program.frozen(name, part) for name, part in kernel.numbers.items()]
    y = Value("y", View(REAL, (len(law.encoders),)))
    program.tables["START"] = (kernel.begin, "estimates or memory to begin with")
    start = Value("START", View(REAL, (len(kernel.begin),)))
    limit = Value(literal(law.torque_limit), Scalar(REAL))
    ref = Value("ref", View(REAL, (1, len(law.columns))))
    began, start_call = program.root(start_target, [start, c, y])
    step, step_call = program.root(kernel.step, [*numbers, limit, c, y, ref])
    if not (began.written and step.written):
        raise NotComputed("the controller keeps no state: its kernels are not those of a target")
    named, generated = source.drive, law.reference is not None
    return Block(
        what="controller",
        drive=named.name if named is not None else "drive",
        title=f"{(named.title or named.name) if named is not None else 'controller'}: {law.name}",
        interval=law.sample_time,
        program=program,
        words={
            "caution": source.c_caution,
            "law": law,
            "encoders": law.encoders,
            "columns": law.columns,
            "counts": [literal(count) for count in law.counts],
            "single": program.precision.single,
            "tolerance": f"{tolerance:.3g}" if tolerance else "0.0",
            "generator": generated,
            "order": needed_rise(law) if generated else 0,
            "step": step,
            "start_call": start_call,
            "step_call": step_call,
            "row_call": _generator(program, law) if generated else "",
            "state": kernel.state,
            "shafts": (),
        },
        variables=[
            *(given(f"{name}_encoder", "rad", "angle read") for name in law.encoders),
            *(given(f"ref_{i}", "", column) for i, column in enumerate(law.columns)),
            *COMMANDED,
        ],
        notes=list(source.notes),
    )


COMMANDED = (
    output("command", "N.m", "limited command"),
    output("kept", "", "1 where the last command was kept"),
)


def _generator(program: Program, law: ControllerFile) -> str:
    """Translate the reference generator; returns its call."""
    order = needed_rise(law)
    program.tables["RISE"] = (
        np.array(rise_coefficients(order)),
        f"rise of order {order} in powers of t / rise",
    )
    path = program.state("cd_reference", "path", path_state(law, order))
    numbers = program.frozen("reference", law.reference)
    row = Value("ref", View(REAL, (len(law.columns),)))
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
