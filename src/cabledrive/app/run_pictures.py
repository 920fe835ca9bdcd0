"""Pictures that `simulate` draws of its run."""

from typing import Any

from cabledrive.app.results import NewFile
from cabledrive.parameters import Drive, InputRefused
from cabledrive.parameters.route import RoutedDrive
from cabledrive.simulation import SimulationResult
from cabledrive.simulation.network import NetworkResult


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
    from cabledrive.report.animation import animation_gif, animation_page

    gif = animate.path.suffix.lower() == ".gif"
    animate.write(animation_gif(drive, result) if gif else animation_page(drive, result))
