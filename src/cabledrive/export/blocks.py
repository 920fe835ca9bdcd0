"""What is translated: the controller of a design, its plant, the loop of both, the cable in modes."""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from math import pi
from typing import Any, NamedTuple

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined

from cabledrive.control import controller_kernels as control
from cabledrive.control.numbers import start_estimates
from cabledrive.control.own_controller import stepped
from cabledrive.control.reference import MotionNumbers, new_reference_state
from cabledrive.export.source import NOTE, ExportSource, plant_loop
from cabledrive.export.translation.nodes import REAL, Precision, Scalar, Value, View, mentions
from cabledrive.export.translation.program import Program
from cabledrive.mechanics.network import network_of
from cabledrive.modal.mode import LONGITUDINAL
from cabledrive.modal.natural import straight_limit
from cabledrive.parameters import InputRefused, Machine, NotComputed, content_hash
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.version import __version__
from cabledrive.reduction.modal_cable import ModalCable, modal_cable
from cabledrive.reduction.stretch_kernels import (
    cable_middle,
    cable_motion,
    cable_step,
    cable_tension,
    start_cable,
)
from cabledrive.reduction.stretches import new_stretch_state
from cabledrive.rig.closed_loop.loop import Loop
from cabledrive.rig.closed_loop.loop_kernels import (
    LoopTarget,
    loop_step,
    new_plant_state,
    plant_read,
    plant_step,
)
from cabledrive.rig.laws.controller_file import ControllerFile
from cabledrive.trajectories.limits import rise_coefficients

SHELLS = {"controller": "law", "plant": "system", "loop": "system", "cable": "cable"}
TEMPLATES = Environment(
    loader=PackageLoader("cabledrive.export"), undefined=StrictUndefined, keep_trailing_newline=True
)
"""The shells around translated kernels, and models in other languages."""


class Variable(NamedTuple):
    """A variable of an FMU: ``causality`` "input", "output" or "parameter"; ``unit`` may be empty."""

    causality: str
    name: str
    unit: str
    about: str
    start: float = 0.0


given, output, parameter = (partial(Variable, causality) for causality in ("input", "output", "parameter"))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Block:
    """A controller, a plant, the loop of both, or a cable."""

    what: str  # key of `SHELLS`
    drive: str  # name of its drive
    title: str
    interval: float  # from one step to the next [s]
    program: Program
    words: Mapping[str, Any]  # what its templates name
    variables: list[Variable]  # in the order of their reference numbers
    notes: list[str]

    @property
    def file(self) -> str:
        """Name of its header and source, without the ending."""
        return f"cabledrive_{'law' if self.what == 'controller' else self.what}"

    def rendered(self, template: str, **more: Any) -> str:
        """A template in the block's words."""
        precision = self.program.precision
        words = {
            "what": self.what,
            "title": self.title,
            "version": __version__,
            "literal": precision.literal,
            "single": precision.single,
        }
        return TEMPLATES.get_template(template).render(words | dict(self.words) | more)

    def code(self) -> dict[str, str]:
        """Header and source, with the few functions below the kernels that these use."""
        program, shell = self.program, SHELLS[self.what]
        functions = program.functions()
        runtime = self.rendered("runtime.c.jinja", used=lambda name: mentions(functions, name))
        words = {"structs": program.structs(), "functions": functions, "runtime": runtime}
        tables = program.used_tables(self.rendered(f"{shell}.c.jinja", tables="", **words))
        return {
            f"{self.file}.{kind}": self.rendered(f"{shell}.{kind}.jinja", tables=tables, **words)
            for kind in ("h", "c")
        }


GAINS = "numbers, arrays, or a tuple or NamedTuple of them"
COMMANDED = (
    output("command", "N.m", "limited command"),
    output("kept", "", "1 where the last command was kept"),
)
TORQUES = [given(f"{on}_torque", "N.m", f"disturbance on the {on}") for on in ("motor", "load")]
MOTION = [
    parameter("angle", "rad", "of the load, there and back", 0.5),
    parameter("rise", "s", "time of a move", 0.5),
    parameter("dwell", "s", "rest after a move", 0.5),
    parameter("pulses", "", "how many", 1.0),
]


