"""Table of the chapter on control: the laws on the nonlinear distributed cable beside its lumped chain."""

from collections.abc import Mapping, Sequence

import numpy as np

from cabledrive.parameters import Drive
from cabledrive.report.blocks import Cell, Column, RowGroup, Table
from cabledrive.report.numbers import number
from cabledrive.rig import Motion, Tracking, track

PULSE = Motion(order=9)

CABLE_SEEDS = 4


def on_cable_table(drive: Drive, runs: Mapping[str, Sequence[Tracking]]) -> Table:
    """Peak errors on both plants, and what the cable does that its lumped chain cannot.

    ``runs``: of each law on the lumped chain, seeds from 0 on.
    """
    rows: list[tuple[Cell, ...]] = []
    for law, found in runs.items():
        on_cable = [
            track(drive, controller=law, plant="cable", seed=seed, motion=PULSE, gains="dissertation").summary
            for seed in range(len(found))
        ]
        ours, theirs = (
            np.array([one["peak_error_deg"] for one in said])
            for said in ([run.summary for run in found], on_cable)
        )
        rows.append(
            (
                law,
                f"{np.median(ours):.3f}",
                f"{np.median(theirs):.3f}",
                f"{ours.max():.3f}",
                f"{theirs.max():.3f}",
                number(max(one["cable"]["spillover_deg"] for one in on_cable), 1),
            )
        )
    cable = on_cable[0]["cable"]
    return Table(
        caption="Peak error on the nonlinear distributed cable with its motor joint, compared with the "
        "lumped model.",
        columns=(
            Column(title="Law"),
            Column(title="Median, row", unit="deg", numeric=True),
            Column(title="cable", unit="deg", numeric=True),
            Column(title="Worst, row", unit="deg", numeric=True),
            Column(title="cable", unit="deg", numeric=True),
            Column(title="Spillover", unit="deg", numeric=True),
        ),
        groups=(RowGroup(rows=tuple(rows)),),
        note=f"Of {CABLE_SEEDS} encoder phases; {cable['segments']} segments per span of "
        f"{number(cable['stiffness'], 3)} N/m. Spillover: motion of the middle of a span against its ends; "
        f"its own mode is at {number(cable['span_mode_hz'], 3)} Hz. The lowest transverse mode is at "
        f"{number(cable['frequency_ratio'], 3)} times the pulley mode; coupling 1:2: {cable['one_to_two']}.",
    )
