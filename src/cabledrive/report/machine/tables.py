"""Pairs of modes and margins of a motion as tables, for pages, the studio and the terminal."""

from collections.abc import Sequence
from math import degrees, pi

from cabledrive.modal.tuning import Pair
from cabledrive.report.blocks import Cell, Table, table
from cabledrive.report.machine.data import both
from cabledrive.report.typesetting import number, quantity, stated
from cabledrive.studies.motion_margins import TEETH, MotionMargins, PulleyMargin
from cabledrive.studies.pair_thresholds import SUM, CoupledPair
from cabledrive.studies.resonance import ResonanceSummary
from cabledrive.studies.route_pairs import RoutePair, RouteResonance


def pairs_table(found: ResonanceSummary | RouteResonance, most: int) -> Table | None:
    """Pairs of modes that can excite one another, lowest threshold first; None where there are none.

    Of a loop the ratio and the tuned pretension of the pulley mode's pairs, of which the lowest of each
    section and the nearest to 1:2 are always listed.
    """
    pairs: Sequence[CoupledPair | RoutePair]
    heads = "Kind | Where | Longitudinal [Hz] | Transverse [Hz] | Detuning [Hz] | Threshold torque []"
    if isinstance(found, RouteResonance):
        pairs, rows = found.pairs, [_pair(pair) for pair in found.pairs[:most]]
    else:
        pairs, heads, rows = found.coupled, f"{heads} | Ratio [] | Tuned at []", []
        for place, pair in enumerate(found.coupled):
            own = own_pair(found.pairs, pair)
            if place < most or (own is not None and _told(own, found.pairs)):
                tuned = None if own is None else own.tuned_pretension
                ratio = "" if own is None else number(own.ratio, 4)
                rows.append((*_pair(pair), ratio, "" if tuned is None else quantity(tuned, "N")))
    left = len(pairs) - len(rows)
    note = f"{left} more with higher thresholds." if left > 0 else ""
    caption = "Longitudinal modes and the transverse modes that they can excite, lowest threshold first."
    return table(caption, heads, rows, note=note) if rows else None


def _pair(pair: CoupledPair | RoutePair) -> tuple[Cell, ...]:
    if isinstance(pair, RoutePair):
        where = f"{pair.span}, {pair.plane}"
    else:
        modes = " + ".join(str(one) for one in dict.fromkeys(pair.numbers))
        where = f"{pair.span}, {pair.section[0]:.4g} to {pair.section[1]:.4g} m, m = {modes}"
    across = pair.transverse_hz if pair.kind == SUM else pair.transverse_hz[:1]
    return (
        pair.kind,
        where,
        number(pair.longitudinal_hz, 6),
        " + ".join(number(hertz, 6) for hertz in across),
        number(pair.detuning_hz, 4),
        "none" if pair.threshold_torque is None else quantity(pair.threshold_torque, "N m"),
    )


def own_pair(pairs: Sequence[Pair], pair: CoupledPair) -> Pair | None:
    """The record of the pulley mode's pair that is the same mode of the same section; None: it is another."""
    for own in pairs if pair.kind != SUM else ():
        ends = zip(own.section, pair.section, strict=True)
        near = all(abs(a - b) <= 1e-9 * pair.section[1] for a, b in ends)
        pulley = abs(pair.longitudinal_hz / own.pulley_frequency - 1.0) < 1e-9
        if pulley and near and (own.span, own.number) == (pair.span, pair.numbers[0]):
            return own
    return None


def _told(pair: Pair, pairs: Sequence[Pair]) -> bool:
    """Whether a pair is always listed: the lowest of each section, and the nearest to 1:2."""
    own = [other for other in pairs if (other.span, other.section) == (pair.span, pair.section)]
    return pair.number <= 3 or pair is min(own, key=lambda other: abs(other.detuning))


def margins_tables(found: MotionMargins) -> tuple[Table, Table, Table]:
    """Spans, pulleys and motors along a motion: what is needed and what holds."""
    spans = (
        (own.name, *map(both, (own.rest, own.even, own.tension)), stated(own.safety_factor, 3), own.verdict)
        for own in found.spans
    )
    pulleys = (
        (own.name, number(degrees(own.wrap), 4), *_needed(own), stated(own.margin, 3), own.verdict)
        for own in found.pulleys
    )
    motors = []
    for own in found.motors:
        shown = (own.peak_torque, own.rms_torque, own.torque_limit, 30.0 / pi * own.peak_speed)
        motors.append((own.name, *(stated(value, 4) for value in shown), own.verdict))
    return (
        table(
            "Tensions along the motion.",
            "Span | At rest [N] | Without vibration [N] | With vibration [N] | Safety [] | Verdict",
            spans,
        ),
        table("Pulleys.", "Pulley | Wrap [deg] | Needed [] | Holds [] | Margin [] | Verdict", pulleys),
        table("Motors.", "Motor | Peak [N m] | Rms [N m] | Limit [N m] | Peak speed [rpm] | Verdict", motors),
    )


def _needed(own: PulleyMargin) -> tuple[str, str]:
    """What a pulley must transmit and what it holds."""
    if own.by == TEETH:
        allowed = "" if own.allowed is None else quantity(own.allowed, "N", 4)
        return quantity(own.effective_tension, "N", 4), f"{allowed} on {own.teeth_in_mesh} teeth"
    need = "slips" if own.needed_friction is None else f"friction {number(own.needed_friction, 3)}"
    return need, stated(own.capstan_friction, 3)
