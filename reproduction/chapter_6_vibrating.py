"""Figs. 6.5 to 6.10: the laws that leave out the cable make it ring."""

import numpy as np

from cabledrive.reduction.lumped_chain import lumped_model, natural_frequencies_of
from reproduction.item import DIFFERS, Outcome, outcome, place
from reproduction.judge import claimed
from reproduction.panel import Curve, Panel, curve
from reproduction.rig_runs import (
    ENCODER,
    JOINT_BAND,
    MOTION,
    dwell_spectrum,
    held_frequency,
    peak_of,
    run,
)
from reproduction.table_6_3 import drive_3

BANDWIDTHS = (5.0, 6.0, 7.0, 8.0)


def model_1(quick: bool) -> Outcome:
    """Figs. 6.5 to 6.8: the law of Model 1 at growing bandwidth, on the drive pulley's encoder.

    ``quick``: changes nothing here.
    """
    runs = {hertz: run("darc-1", hertz, "drive") for hertz in BANDWIDTHS}
    slow, fast = runs[BANDWIDTHS[0]], runs[BANDWIDTHS[-1]]
    load, size = peak_of(dwell_spectrum(slow, -1))
    before = peak_of(dwell_spectrum(slow, -2), *JOINT_BAND)[1]
    joint, after = peak_of(dwell_spectrum(fast, -2), *JOINT_BAND)
    free, open_joint = natural_frequencies_of(lumped_model(drive_3(), 4)) / (2 * np.pi)
    missing = f"bandwidths are not printed: {', '.join(f'{b:g}' for b in BANDWIDTHS)} Hz are chosen. "
    missing += place("erratum-gains-6-3-to-6-6")
    items = [
        claimed(
            "figure-6-5",
            "Fig. 6.5: load pulley under the law of Model 1",
            "vibrations at different values of the bandwidth",
            f"the load rings with {size:.2g} deg in the dwell at {BANDWIDTHS[0]:g} Hz of bandwidth",
            size > 2 * ENCODER,
            otherwise=(DIFFERS, "not explained"),
            note=missing,
        ),
        claimed(
            "figure-6-6",
            "Fig. 6.6: spectrum of the load pulley, law of Model 1",
            "the frequency of vibrations is that of the dominant mode, caused by cable flexibility",
            f"peak at {load:.2f} Hz",
            abs(load / held_frequency() - 1) < 0.05,
            otherwise=(DIFFERS, "not explained"),
            note=(
                f"the cable's mode with the drive pulley held by the law, {held_frequency():.2f} Hz; free it "
                f"would be {free:.2f} Hz. {place('erratum-6-47-beta')}"
            ),
        ),
        claimed(
            "figure-6-7",
            "Fig. 6.7: drive pulley under the law of Model 1",
            "as the bandwidth grows, the mode of the motor joint is also excited",
            f"{before:.2g} deg at {BANDWIDTHS[0]:g} Hz of bandwidth, {after:.2g} deg at {BANDWIDTHS[-1]:g} "
            "Hz",
            after > 20 * before,
            otherwise=(DIFFERS, "not explained"),
            note=(
                "with theta_1 from the drive pulley's encoder, as Section 6.3.4 reads. "
                f"{place('convention-theta-1')}"
            ),
        ),
        claimed(
            "figure-6-8",
            "Fig. 6.8: spectrum of the drive pulley, law of Model 1",
            "the higher-order mode of the motor joint",
            f"peak at {joint:.1f} Hz",
            80.0 < joint < 110.0,
            otherwise=(DIFFERS, "not explained"),
            note=(
                f"{open_joint:.1f} Hz without the law. The caption says load pulley: "
                f"{place('erratum-figure-6-8')}"
            ),
        ),
    ]
    panels = []
    for figure, inertia, words in (("Fig. 6.5", -1, "load pulley"), ("Fig. 6.7", -2, "drive pulley")):
        curves = tuple(
            curve(f"{hertz:g} Hz", one.time, np.degrees(one.angles[:, inertia]))
            for hertz, one in runs.items()
        )
        panels.append(
            Panel(figure=figure, title=f"{words}; {MOTION}", x="time [s]", y="angle [deg]", curves=curves)
        )
    for figure, inertia in (("Fig. 6.6", -1), ("Fig. 6.8", -2)):
        curves = tuple(curve(f"{hertz:g} Hz", *dwell_spectrum(one, inertia)) for hertz, one in runs.items())
        panels.append(_spectrum_panel(figure, curves))
    return outcome(items, panels)


def _spectrum_panel(figure: str, curves: tuple[Curve, ...]) -> Panel:
    title = "spectrum of the error in the dwell"
    return Panel(
        figure=figure, title=title, x="frequency [Hz]", y="[deg]", curves=curves, log_x=True, log_y=True
    )


def model_2(quick: bool) -> Outcome:
    """Figs. 6.9 and 6.10: the law of Model 2 at its printed bandwidth.

    ``quick``: changes nothing here.
    """
    found = run("darc-2")
    hertz, size = peak_of(dwell_spectrum(found, -1))
    _, joint = peak_of(dwell_spectrum(found, -1), *JOINT_BAND)
    items = [
        claimed(
            "figure-6-9",
            "Fig. 6.9: load pulley under the law of Model 2, lambda = 2 pi 22",
            "vibrations occur, deteriorating the tracking",
            f"the load rings with {size:.2g} deg in the dwell",
            size > 2 * ENCODER,
            otherwise=(DIFFERS, "not explained"),
            note=(
                "K_sigma is not printed, its ratio to lambda of Model 3 is taken. "
                f"{place('erratum-gains-6-3-to-6-6')}"
            ),
        ),
        claimed(
            "figure-6-10",
            "Fig. 6.10: spectrum of the load pulley, law of Model 2",
            "the dominant cable mode, and the motor joint is not excited",
            f"peak at {hertz:.2f} Hz; {joint:.1g} deg between {JOINT_BAND[0]:g} and {JOINT_BAND[1]:g} Hz",
            abs(hertz / held_frequency() - 1) < 0.05 and joint < 0.01 * size,
            otherwise=(DIFFERS, "not explained"),
            note=f"the cable's mode with the drive pulley held, {held_frequency():.2f} Hz",
        ),
    ]
    panels = [
        Panel(
            figure="Fig. 6.9",
            title=f"load pulley; {MOTION}",
            x="time [s]",
            y="angle [deg]",
            curves=(curve("load", found.time, np.degrees(found.load_angle)),),
        ),
        _spectrum_panel("Fig. 6.10", (curve("load", *dwell_spectrum(found, -1)),)),
    ]
    return outcome(items, panels)
