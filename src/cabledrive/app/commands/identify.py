"""`cabledrive identify`: parameters of one axis from its logs."""

from typing import Any

import click

from cabledrive.app.combinations import HOW_READ, Chooser, refuse_not_of
from cabledrive.app.failures import note
from cabledrive.app.options import argument, opt, saves_answer, subcommand
from cabledrive.app.results import Answer, NewFile, provenance
from cabledrive.parameters import InputRefused

AXIS, PING = ("axis",), ("ping",)


@subcommand("cabledrive identify log.csv --method output-error", (saves_answer,))
def command(
    logs: tuple[str, ...] = argument("LOG...", nargs=-1, required=True),
    config: str | None = opt("path", "TOML file with [identify] and [log]."),
    model: str | None = opt("NAME", "rigid-axis, rigid-axis-tanh, ..., two-inertia.", of=AXIS),
    method: str | None = opt("NAME", "inverse-dynamics, output-error or prediction-error.", of=AXIS),
    torque: str | None = opt(
        "found|held|interpolated|before", "When a logged torque acts; default: found from the log.", of=AXIS
    ),
    choose: Chooser = HOW_READ,
    drive: str | None = opt(
        "DRIVE",
        "Identify the tension of each span of DRIVE from the recording of a pluck, a log or a .wav file.",
        flags="--ping",
    ),
    spans: tuple[str, ...] = opt(
        "NAME",
        "Span that was plucked, by its name, one for each recording: two are compared; both: upper and lower "
        "of a loop in one recording.",
        multiple=True,
        of=PING,
    ),
    plucked: str | None = opt(
        "upper|lower",
        "Of --span both: which span was plucked harder, where the spans have the same modes.",
        of=PING,
    ),
    section: int = opt(
        click.IntRange(0), "Section of the plucked span between guided carriages, counted from 0.", 0, of=PING
    ),
    tensions: tuple[float, ...] = opt(
        "N",
        "Tell friction at wraps from friction at bearings: pretension of the cable in each log, in order.",
        multiple=True,
        of=("axis", "split"),
    ),
    page: NewFile | None = opt("page", "Write a page with the log's figures.", of=AXIS, flags="--report"),
    other: str | None = opt(
        "path",
        "Hold the identified axis against another log: simulated in open loop, followed by an observer, and "
        "beside what that log gives by itself.",
        metavar="LOG",
        of=AXIS,
        flags="--against",
    ),
    no_check: bool = opt("flag", "Do not test the model against known faults.", of=AXIS),
) -> Answer:
    """Identify inertia, viscous and Coulomb friction and offset of one axis from logs, with intervals.

    With --ping, the tension of each span from the recording of a ping instead; with --tension, friction at
    wraps and at bearings from logs at several tensions.
    """
    from dataclasses import replace

    from cabledrive.app.identified import (
        ANSWER,
        against_lines,
        finding_lines,
        parameter_rows,
        pinged,
        split_answer,
    )
    from cabledrive.identification.axis.answer import IdentifyOptions
    from cabledrive.identification.logs.reading import open_log, read_log
    from cabledrive.identification.one_log import identify, is_long, load_options

    if drive is None:
        refuse_not_of("axis", "belongs to --ping DRIVE: add that, or leave it out")
    else:
        refuse_not_of("ping", "is for the parameters of an axis, not for --ping")
    options = IdentifyOptions() if config is None else load_options(config)
    options = replace(options, columns=choose(options.columns), check=options.check and not no_check)
    options = replace(options, torque=torque or options.torque)
    if drive is not None:
        return pinged(logs, drive, spans, plucked, section, options.columns)
    if tensions:
        refuse_not_of("split", "is not for --tension: leave it out")
        return split_answer(logs, tensions, options.columns)
    if page is not None and is_long(open_log(logs[0], options.columns)):
        raise InputRefused(f"--report: {logs[0]} is too long to be drawn: leave it out, or cut the log")
    found = identify(
        logs[0] if len(logs) == 1 else list(logs), options, model=model, method=method, progress=note
    )
    data = found.as_dict()
    measured = data["method"].get("residual_of", "torque")
    residual = f"residual {100 * data['residual']['relative']:.3g} % of the measured {measured}"
    shown = [f"method: {data['method']['name']}", *[f"note: {words}" for words in data["notes"]]]
    check = f"model checked: {'yes' if data['checked'] else 'no'} ({data['check_reason']})"
    text = "\n".join([parameter_rows(data["parameters"]), residual, *shown, check, *finding_lines(data)])
    if other is not None:
        from cabledrive.identification.axis.check import against

        log = read_log(other, options.columns)
        alone = identify(log, options, model=model, method=method, progress=note)
        data["against"] = against(found, alone, log, options.axis)
        text = "\n".join([text, *against_lines(data["against"])])
    if page is not None:
        from cabledrive.report.log_page import write_log_report

        first = read_log(logs[0], options.columns)  # whole: one that is read in blocks is not drawn
        write_log_report(first, found, page.path, options=options.axis, files=logs, force=page.force)
    return Answer(
        data=ANSWER(data),
        text=text,
        provenance=provenance(method=str(found.method["name"])),
        incomplete=_incomplete(found),
    )


def _incomplete(found: Any) -> str | None:
    """Why not all is found, with a hint where the torque comes in steps, as an encoder's angle does."""
    wrong = [finding for finding in found.findings if "is identified as negative" in finding]
    wrong = wrong if found.identifiable else [f"not identifiable: {'; '.join(found.unidentifiable)}"]
    for stepped in (set(report.quantum) for report in found.reports):
        swapped = stepped & {"torque", "force"} and not stepped & {"angle", "position"}
        if wrong and swapped and not (found.identifiable and "swapped" in wrong[0]):
            return f"{wrong[0]}; are torque and angle swapped? Only the torque comes in steps"
    return wrong[0] if wrong else None
