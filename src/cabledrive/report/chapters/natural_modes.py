"""Chapter "Natural modes": every mode of every machine, its proof, its shape."""

from collections.abc import Sequence

from markupsafe import Markup

from cabledrive.modal import Mode, Modes
from cabledrive.modal.lowest import how_held, lowest_frequencies
from cabledrive.modal.mode_rows import ModeRow, mode_rows
from cabledrive.parameters import Drive
from cabledrive.report import formula as f
from cabledrive.report.blocks import (
    Block,
    Cell,
    Chapter,
    Column,
    Equation,
    Figure,
    Note,
    Paragraph,
    RowGroup,
    Section,
    Table,
)
from cabledrive.report.certificate_words import certificate_words
from cabledrive.report.context import ReportContext
from cabledrive.report.figures.ladder import ladder_picture
from cabledrive.report.figures.shapes import shapes_picture
from cabledrive.report.numbers import decimals_for, fixed, number
from cabledrive.report.simple_models import simple_models_table

PLACE = 200
SHOWN_SHAPES, SHOWN_ACROSS = 4, 6
_PARTS = ("drive pulley", "load pulley", "motor", "carriages", "cable")


def chapter(context: ReportContext) -> Chapter:
    """The natural modes of every machine."""
    parts = zip(context.drives, context.anchors, context.modes, strict=True)
    return Chapter(
        title="Natural modes",
        anchor="natural-modes",
        blocks=_introduction(),
        sections=tuple(
            Section(title=drive.name, anchor=f"modes-{name}", blocks=_about(drive, name, modes))
            for drive, name, modes in parts
        ),
        methods=(
            "Natural modes: exact dynamic stiffness of every span; roots isolated by Wittrick-Williams "
            "counts and refined by inverse iteration, each enclosed between two counts. Transverse modes "
            "about the rest: power series on strings of changing tension, shallow sag in the plane of "
            "gravity. Friction and damping do not enter; longitudinal modes are those of the taut cable.",
        ),
    )


def _introduction() -> tuple[Block, ...]:
    omega = f.inline("ω")
    return (
        Paragraph(
            text="Longitudinal: every span is a wave guide, pulleys enter with their inertia and carriages "
                "with their mass; there is no discretisation. Transverse: a span is a string under its "
                "static tension (weight and slope included), fixed at the pulleys and at guided carriages. "
                "In the plane of gravity the sag is included: a motion that stretches the sagging cable "
                "raises its tension and thus the frequency."
        ),
        Paragraph(
            text=Markup(
                "Completeness needs a count that is independent of the search, the count of Wittrick and "
                "Williams: the number of natural frequencies "
                "below {} is the number of negative eigenvalues of the dynamic stiffness {}, plus those "
                "of the segments of length {} between fixed ends, with wave speed {}:"
            ).format(omega, f.inline("K"), f.inline(f.sub("l", "i")), f.inline("c"))
        ),
        Equation(
            formula=f.row(
                "J", "(", "ω", ")", "=", "s", "{", "K", "(", "ω", ")", "}", "+",
                f.total("i", "⌊", f.fraction(f.row("ω", f.sub("l", "i")), f.row("π", "c")), "⌋"),
            ),
            words="J of omega is the sign count of K of omega, plus the sum over all segments of the whole "
            "part of omega times the length of the segment over pi times the wave speed",
        ),
        Paragraph(
            text="It counts every mode, double ones twice. In the staircases below the line is this count "
                "and the dots are the list: a missed mode would be a step without a dot. The transverse "
                "rungs of the ladder under each staircase are those of the plane of gravity."
        ),
        Paragraph(
            text="Shapes are drawn along the unrolled cable. Dots are the rims of the pulleys, squares the "
                "carriages; displacements are positive in the direction of each span, and the largest is "
                "scaled to one. Modes are named by the parts that move: the pulleys against each other "
                "(out of phase), with each other "
            "(in phase) or not at all (at rest), mainly a carriage, or mainly the motor against its joint."
        ),
    )  # fmt: skip


def _about(drive: Drive, name: str, modes: Modes) -> tuple[Block, ...]:
    tone = "good" if modes.certified else "warning"
    head = Markup("<strong>{}</strong> ").format(
        "Complete." if modes.certified else "Not certified as complete."
    )
    blocks: list[Block] = [
        Note(text=head + certificate_words(modes), tone=tone),
        Paragraph(text=f"{lowest_frequencies(drive).line} {how_held(modes)}"),
    ]
    if any(mode.frequency < modes.certificate.below for mode in modes.longitudinal):
        blocks.append(_ladder(drive, name, modes))
    if modes.longitudinal:
        blocks.append(_along(modes))
    return (
        *blocks,
        _across(modes),
        *_warnings(modes),
        _shapes(drive, name, modes),
        simple_models_table(drive),
    )


