r"""Excitation whose frequency follows the speed, against the natural frequencies of a map: speeds to avoid.

A pulley that turns with the machine shakes it N times a turn (a sheave out of round once, its motor with its
poles), a rail joint once in a length. Where a coordinate moves with speed v, its frequency is
:math:`f = h v`; it meets a mode of frequency :math:`f_n` at the critical speed :math:`f_n/h`.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.network import network_of
from cabledrive.parameters import Drive, InputRefused
from cabledrive.parameters.fields import nearest
from cabledrive.parameters.route import RoutedDrive

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

MARGIN = 0.05
_STRAINED = 1e-2


@dataclass(frozen=True, slots=True, kw_only=True)
class Order:
    """An excitation that follows the motion.

    Attributes
    ----------
    name : str
    pulley : str or None
        It acts ``number`` times a turn of this pulley, or
    number : float
    coordinate : str or None
        once in ``length`` of this coordinate's way.
    length : float
        [m] or [rad].
    """

    name: str
    pulley: str | None = None
    number: float = 1.0
    coordinate: str | None = None
    length: float = 1.0

    def __post_init__(self) -> None:
        for word, value in (("number", self.number), ("length", self.length)):
            if not (np.isfinite(value) and value > 0.0):
                raise InputRefused(f"order {self.name}: {word} = {value:.9g} must be above 0")


@dataclass(frozen=True, slots=True, kw_only=True)
class Zone:
    """Speeds at which an excitation comes near a mode somewhere on the map.

    Attributes
    ----------
    order : str
    kind : {"longitudinal", "transverse"}
    mode : int
        Number of the mode in the map, from 1.
    low, high : float
        Within the asked range, the margin included [m/s] or [rad/s].
    """

    order: str
    kind: str
    mode: int
    low: float
    high: float


def rates(drive: RoutedDrive, coordinate: str) -> dict[str, float]:
    """How fast every coordinate moves where one moves with unit speed and nothing is strained.

    Raises `InputRefused` if the coordinate is unknown, or cannot move without strain.
    """
    network = network_of(drive, motor="free")
    names = network.motion.names
    if coordinate not in names:
        raise InputRefused(f'"{coordinate[:60]}" is no coordinate{nearest(coordinate[:60], names)}')
    stiffness, own = network.static_stiffness, names.index(coordinate)
    others = [i for i in range(len(names)) if i != own]
    rest = -np.linalg.pinv(stiffness[np.ix_(others, others)], rcond=1e-9) @ stiffness[others, own]
    strained = stiffness[own, own] + stiffness[own, others] @ rest
    if abs(strained) > _STRAINED * stiffness[own, own]:
        raise InputRefused(
            f"{coordinate} cannot move without straining a rope or a spring: give the speed of one that can"
        )
    moving = np.insert(rest, own, 1.0)
    return {name: float(rate) for name, rate in zip(names, moving, strict=True)}


def frequency_per_speed(drive: Drive | RoutedDrive, order: Order, coordinate: str) -> float:
    """Frequency of an excitation per unit speed of a coordinate [Hz s/m], [Hz s/rad].

    Raises `InputRefused` if it is not tied to that motion.
    """
    if not isinstance(drive, RoutedDrive):
        raise InputRefused('orders of excitation need a machine of kind "route", whose parts have names')
    found = rates(drive, coordinate)
    part = order.pulley or order.coordinate or ""
    if part not in found:
        raise InputRefused(f'order {order.name}: "{part[:60]}" is no coordinate{nearest(part[:60], found)}')
    turns = order.number / (2 * np.pi) if order.pulley is not None else 1.0 / order.length
    rate = abs(found[part]) * turns
    if rate < 1e-9:
        raise InputRefused(f"order {order.name}: {part} does not move with {coordinate}: choose another part")
    return rate


def with_critical_speeds(
    found: "xr.Dataset", drive: Drive | RoutedDrive, orders: Sequence[Order], coordinate: str
) -> "xr.Dataset":
    """A map with the speed of a coordinate at which each order meets each mode.

    ``found``: of `cabledrive.studies.mode_map.map_modes`.
    Returns it with ``critical_speed_longitudinal`` and ``critical_speed_transverse`` (order, ..., mode) and
    ``hz_per_speed`` (order).
    """
    import xarray as xr

    if not orders:
        raise InputRefused("orders: none is given: name at least one")
    names = [order.name for order in orders]
    if len(set(names)) < len(names):
        raise InputRefused("orders: two have one name: choose another")
    slope = xr.DataArray(
        [frequency_per_speed(drive, order, coordinate) for order in orders], {"order": names}, ["order"]
    )
    speeds = {
        f"critical_speed_{kind}": found[f"{kind}_hz"] / slope for kind in ("longitudinal", "transverse")
    }
    return found.assign({"hz_per_speed": slope, **speeds}).assign_attrs(speed_of=coordinate)


def danger_zones(found: "xr.Dataset", low: float, high: float, margin: float = MARGIN) -> tuple[Zone, ...]:
    """Speeds within a range at which an order comes within a share of a mode's frequency somewhere."""
    if not 0.0 <= low < high:
        raise InputRefused(f"speed from {low:.9g} to {high:.9g}: give two, the larger last, none negative")
    if not 0.0 < margin < 1.0:
        raise InputRefused(f"margin = {margin:.9g} must lie between 0 and 1")
    zones = []
    for kind in ("longitudinal", "transverse"):
        speeds = found[f"critical_speed_{kind}"]
        for order in speeds["order"].values:
            before = np.array([])
            for mode in speeds["mode"].values:
                own = speeds.sel(order=order, mode=mode).values
                own = own[np.isfinite(own)]
                if own.shape == before.shape and np.allclose(own, before, rtol=1e-9):
                    continue  # the same mode once more, by its multiplicity
                before = own
                first, last = own.min(initial=np.inf) * (1 - margin), own.max(initial=-np.inf) * (1 + margin)
                if first <= high and last >= low:
                    zones.append(
                        Zone(
                            order=str(order),
                            kind=kind,
                            mode=int(mode),
                            low=float(max(first, low)),
                            high=float(min(last, high)),
                        )
                    )
    return tuple(sorted(zones, key=lambda zone: (zone.low, zone.high)))


def clear_speeds(zones: Sequence[Zone], low: float, high: float) -> tuple[tuple[float, float], ...]:
    """Parts of a range of speed outside of all zones."""
    clear, reached = [], low
    for zone in sorted(zones, key=lambda own: own.low):
        if zone.low > reached:
            clear.append((reached, zone.low))
        reached = max(reached, zone.high)
    return (*clear, *([(reached, high)] if reached < high else []))
