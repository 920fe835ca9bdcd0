"""What a study leaves: its page, results, the drive as it is known, the law as numbers."""

import hashlib
import json
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from cabledrive.answers.keys import Keys
from cabledrive.answers.runs import CHAIN
from cabledrive.mechanics import DerivedQuantities, drive_warnings
from cabledrive.mechanics.network.span_table import PULLEY_ROW, SPAN_ROW
from cabledrive.modal import modes
from cabledrive.parameters import InputRefused, Machine, NotComputed, content_hash
from cabledrive.parameters.drive_file import drive_text
from cabledrive.parameters.files import with_own_hash, write_whole
from cabledrive.parameters.version import __version__
from cabledrive.reduction.network_axis import axis_words
from cabledrive.report.machine.data import data_sheet
from cabledrive.report.page import page_of
from cabledrive.report.study.controller import acceptance_chapter, controller_chapter
from cabledrive.report.study.mechanics import modes_chapter, resonance_chapter
from cabledrive.report.study.verdict import data_chapter, knowledge_chapter, verdict_chapter
from cabledrive.rig.laws.controller_file import controller_numbers as law_and_filter
from cabledrive.rig.laws.controller_file import plain_numbers
from cabledrive.rig.tuning import LawSetting
from cabledrive.studies.resonance import resonance
from cabledrive.studies.study import stage_cache
from cabledrive.studies.study.acceptance_stage import AcceptanceResult, ReachedError
from cabledrive.studies.study.bandwidth_cost import CarriageController
from cabledrive.studies.study.carriage import CarriageCase
from cabledrive.studies.study.goals import Goals, error_unit, goal_of
from cabledrive.studies.study.log_replay import LogFinding
from cabledrive.studies.study.pipeline import StudyResult
from cabledrive.studies.study.plants import load_case
from cabledrive.studies.study.sampled_plants import LoadLoop
from cabledrive.studies.study.verdict_stage import Margin

COUNT = 6
REMEDY = "name another axis (--axis), or give a machine whose load is the end of a chain"


def study_without_chain(drive: Machine, why: str, logs: int) -> dict[str, Any]:
    """Plain data of a study's results, SI; ``why``: no controller; ``logs``: how many were given."""
    found, sheet = modes(drive, count=COUNT), data_sheet(drive)
    pairs: dict[str, Any] | None = None
    try:
        near = resonance(drive)
    except (InputRefused, NotComputed) as refusal:
        reason = f"internal resonance not computed: {refusal}"
    else:
        names = ("verdict", "threshold_torque", "frequency_ratio", "nearest_span")
        pairs = {name: getattr(near, name) for name in names} | {"longitudinal_hz": near.pulley_frequency}
        reason = f"internal resonance: {near.verdict}; {near.reasons[0]}"
    cautions = [*drive_warnings(drive), *found.warnings]
    if logs:
        cautions.append(f"{logs} logs were not used: without a chain there is nothing to identify")
    return WITHOUT_CHAIN(
        {
            "verdict": "unknown",
            "headline": f"no controller: {why}",
            "candidates": [],
            "reasons": [f"no controller: {why}", reason],
            "findings": [
                {
                    "id": "no-chain",
                    "value": None,
                    "value_reason": why,
                    "limit": None,
                    "unit": "",
                    "decides": True,
                }
            ],
            "remedies": [REMEDY],
            "cautions": cautions,
            "margins": {
                "lowest_tension": sheet.derived["lowest_tension"],
                "safety_factor": min(
                    (own["safety_factor"] for own in sheet.spans if own["safety_factor"] is not None),
                    default=None,
                ),
                "spans": sheet.spans,
                "pulleys": sheet.pulleys,
            },
            "drive": drive.name,
            "drive_hash": content_hash(drive),
            "stages": {
                "modes": {
                    "longitudinal_hz": [mode.frequency for mode in found.longitudinal],
                    "transverse_hz": [mode.frequency for mode in found.transverse],
                    "certified": found.certified,
                    "certified_reason": found.certified_reason,
                },
                "resonance": pairs,
            },
            "provenance": {
                "cabledrive": __version__,
                "drive": drive.name,
                "drive_hash": content_hash(drive),
                "method": "certified modes, pairs near internal resonance, tensions at rest",
            },
        }
    )


