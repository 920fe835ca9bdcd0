"""A run over time: motion of the load and the spans, and its spectrum."""

from collections.abc import Sequence
from textwrap import shorten
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.modal import modes, natural_frequencies
from cabledrive.modal.natural import spectrum_of
from cabledrive.parameters import InputRefused, Machine
from cabledrive.report.picture import SPAN_COLOURS, TEXT, Hue, file_figure, file_picture, label, log_axis
from cabledrive.simulation import SimulationResult

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


STILL = 1e-12
"""Motion below which a body is held by its friction, and what is left is round-off [m]."""


PADDING, FEWEST_SAMPLES = 8, 16


def amplitude_spectrum(time: Array, signal: Array) -> tuple[Array, Array]:
    """Frequencies [Hz] and amplitudes of the sines in a record, shape (n,), without its straight line."""
    if signal.size < FEWEST_SAMPLES:
        raise InputRefused(
            f"spectrum of {signal.size} samples, at least {FEWEST_SAMPLES} are needed: record more of the run"
        )
    window, padded = np.hanning(signal.size), PADDING * signal.size
    level = np.polynomial.Polynomial.fit(time, signal, 1)(time)
    amplitude = 2.0 * np.abs(np.fft.rfft((signal - level) * window, padded)) / window.sum()
    return np.arange(amplitude.size) / (padded * float(time[1] - time[0])), amplitude


class Curve(NamedTuple):
    """One panel: its axis label, values over the records, and a second curve behind them."""

    axis: str
    values: Array
    colour: str
    about: str = ""
    beside: Array | None = None


def curves_of(result: SimulationResult) -> tuple[tuple[Curve, ...], Curve]:
    """Panels of a run, the motion of the load first, and the one whose spectrum is drawn."""
    if "load_angle" not in result.names:
        panels = _of_machine(result)
        # Where a body travels its place has no peaks to see, but the tension has.
        return panels, panels[-1 if result.travels else 0]
    load = Curve("load [deg]", np.degrees(result.load_angle), Hue.INK)
    curves = [load]
    for span in result.spans:
        _, v, w = 1e3 * result.midpoint(span).T
        beside = ("grey: v", v) if np.any(v) else ()
        curves.append(Curve(f"{span} w [mm]", w, SPAN_COLOURS[span], *beside))
    return tuple(curves), load


def _of_machine(result: SimulationResult) -> tuple[Curve, ...]:
    """The body that moves most, the first motor, the span that sways most and the one nearest to slack."""
    channels = {channel.name: channel for channel in result.channels}
    reach = {name: high - low for name, (low, high) in result.extremes.items() if channels[name].unit == "m"}
    bodies = {name: size for name, size in reach.items() if name.endswith((".x", ".y")) and size > STILL}
    shafts = [name.removeprefix("torque on ") for name in channels if name.startswith("torque on ")]
    turning = [name for name in shafts if name in channels]
    first = max(bodies, key=lambda name: bodies[name]) if bodies else None
    found = [_coordinate(result, name, unit, Hue.INK) for name, unit in ((first, "m"),) if name is not None]
    found += [_coordinate(result, name, "rad", Hue.GREEN) for name in turning[:1]]
    for name in list(result.extremes)[: 0 if found else 1]:
        found = [_coordinate(result, name, channels[name].unit, Hue.INK)]
    if result.midpoint_peaks:
        span = max(result.midpoint_peaks, key=lambda name: result.midpoint_peaks[name])
        across = 1e3 * result.channel(f"w at the middle of {span}")
        if np.any(across):
            found.append(Curve("w [mm]", across, Hue.BLUE, span))
    tensions = {span: result.channel(f"least tension, {span}") for span in result.spans}
    lowest = min(tensions, key=lambda span: float(np.min(tensions[span], initial=np.inf)))
    return (*found, Curve("tension [N]", tensions[lowest], Hue.ORANGE, lowest))


def _coordinate(result: SimulationResult, name: str, unit: str, colour: str) -> Curve:
    values = result.channel(name)
    if unit == "m":
        large = float(np.max(np.abs(values), initial=0.0)) >= 1.0
        return Curve("[m]" if large else "[mm]", values if large else 1e3 * values, colour, name)
    return Curve("[deg]", np.degrees(values), colour, name)


HEIGHT = 300.0  # px
MOST_POINTS = 1500
MOST_COUNTED = 200
"""Modes of both planes up to which transverse ones are marked."""
DECADES = 4.0
LONGEST_TITLE = 88


