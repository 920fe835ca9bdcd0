"""The card of a machine, its modes, and whether they excite one another."""

from collections.abc import Iterator
from itertools import chain
from typing import TYPE_CHECKING

from cabledrive.answers.figures import number, quantity
from cabledrive.modal import Modes
from cabledrive.modal.mode_rows import mode_rows
from cabledrive.parameters import InputRefused, Machine, NotComputed
from cabledrive.report.blocks import Figure, Table
from cabledrive.report.figures.ladder import ladder_picture
from cabledrive.report.figures.shapes import mode_title, shapes_picture
from cabledrive.report.machine.tables import pairs_table
from cabledrive.report.mode_figure import draw_map
from cabledrive.report.page import Badge
from cabledrive.report.picture import picture, short_family
from cabledrive.studies.excitation_orders import travels
from cabledrive.studies.mode_map import map_modes
from cabledrive.studies.resonance import resonance
from cabledrive.studies.resonance_detuning import NO_EXCITATION

if TYPE_CHECKING:
    import xarray as xr


BADGES = {
    "safe": ("No internal resonance", "good"),
    "close": ("Close to internal resonance", "warning"),
    "resonant": ("Internal resonance", "warning"),
    "unknown": ("Internal resonance: amplitude not given", "remark"),
    NO_EXCITATION: ("Internal resonance: no excitation given", "remark"),
}
"""Words and tone of each verdict."""


def resonance_words(drive: Machine) -> tuple[Badge, tuple[str, ...], Table | None]:
    """Verdict on the internal resonance, its reasons, its pairs; or why it cannot be computed."""
    try:
        found = resonance(drive)
    except (InputRefused, NotComputed) as refusal:
        return Badge("Internal resonance: not computed", "remark"), (str(refusal),), None
    stated = found.torque is not None and found.verdict != NO_EXCITATION
    at = f" at {quantity(found.torque or 0.0, 'N m', 3)}" if stated else ""
    words, tone = BADGES[found.verdict]
    badge = Badge(words + at, tone)
    ratio = "" if found.frequency_ratio is None else number(found.frequency_ratio, 3)
    span = found.nearest_span or "an empty span"
    facts = f"The lowest transverse frequency of {span} is {ratio} times that of the pulley mode"
    reasons = ([f"{facts}; 0.5 is the principal resonance"] if ratio else ()), found.reasons, found.left_out
    return badge, tuple(chain(*reasons)), pairs_table(found, SHOWN)


def facts_of(modes: Modes) -> list[tuple[str, str]]:
    """The lowest modes of each kind in words."""
    facts = []
    for what, found in (("Longitudinal", modes.longitudinal), ("Transverse", modes.transverse)):
        words = "none found"
        for lowest in found[:1]:
            where = lowest.span or short_family(lowest.family)
            where += {"upper": " span", "lower": " span", "both": " spans"}.get(where, "")
            words = f"{number(lowest.frequency, 4)} Hz, {where}"
        facts.append((what, words))
    return facts


SHOWN, SHOWN_SHAPES = 8, 4


def ladder(drive: Machine, name: str, modes: Modes) -> Figure | None:
    """The count of modes as a staircase; None where no longitudinal mode lies in its range."""
    if not any(mode.frequency < modes.certificate.below for mode in modes.longitudinal):
        return None
    bound = modes.certificate.below
    steps = ", ".join(f"{number(mode.frequency)} Hz" for mode in modes.longitudinal if mode.frequency < bound)
    below = f"{number(bound)} Hz"
    return Figure(
        name=f"ladder-{name}",
        alt=f"Staircase of the number of longitudinal modes below a frequency, up to {below}; it rises at "
        f"{steps}. Under it each mode as a rung, {len(modes.transverse)} of them transverse.",
        caption=f"Longitudinal modes, counted up to {below} (line) and listed (dots); under "
        "it, each mode of both kinds as a rung.",
        drawing=ladder_picture(f"ladder-{name}", drive, modes),
    )


UNROLLED = (
    "Shapes of the lowest modes along the unrolled ropes, span behind span. Dots are rims of pulleys and "
    "ends of ropes, squares the carriages; the largest displacement is scaled to one."
)


def shapes(drive: Machine, name: str, modes: Modes) -> Figure:
    """The lowest mode shapes along the unrolled ropes."""
    across = [row.modes[0] for row in mode_rows(m for m in modes.transverse if m.plane == "w")]
    shown = [*modes.longitudinal[:SHOWN_SHAPES], *across[:2]]
    return Figure(
        name=f"shapes-{name}",
        alt=f"{len(shown)} modes: {'; '.join(map(mode_title, shown))}.",
        caption=UNROLLED,
        drawing=shapes_picture(f"shapes-{name}", drive, shown),
    )


COUNT, MOST_PULLEYS = 3, 14
"""Modes of each kind; pulleys above which a map would take longer than the rest of the page."""
_HEIGHT = 300.0  # px


def travel_figures(drive: Machine, name: str) -> Iterator[Figure]:
    """A figure for each motion of a body that strains nothing; none of machines with many pulleys."""
    if len(drive.pulley) > MOST_PULLEYS:
        return
    for place, travel in enumerate(travels(drive)):
        keys = next(iter(travel))
        try:
            found = map_modes(drive, travel, count=COUNT)
        except InputRefused:  # nowhere but at its place is it a machine
            continue
        yield _figure(f"travel-{name}-{place}", keys, found)


def _figure(name: str, keys: tuple[str, ...], found: "xr.Dataset") -> Figure:
    along = keys[0] + (f" (with {', '.join(keys[1:])})" if len(keys) > 1 else "")
    certified, points = int(found["certified"].sum()), int(found["certified"].size)
    lost = int((found["reason"] != "").sum())
    said = f"The lists of {certified} of {points} places are certified"
    said += f"; at {lost} the machine cannot be" if lost else ""
    return Figure(
        name=name,
        alt=f"Natural frequencies of the first {COUNT} modes of each kind over {along}.",
        caption=f"Natural frequencies over {along}, from end to end of the machine's drawing. {said}.",
        drawing=picture(name, lambda figure: draw_map(figure, found, 1), height=_HEIGHT),
    )
