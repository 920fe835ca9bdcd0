"""A name for the content of a drive, the same on every machine."""

import hashlib
import json

from cabledrive.parameters.drive import Drive
from cabledrive.parameters.tables import tables_from_drive


def content_hash(drive: Drive) -> str:
    """Hash of everything that can change a result: all SI values, not the words around them.

    Defaults are left out, so that a key added to the format later leaves the hashes of older drives alone;
    so are names and other text.

    Parameters
    ----------
    drive : Drive

    Returns
    -------
    str
        64 hexadecimal digits (SHA-256 of the canonical JSON of the drive without its words).
    """
    content = tables_from_drive(drive, words=False)
    for number, carriage in enumerate(drive.carriage):
        if carriage.coupled:  # by the number of the other one, which a new name does not change
            content["carriage"][number]["coupled"] = drive.carriage_number(carriage.coupled)
    canonical = json.dumps(content, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(canonical.encode()).hexdigest()
