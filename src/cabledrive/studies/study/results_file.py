"""What a study leaves besides its report: results, the identified drive, the controller in numbers."""

import hashlib
import json
from pathlib import Path
from typing import Any

import numpy as np

from cabledrive.parameters import content_hash
from cabledrive.parameters.drive_file import drive_text
from cabledrive.parameters.files import with_own_hash, write_whole
from cabledrive.parameters.route.two_pulleys import AxisDrive
from cabledrive.parameters.version import __version__
from cabledrive.rig.laws.controller_file import controller_numbers as law_and_filter
from cabledrive.rig.laws.controller_file import plain_numbers
from cabledrive.studies.study.acceptance_stage import AcceptanceResult, LawScore
from cabledrive.studies.study.bandwidth_cost import CarriageController
from cabledrive.studies.study.carriage_case import case_of, loop_at
from cabledrive.studies.study.controller_stage import law_of
from cabledrive.studies.study.goals import Goals, error_unit, goal_of
from cabledrive.studies.study.pipeline import StudyResult
from cabledrive.studies.study.sampled_plants import joined_loop, near_encoder
from cabledrive.studies.study.stage_cache import as_plain, sources_hash

RESULTS, REPORT, DRIVE, CONTROLLER = "results.json", "report.html", "drive.toml", "controller.json"
LOAD_KEYS, CARRIAGE_KEYS = ("plant", "inside", "reason"), ("rests", "smallest_tension")
"""Keys of an acceptance that only loads, and only carriages, have."""
METHOD = "study in stages, each kept by the hash of its inputs"


def results_of(result: StudyResult) -> dict[str, Any]:
    """The content of ``results.json``, plain data, SI."""
    verdict, laws = result.verdict, None if result.carried else result.laws
    stages = {
        "check": result.check,
        "identification": result.knowledge,
        "modes": result.modes,
        "resonance": result.resonance,
        "demand": result.demand,
        "model": result.model,
        "controller": result.controller,
        "laws": laws and {"chosen": laws.chosen, "cable": laws.cable_scores},
    }
    goals, unit, reached = as_plain(result.goals), error_unit(result.goals), verdict.reached
    key, size = f"reached_error_{unit.name}", reached.error if reached else None
    error: dict[str, Any] = {key: None if size is None else unit.of(size)}
    error |= {name: getattr(reached, name, None) for name in ("share", "confidence")}
    if size is None:
        why = "too many runs ended early" if reached else "no law was run on drawn plants"
        error[f"{key}_reason"] = why
    return {
        "verdict": verdict.answer,
        "headline": verdict.reasons[0],
        **error,
        "candidates": [_candidate(one, result.goals) for one in result.scores],
        "reasons": list(verdict.reasons),
        "findings": [finding.data for finding in result.knowledge.findings],
        "remedies": list(verdict.remedies),
        "cautions": list(verdict.cautions),
        "margins": as_plain(verdict.margins),
        "drive": result.drive.name,
        "drive_hash": content_hash(result.drive),
        **({"axis": result.drive.words} if isinstance(result.drive, AxisDrive) else {}),
        "goals": {name: value for name, value in goals.items() if name not in ("columns", "spreads")},
        "stages": {name: as_plain(stage) for name, stage in stages.items()}
        | {"acceptance": _acceptance(result)},
        "study": result.key,
        "provenance": {
            "cabledrive": __version__,
            "drive": result.drive.name,
            "drive_hash": content_hash(result.drive),
            "logs": {log.name: log.sha256 for log in result.check.logs},
            "source_hash": sources_hash(),
            "method": METHOD,
            "seed": result.goals.seed,
        },
    }


def _candidate(one: LawScore, goals: Goals) -> dict[str, Any]:
    unit = error_unit(goals)
    reached = one.reached.error if one.reached else None
    return {
        "controller": one.controller,
        "setting": one.setting,
        f"worst_{unit.name}": None if one.worst is None else unit.of(one.worst),
        f"reached_{unit.name}": None if reached is None else unit.of(reached),
        "share": one.share,
        "share_low": one.share_low,
        "plant": one.plant,
        "runs": one.runs,
        "ended_early": one.failed,
        "holds": one.holds,
        "reason": one.reason or ("" if goal_of(goals) is not None else "no error goal given"),
    }


def _acceptance(result: StudyResult) -> dict[str, Any]:
    runs = result.runs
    if not result.carried:
        return {"lumped": _shown(runs, CARRIAGE_KEYS), "cable": _shown(result.cable, CARRIAGE_KEYS)}
    if not runs.draws:
        return {"carriage": None}
    found = _shown(runs, LOAD_KEYS) | {"quantile_99_error_at_rest": runs.quantile(0.99, rest=True)}
    if found["worst"]:
        found["worst"]["course"] = found["worst"].pop("reference")
    return {"carriage": found}


def _shown(found: AcceptanceResult, left_out: tuple[str, ...]) -> dict[str, Any]:
    data = {name: value for name, value in as_plain(found).items() if name not in left_out}
    shares = {"median": 0.5, "quantile_95": 0.95, "quantile_99": 0.99, "largest": 1.0}
    return data | {f"{name}_error": found.quantile(share) for name, share in shares.items()}


def controller_numbers(result: StudyResult) -> dict[str, Any] | None:
    """The law and its filter as numbers that another program can run; none where no controller was found."""
    goals, control = result.goals, result.controller
    # So that who exports the law is told what the study says of it.
    said = {"verdict": result.verdict.answer, "reason": result.verdict.reasons[0]}
    if isinstance(control, CarriageController):
        return _carriage_numbers(result, control, said)
    chosen = result.laws.chosen if result.laws is not None else None
    if chosen is None:
        return None
    law = law_of(chosen, result.known, goals.motion, result.knowledge)
    loop = joined_loop(result.known, result.known, law, goals.motion, goals.torque)
    numbers = law_and_filter(loop, result.known, near_encoder(result.known))
    return numbers | {
        "logs": {log.name: log.sha256 for log in result.check.logs},
        "setting": chosen.words,
        "study": said,
        "stated_bound": control.bound if chosen.model is not None and control is not None else None,
    }


def _carriage_numbers(
    result: StudyResult, found: CarriageController, said: dict[str, str]
) -> dict[str, Any] | None:
    """Tables of the scheduled law over the carriage's place; forces at the rim of the drive pulley."""
    if found.bandwidth is None:
        return None
    case = case_of(result.known, result.goals)
    law = loop_at(case, found.bandwidth).law
    return {
        "about": "See cabledrive.control.transporter.ScheduledLaw and scheduled_kernels beside it",
        "name": found.name,
        "bandwidth_hz": found.bandwidth,
        "radius": case.design.radius,
        "interval": case.interval,
        "count": case.count,
        "encoders": ["drive", "load"] if found.both else ["drive"],
        "torque_limit": case.limit * case.design.radius if np.isfinite(case.limit) else None,
        "law": plain_numbers(law._asdict()),
        "stated_bound": None,
        "study": said,
    }


def write_files(result: StudyResult, folder: Path, report: str, *, asked: str, code: str) -> dict[str, Any]:
    """Write everything a study leaves, the results last; returns the content of ``results.json``."""
    controller, drive = controller_numbers(result), result.drive
    # A machine with routes as its file gives it, which a chain does not change.
    identified = drive_text(drive.machine if isinstance(drive, AxisDrive) else result.known)
    written: dict[str, str] = {REPORT: report, DRIVE: identified}
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
