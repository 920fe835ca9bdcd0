"""`cabledrive compare`: control laws side by side on one drive."""

import hashlib
import json
from typing import Any

import click

from cabledrive.answers.runs import COMPARED
from cabledrive.app import finished_study as kept_folder
from cabledrive.app.failures import note
from cabledrive.app.finished_study import REPORT, RESULTS, STAGES
from cabledrive.app.options import ANGLE, axis_argument, force_option, option, pulse_options, subcommand
from cabledrive.app.results import FORCE, Answer, plain, provenance
from cabledrive.parameters import Drive, InputRefused
from cabledrive.parameters.files import with_own_hash, write_whole

METHOD = "Monte Carlo on lumped plants with drawn disturbances, one tuning procedure for all laws"


@subcommand(
    "cabledrive compare dissertation-3 --controllers lqi,lqi-learning --draws 20 -o comparison",
    (axis_argument,),
)
@option("--controllers", "A,B,...", "Laws to compare; default: six; see docs/control.")
@option("--all every_law", "flag", "Compare every law.")
@option("--disturbances", "path", "TOML file: friction of the load, backlash, cogging, delay, shocks ...")
@option("--draws", "count", "Plants for every law.", 100)
@option("--seed", "count", "", 0)
@pulse_options
@option("--pulses", "count", "", 2)
@option("--goal", ANGLE, "Error allowed; default: the drive's, or one count of the load.", metavar="DEG")
@force_option
@option("-o --output", "path", "Folder of page and results.", required=True, metavar="DIR")
def command(
    drive: Drive, controllers: str | None, disturbances: str | None, output: str, **spec: Any
) -> Answer:
    """Compare control laws on DRIVE: each tuned by one procedure, all run on the same drawn plants.

    DIR receives report.html, results.json and the finished parts; the same command goes on where it stopped.
    """
    from cabledrive.report.blocks import table_text
    from cabledrive.report.comparison_page import comparison_html, costs_table, errors_table
    from cabledrive.rig import Motion
    from cabledrive.studies.controller_comparison import compare

    force = bool(click.get_current_context().meta.get(FORCE))
    folder = kept_folder.folder_of(output)
    kept_folder.check_folder(folder, force=force)
    words = [kept_folder.asked_hash(drive, [disturbances]), controllers, spec]
    asked = hashlib.sha256(json.dumps(words, sort_keys=True).encode()).hexdigest()
    before = kept_folder.finished(folder)
    if before is not None and before.get("asked") != asked and not force:
        raise InputRefused(f"{folder}: holds other results: choose another folder, or add --force")
    motion = Motion(**{name: spec[name] for name in ("angle", "rise", "dwell", "pulses")})
    if controllers is not None and spec["every_law"]:
        raise InputRefused("--all compares every law: leave --controllers out")
    names = None if controllers is None else [one.strip() for one in controllers.split(",") if one.strip()]
    with kept_folder.kept_if_interrupted(folder):
        found = compare(
            drive,
            controllers=names,
            **{name: spec[name] for name in ("every_law", "draws", "seed", "goal")},
            disturbances=disturbances,
            motion=motion,
            folder=folder / STAGES,
            note=note,
        )
    about, page = provenance(drive, method=METHOD, seed=spec["seed"]), comparison_html(drive, found)
    write_whole(folder / REPORT, page, force=True)
    said = COMPARED(found.summary)
    kept = plain(said) | {"provenance": about, "asked": asked}
    kept = with_own_hash(kept | {"files": {REPORT: hashlib.sha256(page.encode()).hexdigest()}})
    write_whole(folder / RESULTS, json.dumps(kept, indent=1, allow_nan=False) + "\n", force=True)
    lines = [f"{said['drive']}: {said['best'] or 'no law'} ranks first over {said['draws']} plants"]
    lines += ["", table_text(errors_table(said)), "", table_text(costs_table(said)), ""]
    if learning := [one["name"] for one in said["controllers"] if one["learns"]]:
        lines.append(f"errors after the first pulse: {', '.join(learning)}")
    lines += [f"not covered: {words}" for words in said["not_covered"]]
    lines += ["", f"report: {folder / REPORT}"]
    return Answer(data=said, text="\n".join(lines), provenance=about)
