"""A machine at rest: the tension along its cable and its sag under gravity."""

import numpy as np

from cabledrive.mechanics.network.rest_forces import RestingStretch
from cabledrive.mechanics.rest import RestState, rest_state
from cabledrive.parameters import Drive, NotComputed
from cabledrive.parameters.arrays import Array
from cabledrive.report.blocks import Panel, Plot, Series, Table, table
from cabledrive.report.typesetting import quantity

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


def sag_of(drive: Drive, span: str) -> tuple[Array, Array]:
    """Unstretched positions on a span and the sag below the line of the pulleys [m], shape (p,) each."""
    rest = resting(drive)
    if rest is None:
        return np.array([0.0, drive.span_length]), np.zeros(2)
    places, depths = [], []
    depth = 0.0
    for stretch in rest.stretches:
        if stretch.span == span:
            at, fallen = _fallen(stretch)
            places.append(at)
            depths.append(depth + fallen)
            depth = float(depths[-1][-1])
    return np.concatenate(places), np.concatenate(depths)


def _fallen(stretch: RestingStretch) -> tuple[Array, Array]:
    """Positions of a stretch [m] and its fall from its start [m]."""
    fine = np.linspace(stretch.start, stretch.end, 2 * POINTS - 1)
    along, across = stretch.force_at(fine)
    if not np.any(across):
        return fine[::2], np.zeros(POINTS)
    slope = across * (1.0 / stretch.axial_rigidity + 1.0 / np.hypot(along, across))
    parts = (slope[:-2:2] + 4.0 * slope[1::2] + slope[2::2]) * (fine[2] - fine[0]) / 6.0  # Simpson's rule
    return fine[::2], np.concatenate(([0.0], np.cumsum(parts)))


def rest_plot(drive: Drive, name: str) -> Plot | None:
    """Tension and sag along the spans; None where the weight changes neither by a thousandth."""
    rest = resting(drive)
    if rest is None or not _worth_showing(drive, rest):
        return None
    joints = [end for stretch in rest.stretches for end in (stretch.start, stretch.end)]
    inside = np.unique([end for end in joints if 0.0 < end < drive.span_length])
    step = 1e-6 * drive.span_length
    at = np.unique(
        np.concatenate((np.linspace(0.0, drive.span_length, 2 * POINTS), inside - step, inside + step))
    )
    lines = (Series(f"{span} span", tension_at(rest, span, at), COLOURS[span]) for span in drive.spans)
    panels = [Panel("Tension", "N", tuple(lines))]
    if max(section.sag for section in rest.sections) > SEEN * drive.span_length:
        height = {span: -np.interp(at, *sag_of(drive, span)) for span in drive.spans}
        curves = tuple(Series(f"{span} span", values, COLOURS[span]) for span, values in height.items())
        panels.append(Panel("Height over the line of the pulleys", "m", curves))
    low = quantity(rest.lowest_tension, "N", 3)
    high = quantity(max(max(stretch.tensions) for stretch in rest.stretches), "N", 3)
    deepest = max(section.sag for section in rest.sections)
    sag = f", sag up to {quantity(deepest, 'm', 3)}" if len(panels) > 1 else ""
    return Plot(
        name=f"rest-{name}",
        alt=f"Tension at rest along each span, from {low} to {high}{sag}.",
        caption=f"Tension from {low} to {high}{sag}; drive pulley held. Each carriage steps the tension. "
        "Positions count from the pulley where the span starts.",
        points=at,
        along="position",
        unit="m",
        panels=tuple(panels),
    )


def _worth_showing(drive: Drive, rest: RestState) -> bool:
    tensions = [t for stretch in rest.stretches for t in stretch.tensions]
    changed = max(abs(t - drive.cable.pretension) for t in tensions) > SEEN * drive.cable.pretension
    return changed or max(section.sag for section in rest.sections) > SEEN * drive.span_length


def tension_at(rest: RestState, span: str, at: Array) -> Array:
    """Tension along a span, shape (p,) [N]."""
    values = np.full(at.size, np.nan)
    for stretch in rest.stretches:
        if stretch.span == span:
            on = (at >= stretch.start - 1e-12) & (at <= stretch.end * (1 + 1e-12))
            values[on] = stretch.tension_at(at[on])
    return values


def rest_table(drive: Drive) -> Table | None:
    """Tension and sag of every section; None without weight, or where there are too many for a table."""
    rest = resting(drive)
    if rest is None or not _worth_showing(drive, rest) or len(rest.stretches) > MOST_ROWS:
        return None
    return table(
        "Tension of every stretch at rest.",
        "Stretch | Tension at its start [] | at its end []",
        (_row(stretch) for stretch in rest.stretches),
    )


def _row(stretch: RestingStretch) -> tuple[str, str, str]:
    where = f"{stretch.span} span, {quantity(stretch.start, 'm', 4)} to {quantity(stretch.end, 'm', 4)}"
    first, last = (quantity(tension, "N", 4) for tension in stretch.tensions)
    return where, first, last
