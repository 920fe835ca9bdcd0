r"""A machine with routes whose body is held between two motors, a line from each, as numbers.

Lines are springs without mass; idlers turn with their drums. What that leaves out is in `ASSUMED`. With the
body's coordinates q and the drums' angles :math:`\theta_i` (positive: winding in) the tension is

.. math:: T_i = c_i\,e_i, \qquad e_i = L_i(q) + r_i\theta_i - s_i, \qquad c_i = \frac{EA_i}{\ell_i(q)},

:math:`L_i` the length of line i from its drum to the body, arcs included, :math:`\ell_i` its free part.
"""

from dataclasses import dataclass
from itertools import product
from math import atan2, pi, sqrt
from typing import Any, NamedTuple, TypeGuard

import numpy as np

from cabledrive.mechanics.compiled import njit
from cabledrive.mechanics.network.motion import gravity
from cabledrive.mechanics.network.statics import Statics, statics_of
from cabledrive.parameters import InputRefused, Machine
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.route.drive import body_number
from cabledrive.parameters.route.parts import Body


class TwoMotors(NamedTuple):
    """Numbers of a machine with m coordinates and two motors, in SI; rows by motor."""

    mass: Array  # (m,): of each coordinate [kg]
    force: Array  # (m,): weight and loads [N]
    viscous: Array  # (m,)
    coulomb: Array  # (m,)
    frame: Array  # (2, m): motion of the anchors in x and y
    centre: Array  # (2, 2): of the last pulley before the body [m]
    radius: Array  # (2,): of that pulley, with the sense of the cable as its sign [m]
    anchor: Array  # (2, 2): where each line ends at q = 0 [m]
    bearing: Array  # (2, 2): unit vector along each line at q = 0
    fixed: Array  # (2,): free length before the last pulley [m]
    unwound: Array  # (2,): s at theta = 0 [m]
    rigidity: Array  # (2,): EA [N]
    loss: Array  # (2,): axial damping [N s]
    drum: Array  # (2,): radius [m]
    inertia: Array  # (2,): of the drum and all that turns with it [kg m^2]
    turning_viscous: Array  # (2,)
    turning_coulomb: Array  # (2,)
    limit: Array  # (2,): of the torque [N m]


@njit
def line_at(m: TwoMotors, i: int, q: Array, along: Array) -> tuple[float, float, float]:
    """Length of line i less that at q = 0, its free length, that of its last span [m]; along takes dL/dq."""
    x, y = m.anchor[i, 0] - m.centre[i, 0], m.anchor[i, 1] - m.centre[i, 1]
    before = sqrt(x * x + y * y - m.radius[i] ** 2)
    for j in range(q.size):
        x += m.frame[0, j] * q[j]
        y += m.frame[1, j] * q[j]
    squared = x * x + y * y
    span = sqrt(squared - m.radius[i] ** 2)
    # Unit vector of the tangent: turned from the line of centres by the angle whose sine is radius/distance.
    tx = (span * x - m.radius[i] * y) / squared
    ty = (span * y + m.radius[i] * x) / squared
    ax, ay = m.bearing[i, 0], m.bearing[i, 1]
    turned = atan2(ax * ty - ay * tx, ax * tx + ay * ty)  # both ways up to half a turn
    for j in range(q.size):
        along[j] = tx * m.frame[0, j] + ty * m.frame[1, j]
    return span - before + m.radius[i] * turned, m.fixed[i] + span, span


@njit
def pulled(stretch: float, speed: float, stiffness: float, loss: float) -> float:
    """Tension of a line that only pulls [N]; ``speed``: at which it is stretched [m/s]."""
    return max(stiffness * stretch + loss * speed, 0.0) if stretch > 0.0 else 0.0


ASSUMED = (
    "lines are straight springs without mass or transverse vibration",
    "idlers turn with their drums without slip",
    "the body moves without turning about its anchors",
)


@dataclass(frozen=True, kw_only=True, eq=False)
class TwoMotorMachine:
    """A body between two motors."""

    drive: Machine
    numbers: TwoMotors
    names: tuple[str, ...]  # coordinates of the body, such as "camera.x"
    lines: tuple[str, ...]  # of each motor: its line
    spans: tuple[tuple[str, ...], ...]  # free spans of each line
    motors: tuple[str, ...]  # pulleys that the motors turn
    tension: Array  # (2,): at rest [N]
    left_out: float  # lowest neglected frequency along a line: idlers against spans, waves [rad/s]


def is_winched(drive: Any) -> TypeGuard[Machine]:
    """Whether two motors each wind one end of a line whose other end is clamped to a body."""
    if len(drive.motors) != 2 or len(drive.route) != 2:
        return False
    ends = [_ends(drive, number) for number in range(2)]
    return all(drum in drive.driven and anchor is not None for drum, anchor in ends)


def _ends(drive: Machine, number: int) -> tuple[int | None, int | None]:
    """Pulley at one end of a route and anchor at the other."""
    places = drive.places[number]
    if places[0].pulley is None:
        places = places[::-1]
    return places[0].pulley, places[-1].anchor


