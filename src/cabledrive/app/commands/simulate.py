"""`cabledrive simulate`: the nonlinear cable loop in time, with an audit of its own error."""

from typing import TYPE_CHECKING, Any

import click

from cabledrive.answers.figures import aligned, stated
from cabledrive.app.combinations import refuse_given, tell_given
from cabledrive.app.failures import QUIET, note
from cabledrive.app.options import force_option, machine_argument, option, subcommand
from cabledrive.app.results import Answer, NewFile, provenance
from cabledrive.app.tracked import move_of
from cabledrive.parameters import InputRefused, Machine
from cabledrive.parameters.units import to_si

if TYPE_CHECKING:
    from cabledrive.simulation import Pluck, Scheme, Signal
    from cabledrive.simulation.travel import PlannedMove

FEWEST_RECORDS = 16
_NOT_FAST = (
    *("method", "segments", "fields", "tension_only", "smooth_friction", "error_estimate", "resume"),
    *("torque_on", "moves", "rise", "travel"),
)


@subcommand(
    "cabledrive simulate dissertation-2 --duration 1 --torque-amplitude 0.02 --torque-frequency 81.7 "
    "--pluck-upper '1 mm' -o run.nc",
    (force_option,),
)
@option("-o --output", ".nc", "Write everything to RUN.nc (NetCDF).", metavar="RUN.nc")
@machine_argument
@option("--duration", "s", "Length of the run.", required=True)
@option("--torque-amplitude", "N m", "Torque of the motor, a sine.")
@option("--torque-frequency", "Hz", "Its frequency; 0: a constant torque.")
@option("--pluck", "SPAN=M", "Height of a pluck of a span in w, at midspan; repeatable.", multiple=True)
@option("--pluck-upper", "m", "The same of the upper span of a loop or line.", 0.0)
@option("--pluck-lower", "m", "The same of the lower span.", 0.0)
@option("--torque-on", "NAME", "Of a machine with routes: pulley of the motor.")
@option(
    "--move moves",
    "NAME=M",
    "Of a machine with routes: a body goes far, motors turn as it asks for; repeatable.",
    multiple=True,
)
@option("--rise", "s", "Time that the move takes.")
@option("--travel", "flag", "Spans follow bodies and rope that go far under torques.")
@option("--pluck-shape", "triangle|half-sine", "", "triangle")
@option(
    "--model",
    "exact|weak|weak-consistent|linear|fast",
    "Cable law; fast: transverse modes under uniform tension instead of cable segments.",
    "exact",
)
@option("--method", "TEXT", "Time integrator: verlet, node-centred, energy-conserving.", "verlet")
@option("--segments", "count", "Segments per span; default: 200, where bodies travel 16 on the longest.")
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
    "Animate the first periods of the machine, with a switch. Not with --model fast or bodies that travel.",
    metavar="FILE",
)
@option("--resume", "flag", "Resume an interrupted run.")
def command(
    drive: Machine,
    output: NewFile | None,
    plot: NewFile | None,
    animate: NewFile | None,
    **options: Any,
) -> Answer:
    """Simulate the nonlinear cable of DRIVE, from the straight cable at rest or plucked.

    A machine with routes moves about its state of rest.
    """
    if options["model"] == "fast":
        refuse_given(*_NOT_FAST, why="does not go with --model fast: leave it out or use --model exact")
    if output is None and animate is None:
        refuse_given("fields", why="keeps nodes in RUN.nc or for --animate: add -o RUN.nc, or leave it out")
    if plot is not None and options["duration"] * options["rate"] < FEWEST_RECORDS:
        raise InputRefused(
            f"--plot: {options['duration']:.4g} s at --rate {options['rate']:.4g} Hz are less than the "
            f"{FEWEST_RECORDS} records that a spectrum needs: raise the rate, or run longer"
        )
    if not (options["pluck_upper"] or options["pluck_lower"] or options["pluck"]):
        tell_given("pluck_shape", why="has no effect: no span is plucked")
    if animate is not None:
        options["fields"] = fields_to_animate(drive, options)
    from cabledrive.simulation import Recording, Start, simulate

    plucks, torque = _plucks(options), _torque(options["torque_amplitude"], options["torque_frequency"])
    hung = Start(plucks=plucks, from_equilibrium=True) if options["from_equilibrium"] else None
    recording = Recording(rate=options["rate"], fields=options["fields"])
    kept: dict[str, Any] = {} if output is None else {"output": output.path, "force": output.force}
    result: Any
    if options["model"] == "fast":
        from cabledrive.reduction.fast_simulation import FastScheme, simulate_fast

        result = simulate_fast(
            drive,
            options["duration"],
            torque=torque,
            start=hung or Start(plucks=plucks),
            scheme=FastScheme(step=options["step"]),
            recording=recording,
            **kept,
        )
    else:
        travel = _travel(options)
        result = simulate(
            drive,
            options["duration"],
            torque=torque if options["torque_on"] is None else {options["torque_on"]: torque},
            start=hung or plucks,
            scheme=_scheme(options, travels=bool(travel)),
            recording=recording,
            travel=travel,
            error_estimate=options["error_estimate"],
            resume=options["resume"],
            progress=False if click.get_current_context().meta.get(QUIET) else None,
            **kept,
        )
    if result.path is not None:
        note(f"written to {result.path}")
    missing = undrawn(drive, result, plot, animate)
    return Answer(
        data=result.keys(result.summary()),
        text=run_text(drive, result, options["duration"]),
        provenance=provenance(drive, method=method_of(result), step=result.step) | result.provenance,
        incomplete="; ".join(words for words in (result.stopped, missing) if words) or None,
    )


