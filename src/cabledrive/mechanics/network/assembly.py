r"""The network of a machine: spans, masses, springs, dampers, dry friction, and their rows.

Waves along a span have :math:`R = EA`, waves across it :math:`R = T/(1+\varepsilon)` per unstretched metre.
Of a rope that runs with speed v, per unstretched metre, they have

.. math:: \tau = \frac{c L}{c^2 - v^2}, \qquad \delta = \frac{v L}{c^2 - v^2}, \qquad Z = \sqrt{R\rho},
          \qquad \text{Eq. (N.3)}

travel time, lag and impedance. With damping the waves along a span have :math:`R = EA + i\omega b`, those
across it :math:`\rho (1 - i\Gamma/\omega)` in place of :math:`\rho`; with the impedances and travel times
that follow, Eq. (N.5) is the dynamic stiffness at a complex frequency as well.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.chain import MOTOR_JOINT
from cabledrive.mechanics.holding import HOLDING, motor_condition
from cabledrive.mechanics.network.motion import ACROSS, ALONG, OUT_OF_PLANE, Motion, Row, dense
from cabledrive.mechanics.network.pieces import Piece, pieces_of
from cabledrive.mechanics.network.statics import Statics, geometric_stiffness, statics_of
from cabledrive.parameters import Machine
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.fields import described, meaning
from cabledrive.parameters.route.drive import body_number

DIRECTIONS = (ALONG, ACROSS, OUT_OF_PLANE)


class Parts(NamedTuple):
    """Some parts of one kind: values (k,), the rows by which n coordinates move or strain them, names."""

    values: Array
    rows: tuple[Row, ...]
    names: tuple[str, ...]
    n: int

    @property
    def dense(self) -> Array:
        """Their rows, shape (k, n)."""
        return dense(self.rows, self.n)

    @property
    def matrix(self) -> Array:
        """What they are together, shape (n, n)."""
        total = np.zeros((self.n, self.n))
        for value, row in zip(self.values, self.rows, strict=True):
            for i, factor in row.items():
                for j, other in row.items():
                    total[i, j] += value * factor * other
        return total


@described
@dataclass(frozen=True, eq=False, kw_only=True)
class Network:
    """Waves, masses and springs of a machine in its coordinates."""

    motion: Motion = meaning("its coordinates")
    statics: Statics = meaning("its forces at rest")
    pieces: list[Piece] = meaning("ropes between joints, cut at carriages")
    masses: Parts = meaning("masses [kg] and moments of inertia [kg m^2]")
    springs: Parts = meaning("springs [N/m], [N m/rad]")
    dampers: Parts = meaning("dampers [N s/m], [N m s/rad]; ropes have their own")
    rubs: Parts = meaning("Coulomb friction [N], [N m] of all that rubs, but for ropes on their wraps")

    @property
    def drive(self) -> Machine:
        """The machine."""
        return self.motion.drive

    @cached_property
    def _waves(self) -> Array:
        """Impedance, travel time, lag of each link: along, across, out of plane of each piece, (3, m)."""
        return np.array([waves_of_piece(piece, way) for piece in self.pieces for way in DIRECTIONS]).T

    @property
    def impedance(self) -> Array:
        """Impedance z of one rope of each link, shape (m,) [kg/s]."""
        return np.asarray(self._waves[0])

    @property
    def time(self) -> Array:
        """Travel time of each link, shape (m,) [s]."""
        return np.asarray(self._waves[1])

    @property
    def lag(self) -> Array:
        """Lag of each link of a rope that runs, else 0, shape (m,) [s]."""
        return np.asarray(self._waves[2])

    @property
    def ropes(self) -> NDArray[np.intp]:
        """Parallel ropes of each link, shape (m,)."""
        return np.repeat([piece.route.ropes for piece in self.pieces], 3)

    @cached_property
    def start(self) -> Array:
        """Row of the start of each link, shape (m, n)."""
        return self.motion.dense(*(piece.rows[way][0] for piece in self.pieces for way in DIRECTIONS))

    @cached_property
    def end(self) -> Array:
        """Row of the end of each link, shape (m, n)."""
        return self.motion.dense(*(piece.rows[way][1] for piece in self.pieces for way in DIRECTIONS))

    @cached_property
    def geometric(self) -> Array:
        """Stiffness of turning bodies under the forces at rest, shape (n, n)."""
        return geometric_stiffness(self.motion, self.statics)

    @property
    def turning(self) -> bool:
        """Whether a body turns."""
        return any("turn" in body.moves for body in self.drive.body)

    @cached_property
    def static_stiffness(self) -> Array:
        """Stiffness of every coordinate against every other at rest, shape (n, n)."""
        stretch = self.start - self.end
        link = self.ropes * self.impedance / self.time
        return np.asarray((stretch.T * link) @ stretch + self.springs.matrix + self.geometric)

    @cached_property
    def static_mass(self) -> Array:
        """Mass matrix of slow motions, ropes shared out between their ends, shape (n, n)."""
        rope = self.ropes * self.impedance * self.time / 6.0
        matrix = self.masses.matrix
        for a, b, share in (
            (self.start, self.start, 2.0),
            (self.end, self.end, 2.0),
            (self.start, self.end, 1.0),
        ):
            part = (a.T * (share * rope)) @ b
            matrix = matrix + (part + part.T) / (2.0 if a is b else 1.0)
        return np.asarray(matrix)

    @property
    def sections(self) -> list[list[Piece]]:
        """Pieces in order, parted at the ends of spans and at carriages that are guided."""
        found: list[list[Piece]] = []
        for piece in self.pieces:
            held = piece.start == 0.0 or self.drive.carriage[piece.carriages[0]].guided
            found += [[piece]] if held else []
            found[-1] += [] if held else [piece]
        return found

    @property
    def stretch(self) -> Array:
        """Rows of what each piece is stretched by, shape (pieces, n) [m]."""
        return (self.end - self.start)[::3]

    @property
    def pull(self) -> Array:
        """Tension of one rope of each piece by the coordinates, ropes without mass, (pieces, n) [N/m]."""
        return (self.impedance / self.time)[::3, None] * self.stretch

    @property
    def lowest_tension(self) -> Array:
        """Tension of one rope of each piece at rest at its end where it is lower, shape (pieces,) [N]."""
        return np.array([min(piece.start_tension, piece.end_tension) for piece in self.pieces])

    @property
    def rope_damping(self) -> Array:
        """Damping of ropes that stretch evenly, shape (n, n) [N s/m]."""
        ropes = [piece.rope for piece in self.pieces]
        damping, rigidity = np.array([(rope.axial_damping, rope.axial_rigidity) for rope in ropes]).T
        lengths = self.time[::3] * rigidity / self.impedance[::3]
        return np.asarray((self.stretch.T * (self.ropes[::3] * damping / lengths)) @ self.stretch)


def network_of(
    drive: Machine, *, motor: str | None = None, hold: Sequence[str] = (), statics: Statics | None = None
) -> Network:
    """The network of a machine about its state of rest.

    ``motor``, {"free", "held", "holding"}: how the rotors are held, by default "holding" where the file gives
    a holding stiffness, else "free"; ``hold``: bodies, pulleys and carriages that are held as well;
    ``statics``: the state of rest, if known.
    Raises `InputRefused` if there is no such state, a rope runs too fast, or nothing holds a part.
    """
    names = (hold,) if isinstance(hold, str) else tuple(hold)
    motion, statics = Motion(drive, motor_condition(drive, motor), names), statics or statics_of(drive)
    pieces = pieces_of(motion, statics)
    for piece in pieces:
        if piece.route.speed:
            waves_of_piece(piece, ACROSS)  # refuses one that runs too fast
    network = Network(motion=motion, statics=statics, pieces=pieces, **_parts(motion))
    _check_held(network)
    return network


def waves_of_piece(piece: Piece, direction: str) -> tuple[float, float, float]:
    """Impedance of one rope, travel time and lag of a piece, Eq. (N.3).

    Across, the tension counts by the travel time of a string in which it changes evenly.
    """
    rope, route, length, v = piece.rope, piece.route, piece.rest.length, piece.speed
    tension = (0.5 * (sqrt(piece.start_tension) + sqrt(piece.end_tension))) ** 2
    stretch = 1.0 + tension / rope.axial_rigidity
    rigidity = rope.axial_rigidity if direction == ALONG else tension / stretch
    c, z = sqrt(rigidity / rope.density), sqrt(rigidity * rope.density)
    if v == 0.0:
        return z, length / c, 0.0
    slowest = rope.wave_speed(min(tension, rope.pretension or tension))
    if abs(route.speed) >= slowest:
        raise InputRefused(
            f'route "{route.name}": speed = {route.speed:.4g} m/s reaches the wave speed '
            f"{slowest:.4g} m/s of span {piece.where.name} at its pretension, above which momentum alone "
            "would hold it: lower the speed, or raise the pretension"
        )
    return z, c * length / (c**2 - v**2), v * length / (c**2 - v**2)


def _parts(motion: Motion) -> dict[str, Parts]:
    """What moves with the coordinates beside the ropes: of bodies, pulleys, motors and carriages."""
    drive, motors = motion.drive, dict(zip(motion.drive.driven, motion.drive.motor, strict=True))
    masses, springs, dampers, rubs = (list[tuple[float, Row, str]]() for _ in range(4))
    for number, body in enumerate(drive.body):
        masses += [(body.mass, row, body.name) for row in motion.point(body.at, number)]
        masses.append((body.inertia, motion.rotation(number), body.name))
        for move in body.moves:
            own = motion.unit(f"{body.name}.{move}")
            springs.append((body.stiffness, own, f"spring of {body.name}"))
            dampers.append((body.damping, own, body.name))
            rubs.append((body.coulomb_friction, own, f"{body.name}.{move}"))
    for number, pulley in enumerate(drive.pulley):
        name, motor, turn = pulley.name, motors.get(number), relative_turn(motion, number)
        masses += [
            (pulley.mass, row, name) for row in motion.point(pulley.at, body_number(drive, pulley.on, name))
        ]
        joint = None if motor is None else motor.joint_stiffness
        rigid = motor.inertia if motor is not None and joint is None else 0.0
        masses.append((pulley.inertia + rigid, motion.angle(number), name))
        dampers.append((pulley.viscous_friction, turn, name))
        rubs.append((pulley.coulomb_friction, turn, name))
        if motor is not None:
            rotor = rotor_turn(motion, number)
            dampers.append((motor.viscous_friction, rotor, name))
            if joint is not None:
                masses.append((motor.inertia, motion.rotor(number), name))
                dampers.append((motor.joint_damping, rotor - turn, MOTOR_JOINT))
    for number, motor in motors.items():
        rotor = motion.angle(number) if motor.joint_stiffness is None else motion.rotor(number)
        springs.append((motor.joint_stiffness or 0.0, rotor - motion.angle(number), MOTOR_JOINT))
        if motion.motor == HOLDING:
            springs.append(
                (motor.holding_stiffness or 0.0, rotor - motion.mount(number), "holding stiffness")
            )
        name = f"motor of {drive.pulley[number].name}"
        rubs.append((motor.coulomb_friction, rotor_turn(motion, number), name))
    for number, carriage in enumerate(drive.carriage):
        name = motion.carriage_name(number)
        masses += [(carriage.mass, motion.unit(f"{name} {way}"), name) for way in DIRECTIONS]
    found = {}
    for kind, parts in (("masses", masses), ("springs", springs), ("dampers", dampers), ("rubs", rubs)):
        kept = [part for part in parts if part[0] > 0.0 and any(part[1].values())]
        values, rows, names = zip(*kept, strict=True) if kept else ((), (), ())
        found[kind] = Parts(np.array(values), rows, names, len(motion.names))
    return found


def _check_held(network: Network) -> None:
    """Refuse a coordinate that no rope and no spring holds."""
    strained = {i for piece in network.pieces for pair in piece.rows.values() for row in pair for i in row}
    turned = np.flatnonzero(network.geometric.any(axis=0)).tolist() if network.turning else []
    held = strained.union(*network.springs.rows, turned)
    for number, name in enumerate(network.motion.names):
        if number not in held:
            body, _, move = name.rpartition(".")
            if body in [part.name for part in network.drive.body]:
                way = "about its pivot" if move == "turn" else f"along {move}"
                said = f"body {body}: nothing holds it {way}, no rope and no spring"
                raise InputRefused(f"{said}: add an anchor, a pulley or stiffness")
            raise InputRefused(f"pulley {name}: no route passes it: add it to a path, or leave it out")


def relative_turn(motion: Motion, pulley: int) -> Row:
    """Turn of a pulley against what carries it."""
    return motion.angle(pulley) - motion.mount(pulley)


def rotor_turn(motion: Motion, pulley: int) -> Row:
    """Turn of the rotor that drives a pulley, against what carries the motor."""
    if f"rotor of {motion.drive.pulley[pulley].name}" not in motion.names:
        return relative_turn(motion, pulley)
    return motion.rotor(pulley) - motion.mount(pulley)


def turns_by_torque(network: Network) -> Array:
    """Turns of the rotors of `Machine.turned`, shape (rotors, n)."""
    motion = network.motion
    return motion.dense(*(rotor_turn(motion, number) for number in network.drive.turned))
