"""A run in space and time: the upper span over the time, the tension along the cable, the energy budget."""

from typing import TYPE_CHECKING

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.cable_laws import cable_law
from cabledrive.mechanics.mesh import mesh_of
from cabledrive.mechanics.mesh_forces import gradients
from cabledrive.parameters import Drive, InputRefused
from cabledrive.report.numbers import number
from cabledrive.report.picture import Picture, picture
from cabledrive.report.style import BLUE, GREEN, INK, LINE, OCHRE, ORANGE, PURPLE, QUIET, label
from cabledrive.simulation import SimulationResult

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

HEIGHT = 300.0  # px
LEVELS = 4
MOST_TIMES, MOST_PLACES = 120, 60
ENERGIES = {
    "u": ("axial_energy", GREEN),
    "v and w": ("transverse_energy", ORANGE),
    "elastic": ("strain_energy", BLUE),
}


def span_field(result: SimulationResult, span: str, plane: str = "w") -> Array:
    """Displacements of the nodes of a span at the times of the whole fields.

    ``span``, {"upper", "lower"}; ``plane``, {"u", "v", "w"}.
    Returns shape (field records, n + 1) [m].
    Raises `InputRefused` if the run kept less than two whole fields.
    """
    _check_fields(result)
    segments = result.position.shape[1] - 1
    first = result.spans.index(span) * segments
    return result.fields[:, "uvw".index(plane), first : first + segments + 1]


def tension_field(drive: Drive, result: SimulationResult) -> Array:
    """Tension in every segment at the times of the whole fields, by the cable law of the run.

    ``drive``: the one of the run.
    Returns shape (field records, segments of all spans): round the loop from the drive rim [N].
    Raises `InputRefused` if the run kept less than two whole fields.
    """
    _check_fields(result)
    method = result.provenance["method"]
    mesh = mesh_of(drive, method["segments"])
    law = cable_law(drive.cable, method["model"], tension_only=method["slack"] == "tension-only")
    return np.array([law.tension(*gradients(mesh, field)) for field in result.fields])


def space_time_picture(name: str, result: SimulationResult, span: str = "upper") -> Picture:
    """Map of w along a span over time: blue up, orange down.

    ``name``: unique on the page; ``result``: with whole fields; ``span``, {"upper", "lower"}.
    """
    field = 1e3 * span_field(result, span)
    position = result.position[result.spans.index(span)]

    def _draw(figure: "Figure", narrow: bool) -> None:
        axes = figure.add_subplot()
        _map(axes, figure, 1e3 * result.field_time, position, field.T, "w [mm]")
        axes.set_ylabel("from the pulley [m]")

    return picture(name, _draw, wide=HEIGHT, narrow=HEIGHT)


def tension_picture(name: str, drive: Drive, result: SimulationResult) -> Picture:
    """Map of the tension along the unrolled cable over time, as its difference from the pretension.

    ``name``: unique on the page; ``drive``: the one of the run; ``result``: with whole fields.
    """
    above = tension_field(drive, result) - drive.cable.pretension
    ends = result.position + drive.pulley_distance * np.arange(len(result.spans))[:, None]
    middles = (0.5 * (ends[:, 1:] + ends[:, :-1])).ravel()

    def _draw(figure: "Figure", narrow: bool) -> None:
        axes = figure.add_subplot()
        _map(axes, figure, 1e3 * result.field_time, middles, above.T, "T − T₀ [N]")
        for turn in range(1, len(result.spans)):
            axes.axhline(turn * drive.pulley_distance, color=INK, linewidth=1.0, dashes=(4, 3))
        axes.set_ylabel("along the cable [m]")

    return picture(name, _draw, wide=HEIGHT, narrow=HEIGHT)


