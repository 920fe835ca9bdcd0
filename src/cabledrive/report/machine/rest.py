"""A machine at rest: the tension along its cable and its sag under gravity."""

from collections.abc import Iterable

import numpy as np

from cabledrive.answers.figures import quantity
from cabledrive.mechanics.network.rest_forces import RestingStretch
from cabledrive.mechanics.rest import RestState, rest_state
from cabledrive.parameters import Drive, NotComputed
from cabledrive.parameters.arrays import Array
from cabledrive.report.blocks import Block, Panel, Plot, Series, table

POINTS = 65
MOST_ROWS = 8
SEEN = 1e-3
"""Share of a span from which sag is worth a picture, and of the pretension from which weight is."""
COLOURS = {"upper": "blue", "lower": "orange"}


def resting(drive: Drive) -> RestState | None:
    """A machine at rest; None where gravity is off or no rest is found."""
    if drive.layout.gravity == 0.0:
        return None
    try:
        return rest_state(drive)
    except NotComputed:
        return None


def sag_of(stretches: Iterable[RestingStretch]) -> tuple[Array, Array]:
    """Unstretched positions on a span and what lies across its chord there [m], shape (p,) each."""
    places, depths = [], []
    depth = 0.0
    for stretch in stretches:
        fine = np.linspace(stretch.start, stretch.end, 2 * POINTS - 1)
        along, across = stretch.force_at(fine)
        slope = across * (1.0 / stretch.axial_rigidity + 1.0 / np.hypot(along, across))
        step = (fine[2] - fine[0]) / 6.0  # of Simpson's rule
        parts = (slope[:-2:2] + 4.0 * slope[1::2] + slope[2::2]) * step
        places.append(fine[::2])
        depths.append(depth + np.concatenate(([0.0], np.cumsum(parts))))
        depth = float(depths[-1][-1])
    return np.concatenate(places), np.concatenate(depths)


def tension_at(stretches: Iterable[RestingStretch], at: Array) -> Array:
    """Tension along a span, shape (p,) [N]."""
    values = np.full(at.size, np.nan)
    for stretch in stretches:
        on = (at >= stretch.start - 1e-12) & (at <= stretch.end * (1 + 1e-12))
        values[on] = stretch.tension_at(at[on])
    return values


def rest_blocks(drive: Drive, name: str) -> tuple[Block, ...]:
    """Tension and sag along the spans and of every stretch, unless there are too many for a table.

    None where the weight changes neither by a thousandth.
    """
    rest = resting(drive)
    if rest is None:
        return ()
    tensions = [t for stretch in rest.stretches for t in stretch.tensions]
    deepest, pretension = max(section.sag for section in rest.sections), drive.cable.pretension
    sags = deepest > SEEN * drive.span_length
    if not sags and max(abs(t - pretension) for t in tensions) <= SEEN * pretension:
        return ()
    joints = [end for stretch in rest.stretches for end in (stretch.start, stretch.end)]
    inside = np.unique([end for end in joints if 0.0 < end < drive.span_length])
    step = 1e-6 * drive.span_length
    even = np.linspace(0.0, drive.span_length, 2 * POINTS)
    at = np.unique(np.concatenate((even, inside - step, inside + step)))
    spans = {span: [one for one in rest.stretches if one.span == span] for span in drive.spans}
    shown = [("Tension", "N", {span: tension_at(own, at) for span, own in spans.items()})]
    if sags:
        height = {span: -np.interp(at, *sag_of(own)) for span, own in spans.items()}
        shown.append(("Height over the line of the pulleys", "m", height))
    panels = (
        Panel(title, unit, tuple(Series(f"{span} span", own, COLOURS[span]) for span, own in curves.items()))
        for title, unit, curves in shown
    )
    low, high = (quantity(value, "N", 3) for value in (rest.lowest_tension, max(tensions)))
    sag = f", sag up to {quantity(deepest, 'm', 3)}" if sags else ""
    plot = Plot(
        name=f"rest-{name}",
        alt=f"Tension at rest along each span, from {low} to {high}{sag}.",
        caption=f"Tension from {low} to {high}{sag}; drive pulley held. Each carriage steps the tension. "
        "Positions count from the pulley where the span starts.",
        points=at,
        along="position",
        unit="m",
        panels=tuple(panels),
    )
    heads = "Stretch | Tension at its start [] | at its end []"
    rows = (
        (
            f"{one.span} span, {quantity(one.start, 'm', 4)} to {quantity(one.end, 'm', 4)}",
            *(quantity(tension, "N", 4) for tension in one.tensions),
        )
        for one in rest.stretches
    )
    stretches = table("Tension of every stretch at rest.", heads, rows)
    return (plot, stretches) if len(rest.stretches) <= MOST_ROWS else (plot,)
