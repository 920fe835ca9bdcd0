"""How far the bodies of a machine with routes travel: places along each motion that strains nothing."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from cabledrive.parameters import InputRefused
from cabledrive.parameters.route import RoutedDrive
from cabledrive.studies.excitation_orders import rates

ROOM = 0.08
"""Share of the possible travel that is kept clear at each end."""
LEAST_RATE = 1e-6
SLIDES = ("x", "y")

Travel = dict[tuple[str, ...], NDArray[np.float64]]


def travels(drive: RoutedDrive, points: int = 9) -> Iterator[Travel]:
    """Places along each motion without strain in which a body slides, inside the box round the machine.

    Bodies that move together (a car and its counterweight) are one motion. Each is rows of places in m by
    keys that move together, as `cabledrive.studies.mode_map.map_modes` takes them.
    """
    done: set[str] = set()
    for number, body in enumerate(drive.body):
        for move in body.moves:
            key = f"{body.name}.{move}"
            if move not in SLIDES or key in done:
                continue
            try:
                linked = _sliding(drive, rates(drive, key))
            except InputRefused:  # a spring or a rope holds it: it does not travel
                continue
            done |= set(linked)
            low, high = _reach(drive, linked)
            if high > low:
                yield _places(drive, number, move, linked, np.linspace(low, high, points))


def _sliding(drive: RoutedDrive, moving: dict[str, float]) -> dict[str, float]:
    """The bodies' slides that take part in a motion, with their rates."""
    own = [f"{body.name}.{move}" for body in drive.body for move in body.moves if move in SLIDES]
    return {name: moving[name] for name in own if abs(moving.get(name, 0.0)) > LEAST_RATE}


def _reach(drive: RoutedDrive, linked: dict[str, float]) -> tuple[float, float]:
    """Travel of the first body from where it is, down and up [m], with all that moves inside the box."""
    every = np.array([pulley.at for pulley in drive.pulley] + [anchor.at for anchor in drive.anchor])
    box = every.min(axis=0), every.max(axis=0)
    low, high = -np.inf, np.inf
    for name, rate in linked.items():
        body, _, move = name.rpartition(".")
        axis = SLIDES.index(move)
        at = np.array([point[axis] for point in _carried(drive, body)])
        ends = sorted(((box[0][axis] - at.min()) / rate, (box[1][axis] - at.max()) / rate))
        low, high = max(low, ends[0]), min(high, ends[1])
    own = [_stated(drive, name, rate) for name, rate in linked.items()]
    stated = max((ends[0] for ends in own), default=-np.inf), min((ends[1] for ends in own), default=np.inf)
    if np.isfinite(stated).all():
        return float(stated[0]), float(stated[1])
    room = ROOM * max(high - low, 0.0)
    return low + room, high - room


def _stated(drive: RoutedDrive, key: str, rate: float) -> tuple[float, float]:
    """Ways of the first body [m] to the ends of a body's stated travel; without end where none is stated."""
    name, _, move = key.rpartition(".")
    body = next(one for one in drive.body if one.name == name)
    if body.travel is None:
        return -np.inf, np.inf
    low, high = sorted((end - body.at[SLIDES.index(move)]) / rate for end in body.travel)
    return low, high


def _carried(drive: RoutedDrive, body: str) -> list[tuple[float, float]]:
    """Places of a body and of all that it carries."""
    on = {body}
    while more := {own.name for own in drive.body if own.on in on} - on:
        on |= more
    points = [own.at for own in drive.body if own.name in on]
    points += [pulley.at for pulley in drive.pulley if pulley.on in on]
    return points + [anchor.at for anchor in drive.anchor if anchor.on in on]


def _places(
    drive: RoutedDrive, number: int, move: str, linked: dict[str, float], steps: NDArray[np.float64]
) -> Travel:
    """Rows of places, the body that was asked for first."""
    first = f"{drive.body[number].name}.{move}"
    names = (first, *(name for name in linked if name != first))
    rows = []
    for name in names:
        body, _, way = name.rpartition(".")
        own = next(one for one in drive.body if one.name == body)
        rows.append(own.at[SLIDES.index(way)] + linked[name] / linked[first] * steps)
    return {names: np.array(rows)}
