"""The C99 package of a controller: header, sources, self-test, its vectors, and what to know of them."""

import json
from math import isfinite
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined

from cabledrive.export.self_test import self_test
from cabledrive.export.source import ExportSource
from cabledrive.export.stack_usage import stack_words
from cabledrive.export.target_program import TargetProgram, needed_rise, target_program
from cabledrive.export.translation.literals import Precision
from cabledrive.export.translation.nodes import mentions
from cabledrive.parameters.drive_file import drive_text
from cabledrive.parameters.version import __version__

HEADER, SOURCE, CHECK = "cabledrive_law.h", "cabledrive_law.c", "check.c"
EXPONENTS = {False: ("uint64_t", "0x7ff0000000000000u"), True: ("uint32_t", "0x7f800000u")}


def templates() -> Environment:
    """The shells around translated kernels."""
    return Environment(
        loader=PackageLoader("cabledrive.export"), undefined=StrictUndefined, keep_trailing_newline=True
    )


def controller_package(source: ExportSource, precision: Precision | None = None) -> dict[str, str]:
    """Files of a controller in C99, by name."""
    law, precision = source.law, precision or Precision()
    made = target_program(law, precision)
    code = controller_code(source, made)
    vectors = self_test(law)
    files = code | {
        CHECK: templates().get_template("check.c.jinja").render(),
        "vectors.csv": vectors.csv(law.encoders, law.columns),
        "controller.json": json.dumps(source.data, indent=1, allow_nan=False) + "\n",
    }
    if source.drive is not None:
        files["drive.toml"] = drive_text(source.drive)
    return files | {"README.md": _readme(source, made, files)}


def controller_code(source: ExportSource, made: TargetProgram) -> dict[str, str]:
    """Header and source of a translated controller."""
    words = _words(source, made)
    functions = made.program.functions()
    shell = templates().get_template("law.c.jinja")
    tables = made.program.used_tables(
        functions + made.start_call + made.step_call + ("RISE" if words["generator"] else "")
    )
    body = shell.render(**words, functions=functions, tables=tables, runtime=runtime(made, functions))
    return {HEADER: templates().get_template("law.h.jinja").render(**words), SOURCE: body}


def runtime(made: TargetProgram, text: str) -> str:
    """The few functions below the kernels, those that a text uses."""
    word, exponent = EXPONENTS[made.program.precision.single]
    template = templates().get_template("runtime.c.jinja")
    return template.render(word=word, exponent=exponent, used=lambda name: mentions(text, name))


def _words(source: ExportSource, made: TargetProgram) -> dict[str, Any]:
    law, precision = source.law, made.program.precision
    named = source.drive.title or source.drive.name if source.drive is not None else "controller"
    return {
        "title": f"{named}: {law.name}",
        "version": __version__,
        "law": law,
        "encoders": law.encoders,
        "columns": law.columns,
        "counts": [precision.literal(count) for count in law.counts],
        "single": precision.single,
        "literal": precision.literal,
        "tolerance": "0.0",
        "structs": made.program.structs(),
        "generator": bool(made.row_call),
        "order": needed_rise(law) if made.row_call else 0,
        "step": made.step,
        "start_call": made.start_call,
        "step_call": made.step_call,
        "row_call": made.row_call,
    }


def _readme(source: ExportSource, made: TargetProgram, files: dict[str, str]) -> str:
    law, words = source.law, _words(source, made)
    size = 4 if made.program.precision.single else 8
    state = sum(
        part.size * (size if part.dtype.kind == "f" else 4)
        for part in (*made.state.controller, *made.state[1:])
    )
    used = files[SOURCE]
    tables = sum(
        array.size * (size if array.dtype.kind == "f" else 4)
        for name, (array, _) in made.program.tables.items()
        if mentions(used, name)
    )
    hertz = "" if law.bandwidth is None else f"Bandwidth {law.bandwidth:.4g} Hz. "
    return (
        templates()
        .get_template("README.md.jinja")
        .render(
            **words | {"counts": list(zip(law.encoders, law.counts, strict=True))},
            settings=hertz + f"Sample time {law.sample_time:g} s.",
            limit=f"{law.torque_limit:.6g} N m"
            if isfinite(law.torque_limit)
            else "no bound (the drive has no limit)",
            notes=source.notes,
            state_bytes=state,
            table_bytes=tables,
            stack=stack_words(files),
        )
    )