RESULTS, REPORT, DRIVE, CONTROLLER = "results.json", "report.html", "drive.toml", "controller.json"
ACCEPTED = ("draws", "peaks", "failed", "saturated", "largest_torque", "worst")
LOAD_KEYS, CARRIAGE_KEYS = ("plant", "inside", "reason"), ("rests", "smallest_tension")
"""Keys of an acceptance, and those that only loads, and only carriages, have."""
METHOD = "study in stages, each kept by the hash of its inputs"
FINDING = "text: id unit number: value limit flag: decides"
FOUND_IN_LOG = Keys("id value limit unit decides message=words", of=LogFinding)
FOUND = Keys(
    "text: verdict headline drive drive_hash asked code sha256 texts: reasons remedies cautions map: "
    "files=text rows: candidates{text: controller setting plant reason count: runs ended_early "
    "number: share share_low worst_deg? worst_mm? reached_deg? reached_mm? flag: holds}",
    dict.fromkeys(("share", "share_low", "holds"), "no error goal given, or no run")
    | dict.fromkeys(("worst_deg", "worst_mm", "reached_deg", "reached_mm"), "too many runs ended early"),
)
LEFT_OUT = ("columns", "spreads")
"""Goals that a study does not answer."""
_ASKED = tuple(field.name for field in fields(Goals) if field.name not in LEFT_OUT)
_RUNS = (
    "count: draws failed saturated numbers: peaks number: largest_torque reached median_error "
    "quantile_95_error quantile_99_error largest_error object: worst{count: draw map: values numbers: phases "
    "time error torque reference? course?}"
)
_LOADS = f"{{{_RUNS} text: plant reason number: inside}}?"
NO_GOAL, LASTED = "no error goal given, or no run", "no run lasted"
STAGES = Keys(
    "object: laws{object: chosen rows: cable{text: controller setting plant reason count: runs failed "
    "number: share share_low worst object: reached flag: holds}} "
    f"acceptance{{object: lumped{_LOADS} cable{_LOADS} "
    f"carriage{{{_RUNS} numbers: rests number: smallest_tension quantile_99_error_at_rest}}?}}",
    {
        "laws": "no law was run, or that of a carriage",
        "carriage": "no plant with a carriage was run",
        "chosen": "none holds",
        "inside": "no bound is stated",
        "reached": f"{NO_GOAL} that lasted",
    }
    | dict.fromkeys(("share", "share_low", "holds"), NO_GOAL)
    | {f"{name}_error": LASTED for name in ("median", "quantile_95", "quantile_99", "largest")}
    | {"worst": LASTED, "quantile_99_error_at_rest": LASTED, "largest_torque": LASTED},
    {"chosen": LawSetting, "reached": ReachedError},
    (Keys("check identification=knowledge modes resonance demand model controller", of=StudyResult),),
)
STUDY = Keys(
    f"text: study number: reached_error_deg? reached_error_mm? share confidence rows: margins "
    f"findings{{{FINDING} text: message}} object: goals stages axis?",
    {"share": "no error goal given, or no run"}
    | dict.fromkeys(("value", "limit"), "the finding is in words"),
    {
        "margins": Margin,
        "goals": Keys(" ".join(_ASKED), dict.fromkeys(_ASKED, "not asked for"), of=Goals),
        "stages": STAGES,
        "axis": CHAIN,
    },
    (FOUND,),
)
WITHOUT_CHAIN = Keys(
    f"rows: findings{{{FINDING}}} object: margins{{number: lowest_tension safety_factor rows: spans pulleys}}"
    " stages{object: modes{numbers: longitudinal_hz transverse_hz flag: certified note: certified_reason} "
    "resonance{text: verdict nearest_span number: threshold_torque longitudinal_hz frequency_ratio}}",
    {
        "limit": "there is none",
        "safety_factor": "no strength [N] in the file",
        "resonance": "not computed, see reasons",
        "threshold_torque": "no pair is near resonance",
    },
    {"spans": SPAN_ROW, "pulleys": PULLEY_ROW},
    (FOUND,),
)


REFUSED = dict.fromkeys(("torque", "theorem", "unmatched", "sensors", "bound"), "refused before it was found")
WHYS = REFUSED | {"residual": "no log was given", "model": "the law needs no model of the chain"}
WHYS |= {own.name: own.metadata["why"] for own in fields(DerivedQuantities) if own.metadata["why"]}
"""Why a figure inside a stage may be absent."""


