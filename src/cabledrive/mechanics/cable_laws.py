"""The four cable laws, a law of the user's own, and any of them as a cable that goes slack."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import isfinite
from typing import Any, ClassVar, TypeAlias

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.cable_law import Array, CableLaw, Components
from cabledrive.parameters.cable import Cable
from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.fields import nearest


@dataclass(frozen=True, slots=True, kw_only=True)
class TensionOnly(CableLaw):
    """Another law, for a cable that goes slack instead of pushing."""

    taut: CableLaw  # the law of the taut cable

    @property
    def tension_only(self) -> bool:
        """True."""
        return True

    @property
    def slack_strain(self) -> float:
        """That of the taut law [-]."""
        return self.taut.slack_strain

    def components(self, u_x: Array, v_x: Array, w_x: Array) -> Components:
        """Components of the tension, zero where the cable is slack; see `CableLaw.components`."""
        x, y, z = self.excess_components(u_x, v_x, w_x)
        return self.pretension + x, y, z

    def excess_components(self, u_x: Array, v_x: Array, w_x: Array) -> Components:
        """Components above the pretension, see `CableLaw.excess_components`."""
        slack = self.is_slack(u_x, v_x, w_x)
        x, y, z = self.taut.excess_components(u_x, v_x, w_x)
        return np.where(slack, -self.pretension, x), np.where(slack, 0.0, y), np.where(slack, 0.0, z)

    def strain(self, u_x: Array, v_x: Array, w_x: Array) -> Array:
        """Apparent strain [-], see `CableLaw.strain`."""
        return self.taut.strain(u_x, v_x, w_x)

    def strain_gradient(self, u_x: Array, v_x: Array, w_x: Array) -> Components:
        """Derivative of the strain, zero where the cable is slack; see `CableLaw.strain_gradient`."""
        slack = self.is_slack(u_x, v_x, w_x)
        x, y, z = (np.where(slack, 0.0, part) for part in self.taut.strain_gradient(u_x, v_x, w_x))
        return x, y, z

    def tension(self, u_x: Array, v_x: Array, w_x: Array) -> Array:
        """Tension, not below zero [N]; see `CableLaw.tension`."""
        return np.maximum(self.taut.tension(u_x, v_x, w_x), 0.0)

    def is_slack(self, u_x: Array, v_x: Array, w_x: Array) -> NDArray[np.bool_]:
        """Where the taut law would push, see `CableLaw.is_slack`."""
        return self.taut.is_slack(u_x, v_x, w_x)

    def energy_density(self, u_x: Array, v_x: Array, w_x: Array) -> Array:
        """Energy density [J/m]; where the cable is slack, minus the work of the pretension."""
        limit, zero = np.array(self.taut.slack_strain), np.array(0.0)
        at_limit = self.taut.energy_density(limit, zero, zero) + self.pretension * limit
        taut = self.taut.energy_density(u_x, v_x, w_x)
        return np.where(self.is_slack(u_x, v_x, w_x), at_limit - self.pretension * u_x, taut)

    def largest_stiffness(self) -> float:
        """That of the taut law [N]."""
        return self.taut.largest_stiffness()


def taut_law(law: CableLaw) -> CableLaw:
    """The law of the taut cable, whether it may go slack or not."""
    return law.taut if isinstance(law, TensionOnly) else law


def without_pushing(law: CableLaw) -> TensionOnly:
    """The law of a cable that goes slack where the tension would be negative."""
    return TensionOnly(pretension=law.pretension, axial_rigidity=law.axial_rigidity, taut=law)


Model: TypeAlias = str | type[CableLaw] | CableLaw | Callable[..., CableLaw]


def made_law(model: Any, cable: Cable) -> CableLaw:
    """A law for a cable from what stands for it."""
    if isinstance(model, CableLaw):
        return model
    if not callable(model):
        raise InputRefused(
            f"model is {model!r}: give the name of a law, a subclass of CableLaw, or a function making one"
        )
    try:
        law = model(pretension=cable.pretension, axial_rigidity=cable.axial_rigidity)
    except TypeError as error:
        said = f"model = {label(model)} cannot be made from pretension and axial_rigidity ({error})"
        raise InputRefused(f"{said}: give further fields a default, or functools.partial(...)") from None
    if not isinstance(law, CableLaw):
        raise InputRefused(f"model = {label(model)} makes a {type(law).__name__}: return a CableLaw")
    return law


def check_law(law: CableLaw, cable: Cable, known: Mapping[str, type[CableLaw]]) -> None:
    """Refuse a law of another cable, one that is no function of arrays, or one without the pretension."""
    if isinstance(law, TensionOnly):
        raise InputRefused(f'model = {label(law)}: give the taut law and slack = "tension-only"')
    for name, unit in (("pretension", "N"), ("axial_rigidity", "N")):
        ours, theirs = getattr(law, name), getattr(cable, name)
        if ours != theirs:
            said = f"model = {label(law)} has {name} = {ours:.6g} {unit}, the cable {theirs:.6g} {unit}"
            raise InputRefused(f"{said}: give the class, or make it for this cable")
    if law.name in known and type(law) is not known[law.name]:
        raise InputRefused(f'model = {label(law)}: "{law.name}" is the name of another law: give it its own')
    zero = np.zeros(3)
    try:
        parts = [np.asarray(part, dtype=np.float64) for part in law.components(zero, zero, zero)]
        table = np.array([np.broadcast_to(part, zero.shape) for part in parts])
    except (TypeError, ValueError) as error:
        raise InputRefused(
            f"model = {label(law)}: components fails on arrays ({error}): use numpy functions and np.where"
        ) from None
    if table.shape != (3, 3):
        raise InputRefused(f"model = {label(law)}: components gives {len(table)} parts: return Tx, Ty, Tz")
    rng = np.random.default_rng(0)
    at = rng.uniform(-1e-3, 1e-3, (3, 50))
    total, excess = (
        np.stack(np.broadcast_arrays(*part(*at))) for part in (law.components, law.excess_components)
    )
    total[0] -= law.pretension
    if not np.allclose(total, excess, rtol=1e-9, atol=1e-9 * law.pretension, equal_nan=True):
        raise InputRefused(
            f"model = {label(law)}: excess_components and components disagree: define one of the two"
        )
    off = float(np.max(np.abs(table - np.array([[cable.pretension], [0.0], [0.0]]))))
    if not (isfinite(off) and off <= 1e-9 * cable.pretension):
        raise InputRefused(
            f"model = {label(law)}: the straight cable carries {table[0, 0]:.6g}, {table[1, 0]:.6g}, "
            f"{table[2, 0]:.6g} N instead of its pretension, {cable.pretension:.6g} N: add what is missing"
        )


def label(model: Model) -> str:
    """Name of a model in messages and results."""
    if isinstance(model, str):
        return model
    kind = model if isinstance(model, type) else getattr(model, "func", model)
    return str(getattr(kind, "name", None) or getattr(kind, "__name__", type(kind).__name__))


class _Hookean(CableLaw):
    r"""Hooke's law, :math:`T = T_0 + K\lambda`, in the closed forms of one strain or another."""

    __slots__ = ()

    @property
    def slack_strain(self) -> float:
        r"""Apparent strain at which the tension vanishes, :math:`-T_0/K` [-]."""
        return -self.pretension / self.stiffness

    def strain(self, u_x: Array, v_x: Array, w_x: Array) -> Array:
        """Apparent strain lambda [-]; the tension is T0 + K lambda."""
        return u_x + self._transverse_stretch(u_x, v_x, w_x)

    def tension(self, u_x: Array, v_x: Array, w_x: Array) -> Array:
        """Tension T = T0 + K lambda [N]; negative where the cable would have to push."""
        return self.pretension + self.stiffness * self.strain(u_x, v_x, w_x)

    def is_slack(self, u_x: Array, v_x: Array, w_x: Array) -> NDArray[np.bool_]:
        """Where the cable would have to push."""
        return np.asarray(self.strain(u_x, v_x, w_x) < self.slack_strain)

    def energy_density(self, u_x: Array, v_x: Array, w_x: Array) -> Array:
        r"""Elastic energy per pretensioned metre, above the straight pretensioned cable [J/m].

        .. math:: e = T_0\,(\lambda - u') + \tfrac12 K \lambda^2

        It is zero, and least, for the straight cable; its derivative is `excess_components`. A law without a
        potential answers with that of the truncation nearest to it.
        """
        slopes = self._transverse_stretch(u_x, v_x, w_x)
        return self.pretension * slopes + 0.5 * self.stiffness * self.strain(u_x, v_x, w_x) ** 2

    def largest_stiffness(self) -> float:
        """K [N]."""
        return self.stiffness

    def strain_gradient(self, u_x: Array, v_x: Array, w_x: Array) -> Components:
        """Derivative of the apparent strain with respect to (u', v', w') [-]; of the truncated one."""
        return np.ones_like(u_x), v_x, w_x

    def _transverse_stretch(self, u_x: Array, v_x: Array, w_x: Array) -> Array:
        """What the slopes add to the strain; of the linear law in its energy only, as T0 v' and T0 w'."""
        return 0.5 * (v_x**2 + w_x**2)


