"""What `response` answers of a drive file: the frequency response of a machine with routes."""

from typing import Any

import numpy as np

from cabledrive.app.results import Answer, provenance
from cabledrive.parameters import InputRefused, load_drive, packaged_drives
from cabledrive.parameters.arrays import Array, Complex
from cabledrive.parameters.route import RoutedDrive

LINES = 400
ROUND_OFF = 1e-10
"""Of a response, relative to the mean of the responses of both its coordinates to their own forces."""
_FIRST = 1e-2
"""Lowest line, relative to the highest."""


def is_machine(source: str) -> bool:
    """Whether a source of `response` is a drive, by name or file, and no log."""
    return source.endswith(".toml") or source in packaged_drives()


def response_of_machine(
    source: str, force_on: str | None, motion_of: str | None, below: float | None, *, speed: bool
) -> Answer:
    """The response of a machine with routes; ``below`` [Hz]; ``speed``: of the motion's speed."""
    from cabledrive.mechanics.network import machine_response, network_of
    from cabledrive.mechanics.network.motion import condition
    from cabledrive.modal import natural_frequencies
    from cabledrive.modal.natural import straight_limit

    drive = load_drive(source)
    if not isinstance(drive, RoutedDrive):
        raise InputRefused(
            f'{source}: the response of a drive file needs kind = "route"; give the log of a measured one'
        )
    force_on = force_on or (drive.pulley[drive.driven[0]].name if drive.motor else None)
    if force_on is None:
        raise InputRefused("a machine without a motor: name the coordinate that is pushed with --input")
    motion_of = motion_of or force_on
    top = 3.0 * float(natural_frequencies(drive, count=1)[0]) if below is None else below
    frequency = top * np.geomspace(_FIRST, 1.0, LINES)
    found = machine_response(drive, frequency, force_on, motion_of)
    still = _is_zero(drive, frequency, force_on, motion_of, found)
    if speed:
        found = 2j * np.pi * frequency * found
    sag = straight_limit(network_of(drive), 2 * np.pi * top)
    data: dict[str, Any] = {
        "frequency_hz": frequency,
        "magnitude": np.abs(found),
        "phase_deg": np.degrees(np.unwrap(np.angle(found))),
        "input": force_on,
        "output": motion_of,
        "motor": condition(drive),
        "left_out": [],
        "warnings": [
            *([f"a force on {force_on} does not move {motion_of}: zero but for round-off"] if still else []),
            *(["Coulomb friction is left out"] if _rubs(drive) else []),
            *([sag] if sag else []),
        ],
    }
    what = "speed" if speed else "motion"
    text = f"{drive.name}: {what} of {motion_of} per force on {force_on}, {LINES} lines up to {top:.4g} Hz"
    text += "".join(f"\nwarning: {words}" for words in data["warnings"])
    return Answer(data=data, text=text, provenance=provenance(drive, method="exact waves on every span"))


def _is_zero(drive: RoutedDrive, frequency: Array, force_on: str, motion_of: str, found: Complex) -> bool:
    """Whether a motion is round-off beside what each of both coordinates moves under its own force."""
    from cabledrive.mechanics.network import machine_response

    if force_on == motion_of:
        return False
    own = [np.abs(machine_response(drive, frequency, name, name)) for name in (force_on, motion_of)]
    return bool((np.abs(found) <= ROUND_OFF * np.sqrt(own[0] * own[1])).all())


def _rubs(drive: RoutedDrive) -> bool:
    return any(
        part.coulomb_friction > 0.0 for group in (drive.body, drive.pulley, drive.motor) for part in group
    )
