"""Figs. 5.4 to 5.6: forced and swept responses; the entries of chapter 5."""

import numpy as np
from numpy.typing import NDArray

from cabledrive.parameters import load_drive
from cabledrive.reduction.autoparametric import autoparametric_model
from reproduction.averaged_against_exact import ForcedCase, envelope, exact_motion
from reproduction.chapter_5_conditions import figure_5_2, figure_5_3, section_5
from reproduction.chapter_5_free import CHOSEN, figure_5_7
from reproduction.item import DIFFERS, Entry, Outcome, outcome
from reproduction.judge import claimed
from reproduction.motions_of_chapter_5 import (
    FLOOR,
    LEVEL,
    SWEEP_RATE,
    TORQUE,
    forced_response,
    swept_response,
    tuned_drive,
)
from reproduction.panel import Panel, curve

Array = NDArray[np.float64]

MORE_THAN_HALF = 0.5
SMALL_PLUCKS = (3e-4, 1e-4)


def figure_5_4(quick: bool) -> Outcome:
    """Figs. 5.4 and 5.6: forced response at tuning, by the exact loop.

    ``quick``: changes nothing here.
    """
    drive = tuned_drive(load_drive("dissertation-2"))
    found = forced_response(drive)
    window = 4 * np.pi / autoparametric_model(drive).natural
    _load, across = (envelope(found.time, signal, window) for signal in (found.load_angle, found.midpoint))
    words = (
        f"the load's envelope falls to {100 * found.fallen:.0f} % of its peak, midspan moves "
        f"{across.min() * 1e3:.2f} to {across.max() * 1e3:.2f} mm"
    )
    small = ForcedCase(drive=drive, torque=TORQUE, plucks=SMALL_PLUCKS, duration=4.0, shape="half-sine")
    seen = exact_motion(small, segments=100, rate=3000.0)
    grown = [envelope(seen.time, signal, window) for signal in (seen.load_angle, seen.midpoint)]
    later = [float(one.max() / one[1]) for one in grown]
    items = [
        claimed(
            "figure-5-4",
            "Fig. 5.4, simulated: load pulley and cable midpoint at resonance",
            "a strong coupling, with an exchange of energy",
            words,
            found.fallen < MORE_THAN_HALF,
            otherwise=(DIFFERS, "not explained"),
            note=CHOSEN,
        ),
        claimed(
            "figure-5-6",
            "Fig. 5.6, measured: load pulley and cable midpoint at resonance",
            "growth of both amplitudes, a kind of beats",
            f"from plucks of {1e3 * SMALL_PLUCKS[0]:g} and {1e3 * SMALL_PLUCKS[1]:g} mm the load grows "
            f"{later[0]:.1f} and "
            f"midspan {later[1]:.1f} times within {small.duration:g} s",
            min(later) > 2.0,
            otherwise=(DIFFERS, "not explained"),
            note=f"the measurement is lost; the exact loop stands for it; {CHOSEN}",
        ),
    ]
    panels = [
        Panel(
            figure=figure,
            title=f"{signal}; {CHOSEN}",
            x="time [s]",
            y=unit,
            curves=(curve(signal, run.time, factor * values),),
        )
        for figure, run in (("Fig. 5.4", found), ("Fig. 5.6", seen))
        for signal, unit, factor, values in (
            ("load pulley, trend removed", "load angle [deg]", 180 / np.pi, _level(run.time, run.load_angle)),
            ("midpoint of the upper span", "w [mm]", 1e3, run.midpoint),
        )
    ]
    return outcome(items, panels)


def figure_5_5(quick: bool) -> Outcome:
    """Fig. 5.5: midpoint while the tension rises slowly.

    ``quick``: changes nothing here.
    """
    found = swept_response(tuned_drive(load_drive("dissertation-2")))
    item = claimed(
        "figure-5-5",
        "Fig. 5.5: midpoint with changing gamma",
        "a sudden increase as gamma approaches 0.5",
        f"{1e6 * FLOOR:g} um to {1e3 * LEVEL:g} mm at gamma = {found.found:.4f}, unstable from "
        f"{found.edge:.4f} on",
        abs(found.found - 0.5) < 0.02,
        otherwise=(DIFFERS, "not explained"),
        note=(
            f"steep growth from a floor, not a jump; floor, level and rate of {SWEEP_RATE:g} rad/s^2 are "
            f"chosen; growth integral {found.predicted:.4f}; {CHOSEN}"
        ),
    )
    panel = Panel(
        figure="Fig. 5.5",
        title="Amplitude over the frequency ratio, Hill's equation",
        x="gamma",
        y="amplitude [mm]",
        curves=(curve("midpoint", found.ratio, 1e3 * found.amplitude),),
        log_y=True,
    )
    return outcome([item], [panel])


def _level(time: Array, signal: Array) -> Array:
    """A signal without its linear trend, the drift of the rigid rotation."""
    return np.asarray(signal - np.polyval(np.polyfit(time, signal, 1), time))


ENTRIES = (
    Entry(name="figure-5-2", chapter="5", covers=("Fig. 5.2",), compute=figure_5_2),
    Entry(name="figure-5-3", chapter="5", covers=("Fig. 5.3", "Section 5.1"), compute=figure_5_3),
    Entry(name="section-5", chapter="5", covers=("Section 5.2", "Section 5.3"), compute=section_5),
    Entry(name="figures-5-4-5-6", chapter="5", covers=("Fig. 5.4", "Fig. 5.6"), compute=figure_5_4),
    Entry(name="figure-5-5", chapter="5", covers=("Fig. 5.5",), compute=figure_5_5),
    Entry(name="figure-5-7", chapter="5", covers=("Fig. 5.7",), compute=figure_5_7),
)
