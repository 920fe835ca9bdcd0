r"""The one model of a machine for its modes: coordinates, and the waves, ropes, masses and springs they move.

A loop or line about its state of rest, a machine with routes, and a chain that is built in Python are
constructors of it.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import ceil, inf, pi, sqrt
from typing import Any

import numpy as np

from cabledrive.mechanics.chain import HOLDING_SPRING, MOTOR_JOINT, LabelledChain
from cabledrive.mechanics.holding import (
    DRIVE_PULLEY,
    HELD,
    HOLDING,
    LOAD_PULLEY,
    PULLEYS,
    held_joints,
    motor_condition,
)
from cabledrive.mechanics.network.rest_forces import PLACES, SHARES, RestingStretch
from cabledrive.mechanics.rest import RestingSection, rest_state
from cabledrive.modal.component import Component, Fixed
from cabledrive.modal.elements import ACROSS, ALONG, OUT, Rope, Row, Wave
from cabledrive.modal.rows import MASS, SPRING, Array
from cabledrive.parameters import Cable, Drive, InputRefused, NotComputed

EVEN = 5e-6
"""Change of the tension along a piece, relative, below which it is even."""

COUPLED = 1e-4
"""Largest relative shift of two modes along and across that meet, by sag above its edge."""

CURVED = 5e-3
"""Largest square of the ring frequency of a curved rope over that of its edge."""


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
    condition, held = motor_condition(drive, motor), set(held_joints(drive, hold))
    held |= {name for name, own in zip(PULLEYS, drive.pulley, strict=True) if own.fixed}
    joint = drive.motor.joint_stiffness if drive.motor is not None else None
    held |= {DRIVE_PULLEY} if condition == HELD and joint is None else set()
    index: dict[str, int] = {}

    def row(name: str, way: str = ALONG) -> Row:
        """How a joint moves in one direction."""
        if name in held or (way != ALONG and name in PULLEYS):
            return ()
        name = name if way == ALONG else f"{name} {way}"
        return ((index.setdefault(name, len(index)), 1.0),)

    rotor, square = drive.motor, drive.drive_pulley.radius**2
    rigid = rotor.inertia / square if rotor is not None and joint is None else 0.0
    shaft = rim = row(DRIVE_PULLEY)
    fixed = [
        Fixed(MASS, drive.drive_pulley.rim_mass + rigid, rim),
        Fixed(MASS, drive.load_pulley.rim_mass, row(LOAD_PULLEY)),
    ]
    if rotor is not None and joint is not None:
        shaft = row("motor") if condition != HELD else ()
        fixed.append(Fixed(SPRING, joint / square, (*shaft, *((c, -v) for c, v in rim)), MOTOR_JOINT))
        fixed.append(Fixed(MASS, rotor.inertia / square, shaft))
    if condition == HOLDING and rotor is not None and rotor.holding_stiffness is not None:
        fixed.append(Fixed(SPRING, rotor.holding_stiffness / square, shaft, HOLDING_SPRING))
    sections: tuple[RestingSection, ...] = ()
    if not taut and (drive.layout.gravity or at_torque):
        rest = rest_state(drive, at_torque=at_torque)
        sections = rest.sections
        if rest.lowest_tension <= 0.0 and not drive.layout.gravity:
            raise NotComputed(slack_line(next(own for own in sections if own.lowest_tension <= 0.0)))
    at_rest = {(own.span, own.start): (own, section) for section in sections for own in section.stretches}
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
        rows = [
            [row(name), *((() if own or taut else row(name, way)) for way in (ACROSS, OUT))]
            for (_, name, _), own in zip(joints, still, strict=True)
        ]
        for i, ((start, near, _), (end, far, _)) in enumerate(pairwise(joints)):
            section = max(b for b in bounds if b <= start), min(b for b in bounds if b >= end)
            own = drive.cable, end - start, rows[i], rows[i + 1], len(pieces)
            parts += _parts_of_piece(own, taut, at_rest.get((span, start)))
            pieces.append(PieceOfSpan(span, start, end, section, (near, far)))
    for number, carriage in enumerate(drive.carriage):
        names = (f"carriage {number}", f"carriage {number} {ACROSS}", f"carriage {number} {OUT}")
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


def _parts_of_piece(
    piece: tuple[Cable, float, list[Row], list[Row], int],
    taut: bool,
    rest: tuple[RestingStretch, RestingSection] | None,
) -> list[Wave | Rope]:
    """One piece (cable, length, rows of its ends, number) in all its directions; ``rest``: where it hangs."""
    cable, length, near, far, number = piece
    ea, rho = cable.axial_rigidity, cable.mass_per_length
    along = Wave(near[0], far[0], sqrt(ea * rho), length / sqrt(ea / rho), (number, ALONG))
    if taut or (rest is not None and rest[1].lowest_tension <= 0.0):
        return [along]
    if rest is None:
        time = length * sqrt(rho / (cable.pretension / (1.0 + cable.prestrain)))
        both = ((1, ACROSS), (2, OUT))
        return [along, *(Wave(near[i], far[i], rho * length / time, time, (number, way)) for i, way in both)]
    stretch, section = rest
    tension = stretch.tension_at(stretch.start + np.linspace(0.0, length, 9))
    time, (hold, direction) = sqrt(rho) * stretch.travel_time, _force_of(stretch)

    def string(i: int, way: str) -> Wave | Rope:
        if np.ptp(tension) <= EVEN * tension.min():
            return Wave(near[i], far[i], rho * length / time, time, (number, way))
        return Rope((near[i],), (far[i],), length, hold, rho, ((number, way),))

    edge = straight_above(section, rho)
    if not edge:
        return [string(2, OUT), along, string(1, ACROSS)]
    hanging = Rope(
        tuple(near[:2]),
        tuple(far[:2]),
        length,
        hold,
        rho,
        ((number, ALONG), (number, ACROSS)),
        direction=direction,
        pull=ea,
        straight=(_curved(along, stretch), string(1, ACROSS)),
        edge=edge,
    )
    return [string(2, OUT), hanging]


def _curved(along: Wave, stretch: RestingStretch) -> Wave:
    """The wave along a stretch that sags, far above its ring frequency."""
    force = stretch.force_at(np.array([stretch.start, stretch.end]))
    turned = np.diff(np.arctan2(force[1], force[0]))[0]
    cosine = force[0] / np.hypot(*force)
    start, end = (
        tuple((c, v * float(one)) for c, v in row)
        for row, one in zip((along.start, along.end), cosine, strict=True)
    )
    return replace(along, start=start, end=end, ring=abs(float(turned)) / along.time)


def _force_of(stretch: RestingStretch) -> tuple[Callable[[Array], Array], Callable[[Array], Any]]:
    """R = T/(1 + T/EA) [N], and cosine and sine of the direction, by the distance from its start."""

    def hold(x: Array) -> Array:
        tension = stretch.tension_at(stretch.start + np.ravel(x)).reshape(np.shape(x))
        return np.asarray(tension / (1.0 + tension / stretch.axial_rigidity))

    def direction(x: Array) -> tuple[Array, Array]:
        along, across = stretch.force_at(stretch.start + np.ravel(x)).reshape(2, *np.shape(x))
        tension = np.hypot(along, across)
        return along / tension, across / tension

    return hold, direction


def sag_parameter(section: RestingSection) -> float:
    r"""Irvine's parameter of a section at rest, for any weights on it: 12 EA/T times the mean of sin^2.

    .. math:: \lambda^2 = \frac{12\,EA}{\bar T}\,\overline{\sin^2\theta}

    A level cable without weights has the usual :math:`(\rho_0 g l/T)^2\,EA/T`.
    """
    square = tension = 0.0
    for stretch in section.stretches:
        along, across = stretch.force_at(stretch.start + stretch.length * PLACES)
        share = stretch.length / (section.end - section.start)
        square += share * float(SHARES @ (across**2 / (along**2 + across**2)))
        tension += share * stretch.mean_tension
    return 12.0 * section.stretches[0].axial_rigidity / tension * square


def straight_above(section: RestingSection, density: float) -> float:
    r"""Frequency above which sag moves no mode of a section by more than `COUPLED` [rad/s]; 0: none at all.

    The n-th wave across and a mode along that meet part by half of :math:`\sqrt 8\,\lambda/(n\pi)^2` of their
    frequency; else waves across move by half the square of this. Of the curvature, which raises modes along
    by half of :math:`(\omega_r/\omega)^2 = \lambda^2/(n\pi)^2`, what waves leave out is the square of this.
    """
    irvine = sag_parameter(section)
    number = max(sqrt(sqrt(8.0 * irvine) / (2.0 * COUPLED)), sqrt(irvine / CURVED)) / pi
    if number < 1.0:
        return 0.0
    time = sqrt(density) * sum(own.travel_time for own in section.stretches)
    return (ceil(number) + 2 * len(section.stretches) - 1.5) * pi / time


def check_torque(at_torque: float) -> None:
    """Refuse a torque that is no number."""
    if not np.isfinite(at_torque):
        raise InputRefused(f"at_torque = {at_torque} N m is not finite: give the steady torque in N m")


def slack_line(section: RestingSection) -> str:
    """That a section of a loop or line hangs slack."""
    return (
        f"the {section.span} span hangs slack at rest between {section.start:.4g} m and {section.end:.4g} m, "
        f"lowest tension {section.lowest_tension:.4g} N: raise cable.pretension"
    )
