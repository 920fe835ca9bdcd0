"""The way of a machine along a planned move: poses, and the turns of the motors that lead through them."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.network import Network, network_of
from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.fields import nearest
from cabledrive.parameters.route import RoutedDrive, moved

POSES = 25
_SMALL = 1e-7


@dataclass(frozen=True, kw_only=True, eq=False)
class Way:
    """Poses over the part of a move that is done, from 0 to 1."""

    part: Array  # (poses,)
    places: Array  # (poses, n): coordinates from the pose of the file, without strain beyond that at rest
    shortest: Array  # (spans,): least free length of each span [m]
    networks: list[Network]  # the machine at a few poses, first and last among them

    def turns(self, part: Array, coordinate: int) -> Array:
        """Turn of a rotor where parts of the move are done, shape (p,) [rad]."""
        from scipy.interpolate import CubicSpline  # here, for asking for help does not need it

        return np.asarray(CubicSpline(self.part, self.places[:, coordinate])(part), dtype=np.float64)


def way_of(drive: RoutedDrive, moves: Mapping[str, float]) -> Way:
    """Poses through which bodies go by their distances [m]; other bodies follow or keep their places.

    Raises `InputRefused` if the machine cannot be in one of them, or moves do not go together.
    """
    network = network_of(drive, motor="free")
    names = network.motion.names
    slides = [f"{body.name}.{move}" for body in drive.body for move in body.moves if move != "turn"]
    for name, distance in moves.items():
        if name not in slides:
            raise InputRefused(f'move: "{name[:60]}" slides no body{nearest(name[:60], slides)}')
        if not np.isfinite(distance):
            raise InputRefused(f"move {name} = {distance} m must be finite: give a distance")
    if not any(moves.values()):
        raise InputRefused("move: no body moves: give a distance, such as car.y=10m")
    places, networks = [np.zeros(len(names))], [network]
    part = np.linspace(0.0, 1.0, POSES)
    for step in np.diff(part):  # second order: rates at the middle of each step
        half = places[-1] + 0.5 * step * _rates(networks[-1], moves, slides)
        middle = _posed(drive, half, names, slides)
        places.append(places[-1] + step * _rates(middle, moves, slides))
        networks.append(_posed(drive, places[-1], names, slides))
    lengths = np.array([[span.length for span in one.drive.free_spans] for one in networks])
    return Way(
        part=part, places=np.array(places), shortest=lengths.min(axis=0), networks=networks[:: POSES // 4]
    )


def _posed(drive: RoutedDrive, place: Array, names: tuple[str, ...], slides: list[str]) -> Network:
    """The machine with its bodies at a place."""
    at = {f"{body.name}.{axis}": body.at["xy".index(axis)] for body in drive.body for axis in "xy"}
    pose = {name: at[name] + float(place[names.index(name)]) for name in slides}
    try:
        return network_of(moved(drive, pose), motor="free")
    except InputRefused as refusal:
        raise InputRefused(f"move: {refusal}") from None


def _rates(network: Network, moves: Mapping[str, float], slides: list[str]) -> Array:
    """Rates of all coordinates where bodies move and neither a rope nor a spring is strained."""
    names = network.motion.names
    along = network.direction == 0
    strained = np.vstack([network.start[along] - network.end[along], network.spring_rows])
    _, sizes, rows = np.linalg.svd(strained)
    rank = int(np.sum(sizes > _SMALL * sizes[0]))
    free = rows[rank:].T  # motions that strain nothing, shape (n, m)
    wanted: list[tuple[Array, float]] = []
    for name in (*moves, *(name for name in slides if name not in moves)):
        row, value = free[names.index(name)], moves.get(name, 0.0)
        known = np.array([other for other, _ in wanted]).reshape(-1, free.shape[1])
        share, *_ = np.linalg.lstsq(known.T, row, rcond=None) if len(known) else (np.zeros(0),)
        if np.linalg.norm(row - known.T @ share) > _SMALL:
            wanted.append((row, value))
        elif name in moves and abs(share @ np.array([v for _, v in wanted]) - value) > _SMALL * abs(value):
            raise InputRefused(
                f"move: {name} cannot go {value:.6g} m without straining a rope or a spring: leave it out, "
                "as it follows the others, or give the distance that they leave it"
            )
    matrix, values = np.array([row for row, _ in wanted]), np.array([value for _, value in wanted])
    share, *_ = np.linalg.lstsq(matrix, values, rcond=None)
    return np.asarray(free @ share)
