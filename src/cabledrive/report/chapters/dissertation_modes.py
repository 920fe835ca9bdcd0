"""Chapter "The dissertation's modal analysis": chapter 3 of the print, computed anew and held beside it."""

from dataclasses import replace
from functools import cache

import numpy as np
from markupsafe import Markup

from cabledrive.parameters import Drive, content_hash, load_drive
from cabledrive.report.blocks import Block, Chapter, Column, Figure, Note, Paragraph, RowGroup, Section, Table
from cabledrive.report.context import ReportContext
from cabledrive.report.figures.carriage_on_its_way import carriage_picture
from cabledrive.report.figures.determinant import determinant_picture, determinant_windows
from cabledrive.report.figures.fundamentals import fundamentals_picture
from cabledrive.report.numbers import number
from cabledrive.studies import (
    cable_mass,
    frequency_against,
    frequency_against_carriage_position,
    midspan_crossing,
    mode_shapes,
    table_3_2,
    with_carriage,
)

PLACE = 900
DRIVES = ("dissertation-1", "dissertation-2", "dissertation-transporter")
MASS_RATIOS = (0.0, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0)
SOURCE = (
    "J. R. Bhardhwaj, Modeling and Direct Adaptive Robust Control of Flexible Cable-Actuated Systems, "
    "Purdue University, 2015"
)


def chapter(context: ReportContext) -> Chapter | None:
    """Table 3.2 and the figures of chapter 3 whose data the text defines, if its drives are in the report."""
    if not {content_hash(_drive(name)) for name in DRIVES} & set(context.hashes):
        return None
    return Chapter(
        title="The dissertation’s modal analysis",
        summary="Frequencies, shapes and determinants of chapter 3 of the dissertation, computed anew.",
        anchor="dissertation-modes",
        blocks=(
            Paragraph(
                text=Markup(
                    "Chapter 3 of the source of three of these machines, <cite>{}</cite>, recomputed with "
                    "the parameters of its Table 3.1. Where the print differs, the reason is given."
                ).format(SOURCE)
            ),
        ),
        sections=(
            Section(title="Table 3.2", anchor="table-3-2", blocks=_table()),
            Section(title="Figures 3.1 and 3.2", anchor="figures-3-1-3-2", blocks=_determinants()),
            Section(title="Figures 3.3, 3.4 and 3.9", anchor="figures-3-3-3-9", blocks=_shapes()),
            Section(title="Figure 3.8", anchor="figure-3-8", blocks=_carriage()),
        ),
        methods=("Determinants: of the 4 by 4 matrix (3.13) as printed, in double precision.",),
    )


@cache
def _drive(name: str) -> Drive:
    return load_drive(name)


def _table() -> tuple[Block, ...]:
    data = table_3_2()
    columns = ("configuration", "quantity", "printed", "computed", "mixture", "reproduced", "explanation")
    rows = list(zip(*(data[name].to_numpy() for name in columns), strict=True))
    groups = [
        RowGroup(
            title=f"Configuration {configuration}",
            rows=tuple(_cells(r) for r in rows if r[0] == configuration),
        )
        for configuration in (1, 2)
    ]
    reasons = list(dict.fromkeys((row[1], row[6]) for row in rows))
    items = Markup("").join(Markup("<li><strong>{}:</strong> {}.</li>").format(*reason) for reason in reasons)
    return (
        Table(
            caption="Table 3.2: printed values, values computed here, and values under the conventions "
            "that the print mixes.",
            columns=(
                Column(title="Quantity"),
                Column(title="Printed", unit="Hz", numeric=True),
                Column(title="Computed", unit="Hz", numeric=True),
                Column(title="Print’s conventions", unit="Hz", numeric=True),
                Column(title="Explains the print"),
            ),
            groups=tuple(groups),
        ),
        Note(text=Markup("<strong>Where the print comes from</strong><ul>{}</ul>").format(items)),
    )


def _cells(row: tuple[int, str, str, float, float, bool, str]) -> tuple[str, ...]:
    _, quantity, printed, computed, mixture, reproduced, _ = row
    explains = ("yes" if reproduced else "no") if printed else "not printed"
    return quantity, printed or "–", f"{computed:.4f}", f"{mixture:.2f}", explains


