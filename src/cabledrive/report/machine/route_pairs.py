"""Pairs near internal resonance of a machine with routes: verdict and table."""

from cabledrive.parameters import InputRefused, NotComputed
from cabledrive.parameters.route import RoutedDrive
from cabledrive.report.blocks import Column, RowGroup, Table
from cabledrive.report.machine.internal_resonance import BADGES, TONES, ResonanceVerdict
from cabledrive.report.numbers import number, quantity
from cabledrive.report.views import Badge
from cabledrive.studies.pair_thresholds import SUM
from cabledrive.studies.route_pairs import RoutePair, RouteResonance, route_resonance

SHOWN = 8


def pairs_of_route(drive: RoutedDrive) -> tuple[ResonanceVerdict, Table | None]:
    """Verdict and table of a machine; where there is none, the reason in the verdict."""
    try:
        found = route_resonance(drive)
    except (InputRefused, NotComputed) as refusal:
        badge = Badge(text="Internal resonance: not computed", tone="remark")
        return ResonanceVerdict(badge=badge, reasons=(str(refusal),)), None
    return _verdict(found), _table(found) if found.pairs else None


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


def _table(found: RouteResonance) -> Table:
    more = len(found.pairs) - SHOWN
    return Table(
        caption="Longitudinal modes and the transverse modes that they can excite parametrically, lowest "
        "threshold first.",
        columns=(
            Column(title="Longitudinal", unit="Hz", numeric=True),
            Column(title="Transverse", unit="Hz", numeric=True),
            Column(title="Kind"),
            Column(title="Span"),
            Column(title="Detuning", unit="Hz", numeric=True),
            Column(title="Threshold torque", numeric=True),
        ),
        groups=(RowGroup(rows=tuple(_row(pair) for pair in found.pairs[:SHOWN])),),
        note=f"{more} more with higher thresholds." if more > 0 else "",
    )


def _row(pair: RoutePair) -> tuple[str, ...]:
    both = number(pair.transverse_hz[0], 5)
    both += f" + {number(pair.transverse_hz[1], 5)}" if pair.kind == SUM else ""
    torque = "none" if pair.threshold_torque is None else quantity(pair.threshold_torque, "N m", 3)
    return (
        number(pair.longitudinal_hz, 5),
        both,
        pair.kind,
        f"{pair.span}, {pair.plane}",
        number(pair.detuning_hz, 3),
        torque,
    )
