r"""The lumped chain that the motor of a machine with routes drives, and whether the rest may be left out.

Of the certified modes, of ropes that hang, the rigid one and the few that the motor feels most are kept, each
with its exact frequency. Lanczos' recursion on :math:`\mathrm{diag}(\omega_j^2)`, begun with the motor's row,
gives a tridiagonal matrix :math:`\alpha, \beta`: a chain with these frequencies and the motor's own zeros,

.. math:: J_1 = \frac{1}{|\varphi_m|^2}, \qquad k_i = \alpha_i J_i - k_{i-1}, \qquad
          J_{i+1} = \frac{k_i^2}{\beta_i^2 J_i}, \qquad y = \sum c_i z_i,\; c_i = (Q\varphi_y)_i \sqrt{J_i},
          \qquad \text{Eq. (N.8)}

with the load row c. The load is the chain's end where all other :math:`c_i` are small.

Of two motors that do not split into sum and difference, as of a printer whose head stands beside the middle,
the chain is that of the motion along one axis with motors and load of the other one at rest; what that
neglects along a torque is `network_axis.cross_motion`.
"""

from dataclasses import dataclass, replace
from math import pi

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh, null_space

from cabledrive.mechanics.holding import FREE
from cabledrive.mechanics.network import Network, network_of
from cabledrive.mechanics.network.assembly import rotor_turn
from cabledrive.mechanics.network.response import network_response
from cabledrive.modal.mode import TRANSVERSE
from cabledrive.modal.networks import ModalNetwork
from cabledrive.modal.route_network import network_of_routes
from cabledrive.modal.spectrum import Spectrum
from cabledrive.parameters import Machine
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.errors import InputRefused

SUM, DIFFERENCE = "sum", "difference"
MOST_OFF_THE_END = 0.02
"""Largest entry of the load row before its end, relative to the end."""
MOST_CROSS = 0.02
"""Largest angle of the other axis' motors per angle of a chain that is found as if they did not couple."""
MOST_NEGLECTED = 0.02
"""Largest contribution of the modes left out, up to twice the chain's first mode."""
MOST_STRINGS = 0.2
"""Largest contribution of transverse vibrations of the spans there."""
_HIGHER = 1.2
"""Than that of straight ropes that stretch evenly: up to where a mode is looked for."""
LOSS_FACTOR = 0.02
"""Of both models when they are compared: one per cent of critical damping."""
_ONE = "unlike motors, or a rope askew to a slide (see `check`), leave them one motion: the axes do not split"
_SAME = 1e-9
_FREQUENCIES = 400
_BEYOND = 2.0
"""Of the frequencies at which what is left out counts: up to where modes are listed one by one."""
_PLACES = np.array([0.025, 0.3, 0.7, 0.95])
"""Of them, those at which the modes beyond are found as what all ropes do more; the first is the lowest."""


@dataclass(frozen=True, eq=False, kw_only=True)
class NetworkChain:
    """The chain that an axis of a machine with routes reduces to, Eq. (N.8)."""

    load: str  # coordinate that is the load: "head.x", "joint.turn", the name of a pulley
    motors: dict[str, float]
    """Sign of each pulley's turn in the motor angle; the chain's torque is that of all."""
    inertias: Array  # (n,) [kg m^2], the motor first
    stiffness: Array  # (n - 1,) [N m/rad]
    load_row: Array  # (n,): load per angle of each inertia [m/rad], [rad/rad]
    cross: (
        float  # largest angle of the other axis' motors per angle of this chain, both free; 0 with one motor
    )
    other: str | None  # load of the other axis, which the motors' other combination moves
    ground: float  # stiffness that holds the chain to the frame, relative to its last link
    frequencies: Array  # (n - 1,): of the modes kept [Hz]
    neglected: float
    """Largest contribution of the modes left out to the response of motor and load, up to twice the first
    mode, relative to the sum of the parts of the chain's modes."""
    strings: float  # the same contribution of the transverse modes below that
    shapes: Array  # (n, modes): the modes kept, of unit modal mass, the rigid one first
    network: Network

    @property
    def gain(self) -> float:
        """Load per motor angle of the rigid motion [m/rad], [rad/rad]."""
        return float(self.load_row.sum())

    @property
    def off_the_end(self) -> float:
        """Largest entry of the load row before its end, relative to the end."""
        return float(np.abs(self.load_row[:-1]).max(initial=0.0) / abs(self.load_row[-1]))

    @property
    def refusal(self) -> str | None:
        """Why the load is not the end of this chain; None where it is."""
        who = " and ".join(self.motors)
        if self.cross > MOST_CROSS and self.other is None:
            return (
                f"the motors of {who} do not split into sum and difference: {self.load} turns one "
                f"against the other by {100 * self.cross:.3g} %, allowed are {100 * MOST_CROSS:.3g} %: make "
                "both alike"
            )
        if self.ground > MOST_OFF_THE_END:
            return f"springs hold {self.load} to the frame: the motor turns no free chain"
        if self.off_the_end > MOST_OFF_THE_END:
            row = ", ".join(f"{one:.3g}" for one in self.load_row / np.abs(self.load_row).max())
            said = f"{self.load} is not the end of the chain that {who} drives"
            return f"{said}: load row ({row}), allowed before the end are {100 * MOST_OFF_THE_END:.3g} %"
        if self.neglected > MOST_NEGLECTED:
            return (
                f"the chain of {self.inertias.size} inertias leaves out {100 * self.neglected:.3g} % of the "
                f"response up to {2 * self.frequencies[0]:.4g} Hz, allowed are {100 * MOST_NEGLECTED:.3g} %"
            )
        if self.strings > MOST_STRINGS:
            return (
                f"transverse vibrations of the spans make up {100 * self.strings:.3g} % of the response up "
                f"to {2 * self.frequencies[0]:.4g} Hz, allowed are {100 * MOST_STRINGS:.3g} %: change "
                "the pretension"
            )
        return None


