"""Fig. 5.7: the free response."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cabledrive.parameters import Drive, load_drive
from cabledrive.reduction.autoparametric import autoparametric_model
from reproduction.averaged_against_exact import ForcedCase, envelope, exact_motion
from reproduction.item import DIFFERS, Outcome, outcome, place
from reproduction.judge import claimed
from reproduction.motions_of_chapter_5 import (
    FREE_PLUCKS,
    GAMMA,
    PULLEY_DAMPING,
    TORQUE,
    FreeResponse,
    free_response,
    tuned_drive,
)
from reproduction.panel import Panel, curve

Array = NDArray[np.float64]
CHOSEN = (
    f"dampings of {GAMMA:g} 1/s across and {PULLEY_DAMPING:g} 1/s of the pulley mode, torque "
    f"{1e3 * TORQUE:g} mN m and "
    "plucks are chosen: the print's are lost"
)
ONE_SIDED = (3e-3, 1e-5)
"""Plucks of Fig. 5.7 [m]: the lower span hardly touched."""

LIGHT = 0.25
"""Friction at the load pulley in Fig. 5.7, over that of the other figures."""


def figure_5_7(quick: bool) -> Outcome:
    """Fig. 5.7: free response after unequal plucks.

    ``quick``: changes nothing here.
    """
    drive = tuned_drive(load_drive("dissertation-2"))
    load_pulley = replace(drive.load_pulley, viscous_friction=LIGHT * drive.load_pulley.viscous_friction)
    light = replace(drive, pulley=(drive.drive_pulley, load_pulley))
    case = ForcedCase(drive=light, torque=0.0, plucks=ONE_SIDED, duration=1.5)
    found = exact_motion(case, segments=100, rate=3000.0)
    both = free_response(drive)
    window = 4 * np.pi / autoparametric_model(drive).natural
    peaks_found = [
        _first_second(run.time, run.load_angle, across, window)
        for run, across in ((found, found.midpoint), (both, both.midpoints[0]))
    ]
    load = envelope(both.time, both.load_angle, window)
    left = float(load[-1] / load.max())
    words = [
        f"pulley largest at {peak:.2f} s, upper midpoint least at {least:.2f} s, correlation {c:.2f}"
        for peak, least, c in peaks_found
    ]
    equal = _equal_over(drive, both)
    items = [
        claimed(
            "figure-5-7",
            "Fig. 5.7: free load pulley and upper midpoint over the first second",
            "pulley oscillations grow while the cable's reach their minimum, and vice versa",
            words[0],
            peaks_found[0][2] < 0.0,
            otherwise=(DIFFERS, "not explained"),
            note=(
                f"plucks of {1e3 * ONE_SIDED[0]:g} and {1e3 * ONE_SIDED[1]:g} mm and "
                f"{LIGHT * PULLEY_DAMPING:g} 1/s of the pulley mode chosen; with {1e3 * FREE_PLUCKS[0]:g} "
                f"and {1e3 * FREE_PLUCKS[1]:g} mm the spans swap through the pulley, and the claim fails: "
                f"{words[1]}"
            ),
        ),
        claimed(
            "figure-5-7-dies-out",
            "Section 5.3: vibrations after the first second",
            "die out by the cable's damping",
            f"load pulley at {both.time[-1]:.2g} s: {100 * left:.0f} % of its peak",
            left < 1 / 3,
            otherwise=(DIFFERS, "the dampings are chosen; larger ones make it so"),
            note=CHOSEN,
        ),
        claimed(
            "figure-5-7-equal-plucks",
            "Section 5.3: both spans plucked at their midpoints, the pulley takes part",
            "the plucks must have differed, for equal ones turn no pulley",
            f"load angle after equal plucks {equal:.1g} of that after unequal ones",
            equal < 1e-6,
            otherwise=(DIFFERS, "not explained"),
            note=f"a consequence, not a sentence of the print. {place('confirmed-equal-plucks')}",
        ),
    ]
    signals = (
        ("load pulley", "load angle [deg]", np.degrees(found.load_angle)),
        ("upper midpoint", "w [mm]", 1e3 * found.midpoint),
    )
    panels = [
        Panel(
            figure="Fig. 5.7", title=words, x="time [s]", y=unit, curves=(curve(words, found.time, values),)
        )
        for words, unit, values in signals
    ]
    return outcome(items, panels)


def _equal_over(drive: Drive, unequal: FreeResponse) -> float:
    """Largest load angle after equal plucks over that after unequal ones."""
    case = ForcedCase(drive=drive, torque=0.0, plucks=(FREE_PLUCKS[0], FREE_PLUCKS[0]), duration=0.2)
    seen = exact_motion(case, segments=100, rate=3000.0)
    return float(np.max(np.abs(seen.load_angle)) / np.max(np.abs(unequal.load_angle)))


def _first_second(time: Array, angle: Array, midpoint: Array, window: float) -> tuple[float, float, float]:
    """When the pulley is largest and the midpoint least, and the correlation of their envelopes."""
    load, across = (envelope(time, signal, window) for signal in (angle, midpoint))
    first = slice(1, int(1.0 / window))
    peak, least = (float(window * (k + 1.5)) for k in (np.argmax(load[first]), np.argmin(across[first])))
    return peak, least, float(np.corrcoef(load[first], across[first])[0, 1])
