r"""The one model of a machine for its modes: coordinates, and the waves, ropes, masses and springs they move.

A loop or line about its state of rest, a machine with routes, and a chain that is built in Python are
constructors of it.
"""

from dataclasses import dataclass, field, replace
from math import inf
from typing import Any

from cabledrive.mechanics.chain import HOLDING_SPRING, LabelledChain
from cabledrive.mechanics.holding import PULLEYS
from cabledrive.modal.component import Component, Fixed
from cabledrive.modal.elements import ALONG, Rope, Row, Wave
from cabledrive.modal.rows import MASS, SPRING


@dataclass(frozen=True)
class PieceOfSpan:
    """Rope between two neighbouring joints; ``section``: places between which it is held across."""

    span: str
    start: float
    end: float
    section: tuple[float, float]
    joints: tuple[str, str] = ("", "")


@dataclass(frozen=True, eq=False)
class ModalNetwork:
    """Coordinates by name, and what moves with them.

    ``by_span``: modes are named by span and coordinate, as of a machine with routes, and not by section and
    joint; ``rims``: the two pulleys after whose motion longitudinal modes are named; ``units``: what
    a turn of one moves, of all that turns, by name [m/rad]; ``slack``: a sentence each on sections without
    modes across.
    """

    names: tuple[str, ...]
    pieces: tuple[PieceOfSpan, ...]
    waves: tuple[Wave, ...]
    ropes: tuple[Rope, ...]
    fixed: tuple[Fixed, ...]
    rims: tuple[str, ...] = ()
    units: dict[str, float] = field(default_factory=dict)
    by_span: bool = False
    slack: tuple[str, ...] = ()

    @property
    def edges(self) -> list[float]:
        """Frequencies above which ropes that sag are straight, ascending [rad/s]."""
        return sorted({rope.edge for rope in self.ropes if rope.edge < inf})

    def straight_above(self, edge: float) -> "ModalNetwork":
        """The network above one of its edges."""
        waves, ropes = list(self.waves), list[Rope]()
        for rope in self.ropes:
            for part in rope.straight if rope.edge <= edge else (rope,):
                if isinstance(part, Wave):
                    waves.append(part)
                else:
                    ropes.append(part)
        return replace(self, waves=tuple(waves), ropes=tuple(ropes))

    def components(self) -> tuple[list[Component], list[tuple[Component, int]]]:
        """Parts that nothing ties to each other; ropes between ends at rest, how many have their modes."""
        parts: list[Wave | Rope | Fixed] = [*self.waves, *self.ropes, *self.fixed]
        root = list(range(len(self.names)))

        def find(c: int) -> int:
            while root[c] != c:
                root[c] = root[root[c]]
                c = root[c]
            return c

        columns = [sorted({c for row in part.rows for c, v in row if v}) for part in parts]
        for own in columns:
            for c in own[1:]:
                root[find(c)] = find(own[0])
        named: dict[int, list[int]] = {}
        for c in range(len(self.names)):
            named.setdefault(find(c), []).append(c)
        content: dict[int, list[Wave | Rope | Fixed]] = {key: [] for key in named}
        held: list[tuple[Component, int]] = []
        for part, own in zip(parts, columns, strict=True):
            if own:
                content[find(own[0])].append(part)
            if not isinstance(part, Fixed) and part.ropes > bool(own):
                none: Any = () if isinstance(part, Wave) else ((),) * len(part.start)
                alone = replace(part, start=none, end=none, ropes=1)
                held.append((Component((), [alone]), part.ropes - bool(own)))
        return [Component(own, content[key]) for key, own in named.items()], held


def network_of_chain(labelled: LabelledChain, way: str = ALONG) -> ModalNetwork:
    """A chain as a network of one direction."""
    chain = labelled.chain
    held = {0: chain.fixed[0], chain.masses.size - 1: chain.fixed[1]}
    joints = [i for i in range(chain.masses.size) if chain.closed or not held.get(i)]
    pendants = range(chain.masses.size, chain.masses.size + len(chain.pendants))
    index = {joint: number for number, joint in enumerate([*joints, *pendants])}

    def row(joint: int) -> Row:
        return ((index[joint], 1.0),) if joint in index else ()

    fixed = [Fixed(MASS, float(m), row(i)) for i, m in enumerate(chain.masses)]
    ground = labelled.ground or HOLDING_SPRING
    fixed += [Fixed(SPRING, float(k), row(i), ground) for i, k in enumerate(chain.ground_springs)]
    for number, name, pendant in zip(pendants, labelled.pendant_springs, chain.pendants, strict=False):
        strain = (*row(number), *((c, -v) for c, v in row(pendant.joint)))
        fixed.append(Fixed(MASS, pendant.mass, row(number)))
        fixed.append(Fixed(SPRING, pendant.stiffness, strain, name))
        fixed.append(Fixed(SPRING, pendant.ground, row(number), ground))
    ends = [(row(i), row((i + 1) % chain.masses.size)) for i in range(chain.lengths.size)]
    waves = [
        Wave(start, end, float(z), float(time), (i, way))
        for i, ((start, end), z, time) in enumerate(
            zip(ends, chain.impedances, chain.travel_times, strict=True)
        )
    ]
    where, joints_in_all = labelled.stretches, chain.masses.size
    whole = (where[0].start, where[-1].end)
    return ModalNetwork(
        names=tuple(labelled.joints[joint] for joint in index),
        pieces=tuple(
            PieceOfSpan(
                own.span, own.start, own.end, whole, (first, labelled.joints[(i + 1) % joints_in_all])
            )
            for i, (own, first) in enumerate(zip(where, labelled.joints, strict=False))
        ),
        waves=tuple(waves),
        ropes=(),
        fixed=tuple(own for own in fixed if own.factor > 0.0 and own.row),
        rims=tuple(name for name in PULLEYS if name in labelled.joints),
    )
