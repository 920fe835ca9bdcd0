"""`python -m reproduction`: the dissertation computed anew, item by item."""

import json
from hashlib import sha256
from pathlib import Path
from typing import Any

import click

from cabledrive.app.failures import interrupted, note, run_to_its_end, status_of
from cabledrive.app.options import Subcommand, answering
from cabledrive.app.results import Answer, plain
from cabledrive.parameters import InputRefused
from cabledrive.parameters.files import (
    check_folder_writable,
    intact_object,
    one_process,
    with_own_hash,
    write_whole,
)
from reproduction import run

RESULTS, REPORT, FINISHED = "results.json", "report.html", "entries"


@click.command(
    cls=Subcommand,
    example="python -m reproduction --quick -o dissertation",
    short_help="Recompute the results of the dissertation and compare them with the printed values.",
)
@answering
@click.option("--quick", is_flag=True, help="Fewer runs of the rig and a coarser loop.")
@click.option(
    "--only", metavar="TEXT", help='What to compute: "Fig. 5.3", "Table 3.2", "Section 6.5.1"; default: all.'
)
@click.option("--resume", is_flag=True, help="Resume an interrupted run (also without this option).")
@click.option("--force", is_flag=True, help="Replace results in DIR.")
@click.option("-o", "--output", required=True, metavar="DIR", help="Folder for report.html and results.json.")
def command(quick: bool, only: str | None, resume: bool, force: bool, output: str) -> Answer:
    """Compute every table, figure and printed number anew and say of each whether it agrees.

    Verdicts: agrees, erratum, differs, not computable, each with its reason. Finished entries are kept in DIR
    and not done again while the package does not change.
    """
    if not output:
        raise InputRefused("--output names no folder: give one, or . for this one")
    folder = Path(output)
    if not force and (before := _finished(folder, quick, only)) is not None:
        return _answer(before, folder)
    _check(folder, force=force or resume)
    run.chosen_entries(only)
    try:
        with one_process(folder / FINISHED):
            before = None if force else _finished(folder, quick, only)  # by another process meanwhile
            return _answer(before or _reproduced(quick, only, folder), folder)
    except KeyboardInterrupt:
        raise KeyboardInterrupt(
            f"what is finished is kept in {folder / FINISHED}; to go on, give the same command again"
        ) from None


def _reproduced(quick: bool, only: str | None, folder: Path) -> dict[str, Any]:
    from reproduction.page import reproduction_html

    found = run.reproduce(quick=quick, only=only, folder=folder / FINISHED, note=note)
    note("report")
    page = reproduction_html(found)
    write_whole(folder / REPORT, page, force=True)
    files = {REPORT: sha256(page.encode()).hexdigest()}
    data = with_own_hash(json.loads(json.dumps(plain(found.plain() | {"files": files}), allow_nan=False)))
    write_whole(folder / RESULTS, json.dumps(data, indent=1, allow_nan=False) + "\n", force=True)
    return data


def _answer(data: dict[str, Any], folder: Path) -> Answer:
    shown = {name: value for name, value in data.items() if name not in ("provenance", "figures")}
    shown["calls"] = {figure["figure"]: figure["call"] for figure in data["figures"]}
    return Answer(data=shown, text=_text(data, folder), provenance=data["provenance"])


def _finished(folder: Path, quick: bool, only: str | None) -> dict[str, Any] | None:
    """Results that are there, whole and by the same sources."""
    data = intact_object(folder / RESULTS) or {}
    try:
        made = sha256((folder / REPORT).read_bytes()).hexdigest()
        same = data["files"][REPORT] == made and data["provenance"]["source_hash"] == run.source_hash()
    except (OSError, KeyError):
        return None
    if not same or (data["quick"], data.get("only")) != (quick, only):
        return None
    note("no input has changed: results of the finished run")
    return data


def _check(folder: Path, *, force: bool) -> None:
    check_folder_writable(folder)
    taken = [name for name in (RESULTS, REPORT) if (folder / name).exists()]
    if taken and not force and not (taken == [REPORT] and (folder / FINISHED).is_dir()):
        raise InputRefused(f"{folder / taken[0]}: exists: choose another folder, or add --force")


def _text(data: dict[str, Any], folder: Path) -> str:
    items = data["items"]
    lines = [f"{len(items)} items of the dissertation", ""]
    for verdict, count in data["counts"].items():
        fixed = data["cannot_fail"][verdict]
        lines.append(
            f"  {verdict:<16}{count:>5}" + (f"   of these {fixed} test nothing computed" if fixed else "")
        )
    calls = sorted({figure["call"] for figure in data["figures"]})
    found = [item for item in items if item["verdict"] == "differs"]
    lines += ["", "what differs:"] if found else []
    for item in found:
        values = f"printed {_shown(item['printed'])}, computed {_shown(item['computed'])} {item['unit']}"
        lines += [f"  {item['source']}: {values}", f"    {item['note']}"]
    if data.get("only") is not None and calls:
        lines += ["", "made by:", *(f"  {call}" for call in calls)]
    return "\n".join([*lines, "", f"report: {folder / REPORT}"])


def _shown(value: float | str | None) -> str:
    return f"{value:.5g}" if isinstance(value, float) else str(value)


if __name__ == "__main__":
    raise SystemExit(
        run_to_its_end(lambda: status_of(lambda: command.main(standalone_mode=False)), interrupted)
    )
