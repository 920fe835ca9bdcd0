"""`cabledrive simulate`: the nonlinear cable loop in time, with an audit of its own error."""

from pathlib import Path
from typing import Any

import click

from cabledrive.app.combinations import refuse_given, tell_given
from cabledrive.app.failures import QUIET, note
from cabledrive.app.network_answer import simulated_route
from cabledrive.app.options import Quantity, Subcommand, answering, force_option, machine_argument
from cabledrive.app.results import Answer, NewFile, NewFileType, provenance
from cabledrive.app.run_pictures import fields_to_animate, undrawn
from cabledrive.parameters import Drive, InputRefused
from cabledrive.parameters.route import RoutedDrive
from cabledrive.simulation import (
    Constant,
    Pluck,
    Recording,
    Scheme,
    Signal,
    SimulationResult,
    Sine,
    Start,
    simulate,
)

FEWEST_RECORDS = 16
_OF_ROUTES = ("pluck", "torque_on", "moves", "rise", "travel")


@click.command(
    cls=Subcommand,
    example="cabledrive simulate dissertation-2 --duration 1 --torque-amplitude 0.02 --torque-frequency 81.7 "
    "--pluck-upper '1 mm' -o run.nc",
    short_help="Integrate the nonlinear cable loop in time.",
)
@answering
@force_option
@click.option(
    "-o", "--output", type=NewFileType(".nc"), metavar="RUN.nc", help="Write everything to RUN.nc (NetCDF)."
)
@machine_argument
@click.option("--duration", type=Quantity("s"), required=True, metavar="S", help="Length of the run.")
@click.option("--torque-amplitude", type=Quantity("N m"), metavar="NM", help="Torque of the motor, a sine.")
@click.option(
    "--torque-frequency", type=Quantity("Hz"), metavar="HZ", help="Its frequency; 0: a constant torque."
)
@click.option(
    "--pluck-upper", type=Quantity("m"), default=0.0, metavar="M", help="Height of a pluck in w, at midspan."
)
@click.option(
    "--pluck-lower", type=Quantity("m"), default=0.0, metavar="M", help="The same on the lower span."
)
@click.option(
    "--pluck", multiple=True, metavar="SPAN=M", help="Of a machine with routes: pluck of a span; repeatable."
)
@click.option("--torque-on", metavar="NAME", help="Of a machine with routes: pulley of the motor.")
@click.option(
    "--move",
    "moves",
    multiple=True,
    metavar="NAME=M",
    help="Of a machine with routes: a body goes far, motors turn as it asks for; repeatable.",
)
@click.option("--rise", type=Quantity("s"), metavar="S", help="Time that the move takes.")
@click.option(
    "--travel", is_flag=True, help="Of a machine with routes: spans follow bodies that go far under torques."
)
@click.option(
    "--pluck-shape", type=click.Choice(["triangle", "half-sine"]), default="triangle", show_default=True
)
@click.option(
    "--model",
    type=click.Choice(["exact", "weak", "weak-consistent", "linear", "fast"]),
    default="exact",
    show_default=True,
    help="Cable law; fast: transverse modes under uniform tension instead of cable segments.",
)
@click.option(
    "--method",
    default="verlet",
    show_default=True,
    help="Time integrator: verlet, node-centred, energy-conserving.",
)
@click.option(
    "--segments",
    type=int,
    default=Scheme().segments,
    show_default=True,
    help="Segments per span; where bodies travel 16 on the longest.",
)
@click.option("--step", type=Quantity("s"), metavar="S", help="Time step; default: chosen by stability.")
@click.option(
    "--rate",
    type=Quantity("Hz"),
    default=10_000.0,
    metavar="HZ",
    help="Records per second; default: 10 kHz.",
)
@click.option("--fields", type=int, default=0, metavar="N", help="Keep all nodes at every N-th record.")
@click.option("--from-equilibrium", is_flag=True, help="Start from where the cable hangs.")
@click.option("--tension-only", is_flag=True, help="Let the cable go slack instead of stopping the run.")
@click.option("--smooth-friction", is_flag=True, help="Smooth Coulomb friction instead of stick-slip.")
@click.option("--error-estimate", is_flag=True, help="Estimate the discretisation error by coarser runs.")
@click.option(
    "--plot",
    type=NewFileType(".png", ".svg", ".pdf"),
    metavar="FILE",
    help="Draw time histories and spectrum: .png, .svg or .pdf.",
)
@click.option(
    "--animate",
    type=NewFileType(".gif", ".html"),
    metavar="FILE",
    help="Animate the first periods of the loop: .gif, or .html with a switch. Not with --model fast.",
)
@click.option("--resume", is_flag=True, help="Resume an interrupted run.")
def command(
    drive: Drive | RoutedDrive,
    output: NewFile | None,
    plot: NewFile | None,
    animate: NewFile | None,
    **options: Any,
) -> Answer:
    """Simulate the nonlinear cable of DRIVE, from the straight cable at rest or plucked.

    A machine with routes moves about its state of rest; its spans are plucked by name with --pluck.
    """
    if isinstance(drive, RoutedDrive):
        torque = _torque(options["torque_amplitude"], options["torque_frequency"])
        _check_records(options, plot=plot is not None)
        return simulated_route(drive, torque, output, plot, options)
    refuse_given(*_OF_ROUTES, why='is for machines of kind "route": leave it out')
    _check_combination(options, kept=output is not None or animate is not None, plot=plot is not None)
    if animate is not None:
        options["fields"] = fields_to_animate(drive, options)
    run = _fast_run if options["model"] == "fast" else _exact_run
    result = run(drive, output, options)
    if result.path is not None:
        note(f"written to {result.path}")
    return _answer(drive, result, undrawn(drive, result, plot, animate))


