"""What `identify` says: rows of parameters, findings, tensions from pings, friction at wraps and bearings."""

from collections.abc import Mapping, Sequence
from typing import Any

from cabledrive.answers.keys import Keys
from cabledrive.answers.runs import PARAMETERS
from cabledrive.app.results import Answer, provenance
from cabledrive.identification.axis.check import AGAINST
from cabledrive.identification.estimates import ESTIMATE, IDENTIFIED, Estimate
from cabledrive.identification.logs.log import ColumnMap
from cabledrive.identification.logs.reading import read_log
from cabledrive.identification.rope_friction import FrictionSplit, split_friction
from cabledrive.identification.tension.both import tension_of_both
from cabledrive.identification.tension.family_fit import PINGED
from cabledrive.identification.tension.recording import read_ping
from cabledrive.identification.tension.strings import compared, tensions_of_spans
from cabledrive.parameters import InputRefused, Machine, load_drive
from cabledrive.report.blocks import listed, table_text

INTERVAL = Keys("unit value low high", dict.fromkeys(("value", "low", "high"), ".reason"), of=Estimate)
ANSWER = Keys("object: against?", parts={"against": AGAINST}, also=(IDENTIFIED,))
OF_A_PING = Keys(
    "object: comparison{texts: spans object: difference{number: value low high standard_error text: unit "
    "reason?} number: relative flag: differ}?",
    also=(PINGED,),
)
SPLIT = Keys(
    "flag: separated object: bearings wraps_per_tension rows: total count: strokes texts: findings",
    parts=dict.fromkeys(("bearings", "wraps_per_tension"), INTERVAL)
    | {"total": Keys("number: tension", also=(INTERVAL,))},
)
CURVE = Keys("numbers: frequency_hz magnitude phase_deg rows: left_out{number: start end text: reason}")
MEASURED = Keys(
    "numbers: coherence deviation number: averages count: records_left_out text: input? output? texts: "
    "warnings? object: amplifier{object: gain bandwidth delay number: gain_db misfit}?",
    parts=dict.fromkeys(("gain", "bandwidth", "delay"), ESTIMATE),
    also=(CURVE,),
)
COMPUTED = Keys("text: input output motor texts: warnings", also=(CURVE,))


def pinged(
    logs: tuple[str, ...], name: str, spans: tuple[str, ...], plucked: str | None, section: int, columns: Any
) -> Answer:
    """Tension of each span from its recording; the first two are compared. ``name``: the machine."""
    drive = load_drive(name)
    if spans == (BOTH,):
        if len(logs) != 1:
            raise InputRefused(f"--ping: {len(logs)} logs given, both spans sound in one recording: name one")
        one = tension_of_both(read_ping(logs[0], columns), drive, plucked=plucked, section=section)
        missing = None if one.identifiable else one.unidentifiable[0]
        return _tensions(drive, one.as_dict(), TWO_FAMILIES, (), missing)
    if plucked is not None:
        raise InputRefused("--plucked belongs to --span both: give that, or name each span with --span")
    found = tensions_of_spans([read_ping(log, columns) for log in logs], drive, spans, section)
    parts = [one.as_dict() for one in found]
    data = parts[0] | {
        "parameters": {name: own for part in parts for name, own in part["parameters"].items()},
        "spans": {name: own for part in parts for name, own in part["spans"].items()},
        "findings": [finding for part in parts for finding in part["findings"]],
        "data": [report for part in parts for report in part["data"]],
        "residual": max((part["residual"] for part in parts), key=lambda own: own["relative"]),
    }
    both = list({name: own for one in found for name, own in one.spans.items()}.items())
    lines = [
        f"string formula, {one.span}: {one.bare:.6g} N, off by {100 * one.bias:+.2g} %" for _, one in both
    ]
    if len(found) > 1:
        apart, relative = compared(dict(both[:2]))
        data["comparison"] = {
            "spans": [name for name, _ in both[:2]],
            "difference": apart.as_dict(),
            "relative": relative,
            "differ": not apart.low <= 0.0 <= apart.high,
        }
        lines.append(
            f"{both[0][0]} against {both[1][0]}: {apart.value:+.4g} N "
            f"({apart.low:+.4g} to {apart.high:+.4g} N), {100 * relative:+.3g} %"
        )
    return _tensions(drive, data, VANISHING, lines)


