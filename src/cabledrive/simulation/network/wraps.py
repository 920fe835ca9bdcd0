"""Where a rope may slide on a pulley or a guide: wraps with a friction coefficient."""

from dataclasses import dataclass
from math import exp

from cabledrive.mechanics.network import Network
from cabledrive.mechanics.network.span_table import follows


@dataclass(frozen=True, slots=True, kw_only=True)
class Wrap:
    r"""A wrap on which the rope slips where :math:`T_1 > T_2 e^{\mu\varphi}`."""

    name: str  # of the pulley
    before: int  # piece of rope that meets it
    behind: int  # piece of rope that leaves it
    factor: float  # e^(mu phi) - 1: largest friction per tension of the slacker side
    ropes: int


def wraps_of(network: Network) -> list[Wrap]:
    """Wraps of all pulleys with a friction coefficient, those at the ends of a route left out."""
    drive, found = network.drive, []
    pieces = [piece.span for piece in network.pieces]
    for number, span in enumerate(drive.free_spans):
        if span.wrap is None or span.end.pulley is None:
            continue
        pulley = drive.pulley[span.end.pulley]
        if pulley.capstan_friction is None:
            continue
        after = next(
            i
            for i, other in enumerate(drive.free_spans)
            if other.route == span.route and follows(drive, number, i)
        )
        found.append(
            Wrap(
                name=pulley.name,
                before=len(pieces) - 1 - pieces[::-1].index(number),
                behind=pieces.index(after),
                factor=exp(pulley.capstan_friction * span.wrap) - 1.0,
                ropes=drive.route[span.route].ropes,
            )
        )
    return found
