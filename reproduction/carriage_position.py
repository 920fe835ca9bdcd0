"""A carriage on its way along the span: frequency against position and mass, as in Fig. 3.8."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from cabledrive.modal import longitudinal_modes, natural_frequencies
from cabledrive.parameters import Carriage, Drive, InputRefused, NotComputed
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.route.drive import require_two_pulleys
from cabledrive.studies.varied_drive import stamped

if TYPE_CHECKING:
    import xarray as xr

_ALIKE = 1e-12
_HEAVIEST = 1e6


def cable_mass(drive: Drive) -> float:
    r"""Mass of the whole cable, :math:`2 L_e \rho = 2 L \rho_0` of a loop.

    Parameters
    ----------
    drive : Drive

    Returns
    -------
    float
        Mass [kg].
    """
    return len(drive.spans) * drive.span_length * drive.cable.mass_per_length


def with_carriage(drive: Drive, mass_ratio: float, position: float, *, span: str = "upper") -> Drive:
    r"""Drive with one more guided carriage, its mass in units of the cable's, :math:`\chi_m = m/(2 L_e\rho)`.

    Parameters
    ----------
    drive : Drive
    mass_ratio : float
        Mass over the mass of the cable; zero adds none.
    position : float
        Unstretched distance [m] from the pulley where the span starts. At either end of the span the mass
        moves with the rim and is added to that pulley's inertia.
    span : {"upper", "lower"}, default "upper"

    Returns
    -------
    Drive

    Raises
    ------
    InputRefused
        If the ratio is negative or the position lies outside the span.
    """
    if not (np.isfinite(mass_ratio) and mass_ratio >= 0.0):
        raise InputRefused(
            f"mass ratio = {mass_ratio:.9g} must be finite and not negative: give m / cable mass"
        )
    if mass_ratio == 0.0:
        return drive
    mass = mass_ratio * cable_mass(drive)
    if position in (0.0, drive.span_length):
        return _at_rim(drive, mass, 0 if (position == 0.0) == (span == "upper") else 1)
    carriage = Carriage(mass=mass, position=position, span=span, guided=True)
    return replace(drive, carriage=(*drive.carriage, carriage))


def frequency_against_carriage_position(
    drive: Drive,
    mass_ratios: Sequence[float] | Array,
    positions: Sequence[float] | Array,
    *,
    span: str = "upper",
    modes: int = 3,
) -> "xr.Dataset":
    """Lowest longitudinal frequencies with a carriage added, for several masses and positions: Fig. 3.8.

    Parameters
    ----------
    drive : Drive
        The drive without this carriage; it may have others.
    mass_ratios : array_like, shape (r,)
        Mass of the carriage over the mass of the cable.
    positions : array_like, shape (p,)
        Unstretched positions from the pulley where the span starts [m], the two rims included.
    span : {"upper", "lower"}, default "upper"
    modes : int, default 3
        How many modes, from the lowest.

    Returns
    -------
    xarray.Dataset
        Over ``mass_ratio``, ``position``, ``mode`` (ascending in frequency): ``frequency`` [Hz], ``family``.

    Raises
    ------
    InputRefused
        If a ratio is negative or a position lies outside the span.
    """
    require_two_pulleys(drive, "`frequency_against_carriage_position`")
    import xarray as xr

    ratios, places = np.atleast_1d(mass_ratios).astype(float), np.atleast_1d(positions).astype(float)
    frequency = np.empty((ratios.size, places.size, modes))
    family = np.empty(frequency.shape, dtype=object)
    for i, ratio in enumerate(ratios):
        for j, place in enumerate(places):
            found = longitudinal_modes(with_carriage(drive, ratio, place, span=span), count=modes)
            shown = [mode for mode in found for _ in range(mode.multiplicity)][:modes]
            frequency[i, j] = [mode.frequency for mode in shown]
            family[i, j] = [mode.family for mode in shown]
    dims = ("mass_ratio", "position", "mode")
    data = xr.Dataset(
        {
            "frequency": (dims, frequency, {"units": "Hz", "long_name": "natural frequency"}),
            "family": (dims, family, {"long_name": "what mainly moves"}),
        },
        {
            "mass_ratio": ("mass_ratio", ratios, {"units": "1", "long_name": "carriage mass / cable mass"}),
            "position": ("position", places, {"units": "m", "long_name": "unstretched position"}),
            "mode": np.arange(modes),
        },
    )
    return stamped(data, drive, f"frequency against carriage position on the {span} span")


@dataclass(frozen=True, slots=True, kw_only=True)
class MidspanCrossing:
    """Where the in-phase mode, which carries a mass at midspan, falls below the one that leaves it at rest.

    Attributes
    ----------
    mass_ratio : float
        Mass of the carriage over the mass of the cable.
    mass : float
        Mass of the carriage [kg].
    frequency : float
        Frequency of both modes there [Hz].
    """

    mass_ratio: float
    mass: float
    frequency: float


def midspan_crossing(drive: Drive, *, span: str = "upper") -> MidspanCrossing:
    r"""Mass at midspan above which the fundamental is no longer that of the loop without it.

    In a symmetric loop the out-of-phase modes have a node at midspan, and a mass there does not change them.
    The in-phase mode carries the mass and falls with it. The crossing is found numerically; it lies at
    :math:`m = 2J/r^2`, which is :math:`\chi_m = 16.59` for configuration 1.

    Parameters
    ----------
    drive : Drive
        A loop with equal pulleys and no carriage.
    span : {"upper", "lower"}, default "upper"

    Returns
    -------
    MidspanCrossing

    Raises
    ------
    InputRefused
        If the loop is not symmetric: then the two modes veer and do not cross.
    NotComputed
        If they do not cross below a million times the mass of the cable.
    """
    from scipy.optimize import brentq

    _check_symmetric(drive)
    fundamental = natural_frequencies(drive, count=1)[0]

    def above(mass_ratio: float) -> float:
        """How far the mode that carries the mass is above the other, which is the fundamental itself."""
        pair = natural_frequencies(
            with_carriage(drive, mass_ratio, drive.span_length / 2, span=span), count=2
        )
        return float(pair[:2].sum() - 2.0 * fundamental)

    highest = 1.0
    while above(highest) > 0.0:
        highest *= 4.0
        if highest > _HEAVIEST:
            raise NotComputed(f"no crossing up to a carriage of {_HEAVIEST:g} times the mass of the cable")
    ratio = brentq(above, 0.0, highest, xtol=1e-12, rtol=1e-12)
    return MidspanCrossing(mass_ratio=ratio, mass=ratio * cable_mass(drive), frequency=float(fundamental))


def _check_symmetric(drive: Drive) -> None:
    first, second = (pulley.rim_mass for pulley in drive.pulley)
    fixed = any(pulley.fixed for pulley in drive.pulley)
    if drive.kind != "loop" or drive.carriage or drive.motor is not None or fixed:
        raise InputRefused("a loop of two free pulleys without motor and carriage is needed: take those out")
    if abs(first - second) > _ALIKE * first:
        raise InputRefused(
            f"J/r^2 = {first:.9g} kg and {second:.9g} kg at the two rims differ: without symmetry the modes "
            "veer and do not cross; use frequency_against with a carriage at midspan"
        )


def _at_rim(drive: Drive, mass: float, number: int) -> Drive:
    pulley = drive.pulley[number]
    loaded = replace(pulley, inertia=pulley.inertia + mass * pulley.radius**2)
    pair = (loaded, drive.pulley[1]) if number == 0 else (drive.pulley[0], loaded)
    return replace(drive, pulley=pair)