def _named(name: str, *shape: int) -> Value:
    """An argument of a kernel as the shell calls it: an array, without a shape a number."""
    return Value(name, View(REAL, shape) if shape else Scalar(REAL))


class TargetKernel(NamedTuple):
    """Step of a controller, frozen numbers by name, a state before the start, values to begin with."""

    step: Callable[..., tuple[float, bool]]
    numbers: dict[str, Any]
    state: Any
    begin: Array


def target_kernel(law: ControllerFile) -> TargetKernel:
    """The kernels of a controller; refused: a user's gains that are no numbers, a step that returns none."""
    if law.own is None:
        state = control.new_target_state(law.observer, law.law, law.late_samples)
        numbers = {"observer": law.observer, "law": law.law}
        return TargetKernel(control.target_step, numbers, state, start_estimates(law.law))
    begin, filtered = np.array(law.own.initial_state, dtype=np.float64), law.own.measures == "states"
    gains = as_numbers(law.own.gains, law.name)
    seen = len(law.observer.chosen if filtered else law.observer.output)
    tried = replace(law.own, gains=gains)
    stepped(tried, begin.copy(), np.zeros(seen), np.zeros(len(law.columns)), "when it was tried on zeros")
    sizes = (len(begin), seen, len(law.columns))
    state = control.new_target_state(law.observer, law.law, law.late_samples, sizes)
    numbers = {"observer": law.observer, "own_numbers": gains}
    return TargetKernel(control.own_target_step(law.own.step, filtered), numbers, state, begin)


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


def _of_law(
    source: ExportSource, what: str, program: Program, variables: Sequence[Variable], **words: Any
) -> Block:
    """A block in which a law's numbers stand, its controller or its plant."""
    law, drive = source.law, source.drive
    caution = "" if what == "plant" else source.caution.replace("*/", "* /").replace("/*", "/ *")
    return Block(
        what=what,
        drive=drive.name if drive is not None else "drive",
        title=f"{(drive.title or drive.name) if drive is not None else 'controller'}: "
        f"{law.name if what == 'controller' else what}",
        interval=law.sample_time,
        program=program,
        words=words | {"law": law, "caution": " ".join(caution.split())},
        variables=[*variables],
        notes=[*source.notes, *([] if what == "controller" else [NOTE])],
    )


def controller_block(source: ExportSource, tolerance: float | None = None) -> Block:
    """Translate a controller and its generator; refused if a user's step leaves the subset.

    ``tolerance``: of the self-test of one in single precision [N m].
    """
    law, program = source.law, Program(Precision(single=tolerance is not None))
    kernel = target_kernel(law)
    c = program.state("cd_law", "law", kernel.state)
    numbers = [program.frozen(name, part) for name, part in kernel.numbers.items()]
    y = _named("y", len(law.encoders))
    program.tables["START"] = (kernel.begin, "estimates or memory to begin with")
    limit = _named(program.precision.literal(law.torque_limit))
    began, start_call = program.root(control.start_target, [_named("START", len(kernel.begin)), c, y])
    step, step_call = program.root(kernel.step, [*numbers, limit, c, y, _named("ref", 1, len(law.columns))])
    if not (began.written and step.written):
        raise NotComputed("the controller keeps no state: its kernels are not those of a target")
    words = {"step": step, "start_call": start_call, "step_call": step_call}
    if law.reference is not None:
        order = needed_rise(law)
        program.tables["RISE"] = (
            np.array(rise_coefficients(order)),
            f"rise of order {order} in powers of t / rise",
        )
        path = program.state("cd_reference", "path", path_state(law))
        reference, row = program.frozen("reference", law.reference), _named("ref", len(law.columns))
        _, row_call = program.root(control.path_row, [reference, path, _named("time"), row])
        words |= {"order": order, "row_call": row_call}
    variables = [
        *(given(f"{name}_encoder", "rad", "angle read") for name in law.encoders),
        *(given(f"ref_{i}", "", column) for i, column in enumerate(law.columns)),
        *COMMANDED,
    ]
    allowed = f"{tolerance:.3g}" if tolerance else "0.0"
    return _of_law(source, "controller", program, variables, tolerance=allowed, **words)


