"""A machine at rest: the tension along its cable and its sag under gravity."""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from cabledrive.answers.figures import quantity
from cabledrive.mechanics.network.motion import gravity
from cabledrive.mechanics.network.rest_forces import RestingStretch
from cabledrive.mechanics.network.statics import statics_of
from cabledrive.mechanics.rest import POINTS, sag_of
from cabledrive.parameters import Machine
from cabledrive.parameters.arrays import Array
from cabledrive.report.blocks import COLOURS, Block, Panel, Plot, in_turn, table

MOST_ROWS = 8
SEEN = 1e-3
"""Share of a span from which sag is worth a picture, and of the pretension from which weight is."""


def tension_at(stretches: Iterable[RestingStretch], at: Array) -> Array:
    """Tension along a span, shape (p,) [N]."""
    values = np.full(at.size, np.nan)
    for stretch in stretches:
        on = (at >= stretch.start - 1e-12) & (at <= stretch.end * (1 + 1e-12))
        values[on] = stretch.tension_at(at[on])
    return values


def rest_blocks(machine: Machine, name: str) -> tuple[Block, ...]:
    """Tension and sag along the spans and of every stretch, unless there are too many for a table.

    None where the weight changes neither by a thousandth; of many spans those that it changes most.
    """
    if machine.layout.gravity == 0.0:
        return ()
    found = zip(machine.free_spans, statics_of(machine).stretches, strict=True)
    spans: list[_Hanging] = []
    for span, stretches in found:
        places, depth = sag_of(stretches)
        down = -1.0 if float(np.dot(span.across, gravity(machine))) < 0.0 else 1.0
        spans.append(_Hanging(span.name, stretches, places, down * depth))
    if max(own.change for own in spans) <= SEEN:
        return ()
    shown = sorted(sorted(spans, key=lambda own: -own.change)[: len(COLOURS)], key=spans.index)
    longest = max(own.stretches[-1].end for own in shown)
    inside = np.array([piece.start for own in shown for piece in own.stretches[1:]])
    step, even = 1e-6 * longest, np.linspace(0.0, longest, 2 * POINTS)
    at = np.unique(np.concatenate((even, inside - step, inside + step)))
    curves = [("Tension", "N", [tension_at(own.stretches, at) for own in shown])]
    deepest = max(float(np.abs(own.depth).max()) for own in spans)
    if sags := any(own.sag > SEEN for own in shown):
        fallen = [-np.interp(at, own.places, own.depth, right=np.nan) for own in shown]
        curves.append(("Height over the line between its ends", "m", fallen))
    names = [own.words for own in shown]
    panels = (Panel(title, unit, in_turn(zip(names, lines, strict=True))) for title, unit, lines in curves)
    tensions = [tension for own in shown for tension in own.tensions]
    low, high = (quantity(value, "N", 3) for value in (min(own.lowest for own in shown), max(tensions)))
    sag = f", sag up to {quantity(deepest, 'm', 3)}" if sags else ""
    left = f" The {len(shown)} of {len(spans)} spans that it changes most." if len(shown) < len(spans) else ""
    plot = Plot(
        name=f"rest-{name}",
        alt=f"Tension at rest along each span, from {low} to {high}{sag}.",
        caption=f"Tension from {low} to {high}{sag}; motors held. Each carriage steps the tension. "
        f"Positions count from where the span starts.{left}",
        points=at,
        along="position",
        unit="m",
        panels=tuple(panels),
    )
    heads = "Stretch | Tension at its start [] | at its end []"
    rows = [
        (
            f"{own.words}, {quantity(piece.start, 'm', 4)} to {quantity(piece.end, 'm', 4)}",
            *(quantity(tension, "N", 4) for tension in piece.tensions),
        )
        for own in shown
        for piece in own.stretches
    ]
    return (
        (plot, table("Tension of every stretch at rest.", heads, rows)) if len(rows) <= MOST_ROWS else (plot,)
    )


class _Hanging(NamedTuple):
    """A span at rest: its pieces, and how far it lies below its chord at places along it [m]."""

    name: str
    stretches: tuple[RestingStretch, ...]
    places: Array
    depth: Array

    @property
    def words(self) -> str:
        return self.name if " " in self.name else f"{self.name} span"

    @property
    def tensions(self) -> list[float]:
        return [tension for piece in self.stretches for tension in piece.tensions]

    @property
    def lowest(self) -> float:
        return min(piece.lowest_tension for piece in self.stretches)

    @property
    def sag(self) -> float:
        """Over the length of the span."""
        return float(np.abs(self.depth).max()) / self.stretches[-1].end

    @property
    def change(self) -> float:
        """What weight makes of it: its sag, or the spread of its tension over the highest."""
        return max(self.sag, (max(self.tensions) - self.lowest) / max(self.tensions))
