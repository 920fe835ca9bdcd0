"""Inertias from the differences of three rigs, as in sections 4.2.1 to 4.2.3."""

from math import hypot

from scipy import stats

from cabledrive.identification.estimates import Estimate, Identification


def inertias_of_the_rigs(
    motor: Identification, with_drive_pulley: Identification, with_load_pulley: Identification
) -> dict[str, Estimate]:
    """Inertias of motor, drive pulley and load pulley, as in Table 4.2.

    ``motor``, ``with_drive_pulley``, ``with_load_pulley``: the motor alone, with the drive pulley, and with
    the load pulley on its shaft.
    Returns "J1", "J11", "J12", "J2", intervals propagated from those of the rigs, which are independent.
    """
    return {
        "J1": with_drive_pulley.parameters["inertia"],
        "J11": motor.parameters["inertia"],
        "J12": difference_of(with_drive_pulley, motor),
        "J2": difference_of(with_load_pulley, motor),
    }


def difference_of(larger: Identification, smaller: Identification, name: str = "inertia") -> Estimate:
    """Difference of one parameter of two independent identifications.

    Returns with Welch's degrees of freedom.
    """
    a, b = larger.parameters[name], smaller.parameters[name]
    error = hypot(a.standard_error, b.standard_error)
    parts = a.standard_error**4 / larger.freedom + b.standard_error**4 / smaller.freedom
    half = float(stats.t.ppf(0.975, error**4 / parts)) * error if parts > 0 else float("inf")
    value = a.value - b.value
    return Estimate(value=value, unit=a.unit, standard_error=error, low=value - half, high=value + half)
