r"""What a cable law is: tension from the displacement gradients, and what follows from its components.

A material point that sits at :math:`x` of the straight, pretensioned cable moves to :math:`(x + u, v, w)`.
Everything here is a function of the gradients :math:`(u', v', w')` at that point; the equation of motion is

.. math:: \rho\,(\ddot u, \ddot v, \ddot w) = \frac{\partial}{\partial x}(T_x, T_y, T_z)

with :math:`\rho` per pretensioned metre. A law is one class with one method, `CableLaw.components`; what else
the simulation, the statics and the audit need follows from it.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar, TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float64]
Components: TypeAlias = tuple[Array, Array, Array]

GRADIENT_STEP = 6e-6
"""Step of central differences of components, in gradients [-]."""
SHORTEST = -0.5
"""Strain down to which a cable is looked for that is slack [-]."""


_SOURCES = ("excess_components", "components")
_DERIVED = (
    "slack_strain",
    "strain",
    "strain_gradient",
    "tension",
    "is_slack",
    "energy_density",
    "stiffness_matrix",
    "largest_stiffness",
)
_FOLLOW = frozenset({"strain", "tension", "stiffness", "is_slack"})


@dataclass(frozen=True, slots=True, kw_only=True)
class CableLaw(ABC):
    r"""Relation between the deformation of the cable and the force in it.

    A subclass defines `components`, or `excess_components` where that avoids cancellation, with numpy on
    arrays of any shape. Everything else is derived from them and may be overridden by a closed form. A law
    takes the keywords `pretension` and `axial_rigidity` of the drive's cable; further parameters are fields
    of a dataclass or attributes of the class. Where numba can compile the formula the steps are compiled,
    else the run is interpreted and its result says so.

    Attributes
    ----------
    pretension : float
        Pretension :math:`T_0` [N].
    axial_rigidity : float
        Axial rigidity :math:`EA` [N].
    name : str
        Name in results; default: that of the class.
    source : str
        Which of `components` and `excess_components` the law defines.
    has_potential : bool, default True
        Whether the components are the derivative of an energy.

    Raises
    ------
    TypeError
        When a class is made that changes what only reports the force, such as `tension`, but not the
        components, from which the motion comes.

    Examples
    --------
    >>> class Hardening(CableLaw):
    ...     def components(self, u_x, v_x, w_x):
    ...         tension = self.pretension + self.stiffness * u_x * (1.0 + 1e4 * u_x**2)
    ...         return tension, self.pretension * v_x, self.pretension * w_x
    >>> law = Hardening(pretension=3.0, axial_rigidity=400.0)
    >>> float(law.tension(0.01, 0.0, 0.0).round(3))
    11.06
    """

    name: ClassVar[str]
    source: ClassVar[str]
    has_potential: ClassVar[bool] = True

    pretension: float
    axial_rigidity: float

    def __init_subclass__(cls) -> None:
        """Let nothing that follows from the components of a parent pass for one's own."""
        own = dict(vars(cls))
        if "source" in own:  # the same class once more: `dataclass` makes it anew for slots
            return
        if "name" not in own:
            cls.name = cls.__name__
        defined = [name for name in _SOURCES if name in own]
        inherits = not getattr(cls.__mro__[1], "__abstractmethods__", ())
        if not defined:
            if inherits and (changed := _FOLLOW.intersection(own)):
                said = f"{cls.__name__} changes {min(changed)}, which only reports the force"
                raise TypeError(f"{said}: define components, from which motion, tension and energy follow")
            return
        cls.source = defined[0]
        derived = {name: vars(CableLaw)[name] for name in _DERIVED} if inherits else {}
        if len(defined) == 1:  # each from the other of the same class, so that super() may be called
            derived |= _other_source(defined[0], own[defined[0]])
        for name in derived.keys() - own.keys():
            setattr(cls, name, derived[name])

    @property
    def stiffness(self) -> float:
        r"""Tension per apparent strain of the cable, :math:`K = EA\,(1 + \epsilon_0) = EA + T_0` [N]."""
        return self.axial_rigidity + self.pretension

    @property
    def slack_strain(self) -> float:
        """Strain of the straight cable at which the tension vanishes [-]; -inf: nowhere down to -1/2."""
        zero = np.zeros(1)
        low, high = -self.pretension / self.stiffness, 0.0
        while not np.ravel(self.components(zero + low, zero, zero)[0])[0] < 0.0:
            low, high = 2.0 * low, low
            if low < SHORTEST:
                return -np.inf
        for _ in range(60):  # bisection
            middle = 0.5 * (low + high)
            pushes = np.ravel(self.components(zero + middle, zero, zero)[0])[0] < 0.0
            low, high = (middle, high) if pushes else (low, middle)
        return low

    @property
    def tension_only(self) -> bool:
        """Whether the cable goes slack where it would have to push."""
        return False

    @abstractmethod
    def components(self, u_x: Array, v_x: Array, w_x: Array) -> Components:
        """Components of the tension.

        Parameters
        ----------
        u_x, v_x, w_x : ndarray
            Displacement gradients [-], of any one shape.

        Returns
        -------
        tuple of ndarray
            Tx, Ty, Tz [N]; (pretension, 0, 0) for the straight cable.
        """

    def excess_components(self, u_x: Array, v_x: Array, w_x: Array) -> Components:
        """Components of the tension above the pretension.

        The pretension pulls equally on both sides of everything; what a chain sums is the rest. Override it
        instead of `components` to keep it free of cancellation at small displacements.

        Parameters
        ----------
        u_x, v_x, w_x : ndarray
            Displacement gradients [-].

        Returns
        -------
        tuple of ndarray
            Tx - T0, Ty, Tz [N].
        """
        return _other_source("components", type(self).components)["excess_components"](self, u_x, v_x, w_x)

    def strain(self, u_x: Array, v_x: Array, w_x: Array) -> Array:
        """Apparent strain, measured from the pretensioned cable.

        Parameters
        ----------
        u_x, v_x, w_x : ndarray
            Displacement gradients [-].

        Returns
        -------
        ndarray
            Stretch of the segment per length [-]; default: that of the exact geometry.
        """
        return np.sqrt((1.0 + u_x) ** 2 + v_x**2 + w_x**2) - 1.0

    def strain_gradient(self, u_x: Array, v_x: Array, w_x: Array) -> Components:
        """Derivative of the apparent strain with respect to (u', v', w').

        Parameters
        ----------
        u_x, v_x, w_x : ndarray
            Displacement gradients [-].

        Returns
        -------
        tuple of ndarray
            Its three components [-]; also the direction in which axial damping acts. Default: the unit
            vector along the segment.
        """
        stretch = np.sqrt((1.0 + u_x) ** 2 + v_x**2 + w_x**2)
        return (1.0 + u_x) / stretch, v_x / stretch, w_x / stretch

    def tension(self, u_x: Array, v_x: Array, w_x: Array) -> Array:
        """Tension.

        Parameters
        ----------
        u_x, v_x, w_x : ndarray
            Displacement gradients [-].

        Returns
        -------
        ndarray
            Force along the segment [N], negative where the cable has to push. Default: the part of the
            components along `strain_gradient`.
        """
        x, y, z = self.components(u_x, v_x, w_x)
        along, v_along, w_along = self.strain_gradient(u_x, v_x, w_x)
        return np.asarray(x * along + y * v_along + z * w_along)

    def is_slack(self, u_x: Array, v_x: Array, w_x: Array) -> NDArray[np.bool_]:
        """Where the cable would have to push.

        Parameters
        ----------
        u_x, v_x, w_x : ndarray
            Displacement gradients [-].

        Returns
        -------
        ndarray of bool
        """
        return self.tension(u_x, v_x, w_x) < 0.0

    def energy_density(self, u_x: Array, v_x: Array, w_x: Array) -> Array:
        """Elastic energy per pretensioned metre, above the straight pretensioned cable.

        The work of the pretension on the ends, T0 u', is left out: it cancels round a loop.

        Parameters
        ----------
        u_x, v_x, w_x : ndarray
            Displacement gradients [-].

        Returns
        -------
        ndarray
            Energy density [J/m]. Default: work of `excess_components` on the straight path from zero to the
            gradients, by 16 points of Gauss: exact for smooth laws; an error in it shows in the energy
            budget of a run.
        """
        places, weights = np.polynomial.legendre.leggauss(16)
        total = np.zeros(np.shape(u_x))
        for share, weight in zip(0.5 * (places + 1.0), 0.5 * weights, strict=True):
            x, y, z = self.excess_components(share * u_x, share * v_x, share * w_x)
            total += weight * (x * u_x + y * v_x + z * w_x)
        return total

    def stiffness_matrix(self, u_x: Array, v_x: Array, w_x: Array) -> Array:
        """Derivative of the components with respect to (u', v', w').

        Parameters
        ----------
        u_x, v_x, w_x : ndarray
            Displacement gradients [-].

        Returns
        -------
        ndarray, shape (..., 3, 3)
            Row: component of the tension, column: gradient [N]; symmetric if the law has a potential.
            Default: central differences, good to about 1e-9 of the stiffness. Newton's method of the statics
            uses it as its slope, not in what it solves.
        """
        at = [np.asarray(gradient, dtype=np.float64) for gradient in (u_x, v_x, w_x)]
        columns = []
        for k in range(3):
            ahead = [value + GRADIENT_STEP * (k == i) for i, value in enumerate(at)]
            behind = [value - GRADIENT_STEP * (k == i) for i, value in enumerate(at)]
            change = np.stack(self.excess_components(*ahead)) - np.stack(self.excess_components(*behind))
            columns.append(change / (2.0 * GRADIENT_STEP))
        return np.moveaxis(np.stack(columns), (0, 1), (-1, -2))

    def largest_stiffness(self) -> float:
        """Largest slope of the tension that the time step is chosen for.

        Returns
        -------
        float
            [N]. Default: the largest found between the strain at which the tension vanishes and its
            opposite. A run under a law that grows stiffer than its step allows stops and says so.
        """
        reach = -self.slack_strain
        reach = reach if np.isfinite(reach) else self.pretension / self.stiffness
        strain = np.linspace(-reach, reach, 65)
        matrix = self.stiffness_matrix(strain, 0.0 * strain, 0.0 * strain)
        return float(np.max(np.linalg.norm(matrix, ord=2, axis=(-2, -1))))


def _other_source(name: str, given: Callable[..., Components]) -> dict[str, Callable[..., Components]]:
    """The method that follows from `components` or from `excess_components`, by its name."""

    def components(self: CableLaw, u_x: Array, v_x: Array, w_x: Array) -> Components:
        """Components of the tension [N], see `CableLaw.components`."""
        x, y, z = given(self, u_x, v_x, w_x)
        return self.pretension + x, y, z

    def excess_components(self: CableLaw, u_x: Array, v_x: Array, w_x: Array) -> Components:
        """Components above the pretension [N], see `CableLaw.excess_components`."""
        x, y, z, _ = np.broadcast_arrays(*given(self, u_x, v_x, w_x), u_x)
        return x - self.pretension, y, z

    return {"components": components} if name != "components" else {"excess_components": excess_components}