@dataclass(frozen=True, slots=True, kw_only=True)
class ExactLaw(_Hookean):
    r"""Exact geometry and Hooke's law, Eqs. (2.7), (2.10) and (2.13).

    .. math:: 1 + \lambda = \sqrt{(1 + u')^2 + v'^2 + w'^2}, \qquad T = T_0 + K\lambda, \qquad
              (T_x, T_y, T_z) = T\,\frac{(1 + u', v', w')}{1 + \lambda}
    """

    name: ClassVar[str] = "exact"

    def _transverse_stretch(self, u_x: Array, v_x: Array, w_x: Array) -> Array:
        slopes = v_x**2 + w_x**2  # lambda - u' = slopes / (1 + lambda + 1 + u')
        return slopes / (np.sqrt((1.0 + u_x) ** 2 + slopes) + 1.0 + u_x)

    strain_gradient = CableLaw.strain_gradient

    def excess_components(self, u_x: Array, v_x: Array, w_x: Array) -> Components:
        """Components above the pretension, free of cancellation at small displacements [N]."""
        z = u_x * (2.0 + u_x) + v_x**2 + w_x**2  # (1 + lambda)^2 - 1
        gain = self.axial_rigidity * z / (1.0 + z + np.sqrt(1.0 + z))  # T / (1 + lambda) - T0
        across = self.pretension + gain
        return self.pretension * u_x + gain * (1.0 + u_x), across * v_x, across * w_x


