"""A block of a simulation as translated C: its program, the shell around it, its inputs and outputs."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

from jinja2 import Environment, PackageLoader, StrictUndefined

from cabledrive.export.translation.nodes import mentions
from cabledrive.export.translation.program import Program
from cabledrive.parameters.version import __version__

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
