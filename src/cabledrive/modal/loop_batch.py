"""Many loops of two turning pulleys without carriages, as arrays of their numbers."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from cabledrive.modal.batch import ChainBatch

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class LoopBatch:
    """Loops of one build with numbers of their own; every array is of shape (n,).

    Attributes
    ----------
    rigidity, density, pretension, length : ndarray
        EA [N], mass per unstretched length [kg/m], T0 [N], unstretched length of a span [m].
    transverse_damping, axial_damping : ndarray
        [1/s], [N s].
    radius, inertia, viscous : (ndarray, ndarray)
        Of drive pulley and load pulley [m], [kg m^2], [N m s/rad].
    motor_inertia, motor_viscous, joint_stiffness, joint_damping, holding_stiffness : ndarray
        Zero where the drive has none [kg m^2], [N m s/rad], [N m/rad].
    flexible, held : bool
        Whether the motor is behind a flexible joint; whether it has a holding stiffness.
    gravity_across : float
        [m/s^2].
    """

    rigidity: Array
    density: Array
    pretension: Array
    length: Array
    transverse_damping: Array
    axial_damping: Array
    radius: tuple[Array, Array]
    inertia: tuple[Array, Array]
    viscous: tuple[Array, Array]
    motor_inertia: Array
    motor_viscous: Array
    joint_stiffness: Array
    joint_damping: Array
    holding_stiffness: Array
    flexible: bool
    held: bool
    gravity_across: float

    @cached_property
    def masses(self) -> tuple[Array, Array]:
        """Masses at the rims of drive pulley, a rigidly joined motor included, and load pulley [kg]."""
        drive, load = (self.inertia[i] / self.radius[i] ** 2 for i in range(2))
        return (drive if self.flexible else drive + self.motor_inertia / self.radius[0] ** 2), load

    @cached_property
    def grounds(self) -> Array:
        """Spring from the drive pulley to the ground [N/m]."""
        return np.zeros_like(self.length) if self.flexible else self._holding

    @cached_property
    def pendant(self) -> tuple[Array, Array, Array]:
        """Joint stiffness [N/m], mass [kg] and spring to the ground [N/m] of a motor behind a joint."""
        if not self.flexible:
            return (np.zeros_like(self.length),) * 3
        square = self.radius[0] ** 2
        return self.joint_stiffness / square, self.motor_inertia / square, self._holding

    @property
    def _holding(self) -> Array:
        return self.holding_stiffness / self.radius[0] ** 2

    def chains(self) -> ChainBatch:
        """What carries the longitudinal motion, as `longitudinal_chains` makes it of each drive."""
        time = self.length / np.sqrt(self.rigidity / self.density)
        return ChainBatch(
            times=np.column_stack((time, time)),
            masses=np.column_stack(self.masses),
            grounds=np.column_stack((self.grounds, np.zeros_like(time))),
            impedance=np.sqrt(self.rigidity * self.density),
            pendant=np.column_stack(self.pendant),
            closed=True,
        )
