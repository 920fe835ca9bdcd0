"""Slopes of a mode along the spans of a machine with routes, and how modes couple through them."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.network.assembly import Network
from cabledrive.modal import Mode

Array = NDArray[np.float64]

WAYS = {"w": "across", "v": "out of plane"}
"""Direction of a transverse plane."""


class Slopes(NamedTuple):
    """Slopes of a mode at the points of every piece it moves, by number of the piece."""

    mode: Mode
    by_piece: dict[int, Array]


def slopes_of(network: Network, mode: Mode, way: str, nodes: Array, slope: Array) -> dict[int, Array]:
    """Slopes of a mode of unit modal mass on the pieces that it moves."""
    motion, found = mode._motion, {}
    for number, piece in enumerate(network.pieces):
        name = network.drive.free_spans[piece.span].name
        x = piece.start + nodes * piece.length
        values = motion.displacement(name, way, x)[0].real
        if values.any():
            found[number] = slope @ values / piece.length
    return found


def coupling_by_span(network: Network, q: Slopes, a: Slopes, b: Slopes, weights: Array) -> dict[int, float]:
    """Coupling of two transverse modes by a longitudinal one, by span."""
    shares: dict[int, float] = {}
    for number in set(q.by_piece) & set(a.by_piece) & set(b.by_piece):
        piece = network.pieces[number]
        route = network.drive.free_spans[piece.span].route
        product = q.by_piece[number] * a.by_piece[number] * b.by_piece[number]
        # Of ropes side by side a mode between held ends moves one; a mode with a body moves all alike.
        ropes = 1 if a.mode.clamped or b.mode.clamped else network.drive.route[route].ropes
        value = network.drive.ropes[route].axial_rigidity * ropes * piece.length * float(weights @ product)
        shares[piece.span] = shares.get(piece.span, 0.0) + value
    return shares


def transverse_loss(network: Network, own: Slopes) -> float:
    """Damping rate of a transverse mode [1/s]: that of the ropes that move, by their strain energy."""
    shares = {
        number: float(np.sum(values**2)) * network.pieces[number].length
        for number, values in own.by_piece.items()
    }
    total = sum(shares.values())
    drive = network.drive
    rates = {
        number: drive.ropes[drive.free_spans[network.pieces[number].span].route].transverse_damping
        for number in shares
    }
    return sum(rates[number] * share for number, share in shares.items()) / total
