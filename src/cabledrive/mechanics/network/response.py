r"""The response of a network to forces at a frequency, with the waves of its ropes.

A rope without weight has the waves of Eq. (N.3) in closed form. Of one that hangs, motion r and force F at
the unstretched place s follow

.. math:: r' = E^{-1} (F + i\omega\rho v\,r), \quad
          F' = -\omega^2 \rho\,\mathrm{diag}(1, q, q)\,r + i\omega\rho v\,r', \qquad
          E = (EA + i\omega b)\,tt^T + \frac{T}{1 + T/EA}\,(1 - tt^T) - \rho v^2, \quad
          q = 1 - \frac{i\Gamma}{\omega}

with its direction t and tension T at rest and the unstretched speed v of one that runs, then without
:math:`\Gamma`. They are taken from end to end by products of exponentials of fourth order (Magnus), exact in
the waves, so that steps follow the change of direction and tension alone.
"""

from collections.abc import Sequence
from itertools import compress
from math import hypot, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.network.assembly import Network, network_of
from cabledrive.mechanics.network.motion import OUT_OF_PLANE
from cabledrive.mechanics.network.pieces import Piece
from cabledrive.parameters import Machine
from cabledrive.parameters.arrays import Array, Complex
from cabledrive.parameters.errors import InputRefused, NotComputed

