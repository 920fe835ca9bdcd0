"""Excitation whose frequency follows the speed, against the natural frequencies over the travel.

A pulley that turns with the machine shakes it N times a turn (a sheave out of round once, its motor with its
poles), a rail joint once in a length. Where a coordinate moves with speed v, its frequency is
:math:`f = h v`; it meets a mode of frequency :math:`f_n` at the critical speed :math:`f_n/h`.
"""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.network import network_of
from cabledrive.modal import Modes
from cabledrive.parameters import InputRefused, Machine
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.drive_parts import Order
from cabledrive.parameters.fields import require_known
from cabledrive.studies.mode_map import Grid, Mode, distinct, over

MARGIN = 0.05
_STRAINED = 1e-2
_ASKEW = 1e-6  # share of the stiffness below which a rope a little askew does not hold a body
_ONE_RATE = 0.01
"""Share by which the frequency of an order per unit speed may differ over a map."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Branch:
    """One mode along a map: what it is, and its frequency at each point."""

    kind: str  # {"longitudinal", "transverse"}
    name: str  # its rope span, or the body or pulley that moves most, and its number among those of that name
    # (points,): [Hz]; not finite where it lies above what was searched, or the point is no machine
    hertz: Array
    # 0 to 1: the largest share of its kinetic energy that a body, pulley or carriage has on the map, or 1/n
    # of the nth mode across a span
    weight: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Zone:
    """Speeds, and places on the map, at which an excitation comes near a mode."""

    order: str
    mode: str
    kind: str
    # low, high: speeds within the asked range, the margin included [m/s] or [rad/s]
    low: float
    high: float
    # place_low, place_high: first and last value of the map's first key where that is so, in SI
    place_low: float
    place_high: float
    weight: float  # of the mode, less for a higher number of the order


@dataclass(frozen=True, slots=True, kw_only=True)
class Campbell:
    """What orders of excitation meet over a range of speed, at every point of a map."""

    key: str  # first key of the map
    places: Array  # (points,): its value at each point, in SI
    coordinate: str  # what moves with the speed
    # low, high, margin: range of speed [m/s] or [rad/s]; share of a frequency that is too near
    low: float
    high: float
    margin: float
    orders: dict[str, float]  # frequency per unit speed [Hz s/m], [Hz s/rad]
    covered: float  # every mode below it is known [Hz]
    certified: bool  # whether each point's list is certified complete up to there
    branches: tuple[Branch, ...]
    zones: tuple[Zone, ...]  # the heaviest first

    @property
    def clear(self) -> tuple[tuple[float, float], ...]:
        """Speeds at which no order comes near a mode anywhere on the map."""
        clear, reached = [], self.low
        for zone in sorted(self.zones, key=lambda own: own.low):
            if zone.low > reached:
                clear.append((reached, zone.low))
            reached = max(reached, zone.high)
        return (*clear, *([(reached, self.high)] if reached < self.high else []))


def rates(drive: Machine, coordinate: str) -> dict[str, float]:
    """How fast every coordinate moves where one moves with unit speed and nothing is strained.

    Where that leaves bodies free, those that can be at rest are; refused if this does not tell how all move.
    """
    network = network_of(drive, motor="free")
    names = network.motion.names
    require_known(coordinate[:60], names, f'"{coordinate[:60]}" is no coordinate')
    stiffness, own = network.static_stiffness, names.index(coordinate)
    others = [i for i in range(len(names)) if i != own]
    stiff = np.abs(np.diag(stiffness))
    unit = 1.0 / np.sqrt(np.where(stiff > 0.0, stiff, 1.0))  # of each coordinate: metres are no radians
    stiffness = unit[:, None] * stiffness * unit
    sizes, ways = np.linalg.eigh(stiffness[np.ix_(others, others)])
    free = np.abs(sizes) <= _ASKEW * np.abs(sizes).max(initial=0.0)
    held, loose = ways[:, ~free], ways[:, free]
    rest = -held @ (held.T @ stiffness[others, own] / sizes[~free])
    strained = stiffness[own, own] + stiffness[own, others] @ rest
    if abs(strained) > _STRAINED * stiffness[own, own]:
        raise InputRefused(
            f"{coordinate} cannot move without straining a rope or a spring: give the speed of one that can"
        )
    bodies = np.array(["." in names[i] for i in others], dtype=bool)
    rest -= loose @ (np.linalg.pinv(loose[bodies], rcond=1e-6) @ rest[bodies])
    still = bodies & (np.abs(rest) < 1e-6 * np.abs(rest[bodies]).max(initial=1.0))
    if np.linalg.matrix_rank(loose[still], 1e-6) < np.linalg.matrix_rank(loose[bodies], 1e-6):
        free_names = ", ".join(name for name in names if "." in name and name != coordinate)
        raise InputRefused(f"{coordinate} moves with several of {free_names}: give the speed of one of those")
    moving = unit * np.insert(rest, own, 1.0) / unit[own]
    return {name: float(rate) for name, rate in zip(names, moving, strict=True)}


def frequency_per_speed(drive: Machine, order: Order, coordinate: str) -> float:
    """Frequency of an excitation per unit speed of a coordinate [Hz s/m], [Hz s/rad]."""
    found = rates(drive, coordinate)
    part = order.pulley or order.coordinate or ""
    require_known(part[:60], found, f'order {order.name}: "{part[:60]}" is no coordinate')
    turns = order.number / (2 * np.pi) if order.pulley is not None else 1.0 / order.length
    rate = abs(found[part]) * turns
    if rate < 1e-9:
        raise InputRefused(f"order {order.name}: {part} does not move with {coordinate}: choose another part")
    return rate


def excitation(
    grid: Grid, orders: Sequence[Order], speed: tuple[str, float, float], *, margin: float = MARGIN
) -> Campbell:
    """Speeds at which orders of excitation come near a mode; ``speed``: a coordinate and its range.

    Modes are searched as far as the fastest order reaches: nothing above that is called clear.
    """
    coordinate, low, high = speed
    if not 0.0 <= low < high < np.inf:
        raise InputRefused(f"speed from {low:.9g} to {high:.9g}: give two, the larger last, none negative")
    if not 0.0 < margin < 1.0:
        raise InputRefused(f"margin = {margin:.9g} must lie between 0 and 1")
    names = [order.name for order in orders]
    if not names or len(set(names)) < len(names):
        raise InputRefused("orders: name at least one, each with a name of its own")
    rates_of = {order.name: frequency_per_speed(grid.drive, order, coordinate) for order in orders}
    covered = max(rates_of.values()) * high / (1.0 - margin)
    read = partial(_modes_and_rates, orders=orders, coordinate=coordinate)
    axes, _, points = over(grid, {"below": covered}, read)
    for name, rate in rates_of.items():
        there = [rate, *(point["rates"][name] for point in points if point["rates"])]
        if max(there) - min(there) > _ONE_RATE * rate:
            raise InputRefused(
                f"order {name}: {min(there):.4g} to {max(there):.4g} Hz per unit speed of {coordinate} at "
                "the poses of the map and of the file: one is needed: vary less about the file's pose"
            )
    places = np.meshgrid(*(axis.values[0] for axis in axes), indexing="ij")[0].ravel()
    branches = tuple(_branches(points))
    met = (
        _zone((order, rates_of[order.name]), branch, places, (low, high), margin)
        for order in orders
        for branch in branches
    )
    zones = sorted(
        (zone for zone in met if zone), key=lambda zone: (-round(zone.weight, 9), float(f"{zone.low:.9g}"))
    )
    return Campbell(
        key=axes[0].keys[0],
        places=places,
        coordinate=coordinate,
        low=low,
        high=high,
        margin=margin,
        orders=rates_of,
        covered=covered,
        certified=all(point["certified"] for point in points),
        branches=branches,
        zones=tuple(zones),
    )


def _modes_and_rates(
    drive: Machine, found: Modes | None, below: float, *, orders: Sequence[Order], coordinate: str
) -> dict[str, Any]:
    """Distinct modes of a point, and the frequency per unit speed of every order where it has some."""
    known = () if found is None else orders
    rates_of = {order.name: frequency_per_speed(drive, order, coordinate) for order in known}
    return distinct(drive, found, below) | {"rates": rates_of}


def _branches(points: Sequence[dict[str, Any]]) -> Iterator[Branch]:
    """Modes joined from point to point by number or order; infinite where beyond what was searched."""
    listed_at: list[list[Mode]] = [point["modes"] for point in points]
    groups: dict[tuple[str, str], int] = {}
    for modes in listed_at:
        for label, number in Counter((mode.kind, mode.group) for mode in modes).items():
            groups[label] = max(groups.get(label, 0), number)
    for (kind, group), number in sorted(groups.items()):
        own = [[m for m in modes if (m.kind, m.group) == (kind, group)] for modes in listed_at]
        for n in range(number):
            listed = [modes[n] if n < len(modes) else None for modes in own]
            hertz = np.array(
                [np.nan if point["reason"] else mode.hertz if mode else np.inf
                 for point, mode in zip(points, listed, strict=True)]
            )  # fmt: skip
            found = [mode for mode in listed if mode is not None]
            heaviest = max(found, key=lambda mode: round(mode.share, 9))  # of equal ones the first
            name = f"{group}, mode {n + 1}" if kind == "transverse" else f"{heaviest.name} ({n + 1})"
            weight = 1.0 / (n + 1) if kind == "transverse" else heaviest.share
            yield Branch(kind=kind, name=name, hertz=hertz, weight=weight)


def _zone(
    excited: tuple[Order, float], branch: Branch, places: Array, speed: tuple[float, float], margin: float
) -> Zone | None:
    """Critical speeds and their places of an order, with its frequency per speed, and a mode on the map."""
    (order, rate), (low, high) = excited, speed
    known = ~np.isnan(branch.hertz)
    critical, where = branch.hertz[known] / rate, places[known]
    first, last = critical.min() * (1.0 - margin), critical.max() * (1.0 + margin)
    if first > high or last < low:
        return None
    near = (critical * (1.0 - margin) <= high) & (critical * (1.0 + margin) >= low)
    spread = where[near] if near.any() else where  # it passes the range between two points
    return Zone(
        order=order.name,
        mode=branch.name,
        kind=branch.kind,
        low=float(max(first, low)),
        high=float(min(last, high)),
        place_low=float(spread.min()),
        place_high=float(spread.max()),
        weight=branch.weight / max(order.number, 1.0),
    )


ROOM = 0.08
"""Share of the possible travel that is kept clear at each end."""
LEAST_RATE = 1e-6
PLACES = 9
SLIDES = ("x", "y")

Travel = dict[tuple[str, ...], NDArray[np.float64]]


def travels(drive: Machine) -> Iterator[Travel]:
    """Places along each motion without strain in which bodies slide, rows by keys that move together [m]."""
    done, bodies = set[str](), {body.name: body for body in drive.body}
    for body in drive.body:
        for move in body.moves:
            key = f"{body.name}.{move}"
            if move not in SLIDES or key in done:
                continue
            try:
                moving = rates(drive, key)
            except InputRefused:  # a spring or a rope holds it: it does not travel
                continue
            slides = [f"{own.name}.{way}" for own in drive.body for way in own.moves if way in SLIDES]
            linked = {name: moving[name] for name in slides if abs(moving.get(name, 0.0)) > LEAST_RATE}
            done |= set(linked)
            low, high = _reach(drive, linked)
            if high > low:
                steps = np.linspace(low, high, PLACES)
                names = (key, *(name for name in linked if name != key))
                starts = [bodies[name.rpartition(".")[0]].at[SLIDES.index(name[-1])] for name in names]
                rows = [
                    at + linked[name] / linked[key] * steps for name, at in zip(names, starts, strict=True)
                ]
                yield {names: np.array(rows)}


def _reach(drive: Machine, linked: dict[str, float]) -> tuple[float, float]:
    """Travel of the first body from where it is, down and up [m], with all that moves inside the box."""
    every = np.array([pulley.at for pulley in drive.pulley] + [anchor.at for anchor in drive.anchor])
    box = every.min(axis=0), every.max(axis=0)
    low, high, stated = -np.inf, np.inf, (-np.inf, np.inf)
    bodies = {body.name: body for body in drive.body}
    for key, rate in linked.items():
        name, _, move = key.rpartition(".")
        axis, travel = SLIDES.index(move), bodies[name].travel
        carried = {name}
        while more := {own.name for own in drive.body if own.on in carried} - carried:
            carried |= more
        points = [own.at for own in drive.body if own.name in carried]
        points += [own.at for own in (*drive.pulley, *drive.anchor) if own.on in carried]
        at = np.array([point[axis] for point in points])
        ends = sorted(((box[0][axis] - at.min()) / rate, (box[1][axis] - at.max()) / rate))
        low, high = max(low, ends[0]), min(high, ends[1])
        if travel is not None:  # ways of the first body to the ends of a body's stated travel
            ends = sorted((end - bodies[name].at[axis]) / rate for end in travel)
            stated = max(stated[0], ends[0]), min(stated[1], ends[1])
    if np.isfinite(stated).all():
        return float(stated[0]), float(stated[1])
    room = ROOM * max(high - low, 0.0)
    return low + room, high - room
