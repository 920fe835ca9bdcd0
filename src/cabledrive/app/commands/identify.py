"""`cabledrive identify`: parameters of one axis from its logs."""

from typing import Any

import click

from cabledrive.app.options import Subcommand, answering, saves_answer
from cabledrive.app.results import Answer, provenance


@click.command(
    cls=Subcommand,
    example="cabledrive identify log.csv --method output-error",
    short_help="Identify inertia and friction of an axis from logs.",
)
@answering
@saves_answer
@click.argument("logs", nargs=-1, required=True, metavar="LOG...")
@click.option("--config", type=click.Path(), metavar="FILE", help="TOML file with [identify] and [log].")
@click.option("--model", metavar="NAME", help="rigid-axis, rigid-axis-tanh, rigid-axis-asymmetric, ...")
@click.option("--method", metavar="NAME", help="inverse-dynamics or output-error.")
@click.option(
    "--column",
    "columns",
    multiple=True,
    metavar="CHANNEL=COLUMN:UNIT",
    help="Which column is a channel, as torque=tau:N mm; repeatable.",
)
@click.option("--no-check", is_flag=True, help="Do not test the model against known faults.")
def command(
    logs: tuple[str, ...],
    config: str | None,
    model: str | None,
    method: str | None,
    columns: tuple[str, ...],
    no_check: bool,
) -> Answer:
    """Identify inertia, viscous and Coulomb friction and offset of one axis from logs, with intervals."""
    from dataclasses import replace

    from cabledrive.identification.identify import IdentifyOptions, identify, load_options
    from cabledrive.identification.logs.column_map import with_choices

    options = load_options(config) if config else IdentifyOptions()
    options = replace(
        options, columns=with_choices(options.columns, columns), check=options.check and not no_check
    )
    found = identify(logs[0] if len(logs) == 1 else list(logs), options, model=model, method=method)
    data = found.as_dict()
    return Answer(
        data=data,
        text=_text(data),
        provenance=provenance(method=str(found.method["name"])),
        incomplete=_incomplete(found),
    )


def _incomplete(found: Any) -> str | None:
    if not found.identifiable:
        return f"not identifiable: {'; '.join(found.unidentifiable)}"
    negative = [finding for finding in found.findings if "comes out negative" in finding]
    return negative[0] if negative else None


def _text(data: dict[str, Any]) -> str:
    rows = []
    for name, entry in data["parameters"].items():
        if entry["value"] is None:
            rows.append((name, "not determined", "", "", entry["unit"]))
        else:
            rows.append((name, *(f"{entry[key]:.6g}" for key in ("value", "low", "high")), entry["unit"]))
    rows.insert(0, ("parameter", "value", "low (95 %)", "high (95 %)", "unit"))
    widths = [max(len(row[k]) for row in rows) for k in range(4)]
    lines = [
        "  ".join(f"{cell:<{width}}" for cell, width in zip(row, [*widths, 0], strict=True)) for row in rows
    ]
    relative = data["residual"]["relative"]
    lines.append(
        f"residual {100 * relative:.3g} % of the measured {data['method'].get('residual_of', 'torque')}"
    )
    lines += [f"finding: {finding}" for finding in (*data["findings"], *data["unidentifiable"])]
    for report in data["data"]:
        lines += [f"data: {line}" for line in (*report["repaired"], *report["findings"])]
    return "\n".join(lines)
