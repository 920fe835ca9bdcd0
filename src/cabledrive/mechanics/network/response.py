r"""Frequency response of a machine with routes, from the exact waves on its spans.

With damping the waves along a span have :math:`R = EA + i\omega b`, those across it
:math:`\rho (1 - i\Gamma/\omega)` in place of :math:`\rho`; with the impedances and travel times that follow,
Eq. (N.5) is the dynamic stiffness at a complex frequency as well.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.network.assembly import Network, network_of
from cabledrive.parameters.arrays import Array, Complex
from cabledrive.parameters.errors import InputRefused, NotComputed
from cabledrive.parameters.route import RoutedDrive


def network_response(
    network: Network,
    omega: Array,
    force: Array,
    output: Array,
    *,
    loss_factor: float | None = None,
) -> Complex:
    r"""Motion of outputs per unit force, :math:`B D(\omega)^{-1} f` with the dynamic stiffness D, Eq. (N.7).

    ``omega``, shape (p,): [rad/s], above 0; ``force``, shape (n,): on the coordinates; ``output``, shape
    (k, n): rows; ``loss_factor``: in place of all damping of the file, of every stiffness.
    Returns shape (p, k). Raises `NotComputed` where a frequency is one of an undamped mode.
    """
    found = np.empty((omega.size, output.shape[0]), dtype=np.complex128)
    for number, w in enumerate(omega):
        if loss_factor is None:
            stiffness = dynamic_stiffness(network, complex(w), damped=True)
        else:  # K (1 + i eta) - w^2 M is (1 + i eta) times the undamped one at w / sqrt(1 + i eta)
            scale = 1.0 + 1j * loss_factor
            stiffness = scale * dynamic_stiffness(network, w / np.sqrt(scale), damped=False)
        try:
            found[number] = output @ np.linalg.solve(stiffness, force.astype(np.complex128))
        except np.linalg.LinAlgError:
            raise NotComputed(
                f"{w / (2 * np.pi):.9g} Hz is a natural frequency without damping: give the machine damping"
            ) from None
    return found


def dynamic_stiffness(network: Network, omega: complex, *, damped: bool) -> Complex:
    """Force per motion of the coordinates, shape (n, n)."""
    impedance, time = _waves(network, omega, damped=damped)
    alpha, phase = omega * time, np.exp(1j * omega * network.lag)
    stretch = phase[:, None] * network.start - network.end
    # Where ropes run, the transpose conjugate of a row has the phase turned back, not the frequency's part.
    back = network.start / phase[:, None] - network.end
    link = network.ropes * impedance / np.sin(alpha)
    edge = -network.ropes * impedance * np.tan(0.5 * alpha)
    total: NDArray[Any] = (back.T * link) @ stretch
    total = total + (network.start.T * edge) @ network.start + (network.end.T * edge) @ network.end
    total = omega * total + network.springs.matrix + network.geometric - omega**2 * network.masses.matrix
    if damped:
        total = total + 1j * omega * network.dampers.matrix
    return np.asarray(total)


def _waves(network: Network, omega: complex, *, damped: bool) -> tuple[Complex, Complex]:
    """Impedance of one rope and travel time of each link; those of a rope that runs without damping."""
    impedance, time = network.impedance.astype(np.complex128), network.time.astype(np.complex128)
    if not damped:
        return impedance, time
    for link in np.flatnonzero(network.lag == 0.0):
        rope = network.pieces[link // 3].rope
        if link % 3 == 0:
            root = np.sqrt(1.0 + 1j * omega * rope.axial_damping / rope.axial_rigidity)
            impedance[link], time[link] = impedance[link] * root, time[link] / root
        else:
            root = np.sqrt(1.0 - 1j * rope.transverse_damping / omega)
            impedance[link], time[link] = impedance[link] * root, time[link] * root
    return impedance, time


def machine_response(
    drive: RoutedDrive, frequency: Array, force_on: str, motion_of: str, *, motor: str | None = None
) -> Complex:
    """Motion of one coordinate of a machine with routes per force or torque on another, with its own damping.

    Parameters
    ----------
    drive : RoutedDrive
    frequency : ndarray, shape (p,)
        [Hz], above 0.
    force_on, motion_of : str
        Coordinates: "head.x", "arm.turn", the name of a pulley; of a motor's pulley its rotor.
    motor : {"free", "held", "holding"}, optional
        How the rotors are held; default: "holding" where the file gives a holding stiffness, else "free".

    Returns
    -------
    ndarray of complex, shape (p,)
        [m/N], [rad/N m] or between them; Coulomb friction is left out.

    Raises
    ------
    InputRefused
        If there is no such coordinate, or a frequency is not above 0.
    NotComputed
        If a frequency is that of an undamped mode.
    """
    if not (np.all(np.isfinite(frequency)) and np.all(frequency > 0.0)):
        raise InputRefused("frequency must be finite and above 0 Hz at every line")
    network = network_of(drive, motor=motor)
    force, output = (_coordinate(network, name) for name in (force_on, motion_of))
    return network_response(network, 2.0 * np.pi * frequency, force, output[None, :])[:, 0]


def _coordinate(network: Network, name: str) -> Array:
    """Row of a coordinate by its name."""
    rotor = f"rotor of {name}"
    if rotor in network.motion.names:
        return network.motion.unit(rotor)
    if name not in network.motion.names:
        known = ", ".join(network.motion.names[:20])
        raise InputRefused(f'"{name[:60]}" is no coordinate that moves: take one of {known}')
    return network.motion.unit(name)
