"""A distributed cable, a sample at a time: the fast model of a loop, a network of routes in linear modes."""

from dataclasses import dataclass
from math import ceil, pi

import numpy as np
from scipy.linalg import eigh

from cabledrive.mechanics.mesh import piece_names
from cabledrive.mechanics.network import Network, network_of
from cabledrive.mechanics.network.assembly import rotor_turn
from cabledrive.mechanics.network.motion import Row
from cabledrive.mechanics.network.response import dynamic_stiffness
from cabledrive.modal.route_network import network_of_routes
from cabledrive.modal.spectrum import Spectrum
from cabledrive.parameters import Drive, InputRefused, Machine
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.route.two_pulleys import as_machine
from cabledrive.reduction.fast_simulation import finest_step
from cabledrive.reduction.network_chain import coupled_modes
from cabledrive.reduction.stretches import StretchModel, StretchNumbers, numbers_of
from cabledrive.reduction.uniform_tension import misfit, uniform_tension_model
from cabledrive.simulation.channels import slides

DEFAULT_RATE = 1000.0
"""Of a drive without sensors [Hz]."""
SHARE_OF_RATE = 0.1
"""Modes of a network are kept below this share of the sample rate."""
MOST_MODES = 40


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ModalCable:
    """A cable in modes; ``interval``: of a sample [s]; ``inputs``, ``motions``: names with their units."""

    numbers: StretchNumbers
    interval: float
    inputs: tuple[tuple[str, str], ...]
    motions: tuple[tuple[str, str], ...]
    spans: tuple[str, ...]

    @property
    def highest(self) -> float:
        """Up to which frequency the model goes [Hz]."""
        return self.numbers.model.highest / (2.0 * pi)

    @property
    def sine(self) -> bool:
        """Whether the spans vibrate across and can be plucked."""
        return self.numbers.model.slopes.size > 0


def modal_cable(drive: Machine, sines: int = 8) -> ModalCable:
    """The cable of a drive in modes; ``sines``: across each span of a loop that the fast model fits."""
    rate = (drive.sensors.sample_rate if drive.sensors else None) or DEFAULT_RATE
    loop = drive.plant  # with the names of its file
    if loop is not None and not misfit(loop):
        return _loop(loop, 1.0 / rate, sines)
    turns = loop is not None and not any(pulley.fixed for pulley in loop.pulley)
    return _network(as_machine(loop, loaded=True) if loop and turns else drive, 1.0 / rate)


def _loop(drive: Drive, interval: float, sines: int) -> ModalCable:
    """The equations of `uniform_tension_model`; motion in the plane w of the spans."""
    model = uniform_tension_model(drive, sines)
    steps = ceil(interval / finest_step(model))
    jointed = drive.motor and drive.motor.joint_stiffness
    names, shown = (("motor", "drive", "load"), [2, 0, 1]) if jointed else (("drive", "load"), [0, 1])
    model = model._replace(motions=np.ascontiguousarray(model.motions[shown]))
    return ModalCable(
        numbers=numbers_of(model, interval / steps, steps=steps, inputs=model.motions[[0, -1]].T),
        interval=interval,
        inputs=(("motor_torque", "N.m"), ("load_torque", "N.m")),
        motions=tuple((name, "rad") for name in names),
        spans=("upper", "lower"),
    )


def _network(drive: Machine, interval: float) -> ModalCable:
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
    names = piece_names(network)
    k, straight = squares.size, np.zeros((len(names), 0))
    model = StretchModel(
        natural=np.sqrt(squares),
        damping=modal_damping(network, squares, shapes),
        torque_shape=np.zeros(k),
        transverse=straight,
        mass=straight,
        loss=straight,
        sag=straight,
        coupling=np.zeros((k, *straight.shape)),
        square=straight,
        carried=np.zeros((len(names), len(names))),
        rest=network.lowest_tension,
        tension=np.ascontiguousarray(network.pull @ shapes),
        raised=np.zeros((len(names), len(names))),
        probes=np.zeros((len(names), 0, 1)),
        motions=np.ascontiguousarray(shapes),
        highest=2.0 * pi * top,
    )
    return ModalCable(
        numbers=numbers_of(model, interval, inputs=(rows @ shapes).T),
        interval=interval,
        inputs=inputs,
        motions=tuple((name, "m" if slides(name) else "rad") for name in network.motion.names),
        spans=names,
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
    r"""Damping between the modes, shape (k, k) [1/s].

    Waves of two modes lose :math:`b\int u_i'u_j'` along a rope and :math:`\Gamma\rho\int u_iu_j` across it.
    With the work :math:`A_{ij}` of the forces at the ends of the one on those of the other,

    .. math:: \int R\,u_i'u_j' = \frac{\omega_j^2A_{ij} - \omega_i^2A_{ji}}{\omega_j^2 - \omega_i^2}, \qquad
              \int \rho\,u_iu_j = \frac{A_{ij} - A_{ji}}{\omega_j^2 - \omega_i^2};

    modes of one frequency lose what the exact waves with their damping do.
    """
    loss, drag = np.zeros((2, network.time.size))
    loss[::3] = [piece.rope.axial_damping / piece.rope.axial_rigidity for piece in network.pieces]
    drag[1::3] = drag[2::3] = [piece.rope.transverse_damping for piece in network.pieces]
    near, far, phase = network.start @ shapes, network.end @ shapes, np.outer(network.time, np.sqrt(squares))
    scale = (network.ropes * network.impedance / network.time)[:, None] / np.sinc(phase / pi)
    first, last = scale * (np.cos(phase) * near - far), scale * (np.cos(phase) * far - near)
    strain, moved = (first.T @ (own[:, None] * near) + last.T @ (own[:, None] * far) for own in (loss, drag))
    apart = squares - squares[:, None]
    same = np.abs(apart) <= 1e-6 * squares
    lost = squares * strain - squares[:, None] * strain.T + moved - moved.T
    damping = shapes.T @ network.dampers.matrix @ shapes + lost / np.where(same, np.inf, apart)
    for i, omega in enumerate(np.sqrt(squares)):
        if omega > 0.0:
            force = shapes[:, i] @ dynamic_stiffness(network, complex(omega), damped=True).imag / omega
            damping[i, same[i]] = force @ shapes[:, same[i]]
    return np.asarray(damping)


def _inputs(network: Network) -> tuple[Array, tuple[tuple[str, str], ...]]:
    """Torque on what a run turns, force or torque on each move of a body: rows and names with units."""
    drive, motion = network.drive, network.motion
    driven = [number for number in drive.turned if not drive.pulley[number].fixed]
    rows: list[Row | str] = [rotor_turn(motion, number) for number in driven]
    names = [(f"{drive.pulley[number].name}_torque", "N.m") for number in driven]
    for body in drive.body:
        for move in body.moves:
            rows.append(f"{body.name}.{move}")
            turns = not slides(f".{move}")
            names.append((f"{body.name}.{move}_{'torque' if turns else 'force'}", "N.m" if turns else "N"))
    if not rows:
        raise InputRefused("no pulley turns by a torque and no body moves: nothing can drive the machine")
    return motion.dense(*rows), tuple(names)