BOTH = "both"
VANISHING = "tones at vanishing amplitude against certified modes"
TWO_FAMILIES = "two families of decaying tones against certified modes"


def _tensions(
    drive: Machine,
    data: dict[str, Any],
    method: str,
    more: Sequence[str],
    missing: str | None = None,
) -> Answer:
    """Tensions, what errors of the file's length and mass per length add to their intervals, findings."""
    lines = []
    for name, one in data["spans"].items():
        length, mass = one["of_length_and_mass"].values()
        lines.append(
            f"not in the interval of {name}: 1 % of the length moves it by {length:.2g} N, 1 % of the mass "
            f"per length by {mass:.2g} N"
        )
    text = "\n".join([parameter_rows(data["parameters"]), *lines, *more, *finding_lines(data)])
    return Answer(data=data, text=text, provenance=provenance(drive, method=method), incomplete=missing)


def parameter_rows(parameters: Mapping[str, Mapping[str, Any]]) -> str:
    """The parameters, aligned."""
    rows = ({"name": name} | dict(one) for name, one in parameters.items())
    return table_text(listed("", PARAMETERS, rows))


def finding_lines(data: dict[str, Any]) -> list[str]:
    """What was found, about the model and about the data."""
    messages = [one["message"] if isinstance(one, dict) else one for one in data["findings"]]
    found = [f"finding: {message}" for message in (*messages, *data.get("unidentifiable", ()))]
    for report in data["data"]:
        found += [f"data: {line}" for line in (*report["repaired"], *report["findings"])]
    return found


METHOD_OF_SPLIT = "least squares on strokes between reversals, errors of strokes and of the elastic cable"


def split_answer(logs: Sequence[str], tensions: Sequence[float], columns: ColumnMap) -> Answer:
    """Both frictions from logs at their tensions [N]; not complete where they are not separated."""
    found = split_friction([read_log(log, columns) for log in logs], tensions)
    data = {
        "separated": not found.reason,
        "bearings": INTERVAL(found.constant),
        "wraps_per_tension": INTERVAL(found.per_tension),
        "total": [
            {"tension": tension, **INTERVAL(own)}
            for tension, own in zip(sorted(set(found.tensions)), found.total, strict=True)
        ],
        "strokes": found.strokes,
        "findings": list(found.findings),
    }
    missing = found.findings[0] if found.reason else None
    about = provenance(method=METHOD_OF_SPLIT)
    return Answer(data=data, text=_split_text(found), provenance=about, incomplete=missing)


def _split_text(found: FrictionSplit) -> str:
    levels = zip(sorted(set(found.tensions)), found.total, strict=True)
    rows = {f"all friction at {tension:.4g} N": own for tension, own in levels}
    if not found.reason:
        rows |= {
            "motor and bearings, at the motor": found.constant,
            "wraps, over the tension": found.per_tension,
        }
    shown = parameter_rows({name: INTERVAL(own) for name, own in rows.items()})
    return "\n".join([shown, f"{found.strokes} strokes", *(f"finding: {line}" for line in found.findings)])


def against_lines(found: Mapping[str, Any]) -> list[str]:
    """An identified axis on another log, for people."""
    lines = ["", f"against {found['source']}:"]
    titles = (
        ("open loop", "open_loop", "of the speed"),
        ("followed", "closed_loop", "of the torque is added"),
    )
    for title, key, more in titles:
        part = found[key]
        words = (
            part.get("reason")
            or f"{100 * part['relative']:.2g} % {more}; error {part['error']:.3g} {part['unit']}"
        )
        lines.append(f"  {title:<10} {words}")
    for name, one in found["cross_test"].items():
        state = "agrees" if one["agrees"] else "intervals apart"
        words = f"{one['value']:.4g}, by itself {one['other']:.4g} {one['unit']}"
        lines.append(f"  {name.replace('_', ' '):<20} {words}: {state}")
    return lines
