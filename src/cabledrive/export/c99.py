"""The C99 package of a controller: header, sources, self-test, its vectors, and what its step needs."""

import json
from dataclasses import replace
from math import isfinite
from typing import Any

from cabledrive.export.self_test import self_test
from cabledrive.export.single_precision import SinglePrecision
from cabledrive.export.source import ExportSource
from cabledrive.export.target_program import (
    TargetProgram,
    needed_rise,
    runtime_text,
    target_program,
    templates,
)
from cabledrive.export.translation.nodes import Precision, mentions
from cabledrive.parameters.drive_file import drive_text
from cabledrive.parameters.version import __version__

HEADER, SOURCE, CHECK = "cabledrive_law.h", "cabledrive_law.c", "check.c"


def controller_package(source: ExportSource, single: SinglePrecision | None = None) -> dict[str, str]:
    """Files of a controller in C99, by name; ``single``: written for single precision."""
    law = source.law if single is None else single.law
    source = replace(source, law=law, notes=(*source.notes, single.note) if single else source.notes)
    made = target_program(law, Precision(single=single is not None))
    code = controller_code(source, made, 0.0 if single is None else single.tolerance)
    vectors = self_test(law)
    files = code | {
        CHECK: templates().get_template("check.c.jinja").render(),
        "vectors.csv": vectors.csv(law.encoders, law.columns),
        "controller.json": json.dumps(source.data, indent=1, allow_nan=False) + "\n",
    }
    if source.drive is not None:
        files["drive.toml"] = drive_text(source.drive)
    return files | {"README.md": _readme(source, made, files, 0.0 if single is None else single.tolerance)}


def controller_code(source: ExportSource, made: TargetProgram, tolerance: float = 0.0) -> dict[str, str]:
    """Header and source of a translated controller; ``tolerance``: of its self-test [N m]."""
    words = _words(source, made, tolerance)
    functions = made.program.functions()
    shell = templates().get_template("law.c.jinja")
    tables = made.program.used_tables(
        functions + made.start_call + made.step_call + ("RISE" if words["generator"] else "")
    )
    body = shell.render(
        **words, functions=functions, tables=tables, runtime=runtime_text(made.program.precision, functions)
    )
    return {HEADER: templates().get_template("law.h.jinja").render(**words), SOURCE: body}


def _words(source: ExportSource, made: TargetProgram, tolerance: float) -> dict[str, Any]:
    law, precision = source.law, made.program.precision
    named = source.drive.title or source.drive.name if source.drive is not None else "controller"
    return {
        "title": f"{named}: {law.name}",
        "version": __version__,
        "caution": source.c_caution,
        "law": law,
        "encoders": law.encoders,
        "columns": law.columns,
        "counts": [precision.literal(count) for count in law.counts],
        "single": precision.single,
        "literal": precision.literal,
        "tolerance": f"{tolerance:.3g}" if tolerance else "0.0",
        "structs": made.program.structs(),
        "generator": bool(made.row_call),
        "order": needed_rise(law) if made.row_call else 0,
        "step": made.step,
        "start_call": made.start_call,
        "step_call": made.step_call,
        "row_call": made.row_call,
    }


def _readme(source: ExportSource, made: TargetProgram, files: dict[str, str], tolerance: float) -> str:
    law, words = source.law, _words(source, made, tolerance)
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
        )
    )
