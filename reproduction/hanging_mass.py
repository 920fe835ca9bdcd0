r"""The vertical motion of a hanging mass, driven by a longitudinal mode through the sag of the cable."""

from dataclasses import dataclass
from math import inf, pi

import numpy as np

from cabledrive.modal.lateral import HangingCarriage, hanging_carriage, lateral_frequency
from cabledrive.modal.mode import LONGITUDINAL, Mode
from cabledrive.parameters import Drive, InputRefused
from reproduction.hanging_equilibrium import HangingEquilibrium, linear_equilibrium

_POINTS = 1001


@dataclass(frozen=True, slots=True, kw_only=True)
class DrivenMass:
    """Steady vertical motion y of a hanging mass while a longitudinal mode oscillates.

    Amplitudes of the mode are those of its largest displacement anywhere on the cable.

    Attributes
    ----------
    vertical_frequency : float
        Frequency at which the mass would swing by itself, (3.33) [Hz].
    mode_frequency : float
        Frequency of the longitudinal mode [Hz].
    forcing : float
        Vertical acceleration of the mass, were it held in height, per amplitude of the mode [1/s^2].
    amplitude_ratio : float
        Amplitude of y per amplitude of the mode, negative in antiphase; infinite where frequencies coincide.
    coincidence_pretension : float or None
        Pretension at which they coincide, unstretched lengths kept [N]; None where no pretension is enough.
    sag_stiffening : float
        Stiffness by the stretch that y itself causes on the sagged cable between held points, over the
        lateral stiffness. The equation of motion leaves it out; where it is not small, the mass is faster.
    """

    vertical_frequency: float
    mode_frequency: float
    forcing: float
    amplitude_ratio: float
    coincidence_pretension: float | None
    sag_stiffening: float


def driven_mass(
    drive: Drive, mode: Mode, carriage: int = 0, *, equilibrium: HangingEquilibrium | None = None
) -> DrivenMass:
    r"""Vertical motion of a hanging mass driven by a longitudinal mode, Eqs. (3.31), (3.32).

    .. math:: \ddot y + \frac{T_0}{m}\Big(\frac{1}{L_1} + \frac{1}{L_2}\Big) y
              = \frac{EA(1+\varepsilon_0)}{m}\,(u_1'\sin\theta_1 + u_2'\sin\theta_2)

    with the sag angles of equilibrium on the right, as a linear equation has it. A mode
    :math:`u = \hat u\,\varphi(x)\sin\omega t` then drives
    :math:`y = \hat u\,F/(\omega_y^2 - \omega^2)\sin\omega t`. The print has EA in place of
    :math:`EA(1+\varepsilon_0)`. y points up, against gravity.

    Parameters
    ----------
    drive : Drive
    mode : Mode
        A longitudinal mode of this drive, of multiplicity one.
    carriage : int, default 0
        Number of the hanging carriage in the file.
    equilibrium : HangingEquilibrium, optional
        Where it rests; `linear_equilibrium` if not given.

    Returns
    -------
    DrivenMass

    Raises
    ------
    InputRefused
        If the carriage is guided or hangs beside another, or the mode is transverse or multiple.
    NotComputed
        If no equilibrium is given and the linear one sags too deep.
    """
    hanging = hanging_carriage(drive, carriage)
    _check_mode(mode)
    rest = equilibrium or linear_equilibrium(drive, carriage)
    before, after = (float(slope[0]) for slope in mode.slopes_at(f"carriage {carriage}"))
    force = before * rest.sine_before + after * rest.sine_after
    forcing = drive.cable.axial_rigidity * force / (hanging.mass * largest_displacement(drive, mode))
    vertical = lateral_frequency(hanging)
    gap = (2 * pi) ** 2 * (vertical**2 - mode.frequency**2)
    return DrivenMass(
        vertical_frequency=vertical,
        mode_frequency=mode.frequency,
        forcing=forcing,
        amplitude_ratio=forcing / gap if gap else (inf if forcing else 0.0),
        coincidence_pretension=_coincidence_pretension(drive, hanging, mode.frequency),
        sag_stiffening=_sag_stiffening(drive, hanging, rest),
    )


def largest_displacement(drive: Drive, mode: Mode) -> float:
    """Largest displacement in a mode, on the cable or at a joint.

    ``mode``: of multiplicity one.
    Returns of unit modal mass [kg^-1/2].
    """
    places = np.linspace(0.0, drive.span_length, _POINTS)
    on_cable = max(float(np.abs(mode.shape(span, places)).max()) for span in drive.spans)
    return max(on_cable, *(float(np.abs(value).max()) for value in mode.joints.values()))


def _check_mode(mode: Mode) -> None:
    if mode.kind != LONGITUDINAL or mode.multiplicity != 1:
        raise InputRefused(
            f"mode at {mode.frequency:.9g} Hz is {mode.kind}, of multiplicity {mode.multiplicity}: "
            "give a simple longitudinal one"
        )


def _unstretched(drive: Drive, hanging: HangingCarriage) -> tuple[float, float]:
    position = drive.carriage[hanging.number].position
    return position - hanging.section[0], hanging.section[1] - position


def _coincidence_pretension(drive: Drive, hanging: HangingCarriage, frequency: float) -> float | None:
    """T0 / (1 + T0/EA) = m omega^2 / (1/l1 + 1/l2) solved for T0."""
    before, after = _unstretched(drive, hanging)
    rigidity = drive.cable.axial_rigidity
    needed = hanging.mass * (2 * pi * frequency) ** 2 / (1.0 / before + 1.0 / after)
    return needed / (1.0 - needed / rigidity) if needed < rigidity else None


def _sag_stiffening(drive: Drive, hanging: HangingCarriage, rest: HangingEquilibrium) -> float:
    before, after = _unstretched(drive, hanging)
    added = drive.cable.axial_rigidity * (rest.sine_before**2 / before + rest.sine_after**2 / after)
    return added / hanging.lateral_stiffness
