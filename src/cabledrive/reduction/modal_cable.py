"""A distributed cable, a sample at a time: the fast model of a loop, a network of routes in linear modes."""

from dataclasses import dataclass
from math import ceil, pi

import numpy as np
from scipy.linalg import eigh, expm

from cabledrive.mechanics.network import Network, network_of
from cabledrive.mechanics.network.assembly import dynamic_stiffness, rotor_turn
from cabledrive.modal.route_network import network_of_routes
from cabledrive.modal.spectrum import Spectrum
from cabledrive.parameters import Drive, InputRefused
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.route import RoutedDrive
from cabledrive.reduction.fast_simulation import finest_step
from cabledrive.reduction.modal_cable_kernels import ModalCableNumbers
from cabledrive.reduction.network_chain import coupled_modes
from cabledrive.reduction.uniform_tension import (
    HIGHEST_SHARE,
    coefficients,
    first_order,
    uniform_tension_model,
)
from cabledrive.simulation.network.case import slides
from cabledrive.simulation.network.mesh import piece_names

DEFAULT_RATE = 1000.0
"""Of a drive without sensors [Hz]."""
SHARE_OF_RATE = 0.1
"""Modes of a network are kept below this share of the sample rate."""
MOST_MODES = 40


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ModalCable:
    """A cable in modes.

    ``inputs``, ``motions``: names with their units; ``spans``: names; ``highest``: up to which the model
    goes [Hz]; ``sine``: whether the spans vibrate across and can be plucked.
    """

    numbers: ModalCableNumbers
    interval: float
    inputs: tuple[tuple[str, str], ...]
    motions: tuple[tuple[str, str], ...]
    spans: tuple[str, ...]
    highest: float
    modes: int
    sine: bool


def modal_cable(drive: Drive | RoutedDrive, sines: int = 8) -> ModalCable:
    """The cable of a drive in modes; ``sines``: across each span of a loop.

    Refused: a drive that the fast model does not fit, a machine whose ropes run.
    """
    rate = (drive.sensors.sample_rate if drive.sensors else None) or DEFAULT_RATE
    if isinstance(drive, RoutedDrive):
        return _network(drive, 1.0 / rate)
    return _loop(drive, 1.0 / rate, sines)


def _loop(drive: Drive, interval: float, sines: int) -> ModalCable:
    """The equations of `uniform_tension_model`; motion in the plane w of the spans."""
    model = uniform_tension_model(drive, sines)
    steps = ceil(interval / finest_step(model))
    shafts = np.column_stack((model.torque_shape, model.rims / model.radii))
    names = ("motor", "drive", "load") if drive.motor and drive.motor.joint_stiffness else ("drive", "load")
    shafts = shafts[:, -len(names) :]
    step = interval / steps
    numbers = coefficients(model, step)._replace(
        steps=steps,
        push=_push(model.natural**2, model.damping, shafts[:, [0, -1]], step),
        motions=np.ascontiguousarray(shafts.T),
    )
    return ModalCable(
        numbers=numbers,
        interval=interval,
        inputs=(("motor_torque", "N.m"), ("load_torque", "N.m")),
        motions=tuple((name, "rad") for name in names),
        spans=("upper", "lower"),
        highest=HIGHEST_SHARE * model.span_resonance / (2.0 * pi),
        modes=model.natural.size,
        sine=True,
    )


def _network(drive: RoutedDrive, interval: float) -> ModalCable:
    """Linear modes of the network, rigid motions included, about its state of rest."""
    if any(route.speed for route in drive.route):
        raise InputRefused("a running rope (route.speed) has no modes of this kind: set its speed to 0")
    network = network_of(drive)
    top = SHARE_OF_RATE / interval
    squares, shapes = _kept(network, 2.0 * pi * top)
    if squares.size > MOST_MODES:
        top = float(np.sqrt(squares[MOST_MODES])) / (2.0 * pi)
        squares, shapes = squares[:MOST_MODES], shapes[:, :MOST_MODES]
    rows, inputs = _inputs(network)
    damping = modal_damping(network, squares, shapes)
    k = squares.size
    names = piece_names(network)
    numbers = ModalCableNumbers(
        steps=1,
        step=interval,
        along=expm(first_order(squares, damping) * interval),
        push=_push(squares, damping, (rows @ shapes).T, interval),
        across=np.zeros((4, 0)),
        sag=np.zeros((len(names), 0)),
        coupling=np.zeros((k, 0, 0)),
        carried=np.zeros(0),
        stretching=np.zeros(0),
        wave_numbers=np.zeros(0),
        middle=np.zeros(0),
        factors=np.zeros(3),
        motions=np.ascontiguousarray(shapes),
        rest=network.lowest_tension,
        tension=np.ascontiguousarray(network.pull @ shapes),
    )
    return ModalCable(
        numbers=numbers,
        interval=interval,
        inputs=inputs,
        motions=tuple((name, "m" if slides(name) else "rad") for name in network.motion.names),
        spans=names,
        highest=top,
        modes=k,
        sine=False,
    )


def _kept(network: Network, omega: float) -> tuple[Array, Array]:
    """Squares of the frequencies and shapes of unit modal mass, rigid motions first."""
    spectrum = Spectrum(network_of_routes(network, even=True))
    _, shapes = eigh(network.static_stiffness, network.static_mass)
    rigid = spectrum.rigid_body_modes
    groups = coupled_modes(network, spectrum, omega)
    found = [np.zeros(rigid), *(np.full(group.shape[1], square) for square, group, _ in groups)]
    return np.concatenate(found), np.hstack([shapes[:, :rigid], *(group for _, group, _ in groups)])


def modal_damping(network: Network, squares: Array, shapes: Array) -> Array:
    """Damping between the modes, shape (k, k) [1/s].

    Dampers couple the modes; what ropes lose is counted in each mode for itself, from the exact waves with
    their damping at its frequency.
    """
    damping = np.asarray(shapes.T @ network.dampers.matrix @ shapes)
    for i, square in enumerate(squares):
        if square > 0.0:
            omega = float(np.sqrt(square))
            force = dynamic_stiffness(network, complex(omega), damped=True) @ shapes[:, i]
            damping[i, i] = float((shapes[:, i] @ force).imag) / omega
    return damping


def _push(squares: Array, damping: Array, forces: Array, step: float) -> Array:
    """What unit inputs held over a step add to amplitudes and rates; ``forces``, shape (k, i)."""
    k, i = forces.shape
    block = np.zeros((2 * k + i, 2 * k + i))
    block[: 2 * k, : 2 * k] = first_order(squares, damping)
    block[k : 2 * k, 2 * k :] = forces
    return np.ascontiguousarray(expm(block * step)[: 2 * k, 2 * k :])


def _inputs(network: Network) -> tuple[Array, tuple[tuple[str, str], ...]]:
    """Torque of each motor, force or torque on each move of a body: rows and names with units."""
    drive, motion = network.drive, network.motion
    rows = [rotor_turn(motion, number) for number in drive.driven]
    names = [(f"{drive.pulley[number].name}_torque", "N.m") for number in drive.driven]
    for body in drive.body:
        for move in body.moves:
            rows.append(motion.unit(f"{body.name}.{move}"))
            turns = not slides(f".{move}")
            names.append((f"{body.name}.{move}_{'torque' if turns else 'force'}", "N.m" if turns else "N"))
    if not rows:
        raise InputRefused("the machine has no motor and no body that moves: nothing can drive it")
    return np.array(rows), tuple(names)
