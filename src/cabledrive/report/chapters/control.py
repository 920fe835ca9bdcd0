"""Chapter "Control": the laws of chapter 6 on the virtual rig, beside what the print reports."""

from collections.abc import Sequence
from functools import cache

import numpy as np

from cabledrive.parameters import Drive, InputRefused
from cabledrive.report.blocks import Block, Cell, Chapter, Column, Paragraph, RowGroup, Section, Table
from cabledrive.report.cable_as_plant import CABLE_SEEDS, on_cable_table
from cabledrive.report.chapters.reduced_models import has_models
from cabledrive.report.context import ReportContext
from cabledrive.report.control_figures import curves_figure, pulse_figure, record_figure, vibration_figures
from cabledrive.report.numbers import number
from cabledrive.report.plot import Plot
from cabledrive.report.time_plots import errors_plot
from cabledrive.rig import Motion, Tracking, track
from cabledrive.rig.laws.eigenvalues import closed_loop_poles
from cabledrive.rig.laws.registry import design
from cabledrive.rig.trial import spec_for

PLACE = 700
SEEDS = range(8)
PULSE = Motion(order=9)
LAWS = (
    "darc-1",
    "darc-2",
    "darc-3",
    "darc-4",
    "backstepping",
    "backstepping-6",
    "darc-4-damped",
    "pd",
    "lqg",
)
DESIGNED = LAWS[:7]
SHOWN = ("darc-3", "darc-4", "backstepping", "darc-4-damped")
PRINTED = {"darc-3": "0.17", "darc-4": "0.055", "backstepping": "0.3"}


def chapter(context: ReportContext) -> Chapter | None:
    """The control laws on every machine that has motor, encoders and a flexible joint."""
    parts = [p for p in zip(context.drives, context.anchors, strict=True) if can_be_controlled(p[0])]
    if not parts:
        return None
    sections, said = [], []
    for drive, name in parts:
        context.progress(f"control: {drive.name}")
        runs = {
            law: [
                track(drive, controller=law, seed=seed, motion=PULSE, gains="dissertation") for seed in SEEDS
            ]
            for law in LAWS
        }
        sections.append(Section(title=drive.name, anchor=f"control-{name}", blocks=_about(drive, name, runs)))
        said.append(_headline(drive, runs))
    return Chapter(
        title="Control",
        summary="Tracking errors of the control laws on simulated plants, with encoders, friction and delay.",
        anchor="control",
        blocks=(
            Paragraph(
                text="The laws are tested on a simulated rig: stick-slip friction of the motor, encoder "
                "quantisation with random phases within a count, a torque loop, a torque limit. The "
                "load follows pulses of 45 deg in 0.5 s with 0.5 s rest, of order 9, at the gains of "
                "the dissertation; the error is the true load angle minus the reference. The pulses of the "
                "printed figures are not known, so printed and computed figures can be compared, not checked."
            ),
        ),
        sections=tuple(sections),
        methods=(
            f"Control: hybrid simulation, exact between samples; stick-slip events located on the exact "
            f"motion; {len(SEEDS)} runs of each law with random encoder phases.",
        ),
        headline=" ".join(said),
    )


def _headline(drive: Drive, runs: dict[str, list[Tracking]]) -> str:
    worst = {law: max(run.summary["peak_error_deg"] for run in found) for law, found in runs.items()}
    best = min(worst, key=worst.__getitem__)
    return (
        f"{drive.name}: {best} has the smallest error, at most {number(worst[best], 2)} deg in "
        f"{len(SEEDS)} runs; darc-4, the law of Model 4 in the dissertation, at most "
        f"{number(worst['darc-4'], 2)} deg."
    )


@cache
def can_be_controlled(drive: Drive) -> bool:
    """Whether the laws can run on a drive as the chapter needs it."""
    if drive.motor is None or drive.motor.joint_stiffness is None or not has_models(drive):
        return False
    try:
        track(drive, controller="darc-4-damped", motion=PULSE, gains="dissertation")
    except InputRefused:
        return False
    return True


def _about(drive: Drive, name: str, runs: dict[str, list[Tracking]]) -> tuple[Block, ...]:
    return (
        pulse_figure(name, PULSE),
        _comparison(runs),
        _errors(name, [runs[law][0] for law in SHOWN]),
        *(record_figure(name, runs[law][0]) for law in PRINTED),
        curves_figure(drive, name),
        on_cable_table(drive, {law: runs[law][:CABLE_SEEDS] for law in SHOWN}),
        _poles(drive),
        *vibration_figures(drive, name),
    )


def _comparison(runs: dict[str, list[Tracking]]) -> Table:
    rows: list[tuple[Cell, ...]] = []
    letters: dict[str, str] = {}
    for law, found in runs.items():
        said = [run.summary for run in found]
        peaks = [one["peak_error_deg"] for one in said]
        bound = said[0]["theory_bound_deg"]
        for words in said[0]["broken_assumptions"] if bound is not None else ():
            letters.setdefault(words, "abcdefghijklmnop"[len(letters)])
        rows.append(
            (
                law,
                PRINTED.get(law, ""),
                f"{np.median(peaks):.3f}",
                f"{max(peaks):.3f}",
                f"{max(one['peak_torque'] for one in said):.2f}",
                "" if bound is None else f"{bound:.3f}",
                ", ".join(letters[words] for words in said[0]["broken_assumptions"])
                if bound is not None
                else "",
            )
        )
    return Table(
        caption="Peak error of the load, printed and computed, and the bound of the theorem.",
        columns=(
            Column(title="Law"),
            Column(title="Printed", unit="deg", numeric=True),
            Column(title="Median", unit="deg", numeric=True),
            Column(title="Worst", unit="deg", numeric=True),
            Column(title="Torque", unit="N m", numeric=True),
            Column(title="Bound", unit="deg", numeric=True),
            Column(title="Not met"),
        ),
        groups=(RowGroup(rows=tuple(rows)),),
        note="PD and LQG follow with the damped inverse as feedforward, friction by the speed of the "
        "reference. Assumptions of the bound that do not hold: "
        + "; ".join(f"{letter}, {words}" for words, letter in letters.items())
        + ".",
    )


def _errors(name: str, runs: Sequence[Tracking]) -> Plot:
    words = ", ".join(
        f"{run.summary['controller']} {number(run.summary['peak_error_deg'], 2)} deg" for run in runs
    )
    return errors_plot(
        f"errors-{name}",
        runs,
        alt=f"Error of the load over time in one pulse, a panel for each law; peaks: {words}.",
        caption="Error of the load in one pulse, seed 0. Dashed: the bound of the theorem along the motion.",
    )


def _poles(drive: Drive) -> Table:
    spec, rows = spec_for(drive, PULSE), []
    for law in DESIGNED:
        made = design(law, spec)
        poles = [p for p in closed_loop_poles(drive, made) if p.damping_ratio < 0.99]
        words = ", ".join(f"{p.frequency:.1f} Hz ({p.damping_ratio:.2f})" for p in poles)
        rows.append((law, number(made.gains["bandwidth_hz"], 3), words or "none: all poles are real"))
    return Table(
        caption="Oscillatory poles of each law on the true plant, true states: frequency and damping ratio.",
        columns=(
            Column(title="Law"),
            Column(title="Bandwidth", unit="Hz", numeric=True),
            Column(title="Poles"),
        ),
        groups=(RowGroup(rows=tuple(rows)),),
        note="A law designed without the dampers has other poles than designed; this explains its error.",
    )
