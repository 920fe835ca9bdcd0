"""Figures of the chapter on control: the pulse, records of the laws, vibrations, curves of errors."""

from math import nan

import numpy as np

from cabledrive.parameters import Drive, InputRefused
from cabledrive.report.blocks import Figure
from cabledrive.report.figures.control_curves import Curve, curves_picture
from cabledrive.report.figures.control_records import pulse_picture
from cabledrive.report.figures.control_runs import spectra_picture
from cabledrive.report.numbers import number
from cabledrive.report.plot import Plot
from cabledrive.report.time_plots import record_plot, vibrations_plot
from cabledrive.rig import Motion, RigOptions, Tracking, track
from cabledrive.rig.error_curves import error_curves

PRINTED_FIGURES = {
    "darc-3": "Figs. 6.11 to 6.16",
    "darc-4": "Figs. 6.17 to 6.22",
    "backstepping": "Figs. 6.23 to 6.29",
}
CURVED = ("darc-3", "darc-4", "backstepping", "darc-4-damped")
WORDS = {"rise": "rise time [s]", "angle": "angle [deg]", "bandwidth": "bandwidth [Hz]"}
PRINTED_ERRORS = {"Model 3, 0.17": 0.17, "Model 4, 0.055": 0.055, "backstepping, 0.3": 0.3}


def pulse_figure(name: str, motion: Motion) -> Figure:
    """The pulse and its derivatives, as Fig. 6.1.

    ``name``: of the drive, for anchors.
    """
    picture = pulse_picture(f"pulse-{name}", motion)
    return Figure(
        name=f"pulse-{name}",
        alt="Angle of one pulse over time and its first five derivatives; the fifth jumps at the ends of "
        "each move.",
        caption=f"The pulse, as Fig. 6.1: {motion.angle:g} deg in {motion.rise:g} s and back. Of order "
        f"{motion.rise_order}: the fifth derivative jumps at the ends of each move.",
        wide=picture.wide,
        narrow=picture.narrow,
    )


def record_figure(name: str, run: Tracking) -> Plot:
    """Everything of one law in one pulse, as the print shows it figure by figure.

    ``name``: of the drive, for anchors.
    """
    law, said = run.summary["controller"], run.summary
    like = f" as {PRINTED_FIGURES[law]}" if law in PRINTED_FIGURES else ""
    surface = "its first error" if law.startswith("backstepping") else "its sliding surface"
    return record_plot(
        f"record-{law}-{name}",
        run,
        surface.removeprefix("its ").capitalize(),
        alt=f"Five panels over time under {law}: reference and load angle, error of at most "
        f"{said['peak_error_deg']:.3f} deg, {surface}, torque of at most {said['peak_torque']:.2f} N m, "
        "estimates.",
        caption=f"{law}{like}, seed 0: {surface}, the torque and the estimates, which stay within their "
        "bounds and need not converge to the true values.",
    )


def vibration_figures(drive: Drive, name: str) -> tuple[Plot, Figure]:
    """What the laws of the rigid cable leave behind, over time and as spectra, as Figs. 6.5 to 6.10."""
    runs = _vibrating(drive)
    spectra = spectra_picture(f"spectra-{name}", runs)
    return (
        vibrations_plot(
            f"vibrations-{name}",
            runs,
            alt="Deviation of drive pulley and load from the reference over time under the laws of Models "
            "1, 2 and 3: the load oscillates for a second after each move; at high bandwidth the drive "
            "pulley oscillates permanently.",
            caption="Drive pulley and load against the reference, as Figs. 6.5, 6.7 and "
            "6.9; at the bottom the law of Model 3 closed on the drive pulley's encoder, a limit cycle at "
            "the torque limit.",
        ),
        Figure(
            name=f"spectra-{name}",
            alt="Amplitude spectra of drive pulley and load in the rest after a pulse: a line near the "
            "anti-resonance of the cable, and on the drive pulley's encoder another of the joint.",
            caption="Their spectra in the rest after a pulse, as Figs. 6.6, 6.8 and 6.10. The low line is "
            "the load oscillating against a held pulley, not the natural frequency of the free drive; "
            "the high one is the joint.",
            wide=spectra.wide,
            narrow=spectra.narrow,
        ),
    )


def _vibrating(drive: Drive) -> list[tuple[str, Tracking]]:
    drive_side, motion = RigOptions(feedback="drive", forbid_slack=False), Motion(dwell=2.0, order=9)
    wanted: list[tuple[str, str, float | None, RigOptions]] = [
        (f"darc-1 at {hertz:g} Hz, drive pulley's encoder", "darc-1", hertz, drive_side)
        for hertz in (3.0, 5.0, 11.0)
    ]
    wanted.append(("darc-2 at 22 Hz", "darc-2", None, RigOptions(forbid_slack=False)))
    wanted.append(("darc-3 at 11 Hz, drive pulley's encoder", "darc-3", None, drive_side))
    runs = []
    for words, law, hertz, options in wanted:
        try:
            run = track(
                drive,
                controller=law,
                bandwidth=hertz,
                options=options,
                motion=motion,
                gains="dissertation",
            )
        except InputRefused:
            continue
        if run.incomplete is None:
            runs.append((words, run))
    return runs


def curves_figure(drive: Drive, name: str) -> Figure:
    """Peak errors over rise time, angle and bandwidth."""
    curves = [
        Curve(words=WORDS[one.quantity], values=one.values, errors=one.errors)
        for one in error_curves(drive, CURVED)
    ]
    picture = curves_picture(f"curves-{name}", curves, PRINTED_ERRORS)
    at_rest = {law: errors[2] for law, errors in curves[0].errors.items()}
    words = ", ".join(
        f"{law} {number(value, 2)} deg" for law, value in at_rest.items() if not np.isnan(value)
    )
    return Figure(
        name=f"curves-{name}",
        alt="Peak error over rise time, angle and bandwidth of four laws, at most "
        f"{_largest(curves):.1f} deg; "
        f"at 45 deg in 0.5 s: {words}.",
        caption="Possible origin of the printed errors: peak error of "
        + ", ".join(
            f"{law} ({style})"
            for law, style in zip(CURVED, ("solid", "dashed", "dash-dotted", "dotted"), strict=True)
        )
        + " over rise time, angle and bandwidth, one at a time from 45 deg in 0.5 s, encoders centred. "
        "Horizontal: what the print reports. Where a curve is missing the law is unstable.",
        wide=picture.wide,
        narrow=picture.narrow,
    )


def _largest(curves: list[Curve]) -> float:
    values = [e for curve in curves for errors in curve.errors.values() for e in errors if e == e]
    return max(values, default=nan)
