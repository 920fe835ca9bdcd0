"""Machines driven by flexible cables, belts and tendons: modes, resonance, identification, control."""

from cabledrive.modes import Certificate, Mode, Modes, modes, natural_frequencies
from cabledrive.parameters import (
    Cable,
    Carriage,
    Drive,
    Goal,
    InputRefused,
    Layout,
    Lumped,
    Motor,
    NotComputed,
    Pulley,
    Sensors,
    content_hash,
    load_drive,
    packaged_drives,
    save_drive,
)

__version__ = "0.1.0.dev0"

__all__ = [
    "Cable",
    "Carriage",
    "Certificate",
    "Drive",
    "Goal",
    "InputRefused",
    "Layout",
    "Lumped",
    "Mode",
    "Modes",
    "Motor",
    "NotComputed",
    "Pulley",
    "Sensors",
    "content_hash",
    "load_drive",
    "modes",
    "natural_frequencies",
    "packaged_drives",
    "save_drive",
]
