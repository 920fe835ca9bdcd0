"""Wave-carrying segments joined at point masses: the one structure behind every mode of the package."""

from dataclasses import dataclass
from math import sqrt

import numpy as np

from cabledrive.parameters.arrays import Array


@dataclass(frozen=True, slots=True, kw_only=True)
class Pendant:
    """A mass on a spring at a joint: a motor behind a flexible joint, an absorber.

    Attributes
    ----------
    stiffness : float
        Of the spring between joint and mass [N/m].
    mass : float
        [kg].
    joint : int, default 0
        Number of the joint.
    ground : float, default 0.0
        Stiffness from the mass to the ground [N/m]: the motor's holding stiffness.
    """

    stiffness: float
    mass: float
    joint: int = 0
    ground: float = 0.0


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Chain:
    r"""Segments that carry waves, joined at point masses: an open line or a closed ring.

    Lengths and density are per unstretched metre, so that
    :math:`\rho_0\,\ddot u = R\,\partial^2 u/\partial s^2` with :math:`R = EA` for longitudinal motion and
    :math:`R = T_0/(1+\varepsilon_0)` for transverse motion.

    Attributes
    ----------
    rigidity : float or ndarray, shape (m,)
        Force per slope R [N]; an array where the segments are different cables.
    density : float or ndarray, shape (m,)
        Mass per length rho0 [kg/m], likewise.
    lengths : ndarray, shape (m,)
        Lengths of the segments [m]; segment i from joint i to i + 1, a ring's last one to joint 0.
    masses : ndarray, shape (n,)
        Masses at the joints [kg]; m = n of a ring, m = n - 1 of a line.
    closed : bool, default False
        Whether the chain closes to a ring.
    fixed : (bool, bool), default (False, False)
        Whether the first and last joint of a line are held.
    pendants : tuple of Pendant, default ()
        Masses on springs at the joints.
    grounds : ndarray, shape (n,), optional
        Stiffness of a spring from each joint to the ground [N/m]; none where absent.
    """

    rigidity: float | Array
    density: float | Array
    lengths: Array
    masses: Array
    closed: bool = False
    fixed: tuple[bool, bool] = (False, False)
    pendants: tuple[Pendant, ...] = ()
    grounds: Array | None = None

    def __post_init__(self) -> None:
        joints, given = len(self.masses), len(self.lengths)
        segments = joints if self.closed else joints - 1
        if given != segments or segments < 1:
            raise ValueError(f"{joints} joints need {segments} segments, {given} given")

    @property
    def uniform(self) -> bool:
        """Whether all segments are of one cable and there is at most one pendant."""
        return len(self.pendants) < 2 and np.ndim(self.rigidity) == 0 and np.ndim(self.density) == 0

    @property
    def pendant(self) -> Pendant | None:
        """The pendant of a chain that has no second one."""
        return self.pendants[0] if self.pendants else None

    @property
    def wave_speed(self) -> float:
        """Wave speed in unstretched metres per second, sqrt(R / rho0); of a chain of one cable."""
        return sqrt(self.rigidity / self.density)

    @property
    def impedance(self) -> float:
        """Wave impedance sqrt(R rho0) [kg/s]; of a chain of one cable."""
        return sqrt(self.rigidity * self.density)

    @property
    def impedances(self) -> Array:
        """Wave impedance of each segment, shape (m,) [kg/s]."""
        return np.broadcast_to(np.sqrt(self.rigidity * self.density), self.lengths.shape)

    @property
    def travel_times(self) -> Array:
        """Time a wave takes along each segment, shape (m,) [s]."""
        return self.lengths / np.sqrt(self.rigidity / self.density)

    @property
    def all_masses(self) -> Array:
        """Masses of the joints, then of the pendants [kg]."""
        return np.append(self.masses, [pendant.mass for pendant in self.pendants])

    @property
    def cable_mass(self) -> float:
        """Mass of all segments [kg]."""
        varied = np.ndim(self.density) > 0
        return float(np.sum(self.density * self.lengths) if varied else self.density * self.lengths.sum())

    @property
    def rigid_body_modes(self) -> int:
        """Motions that strain nothing: one of a free ring or line, none where anything is held or sprung."""
        return 0 if any(self.fixed) or self.sprung else 1

    @property
    def sprung(self) -> bool:
        """Whether a joint or a pendant has a spring to the ground."""
        return any(pendant.ground > 0.0 for pendant in self.pendants) or bool(np.any(self.ground_springs))

    @property
    def ground_springs(self) -> Array:
        """Stiffness from each joint to the ground, shape (n,) [N/m]; zeros where there is none."""
        return np.zeros(self.masses.size) if self.grounds is None else self.grounds
