"""Control laws side by side on one motion: error, torque, spectrum and bound, with bandwidths as sliders."""

import threading
from collections.abc import Sequence
from typing import Any

import numpy as np
from starlette.requests import Request
from starlette.responses import JSONResponse, Response

from cabledrive.parameters import InputRefused, NotComputed
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.units import to_si
from cabledrive.reduction.network_axis import as_axis
from cabledrive.report.blocks import instants
from cabledrive.report.figures.run_histories import FEWEST_SAMPLES, amplitude_spectrum
from cabledrive.rig import Tracking, track
from cabledrive.rig.laws.registry import CONTROLLERS, MAIN_LAWS, OPEN_LOOPS, SHAPED
from cabledrive.rig.plant_samples import Disturbances
from cabledrive.rig.setting import Motion, RigOptions, parse_disturbance, parse_encoder_dropout
from cabledrive.rig.trial import offered
from cabledrive.studio import guard as pages
from cabledrive.studio.commands import DISTURBANCES, SWITCHES, disturbed
from cabledrive.studio.log_store import plain
from cabledrive.studio.state import Desk, State, command_line, drive_of, state_of

NONE_HERE = "No control law ran"
PLANTS = ("model-1", "model-2", "model-3", "model-4", "cable")
FIRST_LAWS, STEPPER_LAWS = ("pd", "lqg", "lqi-learning"), (*OPEN_LOOPS, "pd", "lqg")
MOST_LAWS = 4
LOWEST, HIGHEST = 2.0, 200.0
"""Part of the spectrum that is drawn [Hz]."""
LEAST = 1e-8
"""Amplitude that stands for none on an axis of powers of ten [deg]: a rotor that sticks does not move."""
_ONE_AT_A_TIME, _BEST_AT_A_TIME = threading.Lock(), threading.Lock()


def control_page(request: Request) -> Response:
    """The page; its curves are asked for apart."""
    desk: Desk = request.app.state.desk
    state = state_of(request.url.query, desk.first)
    given, laws = request.query_params, _laws_of(desk, state)
    return pages.page(
        request,
        "control.html",
        view="control",
        state=state,
        laws=laws,
        others=[name for name in CONTROLLERS if name not in laws],
        chosen=_laws(request, laws),
        plants=PLANTS,
        given=given,
        bandwidth=given.get("bandwidth", ""),
        own=any(name.startswith("bandwidth-") for name in given),
        switches=SWITCHES,
        disturbances={name: words for name, (words, _) in DISTURBANCES.items()},
        command="",
    )


def control_part(request: Request) -> Response:
    """Runs of all laws that are chosen."""
    desk: Desk = request.app.state.desk
    return JSONResponse(_runs(request, desk, state_of(request.url.query, desk.first)))


def _runs(request: Request, desk: Desk, state: State) -> dict[str, Any]:
    """Curves and figures of the laws, or why none can run here."""
    axis = request.query_params.get("axis", "")[:60] or None
    try:
        drive = as_axis(drive_of(desk.library, state), axis)
    except (InputRefused, NotComputed) as refusal:
        return {"none_here": f"{NONE_HERE}: {refusal}."}
    if drive.sensors is None or drive.sensors.sample_rate is None or drive.motor is None:
        return {"none_here": f"{NONE_HERE}: its file has no motor or no sample rate."}
    motion, options, words = _setting(request)
    words = [*words, *([f"--axis={axis}"] if axis else [])]
    laws = _laws(request, offered(drive, Disturbances()))
    bandwidths = {law: None if law in OPEN_LOOPS else _bandwidth(request, law) for law in laws}
    plant = request.query_params.get("plant") or None
    runs: dict[str, Tracking] = {}
    refused: list[str] = []
    with _ONE_AT_A_TIME:
        for law, bandwidth in bandwidths.items():
            try:
                runs[law] = track(
                    drive, controller=law, bandwidth=bandwidth, plant=plant, motion=motion, options=options
                )
            except (InputRefused, NotComputed) as refusal:
                refused.append(f"{law}: {refusal}")
    common = {words.partition(": ")[2] for words in refused}
    if not runs and len(common) == 1:
        return {"none_here": f"{NONE_HERE}: {common.pop()}."}
    lines = [
        command_line(desk.library, state, "track", f"--controller={law}", *own, *words)
        for law, bandwidth in bandwidths.items()
        for own in [[] if bandwidth is None else [f"--bandwidth={bandwidth:g}"]]
    ]
    return {"refused": refused, "command": "; ".join(lines), "query": state.query} | _seen(runs)


