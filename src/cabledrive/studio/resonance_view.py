"""The internal resonance: verdict, pairs, the map with the machine's own point and a motion's path."""

import threading
from collections.abc import Sequence
from functools import lru_cache
from typing import Any

from starlette.requests import Request
from starlette.responses import HTMLResponse, JSONResponse, Response

from cabledrive.parameters import Drive, InputRefused, NotComputed
from cabledrive.parameters.route.drive import RoutedDrive, require_two_pulleys
from cabledrive.parameters.units import to_si
from cabledrive.report.numbers import number, quantity
from cabledrive.report.resonance_map_page import resonance_map_page
from cabledrive.studies.motion_file import read_motion
from cabledrive.studies.pair_thresholds import CoupledPair
from cabledrive.studies.resonance import resonance
from cabledrive.studies.resonance_map import GrowthMap, growth_map
from cabledrive.studies.route_pairs import RoutePair, route_resonance
from cabledrive.studio import pages
from cabledrive.studio.asked import map_option
from cabledrive.studio.desk import Desk
from cabledrive.studio.state import command_line, drive_of, state_of
from cabledrive.studio.work_view import FRAMED

KEPT = 4
NONE_HERE = "This machine has no internal resonance to show"
NO_MAP = (
    "The map is that of a cable round two pulleys; on this machine the verdict rests on its pairs of modes."
)
TELLS_HEIGHT = """<script>
new ResizeObserver(() => parent.postMessage(document.body.scrollHeight, "*")).observe(document.body);
</script>"""
"""The frame of the map is as high as what it shows."""
_ONE_AT_A_TIME = threading.Lock()


def resonance_page(request: Request) -> Response:
    """Verdict and pairs; the map is a page of its own inside."""
    desk: Desk = request.app.state.desk
    state = state_of(request.url.query, desk.first)
    torque = request.query_params.get("torque", "")[:40]
    words: dict[str, Any] = {"refusal": "", "why_none": "", "facts": [], "pairs": [], "verdict": ""}
    try:
        drive, amplitude = drive_of(desk.library, state), to_si(torque, "N m") if torque else None
    except (InputRefused, NotComputed) as refusal:
        words["refusal"] = str(refusal)
    else:
        try:
            words |= (
                _of_routes(drive, amplitude) if isinstance(drive, RoutedDrive) else _facts(drive, amplitude)
            )
        except (InputRefused, NotComputed) as refusal:
            words["why_none"] = f"{NONE_HERE}: {refusal}."
    options = [f"--torque={torque}"] if torque else []
    options += map_option(desk, state)
    return pages.page(
        request,
        "resonance.html",
        view="resonance",
        state=state,
        torque=torque,
        motion=request.query_params.get("motion", ""),
        logs=[log for log in desk.logs.listed() if log[1].endswith((".csv", ".tsv"))],
        command=command_line(desk.library, state, "resonance", *options),
        **words,
    )


def resonance_map(request: Request) -> Response:
    """The map, as the command `resonance --map` draws it; with a motion, its path."""
    desk: Desk = request.app.state.desk
    try:
        drive = _two_pulleys(desk, request)
        torque = request.query_params.get("torque", "")[:40]
        found = resonance(drive, torque=to_si(torque, "N m") if torque else None)
        chosen = request.query_params.get("motion")
        motion = read_motion(desk.logs.path(chosen)) if chosen else None
        with _ONE_AT_A_TIME:
            html = resonance_map_page(_map(drive, found.torque), motion=motion)
    except (InputRefused, NotComputed) as refusal:
        return JSONResponse({"refusal": str(refusal)}, 422)
    return HTMLResponse(html + TELLS_HEIGHT, headers={"content-security-policy": FRAMED})


@lru_cache(maxsize=KEPT)
def _map(drive: Drive, torque: float) -> GrowthMap:
    return growth_map(drive, torque=torque)


def _two_pulleys(desk: Desk, request: Request) -> Drive:
    drive = drive_of(desk.library, state_of(request.url.query, desk.first))
    require_two_pulleys(drive, "`resonance`")
    assert isinstance(drive, Drive)
    return drive


def _of_routes(drive: RoutedDrive, torque: float | None) -> dict[str, Any]:
    """The same of a machine with routes, whose tensions follow from statics: there is no map."""
    found = route_resonance(drive, torque=torque)
    facts = [
        ("Longitudinal mode", quantity(found.longitudinal_hz, "Hz")),
        (
            f"Frequency ratio, first transverse of {found.nearest_span} over it",
            number(found.frequency_ratio, 5),
        ),
    ]
    if found.threshold_torque is not None:
        facts.append(("Threshold torque", quantity(found.threshold_torque, "N m")))
    return {"verdict": found.verdict, "reasons": found.reasons, "facts": facts, "why_none": NO_MAP} | {
        "pairs": _pairs(found.pairs)
    }


def _pairs(pairs: Sequence[CoupledPair | RoutePair]) -> list[tuple[str, ...]]:
    return [
        (
            pair.kind,
            pair.span,
            number(pair.longitudinal_hz, 6),
            " + ".join(dict.fromkeys(number(value, 6) for value in pair.transverse_hz)),
            "none" if pair.threshold_torque is None else quantity(pair.threshold_torque, "N m", 4),
        )
        for pair in pairs[:12]
    ]


def _facts(drive: Drive, torque: float | None) -> dict[str, Any]:
    found = resonance(drive, torque=torque)
    rows = (
        ("Frequency ratio, first transverse over pulley mode", found.frequency_ratio, "1"),
        ("Pulley mode", found.pulley_frequency, "Hz"),
        ("Tuned pretension", found.tuned_pretension, "N"),
        ("Threshold torque at that tuning", found.threshold_torque, "N m"),
        ("Threshold torque at the own pretension", found.threshold_here, "N m"),
        ("Torque of the verdict", found.torque, "N m"),
    )
    return {
        "verdict": found.verdict,
        "reasons": found.reasons,
        "facts": [(words, quantity(value, unit)) for words, value, unit in rows if value is not None],
        "pairs": _pairs(found.coupled),
    }
