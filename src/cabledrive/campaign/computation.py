"""What is computed for each row: the outputs with units and dimensions, and the function of one row."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from cabledrive.parameters import InputRefused
from cabledrive.parameters.fields import described, meaning, require_known
from cabledrive.parameters.toml_values import flag_of, quantities_of, quantity_of, text_of, whole_of

NUMBER, FLAG, TEXT = "number", "flag", "text"
LIST = "list of "
"""Before the unit of an option that takes several numbers."""


@described
@dataclass(frozen=True, slots=True, kw_only=True)
class Output:
    """A variable of the store."""

    name: str = meaning("of the variable")
    unit: str = meaning("SI unit, or that in the name, such as Hz; empty for flags and text")
    dims: tuple[str, ...] = meaning("dimensions beside ``row``", ())
    shape: tuple[int, ...] = meaning("their sizes", ())
    kind: str = meaning('"number", "flag" or "text"', NUMBER)
    meaning: str = meaning("in words")


def declared(
    table: Mapping[str, tuple[str, str]], dims: tuple[str, ...] = (), shape: tuple[int, ...] = ()
) -> tuple[Output, ...]:
    """Outputs from unit, or "flag" or "text", and meaning by name; all of the same dimensions."""
    found = []
    for name, (unit, words) in table.items():
        unit, kind = ("", unit) if unit in (FLAG, TEXT) else (unit, NUMBER)
        found.append(Output(name=name, unit=unit, meaning=words, dims=dims, shape=shape, kind=kind))
    return tuple(found)


@described
@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Row:
    """One row as a computation gets it."""

    drive: Any = meaning("as the law believes it to be")
    plant: Any = meaning("as it is, where keys under ``plant.`` are varied")
    motion: Mapping[str, Any] = meaning("values of the SPEC with those of this row, in SI")
    goals: Mapping[str, Any] = meaning("values of the SPEC with those of this row, in SI")
    options: Mapping[str, Any] = meaning("values of the SPEC with those of this row, in SI")
    own: Mapping[str, Any] = meaning("values of the SPEC with those of this row, in SI")
    seed: int = meaning("of the row's random numbers")


@described
@dataclass(frozen=True, slots=True, kw_only=True)
class Found:
    """What a row gave although it could not be completed."""

    values: Mapping[str, Any] = meaning("outputs by name")
    incomplete: str = meaning("why: the row gets status 3")


class Computation(Protocol):
    """What a campaign asks of a computation; any object that another process can import will do."""

    @property
    def identity(self) -> str:
        """Distinguishes it from other computations: the same text, the same results. A store keeps it."""

    @property
    def outputs(self) -> tuple[Output, ...]:
        """Variables of the store that it fills."""

    def one(self, row: Row) -> "Mapping[str, Any] | Found":
        """Compute one row.

        Parameters
        ----------
        row : Row

        Returns
        -------
        mapping or Found
            Value of each output by name; what is missing stays NaN, empty or unknown.

        Raises
        ------
        InputRefused, NotComputed
            The row gets status 2 or 3, and the line as its reason.
        """


@dataclass(frozen=True, slots=True, kw_only=True)
class Kind:
    """A computation that the SPEC can name."""

    outputs: Callable[[Mapping[str, Any]], tuple[Output, ...]]  # all outputs, given the options of the SPEC
    default: tuple[str, ...]  # those stored unless ``outputs`` names others
    one: Callable[[Row], "Mapping[str, Any] | Found"]  # of one row
    options: dict[str, str]  # unit of each option, as `values_of` takes it
    modules: tuple[str, ...]  # imported when a row is computed, beside those loaded with the SPEC
    required: tuple[str, ...] = ()  # options without a default
    spaces: tuple[str, ...] = ()  # of keys beside the drive file's and its own options that it reads
    long: bool = False  # a row takes longer than a chunk should: no row is tried to find that out

    @property
    def numbers(self) -> dict[str, str]:
        """Options that can be varied, with their units."""
        others = (TEXT, FLAG, LIST)
        return {name: u for name, u in self.options.items() if not u.startswith(others) and name != "count"}


def values_of(table: Mapping[str, Any], units: Mapping[str, str], place: str) -> dict[str, Any]:
    """Entries of a table of the SPEC, in SI; refused: an unknown key, another unit.

    ``units``: of each entry, or "count", "text", "flag", "list of UNIT".
    """
    plain: dict[str, Callable[[str, Any], Any]] = {TEXT: text_of, FLAG: flag_of, "count": whole_of}
    found: dict[str, Any] = {}
    for name, value in table.items():
        key = f"{place}.{name}"
        require_known(name, units, f'unknown key "{key}"', f"{place}.")
        unit = units[name]
        if unit.startswith(LIST):
            found[name] = list(quantities_of(key, value, unit.removeprefix(LIST)))
        else:
            found[name] = plain[unit](key, value) if unit in plain else quantity_of(key, value, unit)
    return found


@dataclass(frozen=True, slots=True, kw_only=True)
class NamedComputation:
    """A computation of the package, as a SPEC asks for it."""

    what: str  # name of its kind
    options: Mapping[str, Any]  # in SI
    outputs: tuple[Output, ...]

    @property
    def identity(self) -> str:
        """Its kind."""
        return self.what

    @property
    def kind(self) -> Kind:
        """What the package says of it."""
        return kinds()[self.what]

    @property
    def modules(self) -> tuple[str, ...]:
        """What its rows import."""
        return self.kind.modules

    def one(self, row: Row) -> Mapping[str, Any] | Found:
        """Compute one row."""
        return self.kind.one(row)

    def many(self, spec: Any, values: Mapping[str, NDArray[Any]]) -> Any:
        """Compute many rows at once, each to the same number as alone, where there is a way.

        Which rows fit and are done, and their outputs; None: no campaign for this. Values in SI.
        """
        from cabledrive.campaign.kinds import many_modes

        return many_modes(spec, values) if self.what == "modes" else None


def kinds() -> dict[str, Kind]:
    """Every computation that a SPEC can name."""
    from cabledrive.campaign.kinds import KINDS

    return KINDS


def named_computation(table: Mapping[str, Any]) -> NamedComputation:
    """The computation of a table ``[compute]``; refused: an unknown key or output, another unit."""
    known = kinds()
    what = text_of("compute.what", table.get("what", ""))
    require_known(what, known, f'compute.what = "{what}" is not known')
    kind = known[what]
    given = {key: value for key, value in table.items() if key not in ("what", "outputs", "chunk")}
    options = values_of(given, kind.options, "compute")
    everything = {output.name: output for output in kind.outputs(options)}
    wanted = table.get("outputs", list(kind.default))
    if not isinstance(wanted, list) or not wanted:
        raise InputRefused('compute.outputs is no list: write such as ["longitudinal_hz"]')
    for name in wanted:
        require_known(name, everything, f'compute.outputs: "{name}" is no output')
    names = tuple(dict.fromkeys(wanted))
    outputs = tuple(everything[name] for name in names)
    return NamedComputation(what=what, options=options | {"outputs": names}, outputs=outputs)


def padded(values: Any, length: int) -> NDArray[np.float64]:
    """The first values, shape (length,); NaN where there are fewer."""
    out = np.full(length, np.nan)
    some = np.asarray(values, dtype=float)[:length]
    out[: some.size] = some
    return out
