"""The card of a machine, its modes, and whether they excite one another."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any, Protocol

from cabledrive.modal import Mode, Modes
from cabledrive.modal.lowest import against_lumped_springs, against_rigid_supports
from cabledrive.modal.mode_rows import ModeRow, mode_rows
from cabledrive.parameters import Drive, InputRefused, NotComputed
from cabledrive.parameters.route import RoutedDrive
from cabledrive.report.blocks import Cell, Figure, Table, table
from cabledrive.report.figures.ladder import ladder_picture
from cabledrive.report.figures.shapes import mode_title, shapes_picture
from cabledrive.report.machine.tables import pairs_table
from cabledrive.report.mode_figure import draw_map
from cabledrive.report.page import Badge, Card
from cabledrive.report.picture import picture, short_family
from cabledrive.report.typesetting import decimals_for, fixed, number, quantity
from cabledrive.studies.excitation_orders import travels
from cabledrive.studies.mode_map import map_modes
from cabledrive.studies.resonance import ResonanceSummary, resonance
from cabledrive.studies.resonance_detuning import NO_EXCITATION
from cabledrive.studies.route_pairs import RouteResonance, route_resonance

if TYPE_CHECKING:
    import xarray as xr


TONES = {
    "safe": "good",
    "close": "warning",
    "resonant": "warning",
    "unknown": "remark",
    NO_EXCITATION: "remark",
}
BADGES = {
    "safe": "No internal resonance",
    "close": "Close to internal resonance",
    "resonant": "Internal resonance",
    "unknown": "Internal resonance: amplitude not given",
    NO_EXCITATION: "Internal resonance: no excitation given",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class ResonanceVerdict:
    """Verdict on the internal resonance of a machine."""

    badge: Badge
    reasons: tuple[str, ...]  # of the verdict, or why there is none


@lru_cache(maxsize=16)
def kept_resonance(drive: Drive) -> ResonanceSummary:
    """Result of `cabledrive.resonance`, computed once for the page of a machine and the chapter of all."""
    return resonance(drive)


def resonance_verdict(drive: Drive) -> ResonanceVerdict:
    """Verdict of `cabledrive.resonance`; where it cannot be computed, the reason."""
    try:
        found = kept_resonance(drive)
    except (InputRefused, NotComputed) as refusal:
        return ResonanceVerdict(
            badge=Badge(text="Internal resonance: not computed", tone="remark"), reasons=(str(refusal),)
        )
    stated = found.verdict != NO_EXCITATION
    at = f" at {quantity(found.torque, 'N m', 3)}" if stated else ""
    facts = []
    if found.frequency_ratio is not None:
        ratio = number(found.frequency_ratio, 3)
        facts.append(
            f"The lowest transverse frequency of an empty span is {ratio} times that of the pulley mode; "
            "0.5 is the principal resonance"
        )
    return ResonanceVerdict(
        badge=Badge(text=BADGES[found.verdict] + at, tone=TONES[found.verdict]),
        reasons=(*facts, *found.reasons),
    )


class MachineContent(Protocol):
    """What a card needs of the page behind it."""

    @property
    def drive(self) -> Any:
        """A drive of any kind."""

    @property
    def modes(self) -> Modes:
        """Its first modes."""

    @property
    def resonance(self) -> ResonanceVerdict:
        """Its internal resonance."""

    @property
    def warnings(self) -> tuple[str, ...]:
        """What its user should know."""


def machine_card(page: MachineContent, sketch: Any) -> Card:
    """The card that leads to a page."""
    certificate = page.modes.certificate
    below = f"{number(certificate.below, 4)} Hz"
    complete = Badge(text=f"Modes complete up to {below}", tone="good")
    doubtful = Badge(text=f"Modes up to {below} not certified", tone="warning")
    facts = [_fact("Longitudinal", page.modes.longitudinal), _fact("Transverse", page.modes.transverse)]
    if page.warnings:
        facts.append(("Warnings", f"{len(page.warnings)}"))
    return Card(
        text=page.drive.title,
        picture=sketch,
        badges=(complete if page.modes.certified and certificate.count else doubtful, page.resonance.badge),
        facts=tuple(facts),
    )


def _fact(what: str, modes: tuple[Mode, ...]) -> tuple[str, str]:
    """The lowest of some modes in words."""
    if not modes:
        return what, "none found"
    where = modes[0].span or short_family(modes[0].family)
    where += {"upper": " span", "lower": " span", "both": " spans"}.get(where, "")
    return what, f"{number(modes[0].frequency, 4)} Hz, {where}"


SHOWN_SHAPES, SHOWN_ON_ROUTES, SHOWN_ACROSS = 4, 3, 6
_PARTS = ("drive pulley", "load pulley", "motor", "carriages", "cable")


def ladder(drive: Drive, name: str, modes: Modes) -> Figure | None:
    """The count of modes as a staircase; None where no longitudinal mode lies in its range."""
    if not any(mode.frequency < modes.certificate.below for mode in modes.longitudinal):
        return None
    picture = ladder_picture(f"ladder-{name}", drive, modes)
    bound = modes.certificate.below
    steps = ", ".join(f"{number(mode.frequency)} Hz" for mode in modes.longitudinal if mode.frequency < bound)
    below = f"{number(bound)} Hz"
    return Figure(
        name=f"ladder-{name}",
        alt=f"Staircase of the number of longitudinal modes below a frequency, up to {below}; it rises at "
        f"{steps}. Under it each mode as a rung, {len(modes.transverse)} of them transverse.",
        caption=f"Longitudinal modes, counted up to {below} (line) and listed (dots); under "
        "it, each mode of both kinds as a rung.",
        drawing=picture,
    )


def along_table(modes: Modes) -> Table:
    """Longitudinal modes and the shares of their kinetic energy."""
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
    return table(
        "Longitudinal modes and their kinetic energy.",
        "Frequency [Hz] | What moves",
        cells,
        bars=(part.removesuffix(" pulley") for part in parts),
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


def across_table(modes: Modes) -> Table:
    """The lowest transverse modes."""
    rows = mode_rows(modes.transverse)
    decimals = _decimals([row.frequency for row in rows[:SHOWN_ACROSS]])
    more = f"The lowest {SHOWN_ACROSS} of {len(rows)} frequencies." if len(rows) > SHOWN_ACROSS else ""
    return table(
        "Transverse modes.",
        "Frequency [Hz] | Modes [] | Where | Model",
        (_across_cells(row, decimals) for row in rows[:SHOWN_ACROSS]),
        note=more,
    )


def _across_cells(row: ModeRow, decimals: int) -> tuple[Cell, ...]:
    carried = "the carriages move; " if row.family == "carriage-dominated" else ""
    models = sorted({mode.model or "" for mode in row.modes})
    return fixed(row.frequency, decimals), str(row.count), carried + row.where, " and ".join(models)


ON_ROUTES = (
    "The lowest modes on the machine. Blue: along a span, by dots that it moves; orange: across. "
    "Arrows: bodies that slide; rings: bodies that turn; radii: pulleys at rest and turned."
)
UNROLLED = {
    kind: f"Shapes of the lowest modes along the unrolled cable ({way}). Dots are the rims of the pulleys, "
    "squares the carriages; the largest displacement is scaled to one."
    for kind, way in (("line", "drive to load"), ("loop", "drive, load and back to the drive"))
}


def shapes(drive: Drive | RoutedDrive, name: str, modes: Modes) -> Figure:
    """The lowest mode shapes: along the unrolled cable, or on a machine with routes."""
    across = [row.modes[0] for row in mode_rows(m for m in modes.transverse if m.plane == "w")]
    if isinstance(drive, RoutedDrive):
        shown, what = [*modes.longitudinal[:SHOWN_ON_ROUTES], *across[:1]], ON_ROUTES
    else:
        shown, what = [*modes.longitudinal[:SHOWN_SHAPES], *across[:2]], UNROLLED[drive.kind]
    return Figure(
        name=f"shapes-{name}",
        alt=f"{len(shown)} modes: {'; '.join(map(mode_title, shown))}.",
        caption=what,
        drawing=shapes_picture(f"shapes-{name}", drive, shown),
    )


SHOWN = 8


def pairs_of_route(drive: RoutedDrive) -> tuple[ResonanceVerdict, Table | None]:
    """Verdict and table of a machine; where there is none, the reason in the verdict."""
    try:
        found = route_resonance(drive)
    except (InputRefused, NotComputed) as refusal:
        badge = Badge(text="Internal resonance: not computed", tone="remark")
        return ResonanceVerdict(badge=badge, reasons=(str(refusal),)), None
    return _verdict(found), pairs_table(found, SHOWN)


def _verdict(found: RouteResonance) -> ResonanceVerdict:
    at = "" if found.torque is None else f" at {quantity(found.torque, 'N m', 3)}"
    ratio = (
        f"the first transverse mode of {found.nearest_span} has {number(found.frequency_ratio, 3)} times the "
        f"frequency of the longitudinal mode at {number(found.longitudinal_hz, 4)} Hz; 0.5 is resonance"
    )
    return ResonanceVerdict(
        badge=Badge(text=BADGES[found.verdict] + at, tone=TONES[found.verdict]),
        reasons=(*found.reasons, ratio, *found.left_out),
    )


COUNT, MOST_PULLEYS = 3, 14
"""Modes of each kind; pulleys above which a map would take longer than the rest of the page."""
_HEIGHT = 300.0  # px


def travel_figures(drive: RoutedDrive, name: str) -> Iterator[Figure]:
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
    def _draw(figure: Any) -> None:
        draw_map(figure, found, 1)

    drawn = picture(name, _draw, height=_HEIGHT)
    along = keys[0] + (f" (with {', '.join(keys[1:])})" if len(keys) > 1 else "")
    certified, points = int(found["certified"].sum()), int(found["certified"].size)
    lost = int((found["reason"] != "").sum())
    said = f"The lists of {certified} of {points} places are certified"
    said += f"; at {lost} the machine cannot be" if lost else ""
    return Figure(
        name=name,
        alt=f"Natural frequencies of the first {COUNT} modes of each kind over {along}.",
        caption=f"Natural frequencies over {along}, from end to end of the machine's drawing. {said}.",
        drawing=drawn,
    )


def simple_models_table(drive: Drive) -> Table:
    """Frequencies by closed formulas beside the exact ones, as far as each formula applies."""
    return table(
        "What simpler models make of this machine.",
        "Model | Its frequency [Hz] | Exact [Hz] | Deviation [%]",
        (_row(*line) for line in _models(drive)),
    )


def _models(drive: Drive) -> Iterator[tuple[str, float, float]]:
    """Name of the model, its frequency, the certified one [Hz]."""
    along, across = against_rigid_supports(drive)
    if not all(pulley.fixed for pulley in drive.pulley):
        lumped = against_lumped_springs(drive)
        yield "Pulleys on springs without mass, no carriage", lumped.simple, lumped.exact
    yield "Bare span between rigid supports, along (3.14a)", along.simple, along.exact
    yield "Bare span between rigid supports, across (3.14b)", across.simple, across.exact


def _row(model: str, simple: float, exact: float) -> tuple[Cell, ...]:
    deviation = 100.0 * (simple / exact - 1.0)
    sign = "+" if deviation >= 0.05 else ""
    return model, number(simple), number(exact), sign + fixed(deviation + 0.0, 1).replace("−0.0", "0.0")