def energy_picture(name: str, result: SimulationResult) -> Picture:
    """Where the energy is over time, the work done, what was lost, and below it the error of the budget.

    ``name``: unique on the page.
    """
    shares = {
        words: (1e6 * sum(result.channel(f"{stem}_{span}") for span in result.spans), colour)
        for words, (stem, colour) in ENERGIES.items()
    }
    pulleys = sum(result.channel(f"{shaft}_energy") for shaft in ("drive", "load", "motor"))
    shares["pulleys"] = (1e6 * pulleys, PURPLE)
    work = 1e6 * (result.channel("torque_work") + result.channel("force_work"))
    lost = 1e6 * sum(
        result.channel(f"{kind}_loss") for kind in ("transverse", "axial", "viscous", "coulomb", "joint")
    )
    if np.any(lost):
        shares["lost"] = (lost, OCHRE)

    def _draw(figure: "Figure", narrow: bool) -> None:
        from matplotlib.ticker import FuncFormatter, MaxNLocator

        above, below = figure.subplots(2, 1, sharex=True, height_ratios=(2.2, 1.0))
        for words, (energy, colour) in shares.items():
            above.plot(result.time, energy, color=colour, linewidth=1.1, label=words)
        if np.any(work):
            above.plot(result.time, work, color=INK, linewidth=1.4, dashes=(4, 3), label="work done")
        above.set_ylabel("energy [µJ]")
        above.legend(
            loc="lower left", bbox_to_anchor=(0.0, 1.0), fontsize=10, frameon=False, ncols=3 if narrow else 6
        )
        below.plot(
            result.time, result.budget_error / (result.energy_handled or 1.0), color=INK, linewidth=0.9
        )
        below.set_ylabel("error [-]")
        below.set_xlabel("time [s]")
        below.set_xlim(result.time[0], result.time[-1])
        below.yaxis.set_major_locator(MaxNLocator(3))
        below.yaxis.set_major_formatter(FuncFormatter(lambda value, _: number(value, 2)))

    return picture(name, _draw, wide=HEIGHT + 60, narrow=HEIGHT + 60)


def slack_picture(name: str, result: SimulationResult) -> Picture:
    """Tension of the spans over the torque, up to where one goes slack.

    ``name``: unique on the page; ``result``: with a slack event.
    """
    torque = result.channel("torque")
    event = result.slack_events[0]
    at = float(np.interp(event.time, result.time, torque))

    def _draw(figure: "Figure", narrow: bool) -> None:
        axes = figure.add_subplot()
        axes.axhline(0.0, color=LINE, linewidth=1.0)
        for span, colour in zip(result.spans, (BLUE, ORANGE), strict=False):
            tension = result.channel(f"least_tension_{span}")
            axes.plot(torque, tension, color=colour)
            place = (torque[tension.size // 2], tension[tension.size // 2])
            label(axes, f"{span} span", place, (8, 10 if span == event.span else -18), color=colour)
        axes.plot([at], [0.0], "o", color=INK, markersize=7)
        label(axes, f"slack at {number(at, 4)} N m", (at, 0.0), (-8, -16), ha="right", color=INK)
        axes.set_ylim(bottom=-0.2 * float(result.channel(f"least_tension_{event.span}").max()))
        axes.set_xlabel("torque on the drive pulley [N m]")
        axes.set_ylabel("least tension [N]")

    return picture(name, _draw, wide=HEIGHT - 20, narrow=HEIGHT - 20)


def _map(axes: "Axes", figure: "Figure", time: Array, place: Array, values: Array, words: str) -> None:
    """Filled contours, symmetric about zero, in shades of two hues that follow the page."""
    from matplotlib.colors import to_rgba

    later, further = -(-time.size // MOST_TIMES), max(1, place.size // MOST_PLACES)
    time, place, values = time[::later], place[::further], values[::further, ::later]
    largest = float(np.max(np.abs(values))) or 1.0
    edges = largest * np.linspace(-1.0, 1.0, 2 * LEVELS + 2)
    shades = [to_rgba(ORANGE, k / LEVELS) for k in range(LEVELS, 0, -1)]
    shades += [to_rgba(QUIET, 0.0), *(to_rgba(BLUE, k / LEVELS) for k in range(1, LEVELS + 1))]
    filled = axes.contourf(time, place, values, edges, colors=shades)
    bar = figure.colorbar(filled, ax=axes, label=words, format=lambda value, _: number(value, 2))
    bar.outline.set_visible(False)
    axes.set_xlabel("time [ms]")


def _check_fields(result: SimulationResult) -> None:
    if len(result.fields) < 2:
        raise InputRefused(
            f"{len(result.fields)} whole fields kept, at least 2 are needed: run with Recording(fields=...)"
        )