def needed_rise(law: ControllerFile) -> int:
    """Order of the rises of a law's study; else the least odd one without jumps, and at least 9."""
    assert law.reference is not None
    return law.order or max(9, 2 * law.reference.derivatives - 1)


def path_state(law: ControllerFile) -> control.PathState:
    """A motion and its generator, at rest."""
    assert law.reference is not None
    motion = MotionNumbers(np.array(rise_coefficients(needed_rise(law))), scalars=np.zeros(4))
    return control.PathState(motion=motion, generator=new_reference_state(law.reference))


def new_loop(law: ControllerFile, plant: Loop) -> LoopTarget:
    """A closed loop at rest, before a motion is given."""
    target = control.new_target_state(law.observer, law.law, law.late_samples)
    target.datum[:] = np.nan
    start = start_estimates(law.law)
    target.controller.parameters[: len(start)] = start
    return LoopTarget(
        plant=new_plant_state(plant.plant, plant.rig),
        target=target,
        path=path_state(law),
        row=np.zeros((1, len(law.columns))),
        sample=np.zeros(1, dtype=np.int64),
    )


def system_block(source: ExportSource, what: str) -> Block:
    """The plant, or the loop of plant and controller, translated."""
    law, plant, program = source.law, plant_loop(source), Program()
    shafts, closed = plant.chain.names, what == "loop"
    system, rig = (program.frozen(name, getattr(plant, name)) for name in ("plant", "rig"))
    torques = [_named(one.name) for one in TORQUES]
    words: dict[str, Any] = {"shafts": shafts, "at": "loop->plant." if closed else "plant->"}
    if not closed:
        inner = program.state("cd_plant", "plant", new_plant_state(plant.plant, plant.rig))
        step, step_call = program.root(plant_step, [system, rig, inner, _named("u"), *torques])
    else:
        state = program.state("cd_loop", "loop", new_loop(law, plant))
        parts = {"observer": law.observer, "law": law.law, "reference": law.reference}
        numbers = [program.frozen(name, part) for name, part in parts.items()]
        limit = _named(program.precision.literal(law.torque_limit))
        step, step_call = program.root(loop_step, [system, rig, *numbers, limit, state, *torques])
        inner, start, order = program.part(state, "plant"), start_estimates(law.law), needed_rise(law)
        program.tables["START"] = (start, "estimates to begin with")
        program.tables["RISE"] = (np.array(rise_coefficients(order)), "rise in powers of t / rise")
        words |= {"start_size": start.size, "order": order}
    _, read_call = program.root(plant_read, [rig, inner])
    shown = [output(f"{name}_encoder", "rad", "angle read") for name in law.encoders]
    for unit, motion in (("rad", "angle"), ("rad/s", "speed")):
        shown += [output(f"{one}_{motion}", unit, f"true {motion} of the {one}") for one in shafts]
    shown.append(output("slip", "", "1, -1: the motor slips; 0: sticks"))
    wanted = output("wanted", "rad", "wanted load angle of the last sample")
    asked = given("command", "N.m", "torque asked of the motor")
    variables = [*MOTION, *TORQUES, *COMMANDED, wanted, *shown] if closed else [asked, *TORQUES, *shown]
    calls = {"step": step, "step_call": step_call, "read_call": read_call}
    return _of_law(source, what, program, variables, **calls, **words)


