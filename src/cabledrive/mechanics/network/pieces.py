"""Free spans cut at the carriages that are clamped to them."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from cabledrive.mechanics.network.motion import ACROSS, ALONG, OUT_OF_PLANE, Motion
from cabledrive.mechanics.network.sections import gravity
from cabledrive.mechanics.network.statics import Statics
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.errors import InputRefused


@dataclass(frozen=True, eq=False, kw_only=True)
class Piece:
    """A length of rope between two neighbouring joints of a span."""

    span: int  # number of the free span
    start: float  # pretensioned, from the start of the span [m]
    end: float  # the same [m]
    start_tension: float  # of one rope [N]
    end_tension: float  # of one rope [N]
    rows: dict[str, tuple[Array, Array]]  # motion of its start and its end by direction, each shape (n,)

    @property
    def length(self) -> float:
        """Length under tension [m]."""
        return self.end - self.start


def pieces_of(motion: Motion, statics: Statics) -> list[Piece]:
    """Pieces of all free spans in order; refused: two carriages at one place, a slack piece."""
    drive = motion.drive
    g = gravity(drive)
    found = []
    for number, span in enumerate(drive.free_spans):
        u, w = zip(
            *(motion.end_rows(place, span.along, span.across) for place in (span.start, span.end)),
            strict=True,
        )
        rest = np.zeros(len(motion.names))
        joints = [(0.0, {ALONG: u[0], ACROSS: w[0], OUT_OF_PLANE: rest}, 0.0)]
        own = [(place, i) for i, (at, place) in enumerate(drive.carriage_places) if at == number]
        for place, i in sorted(own):
            name = motion.carriage_name(i)
            rows = {way: motion.unit(f"{name} {way}") for way in (ALONG, ACROSS, OUT_OF_PLANE)}
            joints.append((place, rows, drive.carriage[i].mass * float(g @ np.array(span.along))))
        joints.append((span.length, {ALONG: u[1], ACROSS: w[1], OUT_OF_PLANE: rest}, 0.0))
        tension = float(statics.start[number])
        slope = -float(statics.line_load[number] @ np.array(span.along))
        for (start, near, weight), (end, far, _) in pairwise(joints):
            if end - start <= 1e-9 * span.length:
                raise InputRefused(
                    f"two carriages share a place on span {span.name}: add the masses or move one"
                )
            tension -= weight
            after = tension + slope * (end - start)
            if min(tension, after) <= 0.0:
                raise InputRefused(
                    f"span {span.name}: its tension at rest falls to {min(tension, after):.4g} N: "
                    "raise pretension"
                )
            found.append(
                Piece(
                    span=number,
                    start=start,
                    end=end,
                    start_tension=tension,
                    end_tension=after,
                    rows={way: (near[way], far[way]) for way in (ALONG, ACROSS, OUT_OF_PLANE)},
                )
            )
            tension = after
    return found
