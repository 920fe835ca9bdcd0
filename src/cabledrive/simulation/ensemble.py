"""What one member of an ensemble is: every combination of some parameters of a drive and of its motion."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from math import prod

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.parameters.drive import Drive
from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.fields import nearest
from cabledrive.simulation.signals import Constant, Signal, Sine
from cabledrive.simulation.start import Pluck, Start

MOST_NUMBERS = 500_000_000


@dataclass(frozen=True, slots=True, kw_only=True)
class Setting:
    """What one member of an ensemble is; each field may be an axis of the ensemble.

    Attributes
    ----------
    pretension : float or None
        Pretension [N]; None: the drive's.
    transverse_damping : float or None
        Gamma [1/s]; None: the drive's.
    axial_damping : float or None
        Kelvin-Voigt damping [N s]; None: the drive's.
    load_inertia : float or None
        Inertia of the load pulley [kg m^2]; None: the drive's.
    load_friction : float or None
        Viscous friction of the load pulley [N m s/rad]; None: the drive's.
    torque_amplitude : float, default 0.0
        Amplitude of the torque [N m].
    torque_frequency : float, default 0.0
        Its frequency [Hz]; 0: constant.
    pluck_upper, pluck_lower : float, default 0.0
        Heights of plucks in w at midspan [m].
    """

    pretension: float | None = None
    transverse_damping: float | None = None
    axial_damping: float | None = None
    load_inertia: float | None = None
    load_friction: float | None = None
    torque_amplitude: float = 0.0
    torque_frequency: float = 0.0
    pluck_upper: float = 0.0
    pluck_lower: float = 0.0

    def drive(self, base: Drive) -> Drive:
        """The drive of this member.

        Parameters
        ----------
        base : Drive

        Returns
        -------
        Drive
        """
        names = ("pretension", "transverse_damping", "axial_damping")
        cable = {name: getattr(self, name) for name in names if getattr(self, name) is not None}
        load = base.load_pulley
        if self.load_inertia is not None:
            load = replace(load, inertia=self.load_inertia)
        if self.load_friction is not None:
            load = replace(load, viscous_friction=self.load_friction)
        return replace(base, cable=replace(base.cable, **cable), pulley=(base.drive_pulley, load))

    def torque(self) -> Signal:
        """The torque of this member.

        Returns
        -------
        Signal
        """
        if self.torque_frequency == 0.0:
            return Constant(self.torque_amplitude)
        return Sine(amplitude=self.torque_amplitude, frequency=self.torque_frequency)

    def start(self, shape: str) -> Start:
        """The start of this member.

        Parameters
        ----------
        shape : str
            Shape of the plucks.

        Returns
        -------
        Start
        """
        heights = {"upper": self.pluck_upper, "lower": self.pluck_lower}
        return Start(
            plucks=tuple(Pluck(height=h, span=s, shape=shape) for s, h in heights.items() if h != 0.0)
        )


UNITS = {
    "pretension": "N",
    "transverse_damping": "1/s",
    "axial_damping": "N s",
    "load_inertia": "kg m^2",
    "load_friction": "N m s/rad",
    "torque_amplitude": "N m",
    "torque_frequency": "Hz",
    "pluck_upper": "m",
    "pluck_lower": "m",
}


def members_of(
    axes: Mapping[str, Sequence[float] | Array], common: Setting, records: float
) -> tuple[dict[str, Array], list[Setting]]:
    """Values as arrays, and every combination of them as a `Setting`, the last axis quickest.

    ``axes``: by name of a parameter; ``common``: parameters that are not varied; ``records``: of each run.
    Refused: an axis that is unknown or empty, a result that would not fit into memory.
    """
    values = {name: np.atleast_1d(np.asarray(given, dtype=np.float64)) for name, given in axes.items()}
    _check_axes(values, records)
    combinations = product(*(given.tolist() for given in values.values()))
    return values, [replace(common, **dict(zip(values, one, strict=True))) for one in combinations]


def _check_axes(values: dict[str, Array], records: float) -> None:
    for name, given in values.items():
        if name not in UNITS:
            raise InputRefused(f'ensemble: "{name}" cannot be varied{nearest(name, UNITS)}')
        if given.ndim != 1 or given.size == 0 or not np.isfinite(given).all():
            raise InputRefused(f"ensemble: {name} needs a row of finite values in {UNITS[name]}")
    members = prod(given.size for given in values.values())
    if members * records * 4 > MOST_NUMBERS:
        raise InputRefused(
            f"ensemble: {members} runs of {records:.3g} records do not fit into memory: lower rate"
        )
