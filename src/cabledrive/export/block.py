"""A block of a simulation as translated C: its program, the shell around it, its inputs and outputs."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined

from cabledrive.export.translation.nodes import mentions
from cabledrive.export.translation.program import Program
from cabledrive.parameters.version import __version__

EXPONENTS = {False: ("uint64_t", "0x7ff0000000000000u"), True: ("uint32_t", "0x7f800000u")}
SHELLS = {"controller": "law", "plant": "system", "loop": "system", "cable": "cable"}


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
        words = {
            "what": self.what,
            "title": self.title,
            "version": __version__,
            "literal": self.program.precision.literal,
        }
        return templates().get_template(template).render(**words | dict(self.words) | more)

    def code(self) -> dict[str, str]:
        """Header and source."""
        program, shell = self.program, SHELLS[self.what]
        functions, words = program.functions(), {"structs": program.structs()}
        words |= {"functions": functions, "runtime": runtime_text(program, functions)}
        tables = program.used_tables(self.rendered(f"{shell}.c.jinja", tables="", **words))
        return {
            f"{self.file}.{kind}": self.rendered(f"{shell}.{kind}.jinja", tables=tables, **words)
            for kind in ("h", "c")
        }


def templates() -> Environment:
    """The shells around translated kernels, and models in other languages."""
    return Environment(
        loader=PackageLoader("cabledrive.export"), undefined=StrictUndefined, keep_trailing_newline=True
    )


def runtime_text(program: Program, text: str) -> str:
    """The few functions below the kernels, those that a text uses."""
    word, exponent = EXPONENTS[program.precision.single]
    template = templates().get_template("runtime.c.jinja")
    return template.render(word=word, exponent=exponent, used=lambda name: mentions(text, name))


def samples_csv(heads: Sequence[str], *columns: np.ndarray) -> str:
    """One line a sample, 17 digits a number."""
    rows = np.column_stack(columns).tolist()
    lines = [",".join(f"{value:.17g}" for value in row) for row in rows]
    return "\n".join([",".join(heads), *lines]) + "\n"