def _travel(options: dict[str, Any]) -> "PlannedMove | bool":
    """The move that the motors make, or whether bodies go far under given torques."""
    from cabledrive.simulation.travel import PlannedMove

    if not options["moves"]:
        refuse_given("rise", why="is that of a move: add --move NAME=M, or leave it out")
        return bool(options["travel"])
    turn = "does not go with --move, for which the motors turn as the move asks: leave it out"
    refuse_given("torque_amplitude", "torque_frequency", "torque_on", why=turn)
    if options["rise"] is None:
        raise InputRefused("--move needs --rise, the time that it takes: add --rise 10s")
    return PlannedMove(moves=dict(map(move_of, options["moves"])), rise=options["rise"])


def _torque(amplitude: float | None, frequency: float | None) -> "Signal | float":
    from cabledrive.simulation import Constant, Sine

    if (amplitude is None) != (frequency is None):
        missing = "--torque-frequency" if frequency is None else "--torque-amplitude"
        raise InputRefused(f"{missing} is missing: a torque needs both its amplitude and its frequency")
    if amplitude is None or frequency is None:
        return 0.0
    if frequency < 0.0:
        raise InputRefused(f"--torque-frequency = {frequency:.4g} Hz must not be negative: give 0 or more")
    return Sine(amplitude=amplitude, frequency=frequency) if frequency else Constant(amplitude)


def _scheme(options: dict[str, Any], *, travels: bool) -> "Scheme":
    from cabledrive.simulation import Scheme
    from cabledrive.simulation.travel.prepare import SEGMENTS

    return Scheme(
        model=options["model"],
        method=options["method"],
        segments=options["segments"] or (SEGMENTS if travels else Scheme().segments),
        step=options["step"],
        slack="tension-only" if options["tension_only"] else "stop",
        friction="smoothed" if options["smooth_friction"] else "stick-slip",
    )