def _check_combination(options: dict[str, Any], *, kept: bool, plot: bool) -> None:
    """Refuse or report what would have no effect."""
    if options["model"] == "fast":
        refuse_given(*_NOT_FAST, why="does not go with --model fast: leave it out or use --model exact")
    if not kept:
        refuse_given("fields", why="keeps nodes in RUN.nc or for --animate: add -o RUN.nc, or leave it out")
    _check_records(options, plot=plot)
    if not (options["pluck_upper"] or options["pluck_lower"]):
        tell_given("pluck_shape", why="has no effect: no span is plucked")


def _check_records(options: dict[str, Any], *, plot: bool) -> None:
    """Refuse a picture of fewer records than its spectrum needs."""
    if plot and options["duration"] * options["rate"] < FEWEST_RECORDS:
        raise InputRefused(
            f"--plot: {options['duration']:.4g} s at --rate {options['rate']:.4g} Hz are less than the "
            f"{FEWEST_RECORDS} records that a spectrum needs: raise the rate, or run longer"
        )


def _exact_run(drive: Drive, output: NewFile | None, options: dict[str, Any]) -> SimulationResult:
    quiet = click.get_current_context().meta.get(QUIET)
    return simulate(
        drive,
        options["duration"],
        torque=_torque(options["torque_amplitude"], options["torque_frequency"]),
        start=_start(drive, options),
        scheme=_scheme(options),
        recording=Recording(rate=options["rate"], fields=options["fields"]),
        error_estimate=options["error_estimate"],
        output=None if output is None else output.path,
        force=output is not None and output.force,
        resume=options["resume"],
        progress=False if quiet else None,
    )


_NOT_FAST = ("method", "segments", "fields", "tension_only", "smooth_friction", "error_estimate", "resume")


def _fast_run(drive: Drive, output: NewFile | None, options: dict[str, Any]) -> SimulationResult:
    from cabledrive.reduction.fast_simulation import FastScheme, simulate_fast

    return simulate_fast(
        drive,
        options["duration"],
        torque=_torque(options["torque_amplitude"], options["torque_frequency"]),
        start=_start(drive, options),
        scheme=FastScheme(step=options["step"]),
        recording=Recording(rate=options["rate"]),
        output=None if output is None else output.path,
        force=output is not None and output.force,
    )


def _torque(amplitude: float | None, frequency: float | None) -> Signal:
    if (amplitude is None) != (frequency is None):
        missing = "--torque-frequency" if frequency is None else "--torque-amplitude"
        raise InputRefused(f"{missing} is missing: a torque needs both its amplitude and its frequency")
    if amplitude is None or frequency is None:
        return Constant(0.0)
    if frequency < 0.0:
        raise InputRefused(f"--torque-frequency = {frequency:.4g} Hz must not be negative: give 0 or more")
    return Sine(amplitude=amplitude, frequency=frequency) if frequency else Constant(amplitude)


def _start(drive: Drive, options: dict[str, Any]) -> Start:
    heights = {"upper": options["pluck_upper"], "lower": options["pluck_lower"]}
    plucks = tuple(
        Pluck(height=height, span=span, shape=options["pluck_shape"])
        for span, height in heights.items()
        if height
    )
    return Start(plucks=plucks, from_equilibrium=options["from_equilibrium"])


def _scheme(options: dict[str, Any]) -> Scheme:
    return Scheme(
        model=options["model"],
        method=options["method"],
        segments=options["segments"],
        step=options["step"],
        slack="tension-only" if options["tension_only"] else "stop",
        friction="smoothed" if options["smooth_friction"] else "stick-slip",
    )


def _answer(drive: Drive, result: SimulationResult, undrawn: str | None) -> Answer:
    return Answer(
        data=result.summary(),
        text=_text(drive, result, result.path),
        provenance=provenance(drive, method=_method(result), step=result.step) | result.provenance,
        incomplete="; ".join(words for words in (result.stopped, undrawn) if words) or None,
    )


def _method(result: SimulationResult) -> str:
    method = result.provenance["method"]
    if method["model"] == "fast":
        sines = f"{method['sines']} sines per span"
        return f"{method['name']}, {sines}, valid below {method['ends_at_hz']:.4g} Hz"
    words = f"{method['name']}, {method['model']} cable, {method['segments']} segments per span"
    return f"{words}, {method['friction']} friction"


def _text(drive: Drive, result: SimulationResult, path: Path | None) -> str:
    found = result.summary()
    budget = found["energy_budget_error"]
    lines = [
        f"{drive.title or drive.name}: {result.steps * result.step:.6g} s",
        f"{result.steps} steps of {result.step:.4g} s, {100.0 * result.cfl:.0f} % of the stable one",
        _method(result),
        f"load angle, peak to peak    {found['load_angle']['peak_to_peak']:.6g} rad",
        *(
            f"{span} midpoint, peak of |w|  {found[f'{span}_midpoint']['peak']:.6g} m"
            for span in result.spans
        ),
        f"energy budget error         {'no record' if budget is None else f'{budget:.2e}'}",
    ]
    if result.error_estimate is not None:
        for name in ("load_angle", "upper_midpoint"):
            estimate = getattr(result.error_estimate, name)
            lines.append(
                f"estimated error of {name.replace('_', ' ')}: {100.0 * estimate.relative:.2g} % of its peak"
            )
    if result.interpreted:
        lines.append(f"interpreted, slower: {result.interpreted}")
    lines += [f"slack: {event.span} span at {event.time:.6g} s" for event in result.slack_events[:5]]
    return "\n".join(lines)
