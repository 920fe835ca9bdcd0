"""A distributed cable in modes as C: the sources of its FMU."""

import re
from dataclasses import dataclass
from typing import Any

from cabledrive.export.target_program import runtime_text, templates
from cabledrive.export.translation.nodes import REAL, Value, View
from cabledrive.export.translation.program import Program
from cabledrive.parameters import Drive, content_hash
from cabledrive.parameters.route.drive import RoutedDrive
from cabledrive.parameters.version import __version__
from cabledrive.reduction.modal_cable import ModalCable
from cabledrive.reduction.modal_cable_kernels import (
    cable_middle,
    cable_motion,
    cable_step,
    cable_tension,
    new_modal_cable_state,
    start_cable,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Variable:
    """A variable of an FMU: causality "input", "output" or "parameter"; ``unit`` may be empty."""

    name: str
    causality: str
    unit: str
    about: str
    start: float = 0.0


def given(name: str, unit: str, about: str) -> Variable:
    """An input."""
    return Variable(name=name, causality="input", unit=unit, about=about)


def output(name: str, unit: str, about: str) -> Variable:
    """An output."""
    return Variable(name=name, causality="output", unit=unit, about=about)


def parameter(name: str, unit: str, about: str, start: float = 0.0) -> Variable:
    """A parameter with its value at the start."""
    return Variable(name=name, causality="parameter", unit=unit, about=about, start=start)


def cable_notes(cable: ModalCable) -> list[str]:
    """What a user has to know of an exported cable."""
    kind = (
        "the fast model of the loop (uniform tension in each span, spans vibrating in the plane w)"
        if cable.sine
        else "linear modes of the network about its state of rest"
    )
    steep = " or steeper than the model allows" if cable.sine else ""
    return [
        f"{kind}: {cable.modes} modes along, up to {cable.highest:.4g} Hz; inputs are held over a step of "
        f"{cable.interval:g} s",
        f'output "holds" becomes 0, and each further step a warning, once a span has gone slack{steep}',
    ]


def identifier(name: str) -> str:
    """A name as C and FMI take it."""
    return re.sub(r"\W+", "_", name)


def cable_variables(cable: ModalCable) -> list[Variable]:
    """Inputs, parameters and outputs, in the order of their reference numbers."""
    spans = [identifier(name) for name in cable.spans]
    plucks, middles = (spans, spans) if cable.sine else ([], [])
    return [
        *(given(identifier(name), unit, name) for name, unit in cable.inputs),
        *(parameter(f"pluck_{span}", "m", "half sine at the start, in w") for span in plucks),
        *(
            output(f"{identifier(name)}_{'angle' if unit == 'rad' else 'position'}", unit, name)
            for name, unit in cable.motions
        ),
        *(
            output(f"{identifier(name)}_speed", f"{unit}/s", f"speed of {name}")
            for name, unit in cable.motions
        ),
        *(output(f"{span}_tension", "N", "mean tension of the span") for span in spans),
        *(output(f"{span}_middle", "m", "displacement of the middle, in w") for span in middles),
        output("holds", "", "1 while the model holds, then 0"),
    ]


def cable_code(drive: Drive | RoutedDrive, cable: ModalCable) -> dict[str, str]:
    """Header and source of a cable."""
    program, numbers = Program(), cable.numbers
    state = program.state("cd_cable", "cable", new_modal_cable_state(numbers))
    frozen = program.frozen("numbers", numbers)

    def vector(name: str, size: int) -> Value:
        return Value(name, View(REAL, (size,)))

    spans, inputs, motions = len(cable.spans), len(cable.inputs), len(cable.motions)
    calls: dict[str, Any] = {
        "start": program.root(start_cable, [vector("plucks", spans if cable.sine else 0), state])[1],
        "step": program.root(
            cable_step, [frozen, state, vector("inputs", inputs), vector("tensions", spans)]
        )[1],
        "tension": program.root(cable_tension, [frozen, state, vector("tensions", spans)])[1],
        "motion": program.root(
            cable_motion, [frozen, state, vector("places", motions), vector("speeds", motions)]
        )[1],
    }
    if cable.sine:
        calls["middle"] = program.root(cable_middle, [frozen, state, vector("middles", spans)])[1]
    functions = program.functions()
    words = {
        "title": f"{drive.title or drive.name}: cable in modes",
        "version": __version__,
        "hash": content_hash(drive),
        "interval": program.precision.literal(cable.interval),
        "cable": cable,
        "structs": program.structs(),
        "functions": functions,
        "tables": program.used_tables(functions),
        "runtime": runtime_text(program.precision, functions),
        "calls": calls,
    }
    return {
        f"cabledrive_cable.{kind}": templates().get_template(f"cable.{kind}.jinja").render(**words)
        for kind in ("h", "c")
    }