def _determinants() -> tuple[Block, ...]:
    both = [determinant_windows(_drive(name)) for name in DRIVES[:2]]
    gaps = [number(float(np.ptp(windows[2]["natural_frequency"].to_numpy()[1:3])), 2) for windows in both]
    blocks: list[Block] = [
        Paragraph(
            text="The print looks for zeros of a determinant. There are two of them near 750 Hz, "
            f"{gaps[0]} Hz apart in configuration 1 and {gaps[1]} Hz in configuration 2; on a plot up to "
            "3000 Hz the curve appears only to touch the axis there. The print lists the upper one as its "
            "second "
            "frequency. The lower one is the true second mode: both spans move together, the pulleys are "
            "at rest, as in its Fig. 3.5(b)."
        )
    ]
    for number_, windows in enumerate(both, start=1):
        picture = determinant_picture(f"determinant-{number_}", windows)
        zeros = ", ".join(f"{number(f)} Hz" for f in windows[0]["natural_frequency"].to_numpy())
        blocks.append(
            Figure(
                name=f"determinant-{number_}",
                alt=f"Determinant of the modal matrix against frequency in three ranges; zeros at {zeros}.",
                caption=f"Fig. 3.{number_}: determinant of (3.13) for configuration {number_}. Dots are the "
                "certified modes. The ranges of the print are not given; the first two are chosen like "
                "them, the third is new.",
                wide=picture.wide,
                narrow=picture.narrow,
            )
        )
    return tuple(blocks)


def _shapes() -> tuple[Block, ...]:
    first, second, transporter = map(_drive, DRIVES)
    middle = replace(transporter.carriage[0], position=transporter.span_length / 2)
    shapes = (
        ("Configuration 1", mode_shapes(first)),
        ("Configuration 2", mode_shapes(second)),
        ("Carriage at midspan", mode_shapes(replace(transporter, carriage=(middle,)))),
    )
    picture = fundamentals_picture("fundamentals", shapes)
    return (
        Figure(
            name="fundamentals",
            alt="Fundamental displacement of upper and lower span against position: nearly straight lines of "
            "opposite slope; with a carriage at midspan of configuration 1 they cross zero at the carriage.",
            caption="Figs. 3.3, 3.4 and 3.9: fundamental shapes, each span over its own coordinate. The "
            "carriage of the third, five times the cable’s mass, is at a node; the mass in the print is "
            "not given.",
            wide=picture.wide,
            narrow=picture.narrow,
        ),
    )


def _carriage() -> tuple[Block, ...]:
    drive = _drive(DRIVES[0])
    length, mass = drive.span_length, cable_mass(drive)
    crossing = midspan_crossing(drive)
    along = frequency_against_carriage_position(drive, MASS_RATIOS, np.linspace(0.0, length, 81), modes=1)
    loaded = with_carriage(drive, 1.0, length / 2)
    at_midspan = frequency_against(loaded, "carriage.0.mass", mass * np.geomspace(1.0, 100.0, 41), modes=2)
    picture = carriage_picture("carriage-on-its-way", along, at_midspan, mass)
    ratio, fundamental = number(crossing.mass_ratio, 4), number(crossing.frequency, 5)
    heaviest = number(float(along["frequency"][-1, 40, 0]), 3)
    return (
        Paragraph(
            text="A carriage lowers the fundamental of configuration 1 most where it sits on a rim. At "
            "midspan, the print says, it changes nothing. That holds for the out-of-phase mode, which has "
            "its node there; but the frequency of the mode that moves the carriage falls as the mass "
            "grows, crosses it at "
            f"{ratio} times the cable’s mass, and is the fundamental from there on: {heaviest} Hz instead of "
            f"{fundamental} Hz at {number(MASS_RATIOS[-1])} times."
        ),
        Figure(
            name="carriage-on-its-way",
            alt=f"Left: fundamental frequency against the place of a carriage for {len(MASS_RATIOS)} masses; "
            f"all curves but the heaviest two coincide at midspan at {fundamental} Hz. Right: both lowest "
            "modes "
            f"with the carriage at midspan against its mass; they cross at {ratio} times the mass of the "
            "cable.",
            caption="Fig. 3.8, and the second mode that it lacks. Numbers on the curves: mass of the "
            "carriage over mass "
            "of the cable, chosen here; those of the print are not given.",
            wide=picture.wide,
            narrow=picture.narrow,
        ),
    )
