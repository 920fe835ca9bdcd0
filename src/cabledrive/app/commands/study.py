"""`cabledrive study`: from a drive file and logs to a controller with a verdict."""

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from cabledrive.answers.figures import Row, aligned, percent, shown
from cabledrive.app import finished_study as kept
from cabledrive.app.failures import note
from cabledrive.app.options import axis_argument, opt, subcommand
from cabledrive.app.results import Answer
from cabledrive.parameters import Drive, InputRefused, Machine
from cabledrive.parameters.files import one_process

if TYPE_CHECKING:
    from cabledrive.studies.study import Goals

QUICK = {"draws": 400, "cable_draws": 0, "carriage_draws": 400}
SAID = (Row("reasons", "besides"), Row("remedies", "what would help"), Row("cautions", "notes"))
SERVED = "no input has changed: results of the finished study"


@subcommand("cabledrive study dissertation-3 --quick -o study", (partial(axis_argument, chainless=True),))
def command(
    drive: Any,
    no_chain: str | None,
    logs: tuple[str, ...] = opt("path", "A measured log; repeatable.", multiple=True, metavar="LOG"),
    goals: str | None = opt("path", "TOML file: error, motion, torque, load range, carriage, draws."),
    quick: bool = opt(
        "flag", "Fewer samples: 400 lumped plants or plants with a carriage, none on the distributed cable."
    ),
    every_law: bool = opt("flag", "Try every law, not six; see docs/study.", flags="--all"),
    resume: bool = opt("flag", "Resume an interrupted study (also without this option)."),
    force: bool = opt("flag", "Replace the report of another study."),
    output: str = opt(
        "path", "Folder of report and results.", required=True, metavar="DIR", flags="-o --output"
    ),
) -> Answer:
    """Study DRIVE: what logs identify, modes, resonance, a controller with its bound, a test on many plants.

    Of a machine with routes the chain of its axis is studied, see --axis; without one its modes, internal
    resonance and margins, and why there is no controller.

    DIR receives report.html, results.json, drive.toml (as identified), controller.json (the law in numbers)
    and the finished stages; a changed input redoes only the stages that depend on it.
    """
    folder = kept.folder_of(output)
    asked = kept.asked_hash(drive, [goals, *logs], (quick, every_law))
    before = None if force else _finished_before(folder, asked)
    if before is not None:
        return _answer(before, folder)
    kept.check_folder(folder, force=force)
    with kept.kept_if_interrupted(folder), one_process(folder / kept.STAGES):
        before = None if force else _finished_before(folder, asked)  # by another process meanwhile
        if before is not None:
            data = before
        elif no_chain is not None:
            data = _without_chain(drive, no_chain, len(logs), folder, asked)
        else:
            data = _studied(drive, logs, _goals(goals, quick, every_law), folder, asked)
    return _answer(data, folder)


def _finished_before(folder: Path, asked: str) -> dict[str, Any] | None:
    before = kept.finished(folder)
    if before is None:
        return None
    if before.get("asked") != asked:
        raise InputRefused(
            f"{folder}: holds the report of another study: choose another folder, or add --force, which "
            "keeps the stages that still hold"
        )
    if before.get("code") != kept.code_hash():
        raise InputRefused(
            f"{folder}: holds this study as another state of the package made it: choose another folder, or "
            "add --force to do it anew"
        )
    note(SERVED)
    return before


def _without_chain(drive: Machine, why: str, logs: int, folder: Path, asked: str) -> dict[str, Any]:
    """Modes, internal resonance and margins of a machine, with its page."""
    from cabledrive.parameters.drive_file import drive_text
    from cabledrive.report.study.results import DRIVE, REPORT, finish, study_without_chain
    from cabledrive.report.writing import report_html

    results = study_without_chain(drive, why, logs)
    note("report")
    written = {REPORT: report_html([drive]), DRIVE: drive_text(drive)}
    return finish(folder, written, results, asked=asked, code=kept.code_hash())


def _goals(file: str | None, quick: bool, every_law: bool) -> "Goals":
    from cabledrive.studies.study import Goals, load_goals

    wanted = replace(Goals() if file is None else load_goals(file), every_law=every_law)
    fewer = {name: min(most, getattr(wanted, name)) for name, most in QUICK.items()}
    return replace(wanted, **fewer) if quick else wanted


def _studied(
    drive: Drive, logs: tuple[str, ...], wanted: "Goals", folder: Path, asked: str
) -> dict[str, Any]:
    from cabledrive.report.study.results import study_html, write_files
    from cabledrive.studies.study import run_study
    from cabledrive.studies.study.stage_cache import sweep

    sweep(folder)
    sweep(folder / kept.STAGES)
    result = run_study(drive, [Path(log) for log in logs], wanted, folder=folder / kept.STAGES, note=note)
    note("report")
    return write_files(result, folder, study_html(result), asked=asked, code=kept.code_hash())


def _answer(data: dict[str, Any], folder: Path) -> Answer:
    shown = {name: value for name, value in data.items() if name != "provenance"}
    return Answer(data=shown, text=_text(data, folder), provenance=data["provenance"])


def _text(data: dict[str, Any], folder: Path) -> str:
    colour = {"yes": "green", "no": "red"}.get(data["verdict"], "yellow")
    head = f"{data['drive']}: {click.style(data['verdict'], fg=colour, bold=True)}; {data['headline']}"
    said = shown(SAID, data | {"reasons": data["reasons"][1:]})
    tried = [(one["controller"], _tried(one)) for one in data["candidates"]]
    parts = ("\n".join(aligned(pairs)) for pairs in (said, tried))
    return "\n\n".join(filter(None, (head, *parts, f"report: {folder / 'report.html'}")))


def _tried(one: dict[str, Any]) -> str:
    """What became of a law."""
    unit = "mm" if "worst_mm" in one else "deg"
    if not one["runs"]:
        return str(one["reason"])
    worst, low = one[f"worst_{unit}"], one["share_low"]
    reached = "all runs ended early" if worst is None else f"{worst:.3g} {unit}"
    within = "" if low is None else f", at least {percent(low)} of all within the goal"
    return f"worst of {one['runs']} plants {reached}{within}"