def cable_block(machine: Machine) -> Block:
    """The cable of a drive, translated; refused: two parts whose names are one in C."""
    cable, program = modal_cable(machine), Program()
    state = program.state("cd_cable", "cable", new_stretch_state(cable.numbers))
    frozen = program.frozen("numbers", cable.numbers)
    spans, motions = len(cable.spans), len(cable.motions)
    tensions = _named("tensions", spans)
    kernels: dict[str, tuple[Any, list[Value]]] = {
        "start": (start_cable, [_named("plucks", spans if cable.sine else 0), state]),
        "step": (cable_step, [frozen, state, _named("inputs", len(cable.inputs)), tensions]),
        "tension": (cable_tension, [frozen, state, tensions]),
        "motion": (cable_motion, [frozen, state, _named("places", motions), _named("speeds", motions)]),
    }
    if cable.sine:
        kernels["middle"] = (cable_middle, [frozen, state, _named("middles", spans)])
    calls = {name: program.root(kernel, values)[1] for name, (kernel, values) in kernels.items()}
    groups, variables, places = _variables(cable), list[Variable](), dict[str, int]()
    left_out = list[str]()
    if any(part.capstan_friction for part in machine.pulley):
        left_out.append("ropes do not slip: capstan_friction is left out")
    if not cable.sine:  # ropes are straight in the linear model
        rubbing: tuple[Any, ...] = (*machine.body, *machine.pulley, *machine.motor)
        left_out.append("pulleys turn anticlockwise, ropes move along their path: not the senses of a plant")
        if any(part.coulomb_friction > 0.0 for part in rubbing):
            left_out.append("Coulomb friction is left out")
        if sag := straight_limit(network_of(machine), 2.0 * pi * cable.highest, kind=LONGITUDINAL):
            left_out.append(sag)
    for name, group in groups.items():
        places[name] = len(variables) if group else 0
        variables += group
    if len({one.name for one in variables}) != len(variables):
        raise InputRefused("two parts of the machine have names that are one in C: rename one")
    return Block(
        what="cable",
        drive=machine.name,
        title=f"{machine.title or machine.name}: cable in modes",
        interval=cable.interval,
        program=program,
        words={"hash": content_hash(machine), "cable": cable, "calls": calls, "places": places},
        variables=variables,
        notes=[*_notes(cable), *left_out],
    )


def _variables(cable: ModalCable) -> dict[str, list[Variable]]:
    """Inputs, parameters and outputs, group by group in the order of their reference numbers."""

    def name(part: str) -> str:
        return re.sub(r"\W+", "_", part)

    turns = {True: "angle", False: "position"}
    plucked = cable.spans if cable.sine else ()
    tension = "mean tension of the span" if cable.sine else "least tension at rest, and how its mean changed"
    return {
        "inputs": [given(name(one), unit, one) for one, unit in cable.inputs],
        "plucks": [parameter(f"pluck_{name(s)}", "m", "half sine at the start, in w") for s in plucked],
        "motions": [output(f"{name(one)}_{turns[unit == 'rad']}", unit, one) for one, unit in cable.motions],
        "speeds": [output(f"{name(one)}_speed", f"{u}/s", f"speed of {one}") for one, u in cable.motions],
        "tensions": [output(f"{name(s)}_tension", "N", tension) for s in cable.spans],
        "middles": [output(f"{name(s)}_middle", "m", "displacement of the middle, in w") for s in plucked],
        "holds": [output("holds", "", "1 while the model holds, then 0")],
    }


def _notes(cable: ModalCable) -> list[str]:
    """What a user has to know of an exported cable."""
    kind = (
        "the fast model of the loop (uniform tension in each span, spans vibrating in the plane w)"
        if cable.sine
        else "linear modes of the network about its state of rest"
    )
    steep = " or steeper than the model allows" if cable.sine else ""
    return [
        f"{kind}: {cable.numbers.model.natural.size} modes along, up to {cable.highest:.4g} Hz; "
        f"inputs are held over a step of {cable.interval:g} s",
        f'output "holds" becomes 0, and each further step a warning, once a span has gone slack{steep}',
    ]
