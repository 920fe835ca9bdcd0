"""What is decided before the first step of a run of any machine."""

from collections.abc import Mapping
from typing import Any

from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.route import RoutedDrive
from cabledrive.simulation.signals import Function, Signal, checked_signal
from cabledrive.simulation.start import OF_LOOPS, Recording, Scheme, Start


def offsets_of(drive: RoutedDrive) -> list[float]:
    """Constant torque of each motor's own [N m]; 0 for a pulley that has none."""
    return [motor.offset_torque for motor in drive.motor] or [0.0 for _ in drive.turned]


def never_simulated(drive: RoutedDrive) -> list[tuple[Any, str]]:
    """What no run of a machine with routes has: whether it is there, and what to do."""
    running = next((data.name for data in drive.route if data.speed), "")
    return [
        (running, f'route "{running}" runs (speed), and only ropes at rest are simulated: set it to 0'),
        (any(own.backlash for own in drive.motor), "motor.backlash is not simulated on routes: set it to 0"),
    ]


def check_routes(drive: RoutedDrive, scheme: Scheme, recording: Recording, start: Start) -> None:
    """Refuse what no run of a machine with routes has."""
    for refused, why in (
        (
            scheme.friction == "smoothed"
            and any(own.coulomb_friction and own.pivot is None for own in drive.body),
            "friction of bodies that slide is set-valued: leave smoothed friction out",
        ),
        (
            any(getattr(start, name) for name in OF_LOOPS),
            'angles at the start are for loops and lines: give "places" and "speeds"',
        ),
        *never_simulated(drive),
    ):
        if refused:
            raise InputRefused(f'kind = "route": {why}')


def motor_torques(
    names: tuple[str, ...],
    torque: Mapping[str, Signal | float | Function] | Signal | float | Function,
    duration: float,
    step: float,
) -> tuple[Signal, ...]:
    """Torque of each motor by the name of its pulley; one torque is that of the first."""
    given = torque if isinstance(torque, Mapping) else ({names[0]: torque} if names else {})
    if not names and not isinstance(torque, Mapping) and torque != 0.0:
        raise InputRefused('kind = "route": there is no [[pulley]] on which a torque could act: add one')
    for name in given:
        if name not in names:
            raise InputRefused(f'torque on "{str(name)[:60]}": the motors are {", ".join(names) or "none"}')
    return tuple(checked_signal(given.get(name, 0.0), f"torque on {name}", duration, step) for name in names)
