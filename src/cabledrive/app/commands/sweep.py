"""`cabledrive sweep`: a campaign over many variants of a drive."""

import os
import re

import click

from cabledrive.answers.keys import Keys
from cabledrive.app.failures import QUIET
from cabledrive.app.options import argument, force_option, opt, subcommand
from cabledrive.app.results import FORCE, Answer, provenance
from cabledrive.parameters import InputRefused

METHOD = "each row by its number alone; chunks of rows written whole, their status last"

SWEPT = Keys("count: rows done refused failed number: seconds setup_seconds text: engine store first_reason?")


def part_of(text: str) -> tuple[int, int]:
    """Part i of N, written i/N. Raises `InputRefused` if it is none."""
    found = re.fullmatch(r"(\d{1,9})/(\d{1,9})", text)
    if found is None or not 1 <= int(found[1]) <= int(found[2]):
        raise InputRefused(f'--part "{text}" is none: write i/N, such as 3/16, with i from 1 to N')
    return int(found[1]), int(found[2])


@subcommand("cabledrive sweep campaign.toml -o campaign.zarr --workers 2", (force_option,))
def command(
    spec: str = argument("SPEC.toml", type=click.Path()),
    output: str = opt(
        "path", "Store, made or resumed.", required=True, metavar="STORE.zarr", flags="-o --output"
    ),
    workers: int | None = opt("count", "Processes on this machine; default: its cores."),
    scheduler: str | None = opt("URL", "A running scheduler instead, such as tls://host:8786."),
    part: str | None = opt("i/N", "Part i of N of an array job, in one process."),
    yes: bool = opt("flag", "More than 10^7 rows or 100 GB are meant."),
) -> Answer:
    """Compute the campaign of SPEC.toml into STORE.zarr; the same command again goes on where it was left.

    SPEC.toml names a drive, what is varied in [vary], how in [design], and what is computed in [compute].
    """
    from cabledrive.campaign import run_sweep

    if not output:
        raise InputRefused("--output names no store: give one, such as campaign.zarr")
    if workers is not None and (scheduler or part):
        raise InputRefused("--workers does not go with --scheduler or --part: leave it out")
    quiet = click.get_current_context().meta.get(QUIET)
    found = run_sweep(
        spec,
        output,
        workers=workers or (None if scheduler else 1 if part else available_cores()),
        scheduler=scheduler,
        part=None if part is None else part_of(part),
        yes=yes,
        force=bool(click.get_current_context().meta.get(FORCE)),
        progress=False if quiet else None,
    )
    names = ("rows", "done", "refused", "failed", "seconds", "setup_seconds", "engine")
    data = {name: getattr(found, name) for name in names} | {"store": str(output)}
    data |= {"first_reason": found.first_reason} if found.first_reason else {}
    left = found.rows - found.done
    lines = [
        f"{output}: {found.done} of {found.rows} rows, {found.refused} refused, {found.failed} not completed",
        f"{found.seconds:.3g} s on {found.engine}, and {found.setup_seconds:.3g} s before",
    ]
    lines += [f"the first without a result: {found.first_reason}"] if found.first_reason else []
    lines += [f"{left} rows are left to other parts"] if left else []
    return Answer(data=data, text="\n".join(lines), provenance=provenance(method=METHOD))


def available_cores() -> int:
    """Cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
