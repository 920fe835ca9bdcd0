r"""The modal matrices as the dissertation prints them, with the corrections of the errata.

Each is singular at the natural frequencies of its machine. They are kept for comparison: the modes of this
package come from the dynamic stiffness, which has fewer unknowns and counts its zeros.

Unknowns are the coefficients of :math:`U_i = a_i\cos(\omega x_i/c_u) + b_i\sin(\omega x_i/c_u)`. In the
stretched metres of the print, :math:`\omega L_i/c_u` is the phase of a wave along a piece of cable and
:math:`m\omega/(c_u\rho)` the mass m against the wave impedance :math:`c_u\rho`.
"""

from dataclasses import dataclass

import numpy as np

from cabledrive.mechanics.spans import longitudinal_chains
from cabledrive.parameters import Drive, InputRefused
from cabledrive.parameters.arrays import Array


@dataclass(frozen=True, slots=True, eq=False)
class _Pieces:
    """Sines and cosines of the pieces of cable, and the masses over the impedance, in order of the chain."""

    sin: Array
    cos: Array
    mass: Array


def loop_matrix(drive: Drive, omega: float) -> Array:
    r"""Modal matrix of two pulleys and a cable loop, Eqs. (3.12), (3.13).

    ``drive``: a loop without carriages; ``omega``: angular frequency [rad/s].
    Returns shape (4, 4): for the unknowns a1, a2, b1, b2.
    Raises `InputRefused` if the drive is not of that form.
    """
    piece = _pieces(drive, omega, "loop", upper=0, lower=0)
    s, c = piece.sin[0], piece.cos[0]
    j1, j2 = piece.mass
    return np.array([[j1, s, 1, -c], [s, j2, -c, 1], [1, -c, 0, -s], [-c, 1, -s, 0]])


def loop_with_carriage_matrix(drive: Drive, omega: float) -> Array:
    r"""Modal matrix of a cable loop that carries one mass on its upper span, Eqs. (3.19), (3.20).

    ``drive``: a loop with one carriage, on the upper span; ``omega``: angular frequency [rad/s].
    Returns shape (6, 6): for the unknowns a1, a2, a3, b1, b2, b3.
    Raises `InputRefused` if the drive is not of that form.
    """
    piece = _pieces(drive, omega, "loop", upper=1, lower=0)
    (s1, s2, se), (c1, c2, ce) = piece.sin, piece.cos
    j1, m, j2 = piece.mass
    return np.array(
        [
            [s1, m, 0, -c1, 1, 0],
            [j1, 0, se, 1, 0, -ce],
            [0, s2, j2, 0, -c2, 1],
            [1, 0, -ce, 0, 0, -se],
            [0, -c2, 1, 0, -s2, 0],
            [-c1, 1, 0, -s1, 0, 0],
        ]
    )


def line_with_carriage_matrix(drive: Drive, omega: float) -> Array:
    r"""Modal matrix of an open line that carries one mass, Eqs. (3.25), (3.26).

    ``drive``: a line with one carriage; ``omega``: angular frequency [rad/s].
    Returns shape (4, 4): for the unknowns a1, a2, b1, b2.
    Raises `InputRefused` if the drive is not of that form.
    """
    piece = _pieces(drive, omega, "line", upper=1, lower=0)
    (s1, s2), (c1, c2) = piece.sin, piece.cos
    j1, m, j2 = piece.mass
    return np.array([[s1, m, -c1, 1], [j1, 0, 1, 0], [0, -j2 * c2 - s2, 0, -j2 * s2 + c2], [c1, -1, s1, 0]])


def loop_with_two_carriages_matrix(drive: Drive, omega: float) -> Array:
    r"""Modal matrix of a cable loop that carries one mass on each span, Eq. (3.38).

    Rows 3 and 4 hold :math:`J\omega/(c_u\rho r^2)`; the scanned text has lost letters there.

    ``drive``: a loop with one carriage on each span; ``omega``: angular frequency [rad/s].
    Returns shape (8, 8): for the unknowns a1 to a4, b1 to b4; pieces 1, 2 are the upper span, 3, 4 the lower
    one.
    Raises `InputRefused` if the drive is not of that form.
    """
    piece = _pieces(drive, omega, "loop", upper=1, lower=1)
    (s1, s2, s3, s4), (c1, c2, c3, c4) = piece.sin, piece.cos
    j1, m1, j2, m2 = piece.mass
    return np.array(
        [
            [s1, m1, 0, 0, -c1, 1, 0, 0],
            [0, 0, s3, m2, 0, 0, -c3, 1],
            [j1, 0, 0, s4, 1, 0, 0, -c4],
            [0, s2, j2, 0, 0, -c2, 1, 0],
            [1, 0, 0, -c4, 0, 0, 0, -s4],
            [0, -c2, 1, 0, 0, -s2, 0, 0],
            [-c1, 1, 0, 0, -s1, 0, 0, 0],
            [0, 0, -c3, 1, 0, 0, -s3, 0],
        ]
    )


def _pieces(drive: Drive, omega: float, kind: str, *, upper: int, lower: int) -> _Pieces:
    carried = (len(drive.carriages_on("upper")), len(drive.carriages_on("lower")))
    if drive.kind != kind or carried != (upper, lower):
        raise InputRefused(
            f"this matrix is of a {kind} with {upper} carriages on the upper span and {lower} on the lower, "
            f"the drive a {drive.kind} with {carried[0]} and {carried[1]}: take its modes instead"
        )
    if any(pulley.fixed for pulley in drive.pulley):
        raise InputRefused("this matrix has two pulleys that turn, but one is fixed: take the modes instead")
    chain = longitudinal_chains(drive)[0].chain
    if chain.pendant is not None:
        raise InputRefused(
            "this matrix has no flexible motor joint: leave out motor.joint_stiffness or take the modes"
        )
    if chain.grounds is not None:
        raise InputRefused(
            "this matrix is of a motor that turns freely: leave out motor.holding_stiffness or take the modes"
        )
    cable, stretch = drive.cable, 1.0 + drive.cable.prestrain
    phase = omega * stretch * chain.lengths / cable.axial_wave_speed
    impedance = cable.axial_wave_speed * cable.stretched_mass_per_length
    return _Pieces(np.sin(phase), np.cos(phase), omega * chain.masses / impedance)
