"""A planned motion from a table: time and torque, and what else changes slowly along it."""

from pathlib import Path

import numpy as np

from cabledrive.identification.logs.opening import open_table
from cabledrive.parameters import InputRefused
from cabledrive.parameters.fields import nearest
from cabledrive.parameters.files import require_regular
from cabledrive.parameters.units import to_si
from cabledrive.studies.planned_motion import PlannedMotion

MOST_ROWS = 5_000_000
COLUMNS = {
    "time": "s",
    "torque": "N m",
    "pretension": "N",
    "carriage": "m",
    "load torque": "N m",
}
"""Columns of a motion file, and their SI units; the first two are needed."""


def read_motion(path: str | Path) -> PlannedMotion:
    """Read a planned motion from a CSV or TSV file.

    Parameters
    ----------
    path : path-like
        With a head such as ``time [s], torque [N m], pretension [N], carriage [mm], load torque [N m]``. Time
        and torque are needed; time starts at 0 and ascends. A column without a unit is in SI.

    Returns
    -------
    PlannedMotion

    Raises
    ------
    InputRefused
        If the file cannot be read, a column is unknown, missing or there twice, or a number is missing.
    """
    path = Path(path)
    require_regular(path, "name a CSV file with time and torque")
    table = open_table(path, text=True)
    if (table.rows or 0) > MOST_ROWS:
        raise InputRefused(f"{path.name}: about {table.rows} rows, at most {MOST_ROWS} are read: thin it out")
    chosen = {name.lower().replace("_", " "): name for name in table.names}
    if len(chosen) < len(table.names):
        raise InputRefused(f"{path.name}: two columns have one name ({', '.join(table.names)}): drop one")
    for name in chosen:
        if name not in COLUMNS:
            known = nearest(name, tuple(COLUMNS))
            raise InputRefused(
                f'{path.name}: column "{chosen[name]}" is not part of a motion{known}: '
                f"write {', '.join(COLUMNS)}"
            )
    for name in ("time", "torque"):
        if name not in chosen:
            raise InputRefused(f'{path.name}: no column "{name} [{COLUMNS[name]}]": a motion needs it')
    blocks = list(table.read(table.names))
    found = {}
    for name, column in chosen.items():
        values = np.concatenate([block[column] for block in blocks])
        bad = np.flatnonzero(~np.isfinite(values))
        if bad.size:
            raise InputRefused(
                f'{path.name}: row {bad[0] + 1} of column "{column}" holds no finite number: fill it in'
            )
        unit = table.units.get(column, COLUMNS[name])
        try:
            found[name.replace(" ", "_")] = values * to_si(f"1 {unit}", COLUMNS[name])
        except InputRefused as refusal:
            raise InputRefused(f'{path.name}: column "{column}": {refusal}') from None
    try:
        return PlannedMotion(**found)
    except InputRefused as refusal:
        raise InputRefused(f"{path.name}: {refusal}") from None
