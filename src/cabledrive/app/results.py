"""Results at the door: a JSON object for programs, a text for people, files whole or not at all."""

import dataclasses
import json
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from cabledrive.answers.keys import NOT_FINITE
from cabledrive.app.failures import colours, note, watched_output
from cabledrive.parameters import Drive, InputRefused, Machine, content_hash
from cabledrive.parameters.files import check_writable, write_whole
from cabledrive.parameters.version import __version__

if TYPE_CHECKING:
    from cabledrive.identification.logs.log import Log
    from cabledrive.parameters.arrays import Array
    from cabledrive.rig import Tracking


@dataclasses.dataclass(frozen=True, kw_only=True)
class Answer:
    """What a command has found."""

    data: Mapping[str, Any]  # the JSON object: numbers in SI unless the key says otherwise
    text: str  # the same for people
    provenance: Mapping[str, Any] | None  # where the result comes from, see `provenance`
    incomplete: str | None = None  # why not all that was asked for; the command then ends with status 3


def provenance(
    drive: Machine | Drive | None = None,
    *,
    method: str | None = None,
    step: float | None = None,
    tolerances: Mapping[str, float] | None = None,
    seed: int | None = None,
) -> dict[str, Any]:
    """Version of cabledrive, drive, method, step or mesh size in SI, tolerances by name, seed, as given."""
    given = {
        "drive": drive and drive.name,
        "drive_hash": drive and content_hash(drive),
        "method": method,
        "step": step,
        "tolerances": tolerances,
        "seed": seed,
    }
    return {"cabledrive": __version__} | {key: value for key, value in given.items() if value is not None}


def json_text(answer: Answer) -> str:
    """The JSON object of an answer. Returns ASCII, so that it passes through every terminal and pipe."""
    data = dict(answer.data)
    if answer.incomplete is not None:
        data["incomplete"] = answer.incomplete
    if answer.provenance is not None:
        data["provenance"] = answer.provenance
    return json.dumps(plain(data), indent=2, allow_nan=False)


def plain(value: Any) -> Any:
    """What JSON can hold of a value.

    ``value``: mappings, sequences, arrays, dataclasses, numbers, words; numbers that are not finite only
    inside a mapping, which takes the reason.
    Returns dictionaries, lists, finite numbers, words, None.
    """
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        value = {field.name: getattr(value, field.name) for field in dataclasses.fields(value)}
    if isinstance(value, Mapping):
        return _plain_mapping(value)
    if hasattr(value, "tolist"):  # arrays and numbers of numpy
        return plain(value.tolist())
    if isinstance(value, Sequence) and not isinstance(value, str):
        return [plain(item) for item in value]
    if isinstance(value, float) and not isfinite(value):
        return None
    return value


def show(answer: Answer, *, as_json: bool) -> None:
    """Print an answer on standard output, and nothing else there. ``as_json``: whether a program reads it."""
    text = json_text(answer) if as_json else answer.text.replace("\N{MINUS SIGN}", "-")
    encoding = getattr(sys.stdout, "encoding", None) or "utf-8"
    text = text.encode(encoding, errors="replace").decode(encoding)  # in the characters that it knows
    with watched_output():
        click.echo(text, color=colours())


def _plain_mapping(value: Mapping[str, Any]) -> dict[str, Any]:
    data: dict[str, Any] = {}
    for key, item in value.items():
        data[key] = plain(item)
        if _holds_none(data[key]) and not _holds_none(item):
            data[f"{key}_reason"] = NOT_FINITE
    return data


def _holds_none(value: Any) -> bool:
    """Whether a value is None, or a list with one in it."""
    return value is None or (isinstance(value, list) and any(map(_holds_none, value)))


PAGE, OBJECT = (".html", ".htm", ""), (".json", "")
"""Endings of files that have one format each; a bare name will do."""
TAKEN, FORCE = "cabledrive.taken", "cabledrive.force"


@dataclass(frozen=True, slots=True)
class NewFile:
    """A file that a command is going to write."""

    path: Path
    force: bool  # whether an existing file may be replaced

    def write(self, content: str | bytes) -> None:
        """Write it whole or not at all, and say so."""
        write_whole(self.path, content, force=self.force)
        note(f"written to {self.path}")


class NewFileType(click.ParamType):  # type: ignore[type-arg]
    """Path of a file to write; refused before the work starts where it could not be written."""

    name = "file"

    def __init__(self, *suffixes: str) -> None:
        self.suffixes = suffixes

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> NewFile:
        """Check a path to be written: refused if there (without ``--force``), of a wrong ending, or twice."""
        assert ctx is not None
        force = bool(ctx.meta.get(FORCE))
        path = check_writable(value, force=force)
        if self.suffixes and path.suffix.lower() not in self.suffixes:
            endings = " or ".join(filter(None, self.suffixes))
            raise InputRefused(f"{path}: does not end in {endings}: rename it")
        taken = ctx.meta.setdefault(TAKEN, set())
        if path.resolve() in taken:
            raise InputRefused(f"{path}: is to be written twice: give two names")
        taken.add(path.resolve())
        return NewFile(path, force)


def log_csv(log: "Log") -> str:
    """The log as comma-separated values, header such as ``time [s],torque [N m],angle [rad]``."""
    heads = ["time [s]", *(f"{name.replace('_', ' ')} [{log.units[name]}]" for name in log.channels)]
    return csv_text(heads, [log.time, *log.channels.values()])


def csv_text(heads: Sequence[str], columns: "Sequence[Array]") -> str:
    """Columns as comma-separated values of ten digits; ``heads``: with units; ``columns``, shape (rows,)."""
    import numpy as np

    table = np.column_stack(columns) + 0.0  # no negative zeros
    lines = [",".join(f"{value:.10g}" for value in row) for row in table]
    return "\n".join([",".join(heads), *lines]) + "\n"


LOAD_CELL_SEED = 1
HEADS = {"motor": "angle", "drive": "drive angle", "load": "load angle"}
"""As `cabledrive experiment` calls them, and `identify` reads them."""


def log_text(tracking: "Tracking", drive: Drive | None = None) -> str:
    """The log as comma-separated values: time, torque, encoder angles, reference, load cell."""
    shafts = [HEADS[shaft] for shaft in tracking.summary["encoders"]]
    head = ["time [s]", "torque [N m]", *(f"{shaft} [rad]" for shaft in shafts), "reference [rad]"]
    columns = [tracking.time, tracking.torque, *tracking.encoder_angles.T, tracking.reference]
    noise = drive.sensors.load_cell_noise if drive is not None and drive.sensors else None
    if drive is not None and noise is not None and tracking.tensions is not None:
        from numpy.random import default_rng

        from cabledrive.rig.virtual_rig import load_cell_force

        generator = default_rng((tracking.summary["seed"], LOAD_CELL_SEED))
        rim, pull = drive.drive_pulley.radius * tracking.speeds[:, -1], tracking.tensions.sum(axis=1)
        head = [*head, "load cell force [N]"]
        columns = [*columns, load_cell_force(drive, pull, rim, generator)]
    return csv_text(head, columns)
