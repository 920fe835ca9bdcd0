"""Compiled cable laws: what every segment carries, from the displacements of its ends.

Twins of `cabledrive.mechanics.cable_law.CableLaw.excess_components`. Each returns how many are slack.
"""

from math import sqrt

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.compiled import for_kernels, njit_in_place, njit_inlined
from cabledrive.simulation.runs import LARGEST_Z, SERIES

EXACT, WEAK, WEAK_CONSISTENT, LINEAR = range(4)

C0, C1, C2, C3, C4, C5, C6, C7 = SERIES


@njit_in_place
@for_kernels
def segment_tensions(
    law: int,
    tension_only: bool,
    pretension: float,
    rigidity: float,
    x: Array,
    inverse_spacing: Array,
    p: Array,
) -> int:
    """Components above the pretension of all segments, into p (3, segments); the number of slack ones."""
    slack_strain = -pretension / (rigidity + pretension)
    if law == EXACT:
        slack_z = (1.0 + slack_strain) ** 2 - 1.0
        slack = _exact_by_polynomial(pretension, rigidity, slack_z, x, inverse_spacing, p)
        if slack > 0:  # or out of the polynomial's range
            slack = _exact(pretension, rigidity, slack_z, x, inverse_spacing, p)
    else:
        slack = _truncated(law, pretension, rigidity, slack_strain, x, inverse_spacing, p)
    if slack > 0 and tension_only:
        for i in range(p.shape[1]):
            if segment_strain(law, x, inverse_spacing, i) < slack_strain:
                p[0, i] = -pretension
                p[1, i] = 0.0
                p[2, i] = 0.0
    return slack


@njit_in_place
@for_kernels
def segment_strain(law: int, x: Array, inverse_spacing: Array, i: int) -> float:
    """Apparent strain of one segment."""
    h = inverse_spacing[i]
    u_x = (x[0, i + 1] - x[0, i]) * h
    if law == LINEAR:
        return u_x
    return u_x + transverse_stretch(law, u_x, (x[1, i + 1] - x[1, i]) * h, (x[2, i + 1] - x[2, i]) * h)


@njit_in_place
@for_kernels
def transverse_stretch(law: int, u_x: float, v_x: float, w_x: float) -> float:
    """What the slopes add to the stretch of one segment."""
    slopes = v_x * v_x + w_x * w_x
    if law == EXACT:
        return slopes / (sqrt((1.0 + u_x) ** 2 + slopes) + 1.0 + u_x)
    return 0.5 * slopes


@njit_inlined
def _exact_by_polynomial(
    pretension: float,
    rigidity: float,
    slack_z: float,
    x: Array,
    inverse_spacing: Array,
    p: Array,
) -> int:
    """Exact law without root or division; returns how many segments are slack or out of its range."""
    lowest = max(slack_z, -LARGEST_Z)
    centre = 0.5 * (LARGEST_Z + lowest)
    reach = 0.5 * (LARGEST_Z - lowest)
    outside = 0
    for i in range(p.shape[1]):
        h = inverse_spacing[i]
        u_x = (x[0, i + 1] - x[0, i]) * h
        v_x = (x[1, i + 1] - x[1, i]) * h
        w_x = (x[2, i + 1] - x[2, i]) * h
        z = u_x * (2.0 + u_x) + v_x * v_x + w_x * w_x
        series = C0 + z * (C1 + z * (C2 + z * (C3 + z * (C4 + z * (C5 + z * (C6 + z * C7))))))
        gain = rigidity * z * series
        across = pretension + gain
        p[0, i] = pretension * u_x + gain * (1.0 + u_x)
        p[1, i] = across * v_x
        p[2, i] = across * w_x
        outside += abs(z - centre) > reach
    return outside


@njit_in_place
def _exact(
    pretension: float,
    rigidity: float,
    slack_z: float,
    x: Array,
    inverse_spacing: Array,
    p: Array,
) -> int:
    slack = 0
    for i in range(p.shape[1]):
        h = inverse_spacing[i]
        u_x = (x[0, i + 1] - x[0, i]) * h
        v_x = (x[1, i + 1] - x[1, i]) * h
        w_x = (x[2, i + 1] - x[2, i]) * h
        z = u_x * (2.0 + u_x) + v_x * v_x + w_x * w_x
        gain = rigidity * z / (1.0 + z + sqrt(1.0 + z))
        across = pretension + gain
        p[0, i] = pretension * u_x + gain * (1.0 + u_x)
        p[1, i] = across * v_x
        p[2, i] = across * w_x
        slack += z < slack_z
    return slack


@njit_in_place
def _truncated(
    law: int,
    pretension: float,
    rigidity: float,
    slack_strain: float,
    x: Array,
    inverse_spacing: Array,
    p: Array,
) -> int:
    """Weak, consistently weak and linear law."""
    stiffness = rigidity + pretension
    slack = 0
    for i in range(p.shape[1]):
        h = inverse_spacing[i]
        u_x = (x[0, i + 1] - x[0, i]) * h
        v_x = (x[1, i + 1] - x[1, i]) * h
        w_x = (x[2, i + 1] - x[2, i]) * h
        strain = u_x + 0.5 * (v_x * v_x + w_x * w_x)
        if law == WEAK:
            gain = rigidity * strain / (1.0 + strain)
            across = pretension + gain
            along = pretension * u_x + gain * (1.0 + u_x)
        elif law == WEAK_CONSISTENT:
            along = stiffness * strain
            across = pretension + along
        else:
            strain = u_x
            along = stiffness * u_x
            across = pretension
        p[0, i] = along
        p[1, i] = across * v_x
        p[2, i] = across * w_x
        slack += strain < slack_strain
    return slack
