"""`python -m reproduction`: the dissertation computed anew, item by item."""

import json
from pathlib import Path
from typing import Any

import click

from cabledrive.app.failures import interrupted, note, run_to_its_end, status_of
from cabledrive.app.options import Subcommand, answering
from cabledrive.app.results import Answer, plain
from cabledrive.parameters import InputRefused
from cabledrive.parameters.files import check_folder_writable, one_process, write_whole
from reproduction import run
from reproduction.page import reproduction_html

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
@click.option("--force", is_flag=True, help="Replace what others left in DIR.")
@click.option("-o", "--output", required=True, metavar="DIR", help="Folder for report.html and results.json.")
def command(quick: bool, only: str | None, force: bool, output: str) -> Answer:
    """Compute every table, figure and printed number anew and say of each whether it agrees.

    Verdicts: agrees, erratum, differs, not computable, each with its reason. Finished entries are kept in DIR
    and not done again while the package does not change; the page is written anew.
    """
    if not output:
        raise InputRefused("--output names no folder: give one, or . for this one")
    folder = Path(output)
    check_folder_writable(folder)
    taken = [name for name in (RESULTS, REPORT) if (folder / name).exists()]
    if taken and not (force or (folder / FINISHED).is_dir()):
        raise InputRefused(f"{folder / taken[0]}: exists: choose another folder, or add --force")
    run.chosen_entries(only)
    try:
        with one_process(folder / FINISHED):
            found = run.reproduce(quick=quick, only=only, folder=folder / FINISHED, note=note)
            note("report")
            write_whole(folder / REPORT, reproduction_html(found), force=True)
            data = json.loads(json.dumps(plain(found.plain()), allow_nan=False))
            write_whole(folder / RESULTS, json.dumps(data, indent=1) + "\n", force=True)
    except KeyboardInterrupt:
        raise KeyboardInterrupt(
            f"what is finished is kept in {folder / FINISHED}; to go on, give the same command again"
        ) from None
    shown = {name: value for name, value in data.items() if name not in ("provenance", "figures")}
    shown["calls"] = {figure["figure"]: figure["call"] for figure in data["figures"]}
    return Answer(data=shown, text=_text(data, folder), provenance=data["provenance"])


def _text(data: dict[str, Any], folder: Path) -> str:
    items = data["items"]
    lines = [f"{len(items)} items of the dissertation", ""]
    for verdict, count in data["counts"].items():
        fixed = data["cannot_fail"][verdict]
        untested = f"   of these {fixed} test nothing computed" if fixed else ""
        lines.append(f"  {verdict:<16}{count:>5}{untested}")
    calls = sorted({figure["call"] for figure in data["figures"]})
    found = [item for item in items if item["verdict"] == "differs"]
    lines += ["", "what differs:"] if found else []
    for item in found:
        values = [f"{x:.5g}" if isinstance(x, float) else x for x in (item["printed"], item["computed"])]
        lines.append(f"  {item['source']}: printed {values[0]}, computed {values[1]} {item['unit']}")
        lines.append(f"    {item['note']}")
    if data.get("only") is not None and calls:
        lines += ["", "made by:", *(f"  {call}" for call in calls)]
    return "\n".join([*lines, "", f"report: {folder / REPORT}"])


if __name__ == "__main__":
    raise SystemExit(
        run_to_its_end(lambda: status_of(lambda: command.main(standalone_mode=False)), interrupted)
    )
