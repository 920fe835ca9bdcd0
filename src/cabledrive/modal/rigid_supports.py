"""A span between rigid supports in place of the pulleys, and what the pulleys make of it."""

from dataclasses import dataclass

from cabledrive.modal.natural import modes
from cabledrive.parameters import Drive


@dataclass(frozen=True, slots=True, kw_only=True)
class Comparison:
    """A frequency from a simple formula beside the certified one.

    Attributes
    ----------
    simple : float
        Frequency from the formula [Hz].
    exact : float
        Certified frequency [Hz].
    """

    simple: float
    exact: float

    @property
    def deviation(self) -> float:
        """Relative deviation of the simple formula, simple / exact - 1 [-]."""
        return self.simple / self.exact - 1.0


def rigid_support_longitudinal(drive: Drive) -> float:
    r"""Lowest longitudinal frequency of a bare span between rigid supports, Eq. (3.14a), with Le for L.

    .. math:: f = \frac{c_u}{2 L_e} = \frac{1}{2 L}\sqrt{EA/\rho_0}

    Returns frequency [Hz].
    """
    return drive.cable.axial_wave_speed / (2.0 * drive.pulley_distance)


def rigid_support_transverse(drive: Drive) -> float:
    r"""Lowest transverse frequency of a bare span between rigid supports, Eq. (3.14b), with Le for L.

    .. math:: f = \frac{c_w}{2 L_e}

    Returns frequency [Hz].
    """
    return drive.cable.transverse_wave_speed / (2.0 * drive.pulley_distance)


def against_rigid_supports(drive: Drive) -> tuple[Comparison, Comparison]:
    """How far rigid supports in place of pulleys and carriages lead astray.

    Parameters
    ----------
    drive : Drive

    Returns
    -------
    longitudinal, transverse : Comparison
        The bare span between rigid supports against the lowest certified mode of each kind.
    """
    found = modes(drive, count=1)
    return (
        Comparison(simple=rigid_support_longitudinal(drive), exact=found.longitudinal[0].frequency),
        Comparison(simple=rigid_support_transverse(drive), exact=found.transverse[0].frequency),
    )
