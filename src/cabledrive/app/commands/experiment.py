"""`cabledrive experiment`: a log of the virtual rig."""

from typing import Any

import click

from cabledrive.app.combinations import refuse_given
from cabledrive.app.options import axis_argument, force_option, opt, subcommand
from cabledrive.app.results import Answer, NewFile, log_csv, provenance
from cabledrive.parameters import Drive, InputRefused

PEAKS = "peaks: {torque:.4g} N m, {speed:.4g} rad/s, stroke {stroke:.4g} rad"
METHOD = (
    "multi-inertia model with set-valued friction, Runge-Kutta of order 4 with velocity reversals located; "
    "sampled instruments"
)


@subcommand("cabledrive experiment dissertation-3 --model 1 -o log.csv", (force_option, axis_argument))
def command(
    drive: Drive,
    excitation: str | None = opt("path", "TOML file of the command."),
    model: int | None = opt(click.IntRange(1, 4), "Plant: Model 1 to 4; by default the highest."),
    seed: int = opt("count", "Of noise and phases.", 0),
    plan: bool = opt(
        "flag", "Run nothing: predict the standard errors, and the peaks of torque, speed and stroke."
    ),
    stroke: float | None = opt("rad", "With --plan: largest travel from end to end."),
    output: NewFile | None = opt(".csv", "The log to write.", metavar="LOG.csv", flags="-o --output"),
) -> Answer:
    """Excite the virtual rig of DRIVE and write what its instruments say, in the form `identify` reads."""
    from cabledrive.rig.experiment import experiment, load_excitation
    from cabledrive.rig.run_facts import motor_words

    if plan:
        refuse_given("output", why="writes nothing with --plan, which runs nothing: leave one of them out")
    else:
        refuse_given("stroke", why="belongs to --plan: add that, or leave it out")
    chosen = None if excitation is None else load_excitation(excitation)
    if plan:
        return _planned(drive, chosen, model, stroke, seed)
    if output is None:
        raise InputRefused("no log to write: name it with -o LOG.csv, or ask for --plan")
    log = experiment(drive, chosen, model=model, seed=seed)
    output.write(log_csv(log))
    motor = motor_words(drive)
    data = {
        "log": str(output.path),
        "rows": len(log),
        "sample_rate_hz": log.sample_rate,
        "channels": {name: log.units[name] for name in log.channels},
    }
    text = f"{len(log)} rows at {log.sample_rate:g} Hz: {', '.join(log.channels)}"
    text += f"\n{motor['motor_reason']}" if "motor_reason" in motor else ""
    about = provenance(drive, method=METHOD, step=log.interval / 4, seed=seed)
    return Answer(data=data | motor, text=text, provenance=about)


def _planned(drive: Drive, excitation: Any, model: int | None, stroke: float | None, seed: int) -> Answer:
    """Predicted errors, peaks and warnings."""
    from cabledrive.answers.runs import PLANNED
    from cabledrive.rig.experiment import plan_experiment
    from cabledrive.rig.run_facts import motor_words

    found = plan_experiment(drive, excitation, model=model, stroke=stroke, seed=seed)
    errors = found["relative_standard_error"]
    lines = [
        f"{name}: standard error " + ("not identifiable" if value is None else f"{100 * value:.3g} %")
        for name, value in errors.items()
    ]
    lines.append(PEAKS.format(**found["peaks"]))
    if (factor := found["amplitude_factor"]) is not None:
        lines.append(f"the torque can be raised by a factor of {factor:.3g} before a limit is reached")
    lines += [f"warning: {warning}" for warning in found["warnings"]]
    method = (
        "motion simulated with the parameters of the drive file; noise of torque and encoder "
        "propagated through the regression"
    )
    found |= motor_words(drive)
    lines += [found["motor_reason"]] if "motor_reason" in found else []
    return Answer(
        data=PLANNED(found), text="\n".join(lines), provenance=provenance(drive, method=method, seed=seed)
    )