def control_best(request: Request) -> Response:
    """The law that `compare` ranks first along the motion of the page, and why it has its bandwidth."""
    desk: Desk = request.app.state.desk
    try:
        drive = drive_of(desk.library, state_of(request.url.query, desk.first))
        axis = request.query_params.get("axis", "")[:60] or None
        with _BEST_AT_A_TIME:
            run = track(drive, controller="best", motion=_setting(request)[0], axis=axis)
    except (InputRefused, NotComputed) as refusal:
        return JSONResponse({"words": f"{NONE_HERE}: {refusal}."})
    of = "of the laws with feedback " if run.summary.get("motor_reason") else ""
    return JSONResponse({"words": f"{of}compare would take {run.summary['gains']['reasons'][0]}."})


def _laws_of(desk: Desk, state: State) -> list[str]:
    """Laws that are compared on a machine; those of any drive where none can be."""
    try:
        return list(offered(as_axis(drive_of(desk.library, state)), Disturbances()))
    except (InputRefused, NotComputed):
        return list(MAIN_LAWS)


def _laws(request: Request, offered: Sequence[str]) -> list[str]:
    """Laws that are asked for, each once; by default few of those offered, of a stepper its own."""
    given = [law for law in request.query_params.getlist("law") if law in CONTROLLERS]
    first = STEPPER_LAWS if SHAPED in offered else FIRST_LAWS
    return list(dict.fromkeys(given))[:MOST_LAWS] or list(first)


def _bandwidth(request: Request, law: str) -> float | None:
    """Of a law [Hz]: its own where the page gives one, else that of all, else the one that it is tuned to."""
    given = request.query_params
    words = given.get(f"bandwidth-{law}") or given.get("bandwidth")
    if not words:
        return None
    bandwidth = to_si(words, "Hz")
    if not 0.1 <= bandwidth <= 1000.0:
        raise InputRefused(f"bandwidth = {bandwidth:.4g} Hz must lie between 0.1 Hz and 1 kHz")
    return bandwidth


def _setting(request: Request) -> tuple[Motion, RigOptions, list[str]]:
    """Motion and options of the page, and the same for the command `track`."""
    given = request.query_params
    motion = Motion(
        angle=float(f"{np.degrees(to_si(given.get('angle') or '45 deg', 'rad')):.15g}"),
        rise=to_si(given.get("rise") or "0.5 s", "s"),
        dwell=to_si(given.get("dwell") or "0.5 s", "s"),
    )
    on = {name: option.partition("=")[2] for name, (_, option) in DISTURBANCES.items() if given.get(name)}
    options = RigOptions(
        ideal_sensors="ideal" in on,
        smooth_friction="smooth" in on,
        disturbances=(parse_disturbance(on["kick"]),) if "kick" in on else (),
        blind=parse_encoder_dropout(on["dropout"]) if "dropout" in on else None,
        jitter=to_si(on["jitter"], "s") if "jitter" in on else 0.0,
    )
    words = [f"--plant={given['plant']}"] if given.get("plant") else []
    words += [f"--angle={motion.angle:g}", f"--rise={motion.rise:g}", f"--dwell={motion.dwell:g}"]
    return motion, options, words + disturbed(given)


def spectrum(run: Tracking) -> tuple[Array, Array]:
    """Frequency [Hz] and amplitude [deg] of the error of the load in the last dwell; none of a short one."""
    still = run.time > run.time[-1] - run.summary["motion"]["dwell"]
    if np.count_nonzero(still) < FEWEST_SAMPLES:
        return np.empty(0), np.empty(0)
    frequency, amplitude = amplitude_spectrum(run.time[still], np.degrees(run.error[still]))
    kept = (frequency >= LOWEST) & (frequency <= HIGHEST)
    return frequency[kept], amplitude[kept]


def _seen(runs: dict[str, Tracking]) -> dict[str, Any]:
    """Curves of the runs, thinned so that every peak stays, and their figures."""
    curves = []
    for law, run in runs.items():
        bounds = [] if run.bound is None or run.summary["within_bound"] is None else [run.bound]
        kept = instants([run.error, run.torque, *bounds], run.time.size)
        frequency, amplitude = spectrum(run)
        curves.append(
            {
                "name": law,
                "time": run.time[kept].tolist(),
                "error": plain(np.degrees(run.error[kept])),
                "torque": plain(run.torque[kept]),
                "bound": plain(np.degrees(bounds[0][kept])) if bounds else [],
                "frequency": frequency.tolist(),
                "amplitude": plain(np.maximum(amplitude, LEAST)),
            }
        )
    keys = ["peak_error_deg", "rms_error_deg", "peak_torque"]
    keys += ["saturated_fraction", "theory_bound_deg", "within_bound"]
    rows = [
        {
            "law": law,
            "incomplete": run.incomplete,
            "bandwidth_hz": run.summary["gains"].get("bandwidth_hz"),
            "reasons": [f"{law}: {words}" for words in run.summary["gains"].get("reasons", ())],
        }
        | {key: run.summary[key] for key in keys}
        for law, run in runs.items()
    ]
    return {"curves": curves, "rows": rows}
