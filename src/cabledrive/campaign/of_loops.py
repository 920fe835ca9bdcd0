"""Computations in closed loop: one run of the rig, and a whole study."""

from collections.abc import Mapping
from dataclasses import replace
from math import nan
from typing import Any

from cabledrive.campaign.computation import FLAG, TEXT, Found, Kind, Output, Row

TRACKING = {
    "peak_error_deg": ("deg", "largest error of the load angle"),
    "first_pulse_error_deg": ("deg", "over the first pulse with its dwell"),
    "later_pulses_error_deg": ("deg", "over the later pulses"),
    "rms_error_deg": ("deg", "root mean square of the error"),
    "peak_torque": ("N m", "largest torque of the motor"),
    "saturated_fraction": ("1", "share of the samples at the torque limit"),
    "slack_samples": ("1", "samples at which a span was slack"),
    "theory_bound_deg": ("deg", "bound of the theorem"),
}


def _track_outputs(options: Mapping[str, Any]) -> tuple[Output, ...]:
    numbers = (Output(name=name, unit=unit, meaning=meaning) for name, (unit, meaning) in TRACKING.items())
    return (
        *numbers,
        Output(name="within_bound", unit="", kind=FLAG, meaning="whether the error kept the bound"),
        Output(name="broken_assumptions", unit="", kind=TEXT, meaning="of the theorem"),
        Output(name="controller", unit="", kind=TEXT, meaning="name of the law"),
    )


def _track(row: Row) -> Mapping[str, Any] | Found:
    from cabledrive.rig import track

    o = row.options
    found = track(
        row.drive,
        controller=o.get("controller"),
        bandwidth=o.get("bandwidth"),
        gains=o.get("gains", "best"),
        plant=o.get("plant"),
        feedforward=o.get("feedforward", "damped"),
        motion=motion_of(row.motion),
        options=rig_options(o),
        plant_drive=row.plant,
        seed=row.seed,
        adapt=not o.get("no_adaptation", False),
    )
    said = found.summary
    values = {name: nan if said[name] is None else said[name] for name in TRACKING}
    values |= {
        "within_bound": said["within_bound"],
        "broken_assumptions": "; ".join(said["broken_assumptions"]),
        "controller": said["controller"],
    }
    return values if found.incomplete is None else Found(values=values, incomplete=found.incomplete)


def motion_of(quantities: Mapping[str, Any]) -> Any:
    """A motion for the rig, from its quantities in SI; what is not given has its default."""
    from cabledrive.rig import Motion
    from cabledrive.rig.setting import DEGREE

    given = dict(quantities)
    if "angle" in given:
        given["angle"] = given["angle"] / DEGREE
    whole: dict[str, Any] = {name: int(given[name]) for name in ("pulses", "order") if name in given}
    return Motion(**(given | whole))


def rig_options(o: Mapping[str, Any]) -> Any:
    """How the rig is set, from the options of the SPEC."""
    from cabledrive.rig import RigOptions

    plain = RigOptions()
    names = (
        "observer",
        "feedback",
        "encoder_phase",
        "ideal_sensors",
        "smooth_friction",
        "jitter",
        "segments",
    )
    chosen = {name: o.get(name, getattr(plain, name)) for name in names}
    return replace(plain, **chosen, forbid_slack=not o.get("tension_only", False))


def _study_outputs(options: Mapping[str, Any]) -> tuple[Output, ...]:
    return (
        Output(name="verdict", unit="", kind=TEXT, meaning="yes, no or unknown"),
        Output(name="headline", unit="", kind=TEXT, meaning="what decides"),
        Output(name="chosen_controller", unit="", kind=TEXT, meaning="law that is chosen"),
        Output(name="reached_error_deg", unit="deg", meaning="error of the load angle that is reached"),
        Output(name="reached_error_mm", unit="mm", meaning="error of the carriage that is reached"),
        Output(name="confidence", unit="1", meaning="of the reached error"),
    )


def _study(row: Row) -> Mapping[str, Any]:
    from cabledrive.studies.study import Goals, run_study
    from cabledrive.studies.study.results_file import results_of

    given: dict[str, Any] = dict(row.goals) | {"seed": row.seed}
    if row.options.get("quick", True):
        given = {"draws": 400, "cable_draws": 0, "carriage_draws": 400} | given
    counts = ("pulses", "order", "draws", "cable_draws", "carriage_draws", "seed")
    given |= {name: int(given[name]) for name in counts if name in given}
    result = run_study(row.drive, (), Goals(**given))
    said, chosen = results_of(result), None if result.laws is None else result.laws.chosen
    numbers = {name: said.get(name) for name in ("reached_error_deg", "reached_error_mm", "confidence")}
    return {name: nan if value is None else value for name, value in numbers.items()} | {
        "verdict": said["verdict"],
        "headline": said["headline"],
        "chosen_controller": chosen.controller if chosen is not None else "",
    }


KINDS = {
    "track": Kind(
        outputs=_track_outputs,
        default=("peak_error_deg", "rms_error_deg", "peak_torque", "saturated_fraction"),
        one=_track,
        modules=("cabledrive.rig.tracking",),
        options={
            "controller": TEXT,
            "bandwidth": "Hz",
            "gains": TEXT,
            "plant": TEXT,
            "feedforward": TEXT,
            "observer": TEXT,
            "feedback": TEXT,
            "encoder_phase": TEXT,
            "ideal_sensors": FLAG,
            "smooth_friction": FLAG,
            "tension_only": FLAG,
            "no_adaptation": FLAG,
            "jitter": "s",
            "segments": "count",
        },
    ),
    "study": Kind(
        outputs=_study_outputs,
        default=("verdict", "headline", "chosen_controller", "reached_error_deg", "confidence"),
        one=_study,
        modules=("cabledrive.studies.study.results_file",),
        options={"quick": FLAG},
        long=True,
    ),
}
