"""`cabledrive experiment`: a log of the virtual rig."""

import click

from cabledrive.app.options import NewFile, NewFileType, Subcommand, answering, drive_argument, force_option
from cabledrive.app.results import Answer, provenance
from cabledrive.parameters import Drive

METHOD = (
    "row of inertias with set-valued friction, Runge-Kutta of order 4 with turns located; sampled instruments"
)


@click.command(
    cls=Subcommand,
    example="cabledrive experiment dissertation-3 --model 1 -o log.csv",
    short_help="Write a log of the virtual rig of a drive.",
)
@answering
@force_option
@drive_argument
@click.option("--excitation", type=click.Path(), metavar="FILE", help="TOML file of the command.")
@click.option("--model", type=click.IntRange(1, 4), help="Plant: Model 1 to 4; by default the highest.")
@click.option("--seed", type=int, default=0, show_default=True, metavar="N", help="Of noise and phases.")
@click.option(
    "-o", "--output", type=NewFileType(".csv"), metavar="LOG.csv", required=True, help="The log to write."
)
def command(drive: Drive, excitation: str | None, model: int | None, seed: int, output: NewFile) -> Answer:
    """Excite the virtual rig of DRIVE and write what its instruments say, in the form `identify` reads."""
    from cabledrive.rig.experiment import experiment, load_excitation
    from cabledrive.rig.log_table import log_csv

    log = experiment(drive, load_excitation(excitation) if excitation else None, model=model, seed=seed)
    output.write(log_csv(log))
    return Answer(
        data={
            "log": str(output.path),
            "rows": len(log),
            "sample_rate_hz": log.sample_rate,
            "channels": {name: log.units[name] for name in log.channels},
        },
        text=f"{len(log)} rows at {log.sample_rate:g} Hz: {', '.join(log.channels)}",
        provenance=provenance(drive, method=METHOD, step=log.interval / 4, seed=seed),
    )
