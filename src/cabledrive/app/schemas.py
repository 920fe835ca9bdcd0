"""JSON Schemas of what commands answer, from the keys that they declare."""

import dataclasses
import re
from collections.abc import Iterator, Mapping
from functools import reduce
from types import NoneType
from typing import Any, get_args, get_origin

from cabledrive.app.commands.modes import MODES
from cabledrive.app.map_answer import SWAY
from cabledrive.app.motion_answers import ROUTE
from cabledrive.app.resonance_answer import SUMMARY
from cabledrive.app.results import Keys
from cabledrive.app.shaper_answer import SHAPER

SIMPLE = {bool: "boolean", int: "integer", float: "number", str: "string", NoneType: "null"}
KINDS: dict[str, Any] = {
    "text": {"type": "string"},
    "note": {"type": ["string", "null"]},
    "flag": {"type": ["boolean", "null"]},
    "count": {"type": ["integer", "null"]},
    "number": {"type": ["number", "null"]},
    "numbers": {"type": "array", "items": {"type": ["number", "null"]}},
    "texts": {"type": "array", "items": {"type": "string"}},
    "rows": {"type": ["array", "null"], "items": {"type": "object"}},
    "object": {"type": ["object", "null"]},
}
"""Of a key that no result declares; a figure may be null, with its reason beside it. Keys stand behind their
kind, "number: torque speed? text: motor", with "?" where one may be left out."""
DECLARED = {"modes": MODES, "resonance": SUMMARY, "routes": ROUTE, "shaper": SHAPER, "sway": SWAY}
SHARED = {
    "run": "number: energy_budget_error step cfl wall_time count: steps note: stopped rows: slack_events",
    "tracked": "text: controller plant observer count: seed texts: broken_assumptions object: gains motion "
    "over_draws? number: rms_error_deg peak_error_deg theory_bound_deg peak_torque saturated_fraction "
    "sample_rate internal_step flag: within_bound estimates_within_bounds",
}
ANSWERS = """
camera       text: log count: rows frames object: channels number: frame_rate_hz scale texts: findings
check        flag: valid text: drive_hash texts: warnings object: derived motion? rows: spans? pulleys?
compare      text: drive drive_hash note: best count: draws seed number: goal_deg rows: controllers texts:
             not_covered object: motion disturbances limits
drives       rows: drives
drives       text: name title source file
experiment   text: motor motor_reason? text: log count: rows object: channels number: sample_rate_hz
experiment   text: motor motor_reason? object: relative_standard_error peaks number: moving
             amplitude_factor texts: warnings
export       text: format texts: files notes number: sample_time note: drive_hash
identify     flag: identifiable checked? texts: unidentifiable notes? rows: findings data text: model?
             check_reason? number: condition_number? object: parameters residual? method? spans?
             comparison? against?
identify     flag: separated object: bearings wraps_per_tension rows: total count: strokes texts: findings
map          texts: keys outputs text: motor first_reason? numbers: shape rows: ranges zones? orders?
             clear? count: certified_points points_without_modes number: covered_hz? flag:
             covered_certified? object: speed?
modes        @modes number: lowest_frequency_free_hz lowest_frequency_held_hz lowest_frequency_holding_hz?
report       text: report store? rows: drives?
resonance    @resonance text: motor rows: pairs remedies branches? texts: warnings number: load_torque?
             object: instability_region? sensitivity? tuned_pretension_under_load? motion?
resonance    @routes number: tuned_pretension rows: pairs object: motion?
response     numbers: frequency_hz magnitude phase_deg coherence? deviation? number: averages? count:
             records_left_out? rows: left_out text: input? output? motor? texts: warnings? object:
             amplifier?
sensitivity  text: output count: groups rows refused failed groups_left_out object: first? total? effects?
             number: confidence mean? standard_deviation?
shaper       @shaper rows: peaks findings texts: logs note: recommended configuration object:
             recommended_shaper
shaper       rows: axes object: belts
simulate     @run object: load_angle drive_angle upper_midpoint? lower_midpoint? error_estimate number:
             least_tension flag: compiled note: interpreted
simulate     @run object: coordinates rows: spans wraps number: largest_motion texts: assumptions warnings
study        text: verdict headline drive drive_hash study asked code sha256 texts: reasons remedies cautions
             number: reached_error_deg? reached_error_mm? share? confidence? rows: candidates findings?
             margins object: goals? stages? files axis?
sway         @sway texts: warnings assumptions
sweep        count: rows done refused failed number: seconds setup_seconds text: engine store
tolerance    rows: goals number: target yield yield_low yield_high count: rows held refused failed object:
             keys missed
track        @tracked text: motor motor_reason? friction slack_rule note: interpreted number: backlash
             first_pulse_error_deg later_pulses_error_deg encoder_error_deg slack_share delay bound_used
             printed_norm_bound_deg? rest_swing_deg? rest_swing_counts? numbers: encoder_phases flag:
             inside_tube? limit_cycle? count: slack_samples free_play_samples invalid_samples texts:
             feedback encoders departures rows: closed_loop_poles object: circumstances pair? axis?
             repeated? learnt? cable? robust_conditions? d_z?
track        @tracked number: peak_error_mm rms_error_mm least_tension least_allowed reshaped_fraction gust
             least_damping position_bound_used flag: tension_kept position_within_bound texts:
             position_broken_assumptions assumptions reasons rows: lines motors object: error_mm
             position_bound_mm
"""
"""The objects that each command answers, with "@" before keys that a result declares or objects share."""
BY_COMMAND: dict[str, list[str]] = {}
for _name, _words in re.findall(r"^(\w+) +(.*(?:\n .*)*)", ANSWERS, re.M):
    BY_COMMAND.setdefault(_name, []).append(_words)