def _reasoned(stage: Any) -> Any:
    """A stage in plain data with the reason beside each figure that is not there."""
    if not isinstance(stage, dict):
        return [_reasoned(one) for one in stage] if isinstance(stage, list) else stage
    lost = {f"{key}_reason": WHYS[key] for key, value in stage.items() if value is None and key in WHYS}
    kept = {key: value for key, value in stage.items() if value is not None or not key.endswith("_reason")}
    return {key: _reasoned(value) for key, value in kept.items()} | lost


def results_of(result: StudyResult) -> dict[str, Any]:
    """The content of ``results.json``, plain data, SI."""
    verdict, laws = result.verdict, result.laws
    stages = {
        "check": result.check,
        "identification": result.knowledge,
        "modes": result.modes,
        "resonance": result.resonance,
        "demand": result.demand,
        "model": result.model,
        "controller": result.controller,
        "laws": None,
    }
    if laws.scores and not result.carried:
        stages["laws"] = {"chosen": laws.chosen, "cable": [_scored(one) for one in laws.cable_scores]}
    accepted: dict[str, Any] = {"carriage": None}
    if not result.carried:
        kinds = {"lumped": result.runs, "cable": result.cable}
        accepted = {kind: _shown(runs, LOAD_KEYS) for kind, runs in kinds.items()}
    elif result.runs.draws:
        shown = _shown(result.runs, CARRIAGE_KEYS)
        shown["quantile_99_error_at_rest"] = result.runs.quantile(0.99, rest=True)
        if shown["worst"]:
            shown["worst"]["course"] = shown["worst"].pop("reference")
        accepted = {"carriage": shown}
    goals, unit, reached = stage_cache.as_plain(result.goals), error_unit(result.goals), verdict.reached
    key, size = f"reached_error_{unit.name}", reached.error if reached else None
    error: dict[str, Any] = {key: None if size is None else unit.of(size)}
    candidates = [
        {
            f"worst_{unit.name}": one["worst"] and unit.of(one["worst"]),
            f"reached_{unit.name}": one["reached"] and one["reached"].error and unit.of(one["reached"].error),
            **{name: one[name] for name in ("controller", "setting", "share", "share_low", "plant", "runs")},
            "ended_early": one["failed"],
            "holds": one["holds"],
            "reason": one["reason"] or ("" if goal_of(result.goals) is not None else "no error goal given"),
        }
        for one in map(_scored, laws.scores)
    ]
    error |= {name: getattr(reached, name, None) for name in ("share", "confidence")}
    if size is None:
        why = "too many runs ended early" if reached else "no law was run on drawn plants"
        error |= {f"{name}_reason": why for name in tuple(error) if error[name] is None}
    return STUDY(
        {
            "verdict": verdict.answer,
            "headline": verdict.reasons[0],
            **error,
            "candidates": candidates,
            "reasons": list(verdict.reasons),
            "findings": [FOUND_IN_LOG(one) for one in result.knowledge.findings],
            "remedies": list(verdict.remedies),
            "cautions": list(verdict.cautions),
            "margins": stage_cache.as_plain(verdict.margins),
            "drive": result.drive.name,
            "drive_hash": content_hash(result.drive),
            **axis_words(result.drive),
            "goals": {name: value for name, value in goals.items() if name not in LEFT_OUT},
            "stages": {name: _reasoned(stage_cache.as_plain(stage)) for name, stage in stages.items()}
            | {"acceptance": accepted},
            "study": result.key,
            "provenance": {
                "cabledrive": __version__,
                "drive": result.drive.name,
                "drive_hash": content_hash(result.drive),
                "logs": {log.name: log.sha256 for log in result.check.logs},
                "source_hash": stage_cache.sources_hash(),
                "method": METHOD,
                "seed": result.goals.seed,
            },
        }
    )


def _scored(found: AcceptanceResult) -> dict[str, Any]:
    """A law and what its runs say of it."""
    about = {"controller": found.law.controller, "setting": found.law.words, "runs": found.draws}
    names = ("plant", "failed", "reached", "share", "share_low", "holds", "reason")
    same = {name: getattr(found, name) for name in names}
    return about | same | {"worst": found.peaks[-1] if found.peaks else None}


