"""Pairs of modes and margins of a motion: keys of their JSON, and tables for pages, studio and terminal."""

from collections.abc import Iterable
from math import degrees, pi
from typing import Any

from cabledrive.answers.figures import Row, number, quantity, stated
from cabledrive.answers.keys import Keys
from cabledrive.modal.tuning import Pair
from cabledrive.report.blocks import Table, listed
from cabledrive.report.machine.data import both
from cabledrive.report.words import speed_unit
from cabledrive.studies import motion_margins as margins
from cabledrive.studies.excitation_orders import Campbell
from cabledrive.studies.pair_thresholds import BOTH, TOO_FAR, NearPair
from cabledrive.studies.resonance_detuning import ResonanceSummary

NEAR = Keys(
    "kind longitudinal_hz family span section plane number=numbers.0 second_number? detuning_hz "
    "threshold_torque threshold_strain=threshold_amplitude transverse_hz=transverse_hz.0 "
    "second_transverse_hz?",
    {"threshold_torque": ".reason", "threshold_strain": TOO_FAR},
    of=NearPair,
)
TUNING = Keys(
    "transverse_frequency_hz=transverse_frequency frequency_ratio=ratio tuned_pretension",
    {"tuned_pretension": ".reason"},
    of=Pair,
)
PLANES = {"w": "in plane", "v": "out of plane", BOTH: "both"}
ENDS = Row("section", "Section", "m", lambda ends: f"{ends[0]:.4g} to {ends[1]:.4g}")
PLANE = Row("plane", "Plane", form=lambda plane: PLANES[plane], kind="text")


def several(values: Iterable[float]) -> str:
    """Numbers or frequencies [Hz] of the transverse modes of a pair: of 1:2 one, of the sum type two."""
    return " + ".join(dict.fromkeys(number(one, 6) for one in values))


PAIRS = (
    Row("kind", "Kind", kind="text"),
    Row("span", "Span", kind="text"),
    *(PLANE, ENDS, Row("numbers", "m", "", several)),
    Row("longitudinal_hz", "Longitudinal", "Hz", 6),
    Row("transverse_hz", "Transverse", "Hz", several),
    Row("detuning_hz", "Detuning", "Hz", 4),
    Row("threshold_torque", "Threshold torque", "N m", "", none="none"),
    Row("tuning.ratio", "Ratio", "", 4),
    Row("tuning.tuned_pretension", "Tuned at", "N", ""),
)


def pair_data(pair: NearPair) -> dict[str, Any]:
    """A pair as JSON has it; one of a loop's pulley mode with its ratio and tuned pretension."""
    return NEAR(pair) | (TUNING(pair.tuning) if pair.tuning is not None else {})


def pairs_table(found: ResonanceSummary, most: int) -> Table | None:
    """Pairs of modes that can excite one another, lowest threshold first; None where there are none."""
    pairs = found.pairs[:most]
    columns = [row for row in PAIRS if row.none or any(row.of(pair) is not None for pair in pairs)]
    left = len(found.pairs) - most
    note = f"{left} more with higher thresholds." if left > 0 else ""
    caption = "Longitudinal modes and the transverse modes that they can excite, lowest threshold first."
    return listed(caption, columns, pairs, note=note) if pairs else None