def answer_schema(command: str) -> dict[str, Any]:
    """The schema of what a command prints with ``--json``."""
    origin = "object: provenance text: incomplete?"
    return {"anyOf": [schema_of(f"{own} {origin}") for own in BY_COMMAND[command]]}


def schema_of(keys: Keys | str) -> dict[str, Any]:
    """The schema of an object that has some keys; of a figure KEY its reason is KEY_reason."""
    made = list(_declared(keys) if isinstance(keys, Keys) else _said(keys))
    return {
        "type": "object",
        "properties": {key: kind for key, kind, _ in made},
        "required": [key for key, _, optional in made if not optional],
        "patternProperties": {"_reason$": KINDS["note"]},
        "additionalProperties": False,
    }


def _said(words: str) -> Iterator[tuple[str, Any, bool]]:
    """Key, kind, whether it may be left out."""
    kind = ""
    for word in words.split():
        if word[1:] in SHARED:
            yield from _said(SHARED[word[1:]])
        elif word.startswith("@"):
            yield from _declared(DECLARED[word[1:]])
        elif word.endswith(":"):
            kind = word[:-1]
        else:
            yield word.rstrip("?"), KINDS[kind], word.endswith("?")


def _declared(keys: Keys) -> Iterator[tuple[str, Any, bool]]:
    for key, name, optional, _ in keys.each():
        hint = reduce(_hint, name.split("."), keys.of)
        part = keys.parts.get(key)
        if part is None:
            yield key, _kind(hint), optional
        else:
            many = get_origin(hint) in (tuple, list)
            yield key, {"type": "array", "items": schema_of(part)} if many else schema_of(part), optional


def _hint(of: Any, name: str) -> Any:
    """Type of an attribute, or of an item by its number."""
    if name.isdigit():
        return get_args(of)[0] if get_origin(of) is tuple else list
    own = getattr(of, name, None)
    if made := getattr(own, "fget", None) or getattr(own, "func", None):
        return made.__annotations__["return"]
    annotated = (getattr(one, "__annotations__", {}) for one in of.__mro__)
    return next((names[name] for names in annotated if name in names), Any)


def _kind(hint: Any) -> dict[str, Any]:
    """The schema of a type; every number may be null, which says that it is not finite."""
    origin, inside = get_origin(hint), get_args(hint)
    if hint is Any:
        return {}
    if hint in SIMPLE:
        return KINDS["number"] if hint is float else {"type": SIMPLE[hint]}
    if NoneType in inside:
        return {"anyOf": [_kind(one) for one in inside]}
    if dataclasses.is_dataclass(hint):
        return {"type": "object", "properties": {f.name: _kind(f.type) for f in dataclasses.fields(hint)}}
    if isinstance(origin, type) and issubclass(origin, Mapping):
        return {"type": "object", "additionalProperties": _kind(inside[1])}
    return {"type": "array"} | ({"items": _kind(inside[0])} if origin in (tuple, list) else {})
