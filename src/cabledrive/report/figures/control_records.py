"""Pictures of one run of a law: reference and output, error, surface, torque, estimates; vibrations."""

from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from cabledrive.report.picture import Picture, picture
from cabledrive.report.style import BLUE, GREEN, INK, LINE, OCHRE, ORANGE, PURPLE, QUIET, RED, label
from cabledrive.rig import Motion, Tracking

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
COLOURS = (BLUE, ORANGE, GREEN, PURPLE, OCHRE, RED, INK)
STYLES = ("-", "--", "-.", ":", "-", "--", "-.")
BINS = 220
POWERS = ("angle", "speed", "acceleration", "3rd derivative", "4th derivative", "5th derivative")


def thinned(time: Array, values: Array, bins: int = BINS) -> tuple[Array, Array]:
    """A history as few points that keep the least and the largest value of each stretch of time.

    ``time``, ``values``, shape (samples,).
    """
    if values.size <= 2 * bins:
        return time, values
    edges = np.linspace(0, values.size, bins + 1).astype(int)
    kept = set()
    for start, end in pairwise(edges):
        part = values[start:end]
        kept |= {start + int(np.argmin(part)), start + int(np.argmax(part))}
    chosen = np.array(sorted(kept | {0, values.size - 1}))
    return time[chosen], values[chosen]


def pulse_picture(name: str, motion: Motion) -> Picture:
    """A pulse and its first five derivatives, each over its largest value.

    ``name``: unique on the page.
    """
    trajectory = motion.trajectory
    time = np.linspace(0.0, trajectory.duration, 601)
    rows = np.atleast_2d(trajectory(time, 5))

    def _draw(figure: "Figure", narrow: bool) -> None:
        panels = figure.subplots(2, 1, sharex=True)
        panels[0].plot(time, np.degrees(rows[0]), color=BLUE)
        panels[0].set_ylabel("deg")
        panels[0].set_title(POWERS[0])
        for power in range(1, 6):
            line = rows[power] / np.abs(rows[power]).max()
            panels[1].plot(time, line, STYLES[power - 1], color=COLOURS[power - 1], linewidth=1.2)
            at = int(np.argmax(line))
            label(panels[1], str(power), (time[at], line[at]), (2, 2), color=COLOURS[power - 1])
        panels[1].set_title("derivatives 1 to 5 over their largest values")
        panels[1].set_ylim(-1.15, 1.3)
        panels[1].set_xlabel("time [s]")

    return picture(name, _draw, wide=300.0, narrow=320.0)


def record_picture(name: str, run: Tracking) -> Picture:
    """Everything of a run over time, as the print shows it figure by figure.

    ``name``: unique on the page.
    """

    def _draw(figure: "Figure", narrow: bool) -> None:
        panels = figure.subplots(5, 1, sharex=True)
        _output(panels[0], run)
        _error(panels[1], run)
        _history(
            panels[2], run.time, run.sigma / np.abs(run.sigma).max(), "surface over its largest value", ""
        )
        _history(panels[3], run.time, run.torque, "torque", "N m")
        _estimates(panels[4], run)
        panels[4].set_xlabel("time [s]")

    return picture(name, _draw, wide=560.0, narrow=620.0)


def _history(axes: "Axes", time: Array, values: Array, title: str, unit: str) -> None:
    axes.axhline(0.0, color=LINE, linewidth=1.0)
    axes.plot(*thinned(time, values), color=BLUE, linewidth=1.1)
    axes.set_title(title)
    axes.set_ylabel(unit)


def _output(axes: "Axes", run: Tracking) -> None:
    axes.plot(*thinned(run.time, np.degrees(run.reference)), color=QUIET, linewidth=3.0, alpha=0.6)
    axes.plot(*thinned(run.time, np.degrees(run.load_angle)), color=BLUE, linewidth=1.1)
    axes.set_title("reference (wide, grey) and load angle")
    axes.set_ylabel("deg")


def _error(axes: "Axes", run: Tracking) -> None:
    _history(
        axes,
        run.time,
        np.degrees(run.error),
        f"error, at most {run.summary['peak_error_deg']:.3f} deg",
        "deg",
    )
    if run.bound is not None:
        for sign in (-1.0, 1.0):
            axes.plot(*thinned(run.time, sign * np.degrees(run.bound)), ":", color=QUIET, linewidth=1.0)


def _estimates(axes: "Axes", run: Tracking) -> None:
    """Each estimate as a share of its range; p1 or p2 comes first."""
    low, high = run.estimate_bounds
    first = 1 if len(low) == 7 else 2
    shares = (run.estimates - low) / np.where(high > low, high - low, 1.0)
    for i, share in enumerate(shares.T):
        axes.plot(*thinned(run.time, share), STYLES[i], color=COLOURS[i], linewidth=1.1)
    places = _apart(shares[-1])
    for i, place in enumerate(places):
        at = (run.time[-1], place)
        label(axes, f"p{first + i}", at, (3, -3), color=COLOURS[i], annotation_clip=False)
    for edge in (0.0, 1.0):
        axes.axhline(edge, color=LINE, linewidth=1.0)
    axes.set_ylim(-0.1, 1.1)
    axes.set_title("estimates within their bounds, 0 to 1")


def _apart(values: Array, least: float = 0.2) -> Array:
    """Places for names beside values, moved up where they would lie on one another."""
    places, floor = np.zeros(values.size), -1.0
    for i in np.argsort(values):
        floor = places[i] = max(float(values[i]), floor + least)
    return places - max(0.0, 0.5 * (float(places.max()) - 1.1))


def vibrations_picture(name: str, runs: Sequence[tuple[str, Tracking]]) -> Picture:
    """Deviation of drive pulley and load from the reference over time, a panel for each run.

    ``name``: unique on the page; ``runs``: what to call each run, and the run.
    """

    def _draw(figure: "Figure", narrow: bool) -> None:
        panels = figure.subplots(len(runs), 1, sharex=True, squeeze=False)[:, 0]
        for axes, (words, run) in zip(panels, runs, strict=True):
            axes.axhline(0.0, color=LINE, linewidth=1.0)
            for inertia, colour, style in ((-2, ORANGE, "-"), (-1, BLUE, "--")):
                off = np.degrees(run.angles[:, inertia] - run.reference)
                axes.plot(*thinned(run.time, off, 320), style, color=colour, linewidth=1.0)
            axes.set_title(words)
            axes.set_ylabel("deg")
        panels[-1].set_xlabel("time [s]")

    height = 92.0 * len(runs) + 45.0
    return picture(name, _draw, wide=height, narrow=height)
