r"""The modal matrices as the dissertation prints them, with the corrections of the errata.

Each is singular at the natural frequencies of its machine. They are kept for comparison: the modes of this
package come from the dynamic stiffness, which has fewer unknowns and counts its zeros.

Unknowns are the coefficients of :math:`U_i = a_i\cos(\omega x_i/c_u) + b_i\sin(\omega x_i/c_u)`, first all a,
then all b; pieces 1, 2 are the upper span where it has a carriage, 3, 4 the lower one. Each function takes
sines and cosines of the phases :math:`\omega L_i/c_u` of the pieces of cable, and the masses
:math:`m\omega/(c_u\rho)` against the wave impedance, both in order of the chain from the drive pulley.
"""

import numpy as np

from cabledrive.mechanics.spans import longitudinal_chains
from cabledrive.parameters import Drive, InputRefused
from cabledrive.parameters.arrays import Array


def loop_matrix(sin: Array, cos: Array, mass: Array) -> Array:
    """Modal matrix of two pulleys and a cable loop, Eqs. (3.12), (3.13)."""
    s, c, (j1, j2) = sin[0], cos[0], mass
    return np.array([[j1, s, 1, -c], [s, j2, -c, 1], [1, -c, 0, -s], [-c, 1, -s, 0]])


def loop_with_carriage_matrix(sin: Array, cos: Array, mass: Array) -> Array:
    """Modal matrix of a cable loop that carries one mass on its upper span, Eqs. (3.19), (3.20)."""
    (s1, s2, se), (c1, c2, ce), (j1, m, j2) = sin, cos, mass
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


def line_with_carriage_matrix(sin: Array, cos: Array, mass: Array) -> Array:
    """Modal matrix of an open line that carries one mass, Eqs. (3.25), (3.26)."""
    (s1, s2), (c1, c2), (j1, m, j2) = sin, cos, mass
    return np.array([[s1, m, -c1, 1], [j1, 0, 1, 0], [0, -j2 * c2 - s2, 0, -j2 * s2 + c2], [c1, -1, s1, 0]])


def loop_with_two_carriages_matrix(sin: Array, cos: Array, mass: Array) -> Array:
    r"""Modal matrix of a cable loop that carries one mass on each span, Eq. (3.38).

    Rows 3 and 4 hold :math:`J\omega/(c_u\rho r^2)`; the scanned text has lost letters there.
    """
    (s1, s2, s3, s4), (c1, c2, c3, c4), (j1, m1, j2, m2) = sin, cos, mass
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


FORMS = {
    ("loop", 0, 0): loop_matrix,
    ("loop", 1, 0): loop_with_carriage_matrix,
    ("line", 1, 0): line_with_carriage_matrix,
    ("loop", 1, 1): loop_with_two_carriages_matrix,
}
"""By kind of machine and carriages on the upper and the lower span."""


def modal_matrix(drive: Drive, omega: float) -> Array:
    """The printed matrix of a drive at an angular frequency [rad/s].

    Raises `InputRefused` if the print has none for it.
    """
    form = (drive.kind, len(drive.carriages_on("upper")), len(drive.carriages_on("lower")))
    chain = longitudinal_chains(drive)[0].chain
    sprung = chain.pendant is not None or chain.grounds is not None
    if form not in FORMS or any(pulley.fixed for pulley in drive.pulley) or sprung:
        raise InputRefused(
            f"no matrix is printed of a {form[0]} with {form[1]} carriages on the upper and {form[2]} on the "
            "lower span, a pulley that is held, a flexible motor joint or a motor on a spring: take its modes"
        )
    cable, stretch = drive.cable, 1.0 + drive.cable.prestrain
    phase = omega * stretch * chain.lengths / cable.axial_wave_speed
    mass = omega * chain.masses / (cable.axial_wave_speed * cable.stretched_mass_per_length)
    return FORMS[form](np.sin(phase), np.cos(phase), mass)