def spectrum_marks(drive: Machine) -> tuple[tuple[float, str], ...]:
    """Frequency [Hz] and kind of certified modes up to three times the lowest along; across where few."""
    top = 3.0 * float(natural_frequencies(drive, count=1)[0])
    marks = [(float(frequency), "longitudinal") for frequency in natural_frequencies(drive, below=top)]
    if spectrum_of(drive)[0].count(2.0 * np.pi * top) <= MOST_COUNTED:
        across = {mode.frequency for mode in modes(drive, below=top).transverse}
        marks += [(frequency, "transverse") for frequency in across]
    return tuple(sorted(marks))


def draw_histories(panels: "Sequence[Axes]", result: SimulationResult) -> None:
    """The curves of a run over time, one above the other, a panel for each of `curves_of`."""
    time, (curves, _) = result.time, curves_of(result)
    for axes, curve in zip(panels, curves, strict=True):
        _curve(axes, time, curve.values, curve.colour)
        if curve.beside is not None:
            _curve(axes, time, curve.beside, Hue.QUIET)
        if curve.about:
            words = shorten(curve.about, LONGEST_TITLE)
            label(axes, words, (1.0, 1.0), (0, -2), xycoords="axes fraction", ha="right", va="top")
        axes.set_ylabel(curve.axis)
    for axes in panels:
        axes.set_xlim(time[0], time[-1])
        axes.tick_params(labelbottom=axes is panels[-1])
    panels[-1].set_xlabel("time [s]")


def draw_spectrum(
    axes: "Axes",
    result: SimulationResult,
    marks: Sequence[tuple[float, str]],
    highest: float | None = None,
) -> None:
    """Amplitude spectrum of a run, Hann window, with `spectrum_marks`, or up to ``highest`` [Hz]."""
    _, curve = curves_of(result)
    hertz, amplitude = amplitude_spectrum(result.time, curve.values)
    top = 1.05 * max((frequency for frequency, _ in marks), default=highest or hertz[-1])
    shown = (hertz >= 2.0 * PADDING * hertz[1]) & (hertz <= top)  # half of a peak's width at its foot
    amplitude = amplitude[shown]
    highest = float(np.max(amplitude, initial=0.0)) or 1.0
    axes.plot(hertz[shown], np.maximum(amplitude, highest * 10.0**-DECADES), color=Hue.BLUE, linewidth=1.0)
    for frequency, kind in marks:
        if kind == "longitudinal":
            axes.axvline(frequency, ymin=0.93, color=Hue.ORANGE, linewidth=2.0)
            top_of: dict[str, Any] = {"xycoords": ("data", "axes fraction"), "color": Hue.ORANGE}
            label(axes, f"{frequency:.1f} Hz", (frequency, 1.0), (4, -10), **top_of)
        else:
            axes.axvline(frequency, ymin=0.97, color=Hue.QUIET, linewidth=1.0)
    axes.set_ylim(highest * 10.0**-DECADES, 10.0 * highest)
    log_axis(axes, "y", HEIGHT - 70.0)
    axes.set(xlim=(0.0, min(top, hertz[-1])), xlabel="frequency [Hz]", ylabel=curve.axis)


def run_plot(drive: Machine, result: SimulationResult, form: str) -> bytes:
    """Histories and spectrum of a run as "svg", "png" or "pdf"; refused with too few records for one."""
    marks = spectrum_marks(drive)
    highest = max(frequency for frequency, _ in marks)
    if result.travels:  # the frequencies change on the way
        marks = ()

    def draw(figure: "Figure") -> None:
        title = drive.title if 0 < len(drive.title) <= LONGEST_TITLE else shorten(drive.name, LONGEST_TITLE)
        figure.suptitle(title, fontsize=TEXT - 1, y=0.99)
        rows = len(curves_of(result)[0])
        heights = [0.50 / rows] * rows + [0.28]
        feet = [0.96 - sum(heights[: row + 1]) - 0.02 * row for row in range(rows)] + [0.07]
        panels = [figure.add_axes((0.13, y, 0.84, h)) for y, h in zip(feet, heights, strict=True)]
        draw_histories(panels[:-1], result)
        draw_spectrum(panels[-1], result, marks, highest)
        figure.align_ylabels(panels)

    return file_picture(file_figure(draw, (9.0, 8.0), None), form)


def _curve(axes: "Axes", time: Array, signal: Array, colour: str) -> None:
    """A line, or the band that it fills where there are more points than the page can show."""
    per = -(-time.size // MOST_POINTS)
    if per < 4:
        axes.plot(time, signal, color=colour, linewidth=1.2)
        return
    whole = time.size // per * per
    rows = signal[:whole].reshape(-1, per)
    middle = time[:whole].reshape(-1, per).mean(axis=1)
    axes.fill_between(middle, rows.min(axis=1), rows.max(axis=1), color=colour, linewidth=0.6)