def network_chains(drive: Machine) -> tuple[NetworkChain, ...]:
    """The chain of the motor; of two those of their sum and their difference, as far as they move bodies.

    Refused without a motor, with more than two, or where no rigid motion is driven.
    """
    if any(route.speed for route in drive.route):
        raise InputRefused("a running rope (route.speed) is no chain of inertias: set its speed to 0")
    if not 1 <= len(drive.motor) <= 2:
        raise InputRefused(
            f"motor: {len(drive.motor)} given, a chain is driven by one, or by two as sum and difference"
        )
    network = network_of(drive, motor=FREE)
    turns = network.motion.dense(*(rotor_turn(network.motion, number) for number in drive.driven))
    names = [drive.pulley[number].name for number in drive.driven]
    spectrum = Spectrum(_moved(network_of_routes(network)))
    if len(turns) == 1:
        return (_chain(network, spectrum, {names[0]: 1.0}, turns[0], None),)
    half = 0.5 * (turns[0] + turns[1]), 0.5 * (turns[0] - turns[1])
    # Of two motors on one rope the one combination moves the bodies, the other only stretches the rope.
    rigid = eigh(network.static_stiffness, network.static_mass)[1][:, : spectrum.rigid_body_modes]
    moved = [_merged(turn, rigid) for turn in half]
    if moved[0] is None and moved[1] is None:
        raise InputRefused(_held(" and ".join(names)))
    return tuple(
        _chain(
            network,
            spectrum,
            dict(zip(names, (1.0, sign), strict=True)),
            half[way],
            (half[1 - way], moved[1 - way]),
        )
        for way, sign in ((0, 1.0), (1, -1.0))
        if moved[way] is not None
    )


def _moved(found: ModalNetwork) -> ModalNetwork:
    """A network without the waves that no coordinate takes part in."""
    return replace(
        found,
        waves=tuple(own for own in found.waves if any(own.rows)),
        ropes=tuple(own for own in found.ropes if any(own.rows)),
    )


def _held(who: str) -> str:
    return f"springs or ropes hold all that {who} drives to the frame: no free chain; take modes and response"


def _chain(
    network: Network,
    spectrum: Spectrum,
    motors: dict[str, float],
    turn: Array,
    across: tuple[Array, Array | None] | None,
) -> NetworkChain:
    """The chain of one axis.

    ``turn``, shape (n,): its motor angle; ``across``: that of the other axis and the rigid motion that its
    motors drive, None where they only stretch the rope.
    """
    joints = {motor.joint_stiffness is not None for motor in network.drive.motor}
    if len(joints) > 1:
        raise InputRefused("motor: one joint is flexible and the other rigid: the axes do not split")
    who, count = " and ".join(motors), 2 if joints.pop() else 1
    squares, shapes = _kept_modes(network, spectrum, turn, count, who)
    load = _load_of(network, shapes[:, 0], who)
    felt = np.vstack([turn, network.motion.dense(load)])
    neglected, strings = _left_out(network, spectrum, squares, shapes, felt)
    cross, other = 0.0, None
    if across is not None:
        rigid = spectrum.rigid_body_modes
        free = _split(*modes_at_rest(network, np.zeros((0, turn.size))), rigid, count, felt)
        cross = float(np.abs(_chain_rows(*free[:2], turn, across[0][None])[1]).max())
        other = None if across[1] is None else _load_of(network, across[1], who)
        if other == load:
            raise InputRefused(_ONE)
    if across is not None and other is not None and cross > MOST_CROSS:
        still = modes_at_rest(network, np.vstack([across[0], network.motion.dense(other)]))
        squares, shapes, neglected = _split(*still, rigid - 1, count, felt)
    (inertias, stiffness, rest), rows = _chain_rows(squares, shapes, turn, network.motion.dense(load))
    return NetworkChain(
        load=load,
        motors=motors,
        inertias=inertias,
        stiffness=stiffness,
        load_row=rows[0],
        cross=cross,
        other=other,
        ground=abs(rest) / stiffness[-1],
        frequencies=np.sqrt(squares[1:]) / (2.0 * pi),
        neglected=neglected,
        strings=strings,
        shapes=shapes,
        network=network,
    )