NO_STRENGTH, NO_LIMIT = "no strength [N] in the file", "no limit in the file"
SPAN = Keys(
    "name route tension_at_rest=rest tension_without_vibration=even lowest_at highest_at slack safety_factor "
    "verdict lowest_tension=tension.0 highest_tension=tension.1",
    {"safety_factor": NO_STRENGTH},
    of=margins.SpanMargin,
)
MOTOR = Keys(
    "pulley=name peak_torque rms_torque holding_torque torque_limit peak_speed speed_limit verdict",
    {"torque_limit": NO_LIMIT, "speed_limit": NO_LIMIT},
    of=margins.MotorMargin,
)
MARGINS = Keys(
    "verdict reasons assumptions overshoot poses step spans motors",
    {"overshoot": "no tension changes"},
    {"spans": SPAN, "motors": MOTOR},
    of=margins.MotionMargins,
)
HELD = {margins.FRICTION: "capstan_friction", margins.TEETH: "teeth_in_mesh allowed_tension=allowed"}
PULLEYS = {
    by: Keys(
        f"name route by wrap needed_friction effective_tension margin time verdict {held}",
        {
            "needed_friction": "a tension is gone",
            "margin": NO_LIMIT,
            "allowed_tension": NO_STRENGTH,
            "capstan_friction": "no capstan_friction in the file",
        },
        of=margins.PulleyMargin,
    )
    for by, held in HELD.items()
}
ALONG = Keys("text: torque_from rows: pulleys", parts={"pulleys": tuple(PULLEYS.values())}, also=(MARGINS,))
VERDICT = Row("verdict", "Verdict", kind="text")
SPANS = (
    Row("name", "Span", kind="text"),
    Row("rest", "At rest", "N", both),
    Row("even", "Without vibration", "N", both),
    Row("tension", "With vibration", "N", both),
    Row("safety_factor", "Safety", "", 3),
    VERDICT,
)
TURNED = (
    Row("name", "Pulley", kind="text"),
    Row("wrap", "Wrap", "deg", 4, degrees(1.0)),
    Row("needed", "Needed"),
    Row("holds", "Holds"),
    Row("margin", "Margin", "", 3),
    VERDICT,
)
MOTORS = (
    Row("name", "Motor", kind="text"),
    Row("peak_torque", "Peak", "N m", 4),
    Row("rms_torque", "Rms", "N m", 4),
    Row("torque_limit", "Limit", "N m", 4),
    Row("peak_speed", "Peak speed", "rpm", 4, 30.0 / pi),
    VERDICT,
)


def margins_data(found: margins.MotionMargins) -> dict[str, Any]:
    """The margins along a motion as JSON has them."""
    pulleys = [PULLEYS[own.by](own) for own in found.pulleys]
    for own, made in zip(found.pulleys, pulleys, strict=True):
        if own.effective_tension == 0.0 and own.margin is None:
            made["margin_reason"] = "nothing to transmit"
    return MARGINS(found) | {"torque_from": "places" if found.given else "file", "pulleys": pulleys}


def margins_tables(found: margins.MotionMargins) -> tuple[Table, Table, Table]:
    """Spans, pulleys and motors along a motion: what is needed and what holds."""
    turned = (
        {row.key: getattr(own, row.key, None) for row in TURNED} | _needed(own) for own in found.pulleys
    )
    return (
        listed("Tensions along the motion.", SPANS, found.spans),
        listed("Pulleys.", TURNED, turned),
        listed("Motors.", MOTORS, found.motors),
    )


def _needed(own: margins.PulleyMargin) -> dict[str, str]:
    """What a pulley must transmit and what it holds."""
    if own.by == margins.TEETH:
        allowed = "" if own.allowed is None else quantity(own.allowed, "N", 4)
        return {
            "needed": quantity(own.effective_tension, "N", 4),
            "holds": f"{allowed} on {own.teeth_in_mesh} teeth",
        }
    need = "slips" if own.needed_friction is None else f"friction {number(own.needed_friction, 3)}"
    return {"needed": need, "holds": stated(own.capstan_friction, 3)}


def zones_table(found: Campbell, most: int | None = None) -> Table:
    """Speeds at which an excitation comes near a mode, the heaviest first, and which are clear."""
    unit, place = speed_unit(found.coordinate), "m" if found.key.endswith((".x", ".y")) else ""
    columns = (
        Row("order", "Order", kind="text"),
        Row("mode", "Mode", kind="text"),
        Row("low", "From", unit, 4),
        Row("high", "To", unit, 4),
        Row("place_low", f"{found.key} from", place, 4),
        Row("place_high", "to", place, 4),
    )
    clear = ", ".join(f"{low:.4g} to {high:.4g} {unit}" for low, high in found.clear)
    caption = f"Speeds of {found.coordinate} at which an excitation comes near a mode, the heaviest first."
    left = 0 if most is None else max(len(found.zones) - most, 0)
    more = f"{left} more zones of less weight: --json lists all.\n" if left else ""
    return listed(caption, columns, found.zones[:most], f"{more}Clear of all modes: {clear or 'none'}")