def _warnings(modes: Modes) -> tuple[Block, ...]:
    """What of the machine touches the list."""
    return tuple(Note(text=f"{line[0].upper()}{line[1:]}.", tone="warning") for line in modes.warnings)


def _ladder(drive: Drive, name: str, modes: Modes) -> Figure:
    picture = ladder_picture(f"ladder-{name}", drive, modes)
    bound = modes.certificate.below
    steps = ", ".join(f"{number(mode.frequency)} Hz" for mode in modes.longitudinal if mode.frequency < bound)
    below = f"{number(bound)} Hz"
    return Figure(
        name=f"ladder-{name}",
        alt=f"Staircase of the number of longitudinal modes below a frequency, up to {below}; it rises at "
        f"{steps}. Under it each mode as a rung, {len(modes.transverse)} of them transverse.",
        caption=f"{drive.name}: longitudinal modes, counted up to {below} (line) and listed (dots); under "
        "it, each mode of both kinds as a rung.",
        wide=picture.wide,
        narrow=picture.narrow,
    )


def _along(modes: Modes) -> Table:
    rows = [(mode, _shares(mode)) for mode in modes.longitudinal]
    parts = [part for part in _PARTS if any(part in shares for _, shares in rows)]
    decimals = _decimals([mode.frequency for mode, _ in rows])
    cells: list[tuple[Cell, ...]] = [
        (
            fixed(mode.frequency, decimals),
            f"{mode.family} ×{mode.multiplicity}" if mode.multiplicity > 1 else mode.family,
            *(shares.get(part, 0.0) for part in parts),
        )
        for mode, shares in rows
    ]
    return Table(
        caption="Longitudinal modes and their kinetic energy.",
        columns=(
            Column(title="Frequency", unit="Hz", numeric=True),
            Column(title="What moves"),
            *(Column(title=part.removesuffix(" pulley"), unit="%", bar=True) for part in parts),
        ),
        groups=(RowGroup(rows=tuple(cells)),),
    )


def _shares(mode: Mode) -> dict[str, float]:
    """Shares of the kinetic energy, all carriages taken together."""
    shares: dict[str, float] = {}
    for name, share in mode.kinetic_shares.items():
        part = "carriages" if name.startswith("carriage") else name
        shares[part] = shares.get(part, 0.0) + share
    return shares


def _decimals(frequencies: Sequence[float]) -> int:
    """Enough decimals for five digits of the lowest and seven of the highest."""
    return min(8, max(decimals_for(min(frequencies), 5), decimals_for(max(frequencies), 7)))


def _across(modes: Modes) -> Table:
    rows = mode_rows(modes.transverse)
    decimals = _decimals([row.frequency for row in rows[:SHOWN_ACROSS]])
    more = f"The lowest {SHOWN_ACROSS} of {len(rows)} frequencies." if len(rows) > SHOWN_ACROSS else ""
    return Table(
        caption="Transverse modes.",
        columns=(
            Column(title="Frequency", unit="Hz", numeric=True),
            Column(title="Modes", numeric=True),
            Column(title="Where"),
            Column(title="Model"),
        ),
        groups=(RowGroup(rows=tuple(_across_cells(row, decimals) for row in rows[:SHOWN_ACROSS])),),
        note=more,
    )


def _across_cells(row: ModeRow, decimals: int) -> tuple[Cell, ...]:
    carried = "the carriages move; " if row.family == "carriage-dominated" else ""
    models = sorted({mode.model or "" for mode in row.modes})
    return fixed(row.frequency, decimals), str(row.count), carried + row.where, " and ".join(models)


def _shapes(drive: Drive, name: str, modes: Modes) -> Figure:
    across = [row.modes[0] for row in mode_rows(m for m in modes.transverse if m.plane == "w")]
    shown = [*modes.longitudinal[:SHOWN_SHAPES], *across[:2]]
    picture = shapes_picture(f"shapes-{name}", drive, shown)
    seen = "; ".join(f"{number(m.frequency)} Hz, {m.family}" for m in shown)
    what = "drive to load" if drive.kind == "line" else "drive, load and back to the drive"
    return Figure(
        name=f"shapes-{name}",
        alt=f"Displacement along the unrolled cable in {len(shown)} modes: {seen}.",
        caption=f"{drive.name}: shapes of the lowest longitudinal and transverse modes along the unrolled "
        f"cable ({what}).",
        wide=picture.wide,
        narrow=picture.narrow,
    )