@dataclass(frozen=True, slots=True, kw_only=True)
class WeakLaw(_Hookean):
    r"""Weakly nonlinear form as printed: truncated strain, exact directions. Eqs. (2.19) and (2.21).

    .. math:: \lambda = u' + \tfrac12 (v'^2 + w'^2), \qquad T = T_0 + K\lambda, \qquad
              (T_x, T_y, T_z) = T\,\frac{(1 + u', v', w')}{1 + \lambda}

    It has no potential: a segment led round a closed path of gradients gains or loses energy, since
    :math:`\partial T_x/\partial v' - \partial T_y/\partial u' = EA\,u' v'/(1 + \lambda)^2`.
    `ConsistentWeakLaw` is the truncation that has one.
    """

    name: ClassVar[str] = "weak"
    has_potential: ClassVar[bool] = False

    def excess_components(self, u_x: Array, v_x: Array, w_x: Array) -> Components:
        """Components above the pretension, free of cancellation at small displacements [N]."""
        strain = self.strain(u_x, v_x, w_x)
        gain = self.axial_rigidity * strain / (1.0 + strain)  # T / (1 + lambda) - T0
        across = self.pretension + gain
        return self.pretension * u_x + gain * (1.0 + u_x), across * v_x, across * w_x


@dataclass(frozen=True, slots=True, kw_only=True)
class ConsistentWeakLaw(_Hookean):
    r"""Weakly nonlinear form with a potential: the truncated strain in the energy.

    .. math:: \lambda = u' + \tfrac12 (v'^2 + w'^2), \qquad T = T_0 + K\lambda, \qquad
              (T_x, T_y, T_z) = (T,\; T v',\; T w')
    """

    name: ClassVar[str] = "weak-consistent"

    def excess_components(self, u_x: Array, v_x: Array, w_x: Array) -> Components:
        """Components above the pretension, free of cancellation at small displacements [N]."""
        excess = self.stiffness * self.strain(u_x, v_x, w_x)
        tension = self.pretension + excess
        return excess, tension * v_x, tension * w_x


@dataclass(frozen=True, slots=True, kw_only=True)
class LinearLaw(_Hookean):
    r"""Linear cable, whose two kinds of wave do not see each other, Eqs. (3.3) and (3.4).

    .. math:: T = T_0 + K u', \qquad (T_x, T_y, T_z) = (T,\; T_0 v',\; T_0 w')

    The last two are Eq. (3.5) without its products of gradients; together they give Eqs. (3.7)-(3.8).
    """

    name: ClassVar[str] = "linear"

    def strain(self, u_x: Array, v_x: Array, w_x: Array) -> Array:
        """Apparent strain [-]."""
        return u_x + 0.0 * (v_x + w_x)

    def strain_gradient(self, u_x: Array, v_x: Array, w_x: Array) -> Components:
        """Derivative of the apparent strain with respect to (u', v', w') [-]."""
        return np.ones_like(u_x), np.zeros_like(v_x), np.zeros_like(w_x)

    def excess_components(self, u_x: Array, v_x: Array, w_x: Array) -> Components:
        """Components above the pretension, free of cancellation at small displacements [N]."""
        return self.stiffness * u_x, self.pretension * v_x, self.pretension * w_x


LAWS: dict[str, type[CableLaw]] = {law.name: law for law in (ExactLaw, WeakLaw, ConsistentWeakLaw, LinearLaw)}


def cable_law(cable: Cable, model: Model = "exact", *, tension_only: bool = False) -> CableLaw:
    """Law of a cable.

    ``model``: "exact", "weak", "weak-consistent" or "linear"; or one's own law: a subclass of `CableLaw`, any
    callable that makes one from the keywords `pretension` and `axial_rigidity`, or one made for this cable;
    ``tension_only``: whether the cable goes slack instead of pushing.
    Raises `InputRefused` if the model is unknown or does not fit the cable, or the linear one is asked to go
    slack.
    """
    if isinstance(model, str):
        if model not in LAWS:
            raise InputRefused(f'model = "{model}" is no cable law{nearest(model, LAWS)}')
        if model == "linear" and tension_only:
            raise InputRefused(
                'model = "linear" cannot go slack, being linear: write "exact" or "weak-consistent"'
            )
    law = made_law(LAWS[model] if isinstance(model, str) else model, cable)
    if type(law) not in LAWS.values() or not isinstance(model, str):
        check_law(law, cable, LAWS)
    return without_pushing(law) if tension_only else law
