"""A distributed cable in modes as a program in C."""

import re
from typing import Any

from cabledrive.export.block import Block, given, output, parameter
from cabledrive.export.translation.nodes import REAL, Value, View
from cabledrive.export.translation.program import Program
from cabledrive.parameters import Drive, InputRefused, content_hash
from cabledrive.parameters.route.drive import RoutedDrive
from cabledrive.reduction.modal_cable import ModalCable, modal_cable
from cabledrive.reduction.modal_cable_kernels import (
    cable_middle,
    cable_motion,
    cable_step,
    cable_tension,
    new_modal_cable_state,
    start_cable,
)


def cable_block(drive: Drive | RoutedDrive) -> Block:
    """The cable of a drive, translated; refused: two parts whose names are one in C."""
    cable, program = modal_cable(drive), Program()
    numbers = cable.numbers
    state = program.state("cd_cable", "cable", new_modal_cable_state(numbers))
    frozen = program.frozen("numbers", numbers)

    def vector(name: str, size: int) -> Value:
        return Value(name, View(REAL, (size,)))

    spans, inputs, motions = len(cable.spans), len(cable.inputs), len(cable.motions)
    tensions = vector("tensions", spans)
    kernels: dict[str, tuple[Any, list[Value]]] = {
        "start": (start_cable, [vector("plucks", spans if cable.sine else 0), state]),
        "step": (cable_step, [frozen, state, vector("inputs", inputs), tensions]),
        "tension": (cable_tension, [frozen, state, tensions]),
        "motion": (cable_motion, [frozen, state, vector("places", motions), vector("speeds", motions)]),
    }
    if cable.sine:
        kernels["middle"] = (cable_middle, [frozen, state, vector("middles", spans)])
    calls = {name: program.root(kernel, values)[1] for name, (kernel, values) in kernels.items()}
    groups = _variables(cable)
    variables = [one for group in groups.values() for one in group]
    if len({one.name for one in variables}) != len(variables):
        raise InputRefused("two parts of the machine have names that are one in C: rename one")
    places, first = {}, 0
    for name, group in groups.items():
        places[name] = first if group else 0
        first += len(group)
    return Block(
        what="cable",
        drive=drive.name,
        title=f"{drive.title or drive.name}: cable in modes",
        interval=cable.interval,
        program=program,
        words={"hash": content_hash(drive), "cable": cable, "calls": calls, "places": places},
        variables=variables,
        notes=_notes(cable),
    )


def _variables(cable: ModalCable) -> dict[str, list[Any]]:
    """Inputs, parameters and outputs, group by group in the order of their reference numbers."""

    def name(part: str) -> str:
        return re.sub(r"\W+", "_", part)

    turns = {True: "angle", False: "position"}
    plucked = cable.spans if cable.sine else ()
    return {
        "inputs": [given(name(one), unit, one) for one, unit in cable.inputs],
        "plucks": [parameter(f"pluck_{name(s)}", "m", "half sine at the start, in w") for s in plucked],
        "motions": [output(f"{name(one)}_{turns[unit == 'rad']}", unit, one) for one, unit in cable.motions],
        "speeds": [output(f"{name(one)}_speed", f"{u}/s", f"speed of {one}") for one, u in cable.motions],
        "tensions": [output(f"{name(s)}_tension", "N", "mean tension of the span") for s in cable.spans],
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
        f"{kind}: {cable.modes} modes along, up to {cable.highest:.4g} Hz; inputs are held over a step of "
        f"{cable.interval:g} s",
        f'output "holds" becomes 0, and each further step a warning, once a span has gone slack{steep}',
    ]
