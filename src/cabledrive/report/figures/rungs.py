"""The natural frequencies as a ladder, drawn fast enough to follow a slider: a rung for each row."""

from collections.abc import Sequence
from math import ceil, floor, log10

from markupsafe import Markup

from cabledrive.modal.mode import LONGITUDINAL
from cabledrive.modal.mode_rows import ModeRow
from cabledrive.report.figures.sheet import Sheet
from cabledrive.report.numbers import number
from cabledrive.report.style import COLOURS, SMALL, family_colour

LANE, TOP, LEFT, RIGHT, FOOT = 46.0, 22.0, 92.0, 24.0, 40.0  # px
_NAMES = {light: name for name, (light, _) in COLOURS.items()}


def rungs(rows: Sequence[ModeRow], chosen: int, width: float) -> Markup:
    """The ladder of a table of modes; ``chosen``: number of the row that is animated."""
    sheet = Sheet()
    low, high = _limits([row.frequency for row in rows])
    lanes = {"longitudinal": TOP + 0.5 * LANE, "transverse": TOP + 1.5 * LANE}
    foot = TOP + 2 * LANE
    for name, y in lanes.items():
        sheet.elements.append(
            f'<rect x="{LEFT - 6:g}" y="{y - 0.5 * LANE + 6:.1f}" width="{width - LEFT - RIGHT + 12:g}" '
            f'height="{LANE - 12:g}" rx="4" style="fill: var(--faint)"/>'
        )
        sheet.words(name, (LEFT - 12, y + 4), anchor="end", colour="quiet", size=SMALL)
    _axis(sheet, low, high, width, foot)
    for place, row in enumerate(rows):
        x = _across(row.frequency, low, high, width)
        y = lanes["longitudinal" if row.kind == LONGITUDINAL else "transverse"]
        colour = _NAMES[family_colour(row.family)] if row.kind == LONGITUDINAL else "ink"
        half = 0.5 * LANE - (4 if place == chosen else 9)
        sheet.elements.append(f'<g class="rung" data-row="{place}">')
        sheet.path(
            f"M{x:.2f} {y - half:.1f} V{y + half:.1f}", colour=colour, width=4 if place == chosen else 2
        )
        sheet.elements.append(  # a finger is wider than a rung
            f'<rect x="{x - 7:.2f}" y="{y - 0.5 * LANE:.1f}" width="14" height="{LANE:g}" '
            'style="fill: transparent"/>'
        )
        sheet.elements.append("</g>")
        if place == chosen:
            anchor = "end" if x > 0.8 * width else "start" if x < 0.2 * width else "middle"
            sheet.words(f"{number(row.frequency, 6)} Hz", (x, 13.0), anchor=anchor, colour=colour)
    return sheet.svg((width, foot + FOOT))


def _limits(frequencies: Sequence[float]) -> tuple[float, float]:
    """Ends of the axis [Hz]: round numbers, so that the axis rests while a slider moves."""
    low, high = min(frequencies), max(frequencies)

    def _round(value: float, up: bool) -> float:
        ten = 10.0 ** floor(log10(value))
        steps = (1.0, 2.0, 5.0, 10.0)
        if up:
            return ten * next(step for step in steps if step * ten >= value * (1 - 1e-12))
        return ten * max(step for step in steps if step * ten <= value * (1 + 1e-12))

    return _round(low / 1.05, False), _round(high * 1.05, True)


def _across(frequency: float, low: float, high: float, width: float) -> float:
    return LEFT + (width - LEFT - RIGHT) * log10(frequency / low) / log10(high / low)


def _axis(sheet: Sheet, low: float, high: float, width: float, foot: float) -> None:
    sheet.line((LEFT, foot), (width - RIGHT, foot), colour="line")
    steps = (1.0, 2.0, 5.0) if log10(high / low) * 130.0 < width - LEFT else (1.0,)
    decades = range(floor(log10(low) + 1e-9), ceil(log10(high) - 1e-9) + 1)
    for value in (step * 10.0**ten for ten in decades for step in steps):
        if low * (1 - 1e-9) <= value <= high * (1 + 1e-9):
            x = _across(value, low, high, width)
            sheet.line((x, foot), (x, foot + 4), colour="line")
            sheet.words(number(value, 3), (x, foot + 17), colour="quiet", size=SMALL)
    sheet.words("natural frequency [Hz]", ((LEFT + width - RIGHT) / 2, foot + 34), colour="quiet", size=SMALL)
