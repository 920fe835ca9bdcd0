"""What `simulate` answers of a machine with routes, and which pictures of a run cannot be drawn."""

from typing import Any

import click

from cabledrive.app.combinations import refuse_given, tell_given, was_given
from cabledrive.app.failures import QUIET, note
from cabledrive.app.results import Answer, NewFile, provenance
from cabledrive.app.two_motor_answer import move_of
from cabledrive.parameters import Drive, InputRefused
from cabledrive.parameters.route import RoutedDrive
from cabledrive.parameters.units import to_si
from cabledrive.simulation import Pluck, Recording, Scheme, Signal, SimulationResult, simulate
from cabledrive.simulation.network import NetworkResult, NetworkStart
from cabledrive.simulation.travel import PlannedMove
from cabledrive.simulation.travel.prepare import SEGMENTS

_OF_LOOPS = (
    *("pluck_upper", "pluck_lower", "fields", "from_equilibrium", "smooth_friction", "error_estimate"),
    "animate",
)


def simulated_route(
    drive: RoutedDrive,
    torque: Signal,
    output: NewFile | None,
    plot: NewFile | None,
    options: dict[str, Any],
) -> Answer:
    """A run of a machine with routes; ``options``: of the command."""
    refuse_given(*_OF_LOOPS, why='is for kind = "loop" and "line": leave it out')
    if options["model"] == "fast":
        raise InputRefused('kind = "route": --model fast is for loops and lines: take exact')
    if not options["pluck"]:
        tell_given("pluck_shape", why="has no effect: no span is plucked")
    names = [drive.pulley[number].name for number in drive.driven] or [p.name for p in drive.pulley[:1]]
    on = options["torque_on"] or (names[0] if names else None)
    travels = bool(options["moves"]) or options["travel"]
    if not travels:
        refuse_given("rise", why="is that of a move: add --move NAME=M, or leave it out")
    found: Any = simulate(
        drive,
        options["duration"],
        travel=(_planned(options) or True) if travels else False,
        torque={} if on is None else {on: torque},
        start=NetworkStart(plucks=plucks_of(options["pluck"], options["pluck_shape"])),
        scheme=Scheme(
            model=options["model"],
            method=options["method"],
            segments=SEGMENTS if travels and not was_given("segments") else options["segments"],
            step=options["step"],
            slack="tension-only" if options["tension_only"] else "stop",
        ),
        recording=Recording(rate=options["rate"]),
        output=None if output is None else output.path,
        force=output is not None and output.force,
        resume=options["resume"],
        progress=False if click.get_current_context().meta.get(QUIET) else None,
    )
    result: NetworkResult = found
    if result.path is not None:
        note(f"written to {result.path}")
    missing = undrawn(drive, result, plot)
    method = result.provenance["method"]
    words = f"verlet, {method['model']} cable, {method['segments']} segments on the longest span"
    words += ", bodies travel" if result.travels else ""
    return Answer(
        data=result.summary(),
        text=_text(drive, result, words, options["duration"]),
        provenance=provenance(drive, method=words, step=result.step) | result.provenance,
        incomplete="; ".join(words for words in (result.stopped, missing) if words) or None,
    )


def _planned(options: dict[str, Any]) -> PlannedMove | None:
    """The move of the bodies; None where torques are given."""
    if not options["moves"]:
        refuse_given("rise", why="is that of a move: add --move NAME=M, or leave it out")
        return None
    refuse_given(
        "torque_amplitude",
        "torque_frequency",
        "torque_on",
        why="does not go with --move, for which the motors turn as the move asks: leave it out",
    )
    if options["rise"] is None:
        raise InputRefused("--move needs --rise, the time that it takes: add --rise 10s")
    return PlannedMove(moves=dict(map(move_of, options["moves"])), rise=options["rise"])


def plucks_of(given: tuple[str, ...], shape: str) -> tuple[Pluck, ...]:
    """Plucks from "SPAN=HEIGHT"."""
    found = []
    for words in given:
        span, equals, height = words.rpartition("=")
        if not equals:
            raise InputRefused(f'--pluck "{words[:60]}": write SPAN=HEIGHT, such as "motor to idler=1 mm"')
        found.append(Pluck(height=to_si(height.strip(), "m"), span=span.strip(), shape=shape))
    return tuple(found)


def _text(drive: RoutedDrive, result: NetworkResult, words: str, asked: float) -> str:
    """Lines of the answer; ``asked``: duration of the run [s]."""
    found = result.summary()
    short = f" of {asked:.6g} s asked for" if result.stopped else ""
    units = {channel.name: channel.unit for channel in result.channels}
    lines = [
        f"{drive.title or drive.name}: {result.steps * result.step:.6g} s{short}",
        f"{result.steps} steps of {result.step:.4g} s, {100 * found['cfl']:.0f} % of the stable one",
        words,
        "",
        f"  {'coordinate':<32} peak to peak",
        *(
            f"  {name:<32} {part['peak_to_peak']:.6g} {units[name]}"
            for name, part in found["coordinates"].items()
        ),
        "",
        f"  {'span':<44} least tension  midpoint, peak of |w|",
        *(
            f"  {span['name']:<44} {_number(span['least_tension']):>10} N   "
            f"{_number(span['midpoint_peak'], none='left out')}"
            for span in found["spans"]
        ),
        *(
            f"friction that {wrap['pulley']} needs  {wrap['needed_friction']:.3g}"
            + ("" if wrap["friction"] is None else f" of {wrap['friction']:.3g}")
            for wrap in found["wraps"]
        ),
        f"energy budget error  {_number(found['energy_budget_error'], '.2e')}",
        *(f"note: {line}" for line in result.assumptions),
        *(f"warning: {line}" for line in result.warnings),
        *(f"slack: {event['span']} at {event['time']:.6g} s" for event in result.slack_events[:5]),
    ]
    return "\n".join(lines)


def _number(value: float | None, form: str = ".5g", none: str = "no record") -> str:
    """A number, in words where there is none."""
    return none if value is None else format(value, form)


def undrawn(
    drive: Drive | RoutedDrive,
    result: SimulationResult | NetworkResult,
    plot: NewFile | None,
    animate: NewFile | None = None,
) -> str | None:
    """Draw what was asked for, and say why a picture is not there: the run itself is done by then."""
    try:
        if plot is not None:
            from cabledrive.report.figures.run_histories import run_plot

            plot.write(run_plot(drive, result, plot.path.suffix[1:].lower()))
        if animate is not None and isinstance(drive, Drive) and isinstance(result, SimulationResult):
            _write_animation(drive, result, animate)
    except InputRefused as refusal:
        return f"not drawn: {refusal}"
    return None


def fields_to_animate(drive: Drive, options: dict[str, Any]) -> int:
    """Every how many records all nodes are kept: as asked for, else often enough to follow the motion."""
    from cabledrive.report.animation import frame_interval

    if options["model"] == "fast":
        raise InputRefused("--animate does not go with --model fast: leave it out or use --model exact")
    interval = min(frame_interval(drive), options["duration"] / 24.0)
    every = options["fields"] or max(1, round(options["rate"] * interval))
    records = options["duration"] * options["rate"]
    if every > records:
        raise InputRefused(
            f"--animate: all nodes at every {every}th of {records:.0f} records are no two pictures: lower "
            "--fields, raise --rate, or run longer"
        )
    return every


def _write_animation(drive: Drive, result: SimulationResult, animate: NewFile) -> None:
    from cabledrive.report.animation import animation_page

    animate.write(animation_page(drive, result))
