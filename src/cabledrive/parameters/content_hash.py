"""A name for the content of a drive, the same on every machine."""

import hashlib
import json

from cabledrive.parameters.drive import WORDS, Drive
from cabledrive.parameters.tables import tables_from_drive


def content_hash(drive: Drive) -> str:
    """Hash of everything that can change a result: all SI values, not the words around them.

    Defaults are left out, so that a key added to the format later leaves the hashes of older drives alone.

    Parameters
    ----------
    drive : Drive

    Returns
    -------
    str
        64 hexadecimal digits (SHA-256 of the canonical JSON of the drive without name, title and source).
    """
    content = {key: value for key, value in tables_from_drive(drive).items() if key not in WORDS}
    canonical = json.dumps(content, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(canonical.encode()).hexdigest()
