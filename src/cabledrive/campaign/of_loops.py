"""Computations in closed loop: one run of the rig, and a whole study."""

from collections.abc import Mapping
from dataclasses import fields
from typing import Any

from cabledrive.campaign.computation import FLAG, TEXT, Found, Kind, Row, declared

TRACK = {
    "peak_error_deg": ("deg", "largest error of the load angle"),
    "first_pulse_error_deg": ("deg", "over the first pulse with its dwell"),
    "later_pulses_error_deg": ("deg", "over the later pulses"),
    "rms_error_deg": ("deg", "root mean square of the error"),
    "peak_torque": ("N m", "largest torque of the motor"),
    "saturated_fraction": ("1", "share of the samples at the torque limit"),
    "slack_samples": ("1", "samples at which a span was slack"),
    "theory_bound_deg": ("deg", "bound of the theorem"),
    "within_bound": (FLAG, "whether the error kept the bound"),
    "broken_assumptions": (TEXT, "of the theorem"),
    "controller": (TEXT, "name of the law"),
}


OF_THE_RUN = ("controller", "bandwidth", "gains", "plant", "feedforward")


def _track(row: Row) -> Mapping[str, Any] | Found:
    from cabledrive.rig import track

    o = row.options
    found = track(
        row.drive,
        **{name: o[name] for name in OF_THE_RUN if name in o},
        motion=motion_of(row.motion),
        options=rig_options(o),
        plant_drive=row.plant,
        seed=row.seed,
        adapt=not o.get("no_adaptation", False),
    )
    said = found.summary
    values = {name: said[name] for name in TRACK} | {
        "broken_assumptions": "; ".join(said["broken_assumptions"])
    }
    return values if found.incomplete is None else Found(values=values, incomplete=found.incomplete)


def motion_of(quantities: Mapping[str, Any]) -> Any:
    """A motion for the rig, from its quantities in SI; what is not given has its default."""
    from cabledrive.rig import Motion
    from cabledrive.rig.setting import DEGREE

    shown: dict[str, Any] = {"angle": lambda angle: angle / DEGREE, "pulses": int, "order": int}
    return Motion(**{name: shown.get(name, float)(value) for name, value in quantities.items()})


def rig_options(o: Mapping[str, Any]) -> Any:
    """How the rig is set, from the options of the SPEC."""
    from cabledrive.rig import RigOptions

    known = {field.name for field in fields(RigOptions)}
    given = {name: value for name, value in o.items() if name in known}
    return RigOptions(**given, forbid_slack=not o.get("tension_only", False))


STUDY = {
    "verdict": (TEXT, "yes, no or unknown"),
    "headline": (TEXT, "what decides"),
    "chosen_controller": (TEXT, "law that is chosen"),
    "reached_error_deg": ("deg", "error of the load angle that is reached"),
    "reached_error_mm": ("mm", "error of the carriage that is reached"),
    "confidence": ("1", "of the reached error"),
}


def _study(row: Row) -> Mapping[str, Any]:
    from cabledrive.studies.study import Goals, run_study
    from cabledrive.studies.study.pipeline import results_of

    given: dict[str, Any] = dict(row.goals) | {"seed": row.seed}
    if row.options.get("quick", True):
        given = {"draws": 400, "cable_draws": 0, "carriage_draws": 400} | given
    counts = ("pulses", "order", "draws", "cable_draws", "carriage_draws", "seed")
    given |= {name: int(given[name]) for name in counts if name in given}
    result = run_study(row.drive, (), Goals(**given))
    said, chosen = results_of(result), result.laws.chosen
    return {name: said.get(name) for name in STUDY} | {"chosen_controller": chosen and chosen.controller}


KINDS = {
    "track": Kind(
        outputs=lambda options: declared(TRACK),
        default=("peak_error_deg", "rms_error_deg", "peak_torque", "saturated_fraction"),
        one=_track,
        modules=("cabledrive.rig.tracking",),
        options={"bandwidth": "Hz", "jitter": "s", "segments": "count"}
        | dict.fromkeys(("controller", "gains", "plant", "feedforward", "observer", "feedback"), TEXT)
        | {"encoder_phase": TEXT}
        | dict.fromkeys(("ideal_sensors", "smooth_friction", "tension_only", "no_adaptation"), FLAG),
    ),
    "study": Kind(
        outputs=lambda options: declared(STUDY),
        default=("verdict", "headline", "chosen_controller", "reached_error_deg", "confidence"),
        one=_study,
        modules=("cabledrive.studies.study.pipeline",),
        options={"quick": FLAG},
        long=True,
    ),
}
