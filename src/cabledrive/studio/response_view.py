"""A measured frequency response over the one that is computed of the drive."""

from math import pi
from typing import Any

import numpy as np
from numpy.typing import NDArray
from starlette.requests import Request
from starlette.responses import JSONResponse, Response

from cabledrive.parameters import Drive, InputRefused, NotComputed
from cabledrive.parameters.route.drive import require_two_pulleys
from cabledrive.reduction.quality import distributed_response
from cabledrive.studio.desk import Desk
from cabledrive.studio.jobs import Job
from cabledrive.studio.state import drive_of, state_of
from cabledrive.studio.work_view import job_of

OUTPUTS = ("motor angle", "motor speed", "load angle", "load speed")


def response_curves(request: Request) -> Response:
    """Magnitude, phase and coherence of a measured response, and magnitude and phase of the computed one."""
    desk: Desk = request.app.state.desk
    job = job_of(request)
    answer = job.answer
    if "coherence" not in answer:
        raise InputRefused(f"{job.title}: holds no measured response: run Response on a log")
    lines = {name: np.array(answer[name], dtype=float) for name in ("frequency_hz", "magnitude", "phase_deg")}
    lines["coherence"] = np.array(answer["coherence"], dtype=float)
    above = lines["frequency_hz"] > 0.0
    lines = {name: values[above] for name, values in lines.items()}
    output = request.query_params.get("output", "")
    output = output if output in OUTPUTS else _output(job)
    lines["phase_deg"] = _below_zero(lines["phase_deg"])
    found: dict[str, Any] = {name: _plain(values) for name, values in lines.items()}
    found |= {"output": output, "outputs": OUTPUTS, "computed": [], "computed_phase": [], "words": ""}
    try:
        drive = drive_of(desk.library, state_of(request.url.query, desk.first))
        require_two_pulleys(drive, "the computed response")
        assert isinstance(drive, Drive)
        computed = _computed(drive, 2.0 * pi * lines["frequency_hz"], output)
        found["computed"] = _plain(np.abs(computed))
        found["computed_phase"] = _plain(_below_zero(np.degrees(np.angle(computed))))
        found["words"] = f"Dashed: computed of {drive.name}, from motor torque to {output}, friction viscous."
    except (InputRefused, NotComputed) as refusal:
        found["words"] = f"No computed response beside it: {refusal}"
    return JSONResponse(found)


def _computed(drive: Drive, omega: NDArray[np.float64], output: str) -> NDArray[np.complex128]:
    """Of the linear distributed drive; ``omega`` [rad/s]. Returns [rad/(N m)] or [rad/(s N m)]."""
    if any(drive.carriages_on(span) for span in drive.spans):
        raise InputRefused(f"{drive.name}: has carriages, the computed response has none: remove them")
    shaft, quantity = output.split()
    angle = distributed_response(drive, omega, angle_of=shaft)
    return angle * 1j * omega if quantity == "speed" else angle


def _output(job: Job) -> str:
    """What the output of a response most likely is, by the name of its column."""
    name = next((a.partition("=")[2] for a in job.arguments if a.startswith("--response=")), "").lower()
    quantity = "speed" if any(word in name for word in ("speed", "vel", "rate")) else "angle"
    return f"{'load' if 'load' in name else 'motor'} {quantity}"


def _below_zero(degrees: NDArray[np.float64]) -> NDArray[np.float64]:
    """Phases from -270 to 90 deg: that of an inertia, -180 deg, lies inside and does not jump."""
    return (degrees + 270.0) % 360.0 - 270.0


def _plain(values: NDArray[np.float64]) -> list[float | None]:
    return [float(value) if np.isfinite(value) else None for value in values]
