"""What `track` asks of a body between two winches: its own options and no others."""

from collections.abc import Mapping
from dataclasses import fields
from typing import Any

from cabledrive.parameters import Drive, InputRefused
from cabledrive.parameters.route.drive import RoutedDrive
from cabledrive.rig.setting import BodyMotion, Motion, RigOptions
from cabledrive.rig.two_motors.result import TwoMotorTracking
from cabledrive.rig.two_motors.run import track_two_motors
from cabledrive.rig.two_motors.summary import CONTROLLER

OWN = (None, CONTROLLER, "best")
"""Names of the one law that moves a body between two winches."""


def track_winches(
    drive: RoutedDrive,
    *,
    controller: Any,
    motion: Motion | BodyMotion | None,
    options: RigOptions | None,
    plant_drive: Drive | RoutedDrive | None,
    others: Mapping[str, tuple[Any, Any]],
    **spec: Any,
) -> TwoMotorTracking:
    """Run the law of two winches.

    ``others``: arguments of `track` that have no effect here, each as given and by default; ``spec``: those
    of `track_two_motors`.
    Raises `InputRefused` for what has no effect here.
    """
    if controller not in OWN:
        raise InputRefused(
            f'controller = "{str(controller)[:60]}" moves a load by one motor: a body between two winches '
            f"has {CONTROLLER}: leave it out"
        )
    if isinstance(motion, Motion):
        raise InputRefused(
            "motion = Motion(...) is a pulse of a load pulley: two winches move a body, give "
            'BodyMotion(moves={"camera.x": 2.0})'
        )
    given = {name: values for name, values in others.items() if values[0] != values[1]}
    given |= _given_options(options or RigOptions())
    for name in given:
        raise InputRefused(f"{name} is for pulses of a load pulley: two winches move a body: leave it out")
    if isinstance(plant_drive, Drive):
        raise InputRefused("plant_drive has no winches: give the same machine with other figures")
    disturbances = () if options is None else options.disturbances
    return track_two_motors(drive, motion=motion, disturbances=disturbances, plant_drive=plant_drive, **spec)


def _given_options(options: RigOptions) -> dict[str, Any]:
    """Options of the rig that differ from their defaults and that two winches do not have."""
    plain = RigOptions()
    return {
        field.name: getattr(options, field.name)
        for field in fields(options)
        if field.name != "disturbances" and getattr(options, field.name) != getattr(plain, field.name)
    }