def _chain_rows(
    squares: Array, shapes: Array, turn: Array, rows: Array
) -> tuple[tuple[Array, Array, float], Array]:
    """Inertias, stiffnesses and ground of the chain of modes, by Lanczos; rows (k, n) by its inertias."""
    start = turn @ shapes
    basis, inertias, stiffness = [start / np.linalg.norm(start)], [1.0 / float(start @ start)], [0.0]
    while True:
        own = squares * basis[-1]
        link = float(basis[-1] @ own) * inertias[-1] - stiffness[-1]
        if len(basis) == squares.size:
            break
        before = np.array(basis)
        for _ in range(2):  # twice is enough for full orthogonality
            own = own - before.T @ (before @ own)
        size = float(np.linalg.norm(own))
        stiffness.append(link)
        inertias.append(link**2 / (size**2 * inertias[-1]))
        basis.append(-own / size)  # minus: a positive spring pulls neighbours together
    chain = np.array(inertias), np.array(stiffness[1:]), link
    return chain, (np.array(basis) @ (rows @ shapes).T).T * np.sqrt(chain[0])


def modes_at_rest(network: Network, held: Array) -> tuple[Array, Array]:
    """Squares (m,) and shapes (n, m) of unit modal mass of all coupled modes with rows (k, n) held at 0.

    Belts stretch evenly: a frequency lies above that of its waves.
    """
    free = null_space(held) if held.size else np.eye(network.static_mass.shape[0])
    squares, shapes = eigh(free.T @ network.static_stiffness @ free, free.T @ network.static_mass @ free)
    return squares, free @ shapes


def _split(squares: Array, shapes: Array, rigid: int, count: int, rows: Array) -> tuple[Array, Array, float]:
    """Of all modes the rigid one and those that the motor (row 0) feels most; largest part of the rest."""
    first = _merged(rows[0], shapes[:, :rigid])
    if first is None:
        raise InputRefused(_ONE)
    squares, shapes = np.append(0.0, squares[rigid:]), np.column_stack([first, shapes[:, rigid:]])
    felt = np.argsort((rows[0] @ shapes[:, 1:]) ** 2 / squares[1:]) + 1
    kept = np.append(0, np.sort(felt[-count:]))
    omega = 2.0 * np.sqrt(squares[kept[1]]) * np.linspace(0.025, 1.0, _FREQUENCIES)
    parts = _modal_parts(squares, shapes, rows, omega)
    rest = np.abs(np.delete(parts, kept, axis=2).sum(axis=2)) / np.abs(parts[:, :, kept]).sum(axis=2)
    return squares[kept], shapes[:, kept], float(rest.max())


def _kept_modes(
    network: Network, spectrum: Spectrum, turn: Array, count: int, who: str
) -> tuple[Array, Array]:
    """Squares of the frequencies and shapes of the rigid motion and the modes that the motor feels most.

    Shapes are of unit modal mass; modes of one frequency are merged into the one that the motor drives.
    """
    squares, shapes = eigh(network.static_stiffness, network.static_mass)
    rigid = spectrum.rigid_body_modes
    first = _merged(turn, shapes[:, :rigid])
    if first is None:
        raise InputRefused(_held(who))
    felt = (turn @ shapes[:, rigid:]) ** 2 / squares[rigid:]
    if felt.size < count:
        raise InputRefused(
            f"the machine has {felt.size} modes that bodies take part in, a chain needs {count}"
        )
    highest = np.sqrt(squares[rigid:][np.argsort(felt)[-count:]].max())
    # Condensed frequencies lie above the exact ones of straight ropes; sag may part one from a wave across.
    groups = coupled_modes(network, spectrum, highest * _HIGHER)
    merged = [(square, _merged(turn, group)) for square, group, _ in groups]
    modes = [(square, shape) for square, shape in merged if shape is not None]
    if len(modes) < count:
        raise InputRefused(_ONE)
    modes.sort(key=lambda mode: float((turn @ mode[1]) ** 2 / mode[0]))
    kept = sorted(modes[-count:], key=lambda mode: mode[0])
    return np.array([0.0, *(square for square, _ in kept)]), np.column_stack([first, *(x for _, x in kept)])