def _plucks(options: dict[str, Any]) -> "tuple[Pluck, ...]":
    """Plucks from "SPAN=HEIGHT", and of the two spans that have options of their own."""
    from cabledrive.simulation import Pluck

    both = {span: options[f"pluck_{span}"] for span in ("upper", "lower")}
    found = [(span, height) for span, height in both.items() if height]
    for words in options["pluck"]:
        span, equals, height = words.rpartition("=")
        if not equals:
            raise InputRefused(f'--pluck "{words[:60]}": write SPAN=HEIGHT, such as "motor to idler=1 mm"')
        found.append((span.strip(), to_si(height.strip(), "m")))
    return tuple(Pluck(height=height, span=span, shape=options["pluck_shape"]) for span, height in found)


def method_of(result: Any) -> str:
    """How a run was made, in one line."""
    method = result.provenance["method"]
    if method["model"] == "fast":
        sines = f"{method['sines']} sines per span"
        return f"{method['name']}, {sines}, valid below {method['ends_at_hz']:.4g} Hz"
    words = f"{method['name']}, {method['model']} cable, {method['segments']} segments on the longest span, "
    return f"{words}{method['friction']} friction" + (", bodies travel" if method.get("travels") else "")


def run_text(drive: Machine, result: Any, asked: float) -> str:
    """Lines of the answer; ``asked``: duration of the run [s]."""
    found = result.summary()
    short = f" of {asked:.6g} s asked for" if result.stopped else ""
    lines = [f"{drive.title or drive.name}: {result.steps * result.step:.6g} s{short}", method_of(result)]
    lines += aligned(result.figures)
    units = {channel.name: channel.unit for channel in result.channels}
    for name, part in found.get("coordinates", {}).items():
        estimate = (found.get("error_estimate") or {}).get(name)
        error = f", estimated error {100.0 * estimate['relative']:.2g} %" if estimate else ""
        lines.append(f"  {name:<32} {part['peak_to_peak']:.6g} {units[name]} peak to peak{error}")
    for span in found.get("spans", ()):
        least, peak = stated(span["least_tension"], 5), stated(span["midpoint_peak"], 5)
        lines.append(
            f"  {span['name']:<44} least tension {least or 'no record'} N, peak of |w| {peak or 'left out'}"
        )
    for wrap in found.get("wraps", ()):
        of = "" if wrap["friction"] is None else f" of {wrap['friction']:.3g}"
        lines.append(f"  friction that {wrap['pulley']} needs  {wrap['needed_friction']:.3g}{of}")
    lines += [f"slack: {event['span']} at {event['time']:.6g} s" for event in found["slack_events"][:5]]
    return "\n".join(lines)


def undrawn(drive: Any, result: Any, plot: NewFile | None, animate: NewFile | None) -> str | None:
    """Draw what was asked for, and say why a picture is not there: the run itself is done by then."""
    try:
        if plot is not None:
            from cabledrive.report.figures.run_histories import run_plot

            plot.write(run_plot(drive, result, plot.path.suffix[1:].lower()))
        if animate is not None:
            from cabledrive.report.animation import animation_page

            animate.write(animation_page(drive, result))
    except InputRefused as refusal:
        return f"not drawn: {refusal}"
    return None


def fields_to_animate(drive: Machine, options: dict[str, Any]) -> int:
    """Every how many records all nodes are kept: as asked for, else often enough to follow the motion."""
    from cabledrive.report.animation import frame_interval

    if options["model"] == "fast":
        raise InputRefused("--animate does not go with --model fast: leave it out or use --model exact")
    if options["travel"] or options["moves"]:
        raise InputRefused(
            "--animate does not go with --travel or --move, which keep no whole fields: use --plot"
        )
    interval = min(frame_interval(drive), options["duration"] / 24.0)
    every = options["fields"] or max(1, round(options["rate"] * interval))
    records = options["duration"] * options["rate"]
    if every > records:
        raise InputRefused(
            f"--animate: all nodes at every {every}th of {records:.0f} records are no two pictures: lower "
            "--fields, raise --rate, or run longer"
        )
    return every
