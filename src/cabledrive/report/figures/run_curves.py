"""What is drawn of a run over time: of a loop its load and midpoints, of a machine its bodies and spans."""

from typing import NamedTuple

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.report.style import BLUE, GREEN, INK, ORANGE, SPAN_COLOURS
from cabledrive.simulation import SimulationResult
from cabledrive.simulation.network import NetworkResult

STILL = 1e-12
"""Motion below which a body is held by its friction, and what is left is round-off [m]."""


class Curve(NamedTuple):
    """One panel: its axis label, values over the records, and a second curve behind them."""

    axis: str
    values: Array
    colour: str
    about: str = ""
    beside: Array | None = None


class RunCurves(NamedTuple):
    """Panels of a run, and the one whose spectrum is drawn."""

    time: Array
    panels: tuple[Curve, ...]
    spectrum: Curve


def curves_of(result: SimulationResult | NetworkResult) -> RunCurves:
    """Panels of a run, the motion of the load first."""
    if isinstance(result, NetworkResult):
        panels = _of_machine(result)
        # Where a body travels its place has no peaks to see, but the tension has.
        return RunCurves(result.time, panels, panels[-1 if result.travels else 0])
    load = Curve("load [deg]", np.degrees(result.load_angle), INK)
    return RunCurves(result.time, (load, *(_midpoint(result, span) for span in result.spans)), load)


def _midpoint(result: SimulationResult, span: str) -> Curve:
    moved = 1e3 * result.midpoint(span)
    beside = moved[:, 1] if np.any(moved[:, 1]) else None
    return Curve(
        f"{span} w [mm]", moved[:, 2], SPAN_COLOURS[span], "" if beside is None else "grey: v", beside
    )


def _of_machine(result: NetworkResult) -> tuple[Curve, ...]:
    """The body that moves most, the first motor, the span that sways most and the one nearest to slack."""
    channels = {channel.name: channel for channel in result.channels}
    reach = {name: high - low for name, (low, high) in result.extremes.items() if channels[name].unit == "m"}
    bodies = {name: size for name, size in reach.items() if name.endswith((".x", ".y")) and size > STILL}
    shafts = [name.removeprefix("torque on ") for name in channels if name.startswith("torque on ")]
    turning = [name for name in shafts if name in channels]
    first = max(bodies, key=lambda name: bodies[name]) if bodies else None
    found = [_coordinate(result, name, unit, INK) for name, unit in ((first, "m"),) if name is not None]
    found += [_coordinate(result, name, "rad", GREEN) for name in turning[:1]]
    if not found:
        found = [_coordinate(result, name, channels[name].unit, INK) for name in list(result.extremes)[:1]]
    if result.midpoint_peaks:
        span = max(result.midpoint_peaks, key=lambda name: result.midpoint_peaks[name])
        across = 1e3 * result.channel(f"w at the middle of {span}")
        if np.any(across):
            found.append(Curve("w [mm]", across, BLUE, span))
    tensions = {span: result.channel(f"least tension, {span}") for span in result.spans}
    lowest = min(tensions, key=lambda span: float(np.min(tensions[span], initial=np.inf)))
    return (*found, Curve("tension [N]", tensions[lowest], ORANGE, lowest))


def _coordinate(result: NetworkResult, name: str, unit: str, colour: str) -> Curve:
    values = result.channel(name)
    if unit == "m":
        large = float(np.max(np.abs(values), initial=0.0)) >= 1.0
        return Curve("[m]" if large else "[mm]", values if large else 1e3 * values, colour, name)
    return Curve("[deg]", np.degrees(values), colour, name)