def _shown(found: AcceptanceResult, more: tuple[str, ...]) -> dict[str, Any]:
    data = {name: stage_cache.as_plain(getattr(found, name)) for name in (*ACCEPTED, *more)}
    data["reached"] = found.share
    shares = {"median": 0.5, "quantile_95": 0.95, "quantile_99": 0.99, "largest": 1.0}
    return data | {f"{name}_error": found.quantile(share) for name, share in shares.items()}


def controller_numbers(result: StudyResult) -> dict[str, Any] | None:
    """The law and its filter as numbers that another program can run; none where no controller was found."""
    goals, control = result.goals, result.controller
    # Whoever exports the law sees what the study says of it.
    said: dict[str, Any] = {"verdict": result.verdict.answer, "reason": result.verdict.reasons[0]}
    chosen = result.laws.chosen
    if chosen is None:
        return None
    if isinstance(control, CarriageController):  # tables over the carriage's place; forces at the rim
        assert control.bandwidth is not None
        machine = CarriageCase(result.known, result.goals)
        limit = machine.limit * machine.design.radius
        return {
            "about": "See cabledrive.control.transporter.ScheduledLaw and scheduled_kernels beside it",
            "name": control.name,
            "bandwidth_hz": control.bandwidth,
            "radius": machine.design.radius,
            "interval": machine.interval,
            "count": machine.count,
            "encoders": ["drive", "load"] if control.both else ["drive"],
            "torque_limit": limit if np.isfinite(limit) else None,
            "law": plain_numbers(machine.loop(control.bandwidth).law._asdict()),
            "stated_bound": None,
            "study": said,
        }
    case = load_case(result.known, goals, result.knowledge)
    numbers = law_and_filter(LoadLoop(case, chosen, cable=False).loop, result.known, case.spec.feedback)
    if result.exported is not None:
        said["as_written"] = stage_cache.as_plain(result.exported)
    return numbers | {
        "logs": {log.name: log.sha256 for log in result.check.logs},
        "setting": chosen.words,
        "order": goals.motion.rise_order,
        "study": said,
        "stated_bound": control.bound if chosen.model is not None and control is not None else None,
    }


def write_files(result: StudyResult, folder: Path, report: str, *, asked: str, code: str) -> dict[str, Any]:
    """Write everything a study leaves, the results last; returns the content of ``results.json``."""
    controller = controller_numbers(result)
    # A machine with routes as its file gives it, which a chain does not change.
    written: dict[str, str] = {REPORT: report, DRIVE: drive_text(result.known.axis.machine)}
    if controller is not None:
        written[CONTROLLER] = json.dumps(controller, indent=1, allow_nan=False) + "\n"
    return finish(folder, written, results_of(result), asked=asked, code=code)


def finish(
    folder: Path, written: dict[str, str], results: dict[str, Any], *, asked: str, code: str
) -> dict[str, Any]:
    """Write a study's files, results last; an old controller goes where there is none."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in written.items():
        write_whole(folder / name, text, force=True)
    if CONTROLLER not in written:
        (folder / CONTROLLER).unlink(missing_ok=True)
    hashes = {name: hashlib.sha256(text.encode()).hexdigest() for name, text in written.items()}
    data = results | {"asked": asked, "code": code, "files": hashes}
    data = with_own_hash(json.loads(json.dumps(data, allow_nan=False)))
    write_whole(folder / RESULTS, json.dumps(data, indent=1, allow_nan=False) + "\n", force=True)
    return data


def study_html(result: StudyResult) -> str:
    """The report of a study as HTML that needs no other file; the time it states is now unless given."""
    first = (verdict_chapter, data_chapter, knowledge_chapter, modes_chapter, resonance_chapter)
    made = (chapter(result) for chapter in (*first, controller_chapter, acceptance_chapter))
    chapters = [chapter for chapter in made if chapter is not None]
    hashes = (
        (result.drive.name, content_hash(result.drive)),
        ("the same, as identified", content_hash(result.known)),
        *((log.name, log.sha256) for log in result.check.logs),
        ("all inputs of the study", result.key),
    )
    title = f"{result.drive.name}: {result.verdict.answer}"
    subtitle = result.drive.title or "A study from data sheet and logs to a controller"
    return page_of(title, subtitle, chapters, hashes)