STEPS = 8
"""Steps along a rope that hangs, beyond one per radian of its slowest wave."""

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

    ``omega``, shape (p,): [rad/s], above 0; ``force``, shape (n,) or (n, f): on the coordinates; ``output``,
    shape (k, n): rows; ``loss_factor``: in place of all damping of the file, of every stiffness.
    Returns shape (p, k) or (p, k, f). Raises `NotComputed` where a frequency is one of an undamped mode.
    """
    # K (1 + i eta) - w^2 M is (1 + i eta) times the undamped one at w / sqrt(1 + i eta)
    scale = 1.0 if loss_factor is None else 1.0 + 1j * loss_factor
    forces = force.astype(np.complex128).reshape(len(force), -1)
    found = np.empty((omega.size, output.shape[0], forces.shape[1]), dtype=np.complex128)
    together = max(1, TOGETHER // max(1, network.start.size))
    for first in range(0, omega.size, together):
        here = slice(first, first + together)
        stiffness = scale * dynamic_stiffness(
            network, omega[here] / np.sqrt(scale), damped=loss_factor is None, hanging=True
        )
        try:
            found[here] = output @ np.linalg.solve(stiffness, forces)
        except np.linalg.LinAlgError:
            w = omega[here][np.argmin(np.abs(np.linalg.det(stiffness)))]
            raise NotComputed(
                f"{w / (2 * np.pi):.9g} Hz is a natural frequency without damping: give the machine damping"
            ) from None
    return found[..., 0] if force.ndim == 1 else found


def dynamic_stiffness(
    network: Network, omega: Complex | complex, *, damped: bool, hanging: bool = False
) -> Complex:
    """Force per motion of the coordinates at frequencies, shape (...,) [rad/s]; shape (..., n, n).

    ``hanging``: about where ropes hang, else as if each were straight under an even tension.
    """
    hangs = [hanging and any(piece.rest.load) for piece in network.pieces]
    taut = np.repeat(np.logical_not(hangs), 3)
    w = np.asarray(omega, dtype=np.complex128)[..., None]
    impedance, time, lag = network.impedance, network.time, network.lag
    if damped:  # of a rope that runs none across
        along = np.arange(time.size) % 3 == 0
        ropes = [network.pieces[link // 3].rope for link in range(time.size)]
        loss = np.array([rope.axial_damping / rope.axial_rigidity for rope in ropes])
        lost, drag = np.sqrt(1.0 + 1j * w * loss), [rope.transverse_damping for rope in ropes]
        slow = np.where(lag != 0.0, 1.0, np.sqrt(1.0 - 1j * np.array(drag) / w))
        root, flow = np.where(along, 1.0 / lost, slow), lag / time  # speed over that of its waves
        impedance = impedance * np.where(along, lost, root)
        time = time * root * (1.0 - flow**2) / (1.0 - (flow * root) ** 2)
        lag = time * flow * root
    alpha, phase = w * time, np.exp(1j * w * lag)[..., None]
    stretch = phase * network.start - network.end
    # Where ropes run, the transpose conjugate of a row has the phase turned back, not the frequency's part.
    back = network.start / phase - network.end
    link = (taut * network.ropes * impedance / np.sin(alpha))[..., None]
    edge = (taut * network.ropes * -impedance * np.tan(0.5 * alpha))[..., None]
    total: NDArray[Any] = (back * link).swapaxes(-1, -2) @ stretch
    total = total + network.start.T @ (edge * network.start) + network.end.T @ (edge * network.end)
    w = w[..., None]
    total = w * total
    for piece in compress(network.pieces, hangs):
        ends = [(*piece.moves(start), piece.rows[OUT_OF_PLANE][not start]) for start in (True, False)]
        rows = network.motion.dense(*(row for u, w_row, v in ends for row in (u, v, w_row)))
        total = total + piece.route.ropes * rows.T @ hung_stiffness(piece, w[..., 0, 0], damped=damped) @ rows
    total = total + network.springs.matrix + network.geometric - w**2 * network.masses.matrix
    return np.asarray(total + 1j * w * network.dampers.matrix * damped)


def hung_stiffness(piece: Piece, omega: Complex, *, damped: bool) -> Complex:
    """Force per motion u, v, w of both ends of a rope that hangs, (..., 6, 6) [N/m]; ``omega``: [rad/s]."""
    from scipy.linalg import expm

    rope, rest = piece.rope, piece.rest
    slowest = max(min(hypot(*rest.force), hypot(*rest.end_force)), 1e-9 * max(rest.tensions))
    flow = rope.density * piece.speed
    unit = np.sqrt(slowest * rope.density) * omega[..., None, None]  # of the force, so that both are alike
    wave = (abs(flow) + sqrt(flow**2 + slowest * rope.density)) / slowest  # the shorter one
    turn = float(np.abs(omega).max()) * wave * rest.length
    count = STEPS + int(turn)
    h = rest.length / count
    gauss = np.array([0.5 - sqrt(3.0) / 6.0, 0.5 + sqrt(3.0) / 6.0])
    places = rest.start + h * (np.arange(count)[:, None] + gauss).ravel()
    along, across = rest.force_at(places)
    force = np.hypot(along, across)
    t = np.stack([along, 0.0 * along, across], axis=-1) / force[:, None]
    both = t[:, :, None] * t[:, None, :]
    stiff = rope.axial_rigidity + 1j * omega[..., None, None, None] * rope.axial_damping * damped
    soft = (force * (rope.axial_rigidity - rest.flow) / (rope.axial_rigidity + force))[:, None, None]
    gives = both / (stiff - rest.flow) + (np.eye(3) - both) / soft
    turned = 1j * flow * omega[..., None, None, None] * gives
    drag = rope.transverse_damping * (damped and not flow) * np.array([0.0, 1.0, 1.0])
    inertia = rope.density * omega[..., None] * (omega[..., None] - 1j * drag)
    slope = np.zeros((*omega.shape, places.size, 6, 6), dtype=np.complex128)
    slope[..., :3, 3:] = unit[..., None, :, :] * gives
    slope[..., 3:, :3] = (-inertia / unit[..., 0])[..., None, :, None] * np.eye(3)
    slope[..., 3:, :3] += 1j * flow * (omega[..., None, None] / unit)[..., None, :, :] * turned
    slope[..., :3, :3] = slope[..., 3:, 3:] = turned
    one, two = slope[..., ::2, :, :], slope[..., 1::2, :, :]
    steps = expm(0.5 * h * (one + two) + sqrt(3.0) / 12.0 * h**2 * (two @ one - one @ two))
    whole = steps[..., 0, :, :]
    for number in range(1, count):
        whole = steps[..., number, :, :] @ whole
    by_force = np.linalg.inv(whole[..., :3, 3:])  # force at the start for a motion of the end
    start = by_force @ whole[..., :3, :3]
    far = whole[..., 3:, 3:] @ by_force
    top = np.concatenate([start, -by_force], axis=-1)
    below = np.concatenate([whole[..., 3:, :3] - far @ whole[..., :3, :3], far], axis=-1)
    return np.asarray(unit * np.concatenate([top, below], axis=-2))


def responses(drive: Machine, frequency: Array, names: Sequence[str], *, motor: str | None = None) -> Complex:
    """Motions of coordinates of a machine with routes per force or torque on each, with its own damping.

    ``frequency``, (p,): [Hz], above 0; ``names``: of k coordinates, "head.x", "arm.turn", the name of a
    pulley, of a motor's pulley its rotor; ``motor``: as of `network_of`.
    Returns (p, k, k), motions before forces [m/N], [rad/N m] or between them; Coulomb friction is left out.
    Raises `InputRefused` if there is no such coordinate or a frequency is not above 0, `NotComputed` at that
    of an undamped mode.
    """
    if not (np.all(np.isfinite(frequency)) and np.all(frequency > 0.0)):
        raise InputRefused("frequency must be finite and above 0 Hz at every line")
    network = network_of(drive, motor=motor)
    rows = network.motion.dense(*(_coordinate(network, name) for name in names))
    return network_response(network, 2.0 * np.pi * frequency, rows.T, rows)


def _coordinate(network: Network, name: str) -> str:
    """A coordinate by the name that a user gives it."""
    rotor = f"rotor of {name}"
    if rotor in network.motion.names:
        return rotor
    if name not in network.motion.names:
        known = ", ".join(network.motion.names[:20])
        raise InputRefused(f'"{name[:60]}" is no coordinate that moves: take one of {known}')
    return name
