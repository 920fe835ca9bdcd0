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

TOGETHER = 1_000_000
"""Entries of rows that are held at a time."""


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
    # K (1 + i eta) - w^2 M is (1 + i eta) times the undamped one at w / sqrt(1 + i eta)
    scale = 1.0 if loss_factor is None else 1.0 + 1j * loss_factor
    found = np.empty((omega.size, output.shape[0]), dtype=np.complex128)
    together = max(1, TOGETHER // max(1, network.start.size))
    for first in range(0, omega.size, together):
        here = slice(first, first + together)
        stiffness = scale * dynamic_stiffness(
            network, omega[here] / np.sqrt(scale), damped=loss_factor is None
        )
        try:
            found[here] = np.linalg.solve(stiffness, force.astype(np.complex128)[:, None])[..., 0] @ output.T
        except np.linalg.LinAlgError:
            w = omega[here][np.argmin(np.abs(np.linalg.det(stiffness)))]
            raise NotComputed(
                f"{w / (2 * np.pi):.9g} Hz is a natural frequency without damping: give the machine damping"
            ) from None
    return found


def dynamic_stiffness(network: Network, omega: Complex | complex, *, damped: bool) -> Complex:
    """Force per motion of the coordinates at frequencies, shape (...,) [rad/s]; shape (..., n, n)."""
    w = np.asarray(omega, dtype=np.complex128)[..., None]
    impedance, time = network.impedance, network.time
    if damped:  # of a rope that runs without damping
        along = np.arange(time.size) % 3 == 0
        ropes = [network.pieces[link // 3].rope for link in range(time.size)]
        loss = np.array([rope.axial_damping / rope.axial_rigidity for rope in ropes])
        lost, drag = np.sqrt(1.0 + 1j * w * loss), [rope.transverse_damping for rope in ropes]
        root = np.where(
            network.lag != 0.0, 1.0, np.where(along, 1.0 / lost, np.sqrt(1.0 - 1j * np.array(drag) / w))
        )
        impedance, time = impedance * np.where(along, 1.0 / root, root), time * root
    alpha, phase = w * time, np.exp(1j * w * network.lag)[..., None]
    stretch = phase * network.start - network.end
    # Where ropes run, the transpose conjugate of a row has the phase turned back, not the frequency's part.
    back = network.start / phase - network.end
    link = (network.ropes * impedance / np.sin(alpha))[..., None]
    edge = (-network.ropes * impedance * np.tan(0.5 * alpha))[..., None]
    total: NDArray[Any] = (back * link).swapaxes(-1, -2) @ stretch
    total = total + network.start.T @ (edge * network.start) + network.end.T @ (edge * network.end)
    w = w[..., None]
    total = w * total + network.springs.matrix + network.geometric - w**2 * network.masses.matrix
    return np.asarray(total + 1j * w * network.dampers.matrix * damped)


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
