"""Two pulleys on springs without mass, against the exact pulley mode."""

from dataclasses import replace
from math import pi

from cabledrive.mechanics.lumped_modes import lumped_cable_mode
from cabledrive.modal.rigid_supports import Comparison
from cabledrive.modal.tuning import pulley_mode
from cabledrive.parameters import Drive, InputRefused


def against_lumped_springs(drive: Drive) -> Comparison:
    r"""How far a cable of springs without mass leads astray.

    The simple frequency is that of `lumped_cable_mode` with :math:`k = EA/L`,
    :math:`\omega = \sqrt{2k\,(r_1^2/J_1 + r_2^2/J_2)}` for a loop; carriages are left out, the motor joint is
    taken as rigid. On a bare drive it is too high, to first order in the mass :math:`m_c` of the cable by

    .. math:: \frac{m_c}{6\mu}\Big(1 - \frac{3\mu}{m_1 + m_2}\Big), \qquad
              \mu = \frac{m_1 m_2}{m_1 + m_2}, \quad m_i = J_i/r_i^2 \qquad \text{Eq. (M.7)}

    Parameters
    ----------
    drive : Drive

    Returns
    -------
    Comparison
        Against the certified `pulley_mode`.

    Raises
    ------
    InputRefused
        If both pulleys are fixed.
    """
    simple = lumped_cable_mode(replace(drive, lumped=None))
    if simple is None:
        raise InputRefused("both pulleys are fixed, so that no mode turns one: leave out pulley.0.fixed or 1")
    return Comparison(simple=simple / (2 * pi), exact=pulley_mode(drive).omega / (2 * pi))
