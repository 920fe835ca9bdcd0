r"""The one model of a machine for its modes: coordinates, and the waves, ropes, masses and springs they move.

A loop or line about its state of rest, a machine with routes, and a chain that is built in Python are
constructors of it.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import inf, pi, sqrt
from typing import Any

from cabledrive.mechanics.chain import HOLDING_SPRING, LabelledChain
from cabledrive.mechanics.holding import (
    DRIVE_PULLEY,
    LOAD_PULLEY,
    PULLEYS,
    held_joints,
)
from cabledrive.mechanics.network.rest_forces import RestingStretch
from cabledrive.mechanics.rest import RestingSection, rest_state
from cabledrive.mechanics.spans import longitudinal_chains
from cabledrive.modal.component import Component, Fixed
from cabledrive.modal.elements import ACROSS, ALONG, OUT, Rope, Row, Wave
from cabledrive.modal.pieces import End, parts_of_piece, straight_above
from cabledrive.modal.rows import MASS, SPRING
from cabledrive.parameters import Drive, NotComputed


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
    joint; ``rims``: the two pulleys after whose motion longitudinal modes are named; ``slack``: sections that
    hang slack, and have no modes across.
    """

    names: tuple[str, ...]
    pieces: tuple[PieceOfSpan, ...]
    waves: tuple[Wave, ...]
    ropes: tuple[Rope, ...]
    fixed: tuple[Fixed, ...]
    rims: tuple[str, ...] = ()
    by_span: bool = False
    slack: tuple[RestingSection, ...] = ()

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


def network_of_drive(
    drive: Drive,
    *,
    motor: str | None = None,
    hold: Sequence[str] = (),
    at_torque: float = 0.0,
    taut: bool = False,
) -> ModalNetwork:
    """A loop or line about its state of rest; ``taut``: what moves along it, without weights."""
    index: dict[str, int] = {}
    fixed: list[Fixed] = []
    for along in map(network_of_chain, longitudinal_chains(drive, motor=motor, hold=hold)):
        place = [index.setdefault(name, len(index)) for name in along.names]
        fixed += [own._replace(row=tuple((place[c], v) for c, v in own.row)) for own in along.fixed]
    held = held_joints(drive, hold)
    bending = drive.cable.bending_stiffness or 0.0
    radii = {name: own.radius for name, own in zip(PULLEYS, drive.pulley, strict=True)}

    def row(name: str, way: str = ALONG) -> Row:
        """How a joint moves in one direction."""
        if way != ALONG:
            index.setdefault(name := f"{name} {way}", len(index))
        return ((index[name], 1.0),) if name in index else ()

    sections: tuple[RestingSection, ...] = ()
    if not taut and (drive.layout.gravity or at_torque):
        rest = rest_state(drive, at_torque=at_torque)
        sections = rest.sections
        if rest.lowest_tension <= 0.0 and not drive.layout.gravity:
            raise NotComputed(slack_line(next(own for own in sections if own.lowest_tension <= 0.0)))
    at_rest = {(one.span, one.start): (one, own) for own in sections for one in own.stretches}
    cable = drive.cable
    edges = {
        id(own): straight_above(own.stretches, cable.mass_per_length)
        for own in sections
        if own.lowest_tension > 0.0
    }
    numbers = {id(own): number for number, own in enumerate(drive.carriage)}
    pieces: list[PieceOfSpan] = []
    parts: list[Wave | Rope] = []
    for span in drive.spans:
        joints: list[tuple[float, str, bool]] = [
            (own.position, f"carriage {numbers[id(own)]}", own.guided) for own in drive.carriages_on(span)
        ]
        ends = (DRIVE_PULLEY, LOAD_PULLEY) if span == "upper" else (LOAD_PULLEY, DRIVE_PULLEY)
        joints = [(0.0, ends[0], True), *joints, (drive.span_length, ends[1], True)]
        still = [guided or name in held for _, name, guided in joints]  # across
        bounds = [at for (at, _, _), own in zip(joints, still, strict=True) if own]
        free = [(name, not own and not taut) for (_, name, _), own in zip(joints, still, strict=True)]
        ways, bends = (ACROSS, OUT), bending > 0.0
        rows = [[row(name), *(row(name, way) if own else () for way in ways)] for name, own in free]
        slopes = [[row(f"{name} slope", way) if own and bends else () for way in ways] for name, own in free]
        for i, ((start, near, _), (end, far, _)) in enumerate(pairwise(joints)):
            section = max(b for b in bounds if b <= start), min(b for b in bounds if b >= end)
            stretch, hung = at_rest.get((span, start)) or (
                RestingStretch(
                    span=span,
                    start=start,
                    end=end,
                    force=(cable.pretension, 0.0),
                    load=(0.0, 0.0),
                    axial_rigidity=cable.axial_rigidity,
                ),
                None,
            )
            rope = cable.mass_per_length, bending, 1
            across = not taut and (hung is None or hung.lowest_tension > 0.0)
            first, last = (
                End(
                    rows[k],
                    slopes[k],
                    min(sqrt(bending / tension), 0.5 * pi * radii.get(name, 0.0)) if across else 0.0,
                    radii.get(name, 0.0),
                )
                for k, name, tension in zip((i, i + 1), (near, far), stretch.tensions, strict=True)
            )
            own = parts_of_piece(len(pieces), stretch, rope, first, last, edges.get(id(hung), 0.0))
            parts += own if across else own[1:2]
            pieces.append(PieceOfSpan(span, start, end, section, (near, far)))
    for number, carriage in enumerate(drive.carriage):
        names = (f"carriage {number} {way}" for way in (ACROSS, OUT))
        fixed += [Fixed(MASS, carriage.mass, ((index[name], 1.0),)) for name in names if name in index]
    return ModalNetwork(
        names=tuple(index),
        pieces=tuple(pieces),
        waves=tuple(part for part in parts if isinstance(part, Wave)),
        ropes=tuple(part for part in parts if isinstance(part, Rope)),
        fixed=tuple(own for own in fixed if own.factor > 0.0 and own.row),
        rims=PULLEYS,
        slack=tuple(own for own in sections if own.lowest_tension <= 0.0),
    )


def slack_line(section: RestingSection) -> str:
    """That a section of a loop or line hangs slack."""
    return (
        f"the {section.span} span hangs slack at rest between {section.start:.4g} m and {section.end:.4g} m, "
        f"lowest tension {section.lowest_tension:.4g} N: raise cable.pretension"
    )
