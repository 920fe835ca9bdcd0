"""`cabledrive simulate`: the nonlinear cable loop in time, with an audit of its own error."""

from pathlib import Path
from typing import Any

import click

from cabledrive.app.combinations import refuse_given, tell_given
from cabledrive.app.failures import QUIET, note
from cabledrive.app.options import Subcommand, answering, force_option, machine_argument, option
from cabledrive.app.results import Answer, NewFile, provenance
from cabledrive.app.run_answer import fields_to_animate, simulated_route, undrawn
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
@option("-o --output", ".nc", "Write everything to RUN.nc (NetCDF).", metavar="RUN.nc")
@machine_argument
@option("--duration", "s", "Length of the run.", required=True)
@option("--torque-amplitude", "N m", "Torque of the motor, a sine.")
@option("--torque-frequency", "Hz", "Its frequency; 0: a constant torque.")
@option("--pluck-upper", "m", "Height of a pluck in w, at midspan.", 0.0)
@option("--pluck-lower", "m", "The same on the lower span.", 0.0)
@option("--pluck", "SPAN=M", "Of a machine with routes: pluck of a span; repeatable.", multiple=True)
@option("--torque-on", "NAME", "Of a machine with routes: pulley of the motor.")
@option(
    "--move moves",
    "NAME=M",
    "Of a machine with routes: a body goes far, motors turn as it asks for; repeatable.",
    multiple=True,
)
@option("--rise", "s", "Time that the move takes.")
@option("--travel", "flag", "Of a machine with routes: spans follow bodies that go far under torques.")
@option("--pluck-shape", "triangle|half-sine", "", "triangle")
@option(
    "--model",
    "exact|weak|weak-consistent|linear|fast",
    "Cable law; fast: transverse modes under uniform tension instead of cable segments.",
    "exact",
)
@option("--method", "TEXT", "Time integrator: verlet, node-centred, energy-conserving.", "verlet")
@option("--segments", "count", "Segments per span; where bodies travel 16 on the longest.", Scheme().segments)
@option("--step", "s", "Time step; default: chosen by stability.")
@option("--rate", "Hz", "Records per second; default: 10 kHz.", 10_000.0)
@option("--fields", "count", "Keep all nodes at every N-th record.", 0)
@option("--from-equilibrium", "flag", "Start from where the cable hangs.")
@option("--tension-only", "flag", "Let the cable go slack instead of stopping the run.")
@option("--smooth-friction", "flag", "Smooth Coulomb friction instead of stick-slip.")
@option("--error-estimate", "flag", "Estimate the discretisation error by coarser runs.")
@option("--plot", "picture", "Draw time histories and spectrum: .png, .svg or .pdf.")
@option(
    "--animate",
    ".html",
    "Animate the first periods of the loop, with a switch. Not with --model fast.",
    metavar="FILE",
)
@option("--resume", "flag", "Resume an interrupted run.")
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
