r"""First estimates of the two flexible modes, each as if it were alone: the cable's and the motor joint's."""

from math import sqrt

from cabledrive.parameters.drive import Drive


def lumped_cable_mode(drive: Drive) -> float | None:
    r"""Frequency of the pulleys against each other on a cable without mass, the motor joint taken as rigid.

    .. math:: \omega^2 = N k\,\Big(\frac{r_1^2}{J_1} + \frac{r_2^2}{J_2}\Big)

    with N spans of stiffness k, that of ``[lumped]`` where given, else EA/L. Carriages are left out.

    Parameters
    ----------
    drive : Drive

    Returns
    -------
    float or None
        Angular frequency [rad/s]; None if neither pulley turns.
    """
    motor = drive.motor.inertia if drive.motor else 0.0
    first, second = drive.pulley
    inertias = ((first, first.inertia + motor), (second, second.inertia))
    inverse_mass = sum(pulley.radius**2 / inertia for pulley, inertia in inertias if not pulley.fixed)
    stiffness = len(drive.spans) * span_stiffness(drive)
    return sqrt(stiffness * inverse_mass) if inverse_mass > 0.0 else None


def lumped_joint_mode(drive: Drive) -> float | None:
    r"""Frequency of the motor against the drive pulley, the cable taken away.

    .. math:: \omega^2 = k_m\,\Big(\frac{1}{J_{11}} + \frac{1}{J_{12}}\Big)

    Parameters
    ----------
    drive : Drive

    Returns
    -------
    float or None
        Angular frequency [rad/s]; None without a flexible joint.
    """
    if drive.motor is None or drive.motor.joint_stiffness is None:
        return None
    return sqrt(drive.motor.joint_stiffness * (1.0 / drive.motor.inertia + 1.0 / drive.drive_pulley.inertia))


def span_stiffness(drive: Drive) -> float:
    """Stiffness k of one span: as measured, ``[lumped]``, else EA / L.

    Parameters
    ----------
    drive : Drive

    Returns
    -------
    float
        Stiffness [N/m].
    """
    if drive.lumped is not None and drive.lumped.cable_stiffness is not None:
        return drive.lumped.cable_stiffness
    return drive.cable.axial_rigidity / drive.span_length
