r"""The network of a machine: spans, masses, springs, dampers and dry friction, with their rows.

Waves along a span have :math:`R = EA`, waves across it :math:`R = T/(1+\varepsilon)` per unstretched metre.
Of a rope that runs with speed v the waves across it have

.. math:: \tau = \frac{c L}{c^2 - v^2}, \qquad \delta = \frac{v L}{c^2 - v^2}, \qquad Z = \sqrt{R\rho},
          \qquad \text{Eq. (N.3)}

travel time, lag and impedance; the motion along it has :math:`v \ll c` and keeps :math:`\tau = L/c`.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import sqrt

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.holding import HOLDING
from cabledrive.mechanics.network.motion import ACROSS, ALONG, OUT_OF_PLANE, Motion, condition
from cabledrive.mechanics.network.pieces import Piece, pieces_of
from cabledrive.mechanics.network.statics import Statics, geometric_stiffness, statics_of
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.fields import described, meaning
from cabledrive.parameters.route import RoutedDrive

DIRECTIONS = (ALONG, ACROSS, OUT_OF_PLANE)


@described
@dataclass(frozen=True, eq=False, kw_only=True)
class Network:
    """Waves, masses and springs of a machine in its coordinates."""

    motion: Motion = meaning("its coordinates")
    statics: Statics = meaning("its forces at rest")
    pieces: list[Piece] = meaning("ropes between joints, cut at carriages")
    piece: NDArray[np.intp] = meaning(
        "(m,): piece of each link; three links a piece: along, across, out of plane"
    )
    direction: NDArray[np.intp] = meaning("(m,): 0: along, 1: across, 2: out of plane")
    start: Array = meaning("(m, n): row of the start of each link")
    end: Array = meaning("(m, n): row of its end")
    impedance: Array = meaning("(m,): z of one rope [kg/s], Eq. (N.3)")
    time: Array = meaning("(m,): travel time [s]")
    lag: Array = meaning("(m,): of a rope that runs [s]")
    ropes: NDArray[np.intp] = meaning("(m,): parallel ropes")
    mass: Array = meaning("masses [kg] and moments of inertia [kg m^2]")
    mass_rows: Array = meaning("how q moves them")
    spring: Array = meaning("springs [N/m], [N m/rad]")
    spring_rows: Array = meaning("how q strains them")
    spring_names: tuple[str, ...] = meaning("what each spring is")
    geometric: Array = meaning("(n, n): stiffness of turning bodies under the forces at rest, Eq. (N.4)")

    @property
    def drive(self) -> RoutedDrive:
        """The machine."""
        return self.motion.drive

    @cached_property
    def places(self) -> list[tuple[str, str]]:
        """Span and direction of each link."""
        spans = [self.drive.free_spans[piece.span].name for piece in self.pieces]
        return [
            (spans[piece], DIRECTIONS[way]) for piece, way in zip(self.piece, self.direction, strict=True)
        ]

    @cached_property
    def static_stiffness(self) -> Array:
        """Stiffness of every coordinate against every other at rest, shape (n, n)."""
        stretch = self.start - self.end
        link = self.ropes * self.impedance / self.time
        matrix = (stretch.T * link) @ stretch + (self.spring_rows.T * self.spring) @ self.spring_rows
        return np.asarray(matrix + self.geometric)

    @cached_property
    def static_mass(self) -> Array:
        """Mass matrix of slow motions, ropes shared out between their ends, shape (n, n)."""
        rope = self.ropes * self.impedance * self.time / 6.0
        matrix = (self.mass_rows.T * self.mass) @ self.mass_rows
        for a, b, share in (
            (self.start, self.start, 2.0),
            (self.end, self.end, 2.0),
            (self.start, self.end, 1.0),
        ):
            part = (a.T * (share * rope)) @ b
            matrix = matrix + (part + part.T) / (2.0 if a is b else 1.0)
        return np.asarray(matrix)


def network_of(drive: RoutedDrive, *, motor: str | None = None, hold: Sequence[str] = ()) -> Network:
    """The network of a machine about its state of rest.

    Parameters
    ----------
    drive : RoutedDrive
    motor : {"free", "held", "holding"}, optional
        How the rotors are held; default: "holding" where the file gives a holding stiffness, else "free".
    hold : sequence of str, optional
        Bodies, pulleys and carriages that are held as well.

    Returns
    -------
    Network

    Raises
    ------
    InputRefused
        If there is no such state, a rope runs too fast, or nothing holds a part.
    """
    names = (hold,) if isinstance(hold, str) else tuple(hold)
    motion, statics = Motion(drive, condition(drive, motor), names), statics_of(drive)
    pieces = pieces_of(motion, statics)
    links = [(number, way) for number in range(len(pieces)) for way in range(len(DIRECTIONS))]
    waves = [waves_of_piece(drive, pieces[number], DIRECTIONS[way]) for number, way in links]
    start, end = (
        np.array([pieces[number].rows[DIRECTIONS[way]][side] for number, way in links]) for side in (0, 1)
    )
    mass, mass_rows = _masses(motion)
    spring, spring_rows, spring_names = _springs(motion)
    network = Network(
        motion=motion,
        statics=statics,
        pieces=pieces,
        piece=np.array([number for number, _ in links]),
        direction=np.array([way for _, way in links]),
        start=start,
        end=end,
        impedance=np.array([wave[0] for wave in waves]),
        time=np.array([wave[1] for wave in waves]),
        lag=np.array([wave[2] for wave in waves]),
        ropes=np.array(
            [drive.route[drive.free_spans[pieces[number].span].route].ropes for number, _ in links]
        ),
        mass=mass,
        mass_rows=mass_rows,
        spring=spring,
        spring_rows=spring_rows,
        spring_names=spring_names,
        geometric=geometric_stiffness(motion, statics),
    )
    _check_held(network)
    return network


def waves_of_piece(drive: RoutedDrive, piece: Piece, direction: str) -> tuple[float, float, float]:
    """Impedance of one rope, travel time and lag of a piece, Eq. (N.3).

    Across, the tension counts by the travel time of a string in which it changes evenly.
    """
    span = drive.free_spans[piece.span]
    rope, route = drive.ropes[span.route], drive.route[span.route]
    tension = (0.5 * (sqrt(piece.start_tension) + sqrt(piece.end_tension))) ** 2
    stretch = 1.0 + tension / rope.axial_rigidity
    length = piece.length / stretch
    rigidity = rope.axial_rigidity if direction == ALONG else tension / stretch
    c, v = sqrt(rigidity / rope.density), route.speed / stretch
    z = sqrt(rigidity * rope.density)
    if direction == ALONG or v == 0.0:
        return z, length / c, 0.0
    if abs(v) >= c:
        raise InputRefused(
            f'route "{route.name}": speed = {route.speed:.4g} m/s reaches the wave speed '
            f"{c * stretch:.4g} m/s of span "
            f"{span.name}, above which no vibration is stable: lower the speed, or raise the pretension"
        )
    return z, c * length / (c**2 - v**2), v * length / (c**2 - v**2)


def _masses(motion: Motion) -> tuple[Array, Array]:
    """Masses and moments of inertia with the rows by which they move."""
    drive = motion.drive
    parts: list[tuple[float, Array]] = []
    for number, body in enumerate(drive.body):
        parts += [(body.mass, row) for row in motion.point(body.at, number)]
        parts.append((body.inertia, motion.rotation(number)))
    motors = dict(zip(drive.driven, drive.motor, strict=True))
    for number, pulley in enumerate(drive.pulley):
        body_number = drive.body_number(pulley.on, pulley.name)
        parts += [(pulley.mass, row) for row in motion.point(pulley.at, body_number)]
        motor = motors.get(number)
        rigid = motor.inertia if motor is not None and motor.joint_stiffness is None else 0.0
        parts.append((pulley.inertia + rigid, motion.angle(number)))
        if motor is not None and motor.joint_stiffness is not None:
            parts.append((motor.inertia, motion.rotor(number)))
    for number, carriage in enumerate(drive.carriage):
        name = motion.carriage_name(number)
        parts += [(carriage.mass, motion.unit(f"{name} {way}")) for way in DIRECTIONS]
    kept = [(mass, row) for mass, row in parts if mass > 0.0 and row.any()]
    return _stacked(kept, len(motion.names))


def _stacked(parts: list[tuple[float, Array]], n: int) -> tuple[Array, Array]:
    rows = np.array([row for _, row in parts]) if parts else np.zeros((0, n))
    return np.array([value for value, _ in parts]), rows


def _springs(motion: Motion) -> tuple[Array, Array, tuple[str, ...]]:
    """Springs of bodies, joints and holding stiffnesses, with the rows that strain them and their names."""
    drive = motion.drive
    parts: list[tuple[float, Array]] = []
    names: list[str] = []
    for body in drive.body:
        if body.stiffness > 0.0:
            parts += [(body.stiffness, motion.unit(f"{body.name}.{move}")) for move in body.moves]
            names += [f"spring of {body.name}"] * len(body.moves)
    for number, motor in zip(drive.driven, drive.motor, strict=True):
        shaft = motion.angle(number)
        if motor.joint_stiffness is not None:
            rotor = motion.rotor(number)
            parts.append((motor.joint_stiffness, rotor - shaft))
            names.append("motor joint")
            shaft = rotor
        if motion.motor == HOLDING and motor.holding_stiffness is not None:
            parts.append((motor.holding_stiffness, shaft - motion.mount(number)))
            names.append("holding stiffness")
    kept = [(part, name) for part, name in zip(parts, names, strict=True) if part[1].any()]
    stiffness, rows = _stacked([part for part, _ in kept], len(motion.names))
    return stiffness, rows, tuple(name for _, name in kept)


def _check_held(network: Network) -> None:
    """Refuse a coordinate that no rope and no spring holds."""
    held = np.abs(network.static_stiffness).sum(axis=0)
    for name, stiffness in zip(network.motion.names, held, strict=True):
        if stiffness == 0.0:
            body, _, move = name.rpartition(".")
            if body in [part.name for part in network.drive.body]:
                way = "about its pivot" if move == "turn" else f"along {move}"
                raise InputRefused(
                    f"body {body}: nothing holds it {way}, no rope and no spring: add an anchor, a "
                    "pulley or stiffness"
                )
            raise InputRefused(f"pulley {name}: no route passes it: add it to a path, or leave it out")


def dampers_of(network: Network) -> tuple[Array, Array]:
    """Dampers [N s/m], [N m s/rad], shape (k,), and their rows, shape (k, n); ropes have their own."""
    drive, motion = network.drive, network.motion
    parts: list[tuple[float, Array]] = []
    for body in drive.body:
        parts += [(body.damping, motion.unit(f"{body.name}.{move}")) for move in body.moves]
    motors = dict(zip(drive.driven, drive.motor, strict=True))
    for number, pulley in enumerate(drive.pulley):
        turn = relative_turn(network, number)
        parts.append((pulley.viscous_friction, turn))
        motor = motors.get(number)
        if motor is None:
            continue
        rotor = rotor_turn(network, number)
        parts.append((motor.viscous_friction, rotor))
        if motor.joint_stiffness is not None:
            parts.append((motor.joint_damping, rotor - turn))
    return _stacked([part for part in parts if part[0] > 0.0 and part[1].any()], len(motion.names))


def relative_turn(network: Network, pulley: int) -> Array:
    """Turn of a pulley against what carries it, shape (n,)."""
    return network.motion.angle(pulley) - network.motion.mount(pulley)


def rotor_turn(network: Network, pulley: int) -> Array:
    """Turn of the rotor that drives a pulley, against what carries the motor, shape (n,)."""
    if f"rotor of {network.drive.pulley[pulley].name}" not in network.motion.names:
        return relative_turn(network, pulley)
    return network.motion.rotor(pulley) - network.motion.mount(pulley)


def coulomb_of(network: Network) -> list[tuple[str, Array, float]]:
    """Name, row, shape (n,), and friction [N], [N m] of all that rubs, but for ropes on their wraps."""
    drive, motion = network.drive, network.motion
    parts = [
        (f"{body.name}.{move}", motion.unit(f"{body.name}.{move}"), body.coulomb_friction)
        for body in drive.body
        for move in body.moves
    ]
    parts += [
        (pulley.name, relative_turn(network, number), pulley.coulomb_friction)
        for number, pulley in enumerate(drive.pulley)
    ]
    for number, motor in zip(drive.driven, drive.motor, strict=True):
        parts.append(
            (f"motor of {drive.pulley[number].name}", rotor_turn(network, number), motor.coulomb_friction)
        )
    return [part for part in parts if part[2] > 0.0 and part[1].any()]
