"""What `simulate` says of a run, and which pictures of it cannot be drawn."""

from collections.abc import Iterator
from typing import Any

from cabledrive.app.results import NewFile
from cabledrive.parameters import Drive, InputRefused
from cabledrive.parameters.route import RoutedDrive
from cabledrive.parameters.units import to_si
from cabledrive.simulation import Pluck, SimulationResult
from cabledrive.simulation.network import NetworkResult


def plucks_of(given: tuple[str, ...], shape: str) -> tuple[Pluck, ...]:
    """Plucks from "SPAN=HEIGHT"."""
    found = []
    for words in given:
        span, equals, height = words.rpartition("=")
        if not equals:
            raise InputRefused(f'--pluck "{words[:60]}": write SPAN=HEIGHT, such as "motor to idler=1 mm"')
        found.append(Pluck(height=to_si(height.strip(), "m"), span=span.strip(), shape=shape))
    return tuple(found)


def method_of(result: Any) -> str:
    """How a run was made, in one line."""
    method = result.provenance["method"]
    if isinstance(result, NetworkResult):
        words = f"verlet, {method['model']} cable, {method['segments']} segments on the longest span"
        return words + (", bodies travel" if result.travels else "")
    if method["model"] == "fast":
        sines = f"{method['sines']} sines per span"
        return f"{method['name']}, {sines}, valid below {method['ends_at_hz']:.4g} Hz"
    words = f"{method['name']}, {method['model']} cable, {method['segments']} segments per span"
    return f"{words}, {method['friction']} friction"


def run_text(drive: Drive | RoutedDrive, result: Any, asked: float) -> str:
    """Lines of the answer; ``asked``: duration of the run [s]."""
    found = result.summary()
    short = f" of {asked:.6g} s asked for" if result.stopped else ""
    lines = [
        f"{drive.title or drive.name}: {result.steps * result.step:.6g} s{short}",
        f"{result.steps} steps of {result.step:.4g} s, {100 * found['cfl']:.0f} % of the stable one",
        method_of(result),
        *(_of_a_route(result, found) if isinstance(result, NetworkResult) else _of_a_loop(result, found)),
        *(f"slack: {event['span']} at {event['time']:.6g} s" for event in found["slack_events"][:5]),
    ]
    return "\n".join(lines)


def _of_a_loop(result: SimulationResult, found: dict[str, Any]) -> Iterator[str]:
    yield f"load angle, peak to peak    {found['load_angle']['peak_to_peak']:.6g} rad"
    for span in result.spans:
        yield f"{span} midpoint, peak of |w|  {found[f'{span}_midpoint']['peak']:.6g} m"
    yield f"energy budget error         {_number(found['energy_budget_error'], '.2e')}"
    if result.error_estimate is not None:
        for name in ("load_angle", "upper_midpoint"):
            share = 100.0 * getattr(result.error_estimate, name).relative
            yield f"estimated error of {name.replace('_', ' ')}: {share:.2g} % of its peak"
    if result.interpreted:
        yield f"interpreted, slower: {result.interpreted}"


def _of_a_route(result: NetworkResult, found: dict[str, Any]) -> Iterator[str]:
    units = {channel.name: channel.unit for channel in result.channels}
    yield from ("", f"  {'coordinate':<32} peak to peak")
    for name, part in found["coordinates"].items():
        yield f"  {name:<32} {part['peak_to_peak']:.6g} {units[name]}"
    yield from ("", f"  {'span':<44} least tension  midpoint, peak of |w|")
    for span in found["spans"]:
        peak = _number(span["midpoint_peak"], none="left out")
        yield f"  {span['name']:<44} {_number(span['least_tension']):>10} N   {peak}"
    for wrap in found["wraps"]:
        of = "" if wrap["friction"] is None else f" of {wrap['friction']:.3g}"
        yield f"friction that {wrap['pulley']} needs  {wrap['needed_friction']:.3g}{of}"
    yield f"energy budget error  {_number(found['energy_budget_error'], '.2e')}"
    yield from (f"note: {line}" for line in result.assumptions)
    yield from (f"warning: {line}" for line in result.warnings)


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
            from cabledrive.report.animation import animation_page

            animate.write(animation_page(drive, result))
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