def coupled_modes(network: Network, spectrum: Spectrum, omega: float) -> list[tuple[float, Array, bool]]:
    """Squared frequency, shape and whether transverse of all coupled modes below one; equal ones in a row."""
    found: list[tuple[float, Array, bool]] = []
    for mode in spectrum.below(omega):
        joints = mode.joints
        if not joints:
            continue
        shape = np.array(
            [joints.get(name, np.zeros(mode.multiplicity)) for name in network.motion.names]
        ).real
        square, across = (2.0 * pi * mode.frequency) ** 2, mode.kind == TRANSVERSE
        if found and square < found[-1][0] * (1.0 + _SAME) and across == found[-1][2]:
            found[-1] = found[-1][0], np.hstack((found[-1][1], shape)), across
        else:
            found.append((square, shape, across))
    return found


def _merged(turn: Array, shapes: Array) -> Array | None:
    """Of modes of one frequency the combination that a force drives, shape (n,); None: it drives none."""
    force = turn @ shapes
    size = np.linalg.norm(force)
    if size <= _SAME * np.sqrt(np.abs(turn).max()):
        return None
    return np.asarray(shapes @ force / size)


def _load_of(network: Network, rigid: Array, who: str) -> str:
    """The coordinate with the largest kinetic energy of the rigid motion, the motors' own left out."""
    energy = dict(zip(network.motion.names, rigid * (network.masses.matrix @ rigid), strict=True))
    pulleys = [network.drive.pulley[number].name for number in network.drive.driven]
    for name in pulleys:
        energy.pop(name, None)
        energy.pop(f"rotor of {name}", None)
    if not energy or max(energy.values()) <= 0.0:
        raise InputRefused(f"{who} drives nothing but itself: there is no load")
    return max(energy, key=lambda name: float(energy[name]))


def _left_out(
    network: Network, spectrum: Spectrum, squares: Array, shapes: Array, rows: Array
) -> tuple[float, float]:
    """Parts of the responses of motor and load up to twice the first mode that a chain of these modes lacks.

    ``rows``, shape (2, n): of the motor's angle and the load. Returns the part of all other modes but the
    transverse ones, and that of these. The parts of rigid motion and modes are added by magnitude: a zero of
    the response does not count as an error. Modes above twice these frequencies are even there in the square;
    a rigid motion that sag makes a slow mode lacks the inverse of its square.
    """
    top = 2.0 * np.sqrt(squares[1])
    omega, places = top * np.linspace(_PLACES[0], 1.0, _FREQUENCIES), top * _PLACES
    others = [
        (square, shape, across)
        for square, group, across in coupled_modes(network, spectrum, _BEYOND * top)
        for shape in group.T
        if not np.any(np.abs(square - squares) <= _SAME * square)
    ]
    modes = (
        np.append(squares, [one[0] for one in others]),
        np.column_stack([shapes, *(one[1] for one in others)]),
    )
    exact = network_response(network, places, rows[0], rows, loss_factor=LOSS_FACTOR)
    exact -= _modal_parts(*modes, rows, places).sum(axis=2)
    terms = [np.column_stack((x**-2.0, np.vander(x, 3))) for x in ((omega / top) ** 2, _PLACES**2)]
    beyond = terms[0] @ np.linalg.solve(terms[1], exact)
    kept, rest = np.split(_modal_parts(*modes, rows, omega), [squares.size], axis=2)
    across, size = np.array([one[2] for one in others], dtype=bool), np.abs(kept).sum(axis=2)
    along, strings = rest[:, :, ~across].sum(axis=2) + beyond, rest[:, :, across].sum(axis=2)
    return float((np.abs(along) / size).max()), float((np.abs(strings) / size).max())


def _modal_parts(squares: Array, shapes: Array, rows: Array, omega: Array) -> NDArray[np.complex128]:
    """Part of each mode in the motion of each row per force on row 0, shape (frequencies, rows, modes)."""
    weights = (rows @ shapes) * (rows[0] @ shapes)
    damped = squares * (1.0 + 1j * LOSS_FACTOR)
    return np.asarray(weights / (damped - omega[:, None] ** 2)[:, None, :])
