"""The drive in a file: what the machine is made of, in SI, checked once.

Units exist only here, at the door; every other room works with SI floats.
"""

from cabledrive.parameters.cable import Cable
from cabledrive.parameters.drive import Drive
from cabledrive.parameters.drive_file import (
    drive_text,
    load_drive,
    packaged_drives,
    packaged_text,
    save_drive,
)
from cabledrive.parameters.drive_parts import Carriage, Goal, Layout, Lumped, Motor, Pulley, Sensors
from cabledrive.parameters.errors import InputRefused, NotComputed
from cabledrive.parameters.route.drive import Machine
from cabledrive.parameters.schema import content_hash, drive_schema

__all__ = [
    "Cable",
    "Carriage",
    "Drive",
    "Goal",
    "InputRefused",
    "Layout",
    "Lumped",
    "Machine",
    "Motor",
    "NotComputed",
    "Pulley",
    "Sensors",
    "content_hash",
    "drive_schema",
    "drive_text",
    "load_drive",
    "packaged_drives",
    "packaged_text",
    "save_drive",
]
