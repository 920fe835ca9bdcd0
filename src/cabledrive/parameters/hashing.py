"""A name for the content of a drive, the same on every machine."""

import hashlib
import json
from typing import Any

from cabledrive.parameters.drive import Drive
from cabledrive.parameters.route.axis import AxisDrive
from cabledrive.parameters.route.drive import RoutedDrive
from cabledrive.parameters.route.tables import tables_from_routed
from cabledrive.parameters.tables import tables_from_drive


def content_hash(drive: Drive | RoutedDrive) -> str:
    """Hash of everything that can change a result: all SI values, not the words around them.

    Defaults are left out, so that a key added to the format later leaves the hashes of older drives alone;
    so are names and other text.

    Parameters
    ----------
    drive : Drive or RoutedDrive

    Returns
    -------
    str
        64 hexadecimal digits (SHA-256 of the canonical JSON of the drive without its words).
    """
    if isinstance(drive, RoutedDrive):
        return _digest(tables_from_routed(drive, words=False))
    content = tables_from_drive(drive, words=False)
    if isinstance(drive, AxisDrive):
        content["machine"] = tables_from_routed(drive.machine, words=False)
    for number, carriage in enumerate(drive.carriage):
        if carriage.coupled:  # by the number of the other one, which a new name does not change
            content["carriage"][number]["coupled"] = drive.carriage_number(carriage.coupled)
    return _digest(content)


def _digest(content: dict[str, Any]) -> str:
    canonical = json.dumps(content, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(canonical.encode()).hexdigest()
