"""What a span between rigid supports, or two pulleys on springs without mass, leaves out."""

from dataclasses import dataclass, replace
from math import pi

from cabledrive.mechanics.spans import lumped_cable_mode
from cabledrive.modal.natural import modes
from cabledrive.modal.tuning import pulley_mode
from cabledrive.parameters import Drive, InputRefused
from cabledrive.parameters.fields import described, meaning


@described
@dataclass(frozen=True, slots=True, kw_only=True)
class Comparison:
    """A frequency from a simple formula beside the certified one."""

    simple: float = meaning("frequency from the formula [Hz]")
    exact: float = meaning("certified frequency [Hz]")

    @property
    def deviation(self) -> float:
        """Relative deviation of the simple formula, simple / exact - 1 [-]."""
        return self.simple / self.exact - 1.0


def against_rigid_supports(drive: Drive) -> tuple[Comparison, Comparison]:
    r"""How far rigid supports in place of pulleys and carriages lead astray.

    Eqs. (3.14a), (3.14b) with Le for L:

    .. math:: f_u = \frac{c_u}{2 L_e} = \frac{1}{2 L}\sqrt{EA/\rho_0}, \qquad f_w = \frac{c_w}{2 L_e}

    Parameters
    ----------
    drive : Drive

    Returns
    -------
    longitudinal, transverse : Comparison
        The bare span between rigid supports against the lowest certified mode of each kind.
    """
    found, cable, twice = modes(drive, count=1), drive.cable, 2.0 * drive.pulley_distance
    return (
        Comparison(simple=cable.axial_wave_speed / twice, exact=found.longitudinal[0].frequency),
        Comparison(simple=cable.transverse_wave_speed / twice, exact=found.transverse[0].frequency),
    )


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
