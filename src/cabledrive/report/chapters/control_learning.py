"""Chapter "Control at the resolution of the sensor": learning, the bound, feedforward and feedback."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np

from cabledrive.parameters import Drive, InputRefused, Lumped
from cabledrive.report.blocks import Block, Cell, Chapter, Column, Paragraph, RowGroup, Section, Table
from cabledrive.report.chapters.control import can_be_controlled
from cabledrive.report.context import ReportContext
from cabledrive.report.numbers import number
from cabledrive.report.plot import Plot
from cabledrive.report.time_plots import errors_plot
from cabledrive.rig import Motion, RigOptions, Tracking, track
from cabledrive.rig.closed_loop.loop import Loop, close_loop
from cabledrive.rig.comparison import compared
from cabledrive.rig.error_budget import error_sources, in_degrees
from cabledrive.rig.expected_bound import PARTS, bound_over_draws
from cabledrive.rig.laws.baselines import FEEDFORWARDS
from cabledrive.rig.laws.fitting import fitted_encoders
from cabledrive.rig.laws.registry import design
from cabledrive.rig.learning_samples import run_learning_samples
from cabledrive.rig.plant_samples import run_samples
from cabledrive.rig.trial import spec_for

PLACE = 720
SEEDS, DRAWS, SOFTER = 6, 8, 0.9
ONE, TWO = Motion(order=11), Motion(pulses=2, order=11)
SETTINGS = {"pd": 20.0, "pid": 2.0, "lqg": 0.2, "dob": 11.0, "shaper": 11.0}
SAID = {
    "matched": "motor: inertia, friction and offset within their bounds",
    "friction": "stick-slip friction, in plant and filter",
    "unmatched": "cable, load and joint within their tolerances",
    "counts": "encoder quantisation and unknown zeros",
}


def chapter(context: ReportContext) -> Chapter | None:
    """What the sensors allow, on every machine with motor, flexible joint and three encoders."""
    parts = [p for p in zip(context.drives, context.anchors, strict=True) if can_learn(p[0])]
    if not parts:
        return None
    sections = []
    for drive, name in parts:
        context.progress(f"control, learning: {drive.name}")
        sections.append(
            Section(title=drive.name, anchor=f"control-learning-{name}", blocks=_about(drive, name))
        )
    return Chapter(
        title="Control at the resolution of the sensor",
        summary="How far the error falls when friction and load inertia are identified in the loop.",
        anchor="control-learning",
        blocks=(
            Paragraph(
                text="The parameters that the laws of the dissertation adapt are not those that limit "
                "their error. The ratio of stiffness to load inertia, an unmatched uncertainty, is "
                "identified here from one pulse and two encoders; law, reference and filter are "
                "redesigned while the load rests. Baselines use the same feedforwards, which shows the "
                "contribution of the feedback."
            ),
        ),
        sections=tuple(sections),
        methods=(
            f"Control, learning: {DRAWS} plants sampled from the bounds and tolerances of the drive, "
            "random encoder phases; intervals by rounding the smoothed motion again with other phases.",
        ),
    )


@cache
def can_learn(drive: Drive) -> bool:
    """Whether the law that learns can run on a drive with the gains that the package chooses."""
    if not can_be_controlled(drive):
        return False
    try:
        design("darc-indirect", spec_for(drive, TWO, best=True))
    except InputRefused:
        return False
    return list(fitted_encoders(drive)) == ["motor", "drive", "load"]


def _about(drive: Drive, name: str) -> tuple[Block, ...]:
    actual = softer(drive)
    runs = [
        track(drive, controller=law, gains="best", motion=TWO, plant_drive=actual, seed=1)
        for law in ("darc-4-damped", "darc-indirect")
    ]
    loop = _loop(drive, "darc-4-damped", ONE)
    return (
        _errors(name, runs),
        _learnt(runs[1].summary["learnt"]),
        _draws(drive, loop),
        _baselines(drive),
        _error_sources(drive),
        _bound(loop),
        Paragraph(text="Gains: " + "; ".join(loop.controller.gains["reasons"]) + "."),
    )


def softer(drive: Drive) -> Drive:
    """The drive with a cable a tenth softer than believed, where the file gives its stiffness."""
    lumped = drive.lumped
    if lumped is None or lumped.cable_stiffness is None:
        return drive
    cable = Lumped(cable_stiffness=SOFTER * lumped.cable_stiffness, cable_damping=lumped.cable_damping)
    return replace(drive, lumped=cable)


def _loop(drive: Drive, name: str, motion: Motion) -> Loop:
    made = design(name, spec_for(drive, motion, best=True))
    return close_loop(drive, drive, made, motion, RigOptions(), np.random.default_rng(0))


def _errors(name: str, runs: list[Tracking]) -> Plot:
    later = [run.summary["later_pulses_error_deg"] for run in runs]
    return errors_plot(
        f"learning-{name}",
        runs,
        alt="Error of the load over two pulses on a cable 10 % softer than assumed: in the second pulse "
        f"{number(later[1], 2)} deg with learning, {number(later[0], 2)} deg without.",
        caption="Two pulses on a cable 10 % softer than assumed in the design. Above: the damping-aware law "
        "without learning. Below: redesigned in the rest after the first pulse. Dashed: the bound of the "
        "theorem, valid for true states and a known cable only.",
    )


def _learnt(said: dict[str, Any]) -> Table:
    rows: list[tuple[Cell, ...]] = [
        (
            "stiffness over load inertia",
            "1/s²",
            *(number(said[k], 5) for k in ("beta", "beta_low", "beta_high")),
        ),
        (
            "damping over load inertia",
            "1/s",
            *(number(said[k], 3) for k in ("gamma", "gamma_low", "gamma_high")),
        ),
    ]
    units = {
        "inertia": ("total inertia", "kg m²"),
        "viscous_friction": ("viscous friction", "N m s/rad"),
        "coulomb_friction": ("Coulomb friction", "N m"),
        "offset_torque": ("offset torque", "N m"),
    }
    for key, (words, unit) in units.items():
        rows.append((words, unit, *(number(said[key][k], 3) for k in ("value", "low", "high"))))
    return Table(
        caption="Identified from the first pulse of the lower run, with 95 % intervals.",
        columns=(
            Column(title="Quantity"),
            Column(title="Unit"),
            Column(title="Value", numeric=True),
            Column(title="From", numeric=True),
            Column(title="To", numeric=True),
        ),
        groups=(RowGroup(rows=tuple(rows)),),
    )


def _draws(drive: Drive, loop: Loop) -> Table:
    plain = run_samples(loop, RigOptions(), DRAWS, 1)
    spec = spec_for(drive, TWO, best=True)
    said = run_learning_samples(_loop(drive, "darc-indirect", TWO), spec, RigOptions(), DRAWS, 1).words
    peak, own = plain.degrees("peak"), plain.degrees("own_peak")
    rows = (
        ("damping-aware, one pulse", *(f"{v:.3f}" for v in (np.median(peak), peak.max(), own.max()))),
        (
            "the same after learning",
            f"{said['median_peak_error_deg']:.3f}",
            f"{said['worst_peak_error_deg']:.3f}",
            f"{said['worst_encoder_error_deg']:.3f}",
        ),
    )
    count = np.degrees(loop.rig.counts[-1] / loop.gear)
    return Table(
        caption=f"Peak error over {DRAWS} sampled plants; one count of the load encoder is {count:.3f} deg.",
        columns=(
            Column(title="Law, best gains"),
            Column(title="Median", unit="deg", numeric=True),
            Column(title="Worst", unit="deg", numeric=True),
            Column(title="Worst, encoder's zero", unit="deg", numeric=True),
        ),
        groups=(RowGroup(rows=rows),),
        note="A rig measures angles from the zero of its encoder, which differs from the true one by up to "
        "half a count.",
    )


def _baselines(drive: Drive) -> Table:
    spec, kinds = spec_for(drive, ONE), tuple(FEEDFORWARDS)
    settings = {(law, kind): value for law, value in SETTINGS.items() for kind in kinds}
    found = compared(drive, tuple(SETTINGS), kinds, 4, 3, spec, ONE, settings=settings)
    cells = {(one.law, one.feedforward): one.draws for one in found}
    rows = []
    for law, setting in SETTINGS.items():
        peaks = [cells[law, kind] for kind in kinds]
        words = ["ended early" if one.failed else f"{one.degrees('peak').max():.3f}" for one in peaks]
        rows.append((law, f"{setting:g} {'N m' if law == 'lqg' else 'Hz'}", *words))
    return Table(
        caption="Worst peak error of four sampled plants: each feedback with each feedforward.",
        columns=(
            Column(title="Feedback"),
            Column(title="Setting"),
            *(
                Column(title=words, unit="deg", numeric=True)
                for words in ("Damped inverse", "Undamped", "Rigid")
            ),
        ),
        groups=(RowGroup(rows=tuple(rows)),),
        note="All with friction compensation by the reference speed and the same filter. The page on the "
        "choice of a controller in the documentation has each pair tuned by one rule, over more samples.",
    )


def _error_sources(drive: Drive) -> Table:
    rows = []
    for one in error_sources(drive, "darc-4-damped", ONE, SEEDS):
        rows.append((one.away, *(f"{value:.4f}" for value in in_degrees(one))))
    return Table(
        caption=f"Error budget of the damping-aware law: one disturbance removed at a time, {SEEDS} "
        "encoder phases.",
        columns=(
            Column(title="Removed"),
            Column(title="Median", unit="deg", numeric=True),
            Column(title="Worst", unit="deg", numeric=True),
            Column(title="Worst, encoder's zero", unit="deg", numeric=True),
        ),
        groups=(RowGroup(rows=tuple(rows)),),
    )


def _bound(loop: Loop) -> Table:
    said = bound_over_draws(loop)
    if said["expected_bound_deg"] is None:
        rows: tuple[tuple[Cell, ...], ...] = ((str(said["expected_bound_deg_reason"]), ""),)
    else:
        parts = said["expected_bound_parts_deg"]
        rows = (
            *((SAID[part], f"{parts[part]:.3f}") for part in PARTS),
            ("all together, where the sum is largest", f"{said['expected_bound_deg']:.3f}"),
        )
    return Table(
        caption="Bound of the error for all uncertainties together, filter and quantisation included.",
        columns=(Column(title="From"), Column(title="Bound", unit="deg", numeric=True)),
        groups=(RowGroup(rows=rows),),
    )