def winched_machine(drive: Machine) -> TwoMotorMachine:
    """The numbers of a body on two winches; a machine that has what they cannot hold is refused."""
    body = _checked_body(drive)
    statics, moves = statics_of(drive), body.moves
    order = sorted(range(2), key=lambda number: drive.driven.index(_ends(drive, number)[0]))
    lines = [_line(drive, number, motor, statics) for motor, number in enumerate(order)]
    by_line = {name: np.array([line[name] for line in lines], dtype=np.float64) for name in lines[0]}
    frame = np.array([[1.0 if move == axis else 0.0 for move in moves] for axis in ("x", "y")])
    # Half of each last span rides with the body, as a rope shares its weight between its ends.
    mass = body.mass + sum(0.5 * line["rope_mass"] for line in lines)
    weight = frame.T @ (mass * gravity(drive) + np.array(body.load))
    along = by_line["bearing"] @ frame
    # Ropes have weight in statics and none here: the nearest tensions that hold the body.
    rest = by_line["rest"]
    rest = rest + np.linalg.lstsq(along.T, weight - along.T @ rest, rcond=None)[0]
    free = by_line["fixed"] + by_line["last"]
    n = len(moves)
    numbers = TwoMotors(
        mass=np.full(n, mass),
        force=np.asarray(weight, dtype=np.float64),
        viscous=np.full(n, body.damping),
        coulomb=np.full(n, body.coulomb_friction),
        frame=frame,
        unwound=-rest * free / by_line["rigidity"],
        limit=np.array([np.inf if m.torque_limit is None else m.torque_limit for m in drive.motor]),
        **{name: values for name, values in by_line.items() if name in TwoMotors._fields},
    )
    return TwoMotorMachine(
        drive=drive,
        numbers=numbers,
        names=tuple(f"{body.name}.{move}" for move in moves),
        lines=tuple(drive.route[number].name for number in order),
        spans=tuple(tuple(s.name for s in drive.free_spans if s.route == number) for number in order),
        motors=tuple(drive.pulley[number].name for number in drive.driven),
        tension=rest,
        left_out=float(by_line["left_out"].min()),
    )


def _checked_body(drive: Machine) -> Body:
    """The one body that both lines end at; refused: what these numbers cannot hold."""
    anchors = [drive.anchor[_ends(drive, number)[1] or 0] for number in range(2)]
    bodies = {body_number(drive, anchor.on, anchor.name) for anchor in anchors}
    if len(bodies) > 1 or None in bodies:
        raise InputRefused("both lines must end at one body: put both anchors on it (anchor.on)")
    if len(drive.body) > 1:
        raise InputRefused(f"{len(drive.body)} bodies: a law of two winches moves one, carried by nothing")
    body = drive.body[0]
    if "turn" in body.moves:
        raise InputRefused(f'{body.name}: moves = "turn" is not moved by two winches: take x, y or both')
    if body.stiffness:
        raise InputRefused(f"{body.name}.stiffness: a spring holds the body as well: set it to 0")
    if body.mass <= 0.0:
        raise InputRefused(f"{body.name}.mass = {body.mass:.4g} kg: two winches move a mass: give it")
    absent = {"joint_stiffness": None, "holding_stiffness": None, "backlash": 0.0, "offset_torque": 0.0}
    for motor, (key, without) in product(drive.motor, absent.items()):
        value = getattr(motor, key)
        if value != without:
            said = f'motor "{motor.pulley}": {key} = {value:.4g} is not part of the model of two winches'
            raise InputRefused(f"{said}: leave it out")
    if drive.carriage:
        raise InputRefused("carriage: lines of winches carry no carriages here: make it a body")
    if any(route.closed or route.speed for route in drive.route):
        raise InputRefused("route: lines of winches are open and at rest: leave closed and speed out")
    for pulley in drive.pulley:
        if pulley.fixed or pulley.on:
            said = f'pulley "{pulley.name}" is {"fixed" if pulley.fixed else "on a body"}'
            raise InputRefused(f"{said}: lines of winches run over pulleys that turn on the frame")
    return body


def _line(drive: Machine, number: int, motor: int, statics: Statics) -> dict[str, Any]:
    """One line from its drum to the body."""
    route, rope = drive.route[number], drive.ropes[number]
    spans = [(i, span) for i, span in enumerate(drive.free_spans) if span.route == number]
    places, sense = list(drive.places[number]), 1
    if places[0].pulley is None:
        places, spans, sense = places[::-1], spans[::-1], -1
    last, anchor = places[-2], places[-1]
    index, span = spans[-1]
    drum = drive.pulley[drive.driven[motor]]
    own = drive.motor[motor]
    idlers = [drive.pulley[place.pulley] for place in places[1:-1] if place.pulley is not None]
    turning = [(idler, drum.radius / idler.radius) for idler in idlers]
    waves = pi / sum(one.length for _, one in spans) * sqrt(rope.axial_rigidity / rope.density)
    springs = [
        sqrt(route.ropes * rope.axial_rigidity * (1.0 / one.length + 1.0 / two.length) / idler.inertia)
        * idler.radius
        for idler, (_, one), (_, two) in zip(idlers, spans[:-1], spans[1:], strict=True)
        if idler.inertia > 0.0
    ]
    return {
        "left_out": min([waves, *springs]),
        "centre": last.centre,
        "radius": sense * last.sense * last.radius,
        "anchor": anchor.centre,
        "bearing": sense * np.array(span.along),
        "fixed": sum(one.length for _, one in spans[:-1]),
        "last": span.length,
        "rope_mass": route.ropes * rope.density * span.length,
        "rest": route.ropes * statics.mean[index],
        "rigidity": route.ropes * rope.axial_rigidity,
        "loss": route.ropes * rope.axial_damping,
        "drum": drum.radius,
        "inertia": own.inertia + drum.inertia + sum(p.inertia * ratio**2 for p, ratio in turning),
        "turning_viscous": own.viscous_friction
        + drum.viscous_friction
        + sum(p.viscous_friction * ratio**2 for p, ratio in turning),
        "turning_coulomb": own.coulomb_friction
        + drum.coulomb_friction
        + sum(p.coulomb_friction * ratio for p, ratio in turning),
    }
