"""A planned motion, from a table, and the drive along it."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from cabledrive.answers.result import Result
from cabledrive.identification.logs.reading import open_table
from cabledrive.parameters import InputRefused, Machine
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.drive import moving_with
from cabledrive.parameters.fields import nearest
from cabledrive.parameters.files import require_regular
from cabledrive.parameters.route.strain_free import POSE
from cabledrive.parameters.units import to_si


@dataclass(frozen=True, slots=True, kw_only=True, eq=False, repr=False)
class PlannedMotion(Result):
    """A motion, sampled."""

    _table = "time: torque pretension carriage load_torque places torques"
    time: Array  # (n,): from 0, ascending [s]
    torque: Array  # (n,): [N m]; of a machine with routes beyond what holds it at rest
    pretension: Array | None = None  # (n,): [N]; the drive's own unless given
    # (n,): position of the first carriage [m]; carriages coupled to it move as far
    carriage: Array | None = None
    # (n,): slowly changing torque on the load pulley [N m]; it splits the span tensions
    load_torque: Array | None = None
    # (n,): of bodies of a machine with routes, by "head.x", "arm.turn" [m], [rad]
    places: Mapping[str, Array] = field(default_factory=dict)
    # (n,): of its motors but the first, by the name of their pulley [N m]
    torques: Mapping[str, Array] = field(default_factory=dict)

    def __post_init__(self) -> None:
        n = np.asarray(self.time).size
        if n < 2 or not np.all(np.diff(self.time) > 0.0) or self.time[0] != 0.0:
            raise InputRefused("motion: time must start at 0 and ascend: give two instants or more")
        named = {name: getattr(self, name) for name in ("torque", "pretension", "carriage", "load_torque")}
        for name, values in {**named, **self.places, **self.torques}.items():
            if values is not None and (np.shape(values) != (n,) or not np.all(np.isfinite(values))):
                raise InputRefused(f"motion: {name} must be {n} finite numbers, one for each time")

    @property
    def changes(self) -> bool:
        """Whether pretension, carriages or load torque change along it."""
        columns = (self.pretension, self.carriage, self.load_torque)
        return any(values is not None and np.ptp(values) > 0.0 for values in columns)

    def by_pulley(self, sense: float = 1.0) -> "PlannedMotion":
        """The motion of a machine of which only places and torques change; that on the load by its pulley.

        ``sense``: turn of the machine's pulleys per turn that the motion counts.
        """
        for name in ("pretension", "carriage"):
            if getattr(self, name) is not None:
                raise InputRefused(
                    f"motion: {name} is not for margins, which take the tension and places of the drive "
                    "file: leave the column out"
                )
        loads = {} if self.load_torque is None else {"load pulley": sense * self.load_torque}
        torques = {**self.torques, **loads}
        return replace(self, torque=sense * self.torque, load_torque=None, torques=torques)


def machine_at(machine: Machine, pose: Mapping[str, float]) -> Machine:
    """The machine with the pretension [N] and the place of its first carriage [m] that a motion has."""
    own: Any = machine.listed
    if "pretension" in pose:
        own = replace(own, cable=replace(own.cable, pretension=pose["pretension"]))
    if "carriage" in pose:
        if not own.carriage:
            raise InputRefused("motion: carriage positions are given, but the drive has none: leave them out")
        way, carriages = pose["carriage"] - own.carriage[0].position, list(own.carriage)
        for number, direction in moving_with(own, 0).items():
            one = carriages[number]
            position = pose["carriage"] if number == 0 else one.position + direction * way
            carriages[number] = replace(one, position=position)
        own = replace(own, carriage=tuple(carriages))
    moved: Machine = own.machine
    return moved


MOST_ROWS = 5_000_000
COLUMNS = {"time": "s", "torque": "N m", "pretension": "N", "carriage": "m", "load torque": "N m"}
"""Columns of a motion file, and their SI units; the first two are needed."""


def read_motion(path: str | Path, machine: Machine | None = None, *, torque: bool = True) -> PlannedMotion:
    """Read a planned motion from a CSV or TSV file.

    Parameters
    ----------
    path : path-like
        With a head such as ``time [s], torque [N m], pretension [N], carriage [mm], load torque [N m]``. Time
        and torque are needed; time starts at 0 and ascends. A column without a unit is in SI.
    machine : Machine, optional
        Whose motion it is: of routes torque is that of the first motor, ``torque NAME [N m]`` that of another
        motor's pulley, and ``head.x [m]`` the place of a body.
    torque : bool, default True
        Whether the torque is needed; else it is zero where the file gives places alone.

    Returns
    -------
    PlannedMotion

    Raises
    ------
    InputRefused
        If the file cannot be read, a column is unknown, missing or there twice, or a number is missing.
    """
    path, columns, places, torques = Path(path), COLUMNS, dict[str, str](), dict[str, str]()
    if machine is not None and not machine.angles:  # bodies, motors behind the first, by their words
        moves = [f"{body.name}.{move}" for body in machine.body for move in body.moves]
        motors = [machine.pulley[number].name for number in machine.driven[1:]]
        places = {name.lower().replace("_", " "): name for name in moves}
        torques = {f"torque {name}".lower().replace("_", " "): name for name in motors}
        columns = {name: COLUMNS[name] for name in ("time", "torque")}
        columns |= {column: POSE[name.rpartition(".")[2]] for column, name in places.items()}
        columns |= dict.fromkeys(torques, "N m")
    require_regular(path, "name a CSV file with time and torque")
    table = open_table(path, text=True)
    if (table.rows or 0) > MOST_ROWS:
        raise InputRefused(f"{path.name}: about {table.rows} rows, at most {MOST_ROWS} are read: thin it out")
    chosen = {name.lower().replace("_", " "): name for name in table.names}
    if len(chosen) < len(table.names):
        raise InputRefused(f"{path.name}: two columns have one name ({', '.join(table.names)}): drop one")
    for name in chosen:
        if name not in columns:
            known = nearest(name, tuple(columns))
            said = f'{path.name}: column "{chosen[name]}" is not part of a motion{known}'
            raise InputRefused(f"{said}: write {', '.join(columns)}")
    for name in ("time", "torque") if torque or places.keys().isdisjoint(chosen) else ("time",):
        if name not in chosen:
            raise InputRefused(f'{path.name}: no column "{name} [{COLUMNS[name]}]": a motion needs it')
    blocks = list(table.read(table.names))
    found: dict[str, Array] = {}
    for name, column in chosen.items():
        values = np.concatenate([block[column] for block in blocks])
        bad = np.flatnonzero(~np.isfinite(values))
        if bad.size:
            raise InputRefused(
                f'{path.name}: row {bad[0] + 1} of column "{column}" holds no finite number: fill it in'
            )
        unit = table.units.get(column, columns[name])
        try:
            found[name] = values * to_si(f"1 {unit}", columns[name])
        except InputRefused as refusal:
            raise InputRefused(f'{path.name}: column "{column}": {refusal}') from None
    found.setdefault("torque", np.zeros(found["time"].size))
    try:
        return PlannedMotion(
            **{name.replace(" ", "_"): values for name, values in found.items() if name in COLUMNS},
            places={places[name]: values for name, values in found.items() if name in places},
            torques={torques[name]: values for name, values in found.items() if name in torques},
        )
    except InputRefused as refusal:
        raise InputRefused(f"{path.name}: {refusal}") from None
