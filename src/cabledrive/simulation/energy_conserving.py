"""An explicit scheme whose energy changes by work and losses alone, whatever the step."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from cabledrive.mechanics.cable_law import Array, CableLaw
from cabledrive.parameters.errors import InputRefused
from cabledrive.simulation.method import Method, refuse_own_law
from cabledrive.simulation.plan import INVERSE_SPACING, KERNEL_LAWS, SPACING, Plan, law_of
from cabledrive.simulation.state import MOTOR_LOST, SHIFT, STORED, State


@final
@dataclass(frozen=True, slots=True)
class EnergyConserving(Method):
    r"""Scalar auxiliary variable on the chain of `StoermerVerlet`.

    The linear part of the cable is integrated by leapfrog. The rest of its energy is represented by one
    number that is integrated with it, and the nonlinear forces are scaled by it so that the energy budget
    closes to round-off at every step, see `cabledrive.simulation.kernels.energy_conserving`. Order 2 in
    space and time.

    The energy that is conserved is the scheme's own: how far its number E is from the energy V(x) it stands
    for is a discretisation error of second order, and shows as the difference between the column "balance"
    and the energies, works and losses beside it.
    """

    name: ClassVar[str] = "energy-conserving"

    def check(self, plan: Plan) -> None:
        """Refuse what has no energy to conserve, see `Method.check`.

        Raises `InputRefused` for an own law, for the weak law as printed, which has no potential, and for a
        cable that goes slack, whose energy beyond the linear one has no lower bound.
        """
        refuse_own_law(plan, self.name)
        law = KERNEL_LAWS[plan.law]
        if not law.has_potential:
            raise InputRefused(
                f'model = "{law.name}" has no potential energy that method = "{self.name}" could conserve: '
                'use "weak-consistent"'
            )
        if plan.tension_only:
            raise InputRefused(
                f'slack = "tension-only" leaves method = "{self.name}" without a lower bound of energy: '
                'use "verlet"'
            )

    def extra(self, plan: Plan, state: State) -> Array:
        """E and C at the start, and what rounding took, see `Method.extra`.

        Returns shape (6,): energies [J] and displacements [m].
        """
        return extra_at_start(plan, state)

    def kernel(self, plan: Plan) -> Callable[..., int]:
        """What takes the steps, see `Method.kernel`."""
        from cabledrive.simulation.kernels.energy_conserving import integrate

        return integrate


def extra_at_start(plan: Plan, state: State) -> Array:
    """E half a step before the start, and a shift C of half the pretension times the slack elongation.

    ``state``: at the start.
    Returns shape (6,): `State.extra` of the scheme: energies [J], then what rounding took [J], [m].
    """
    law = law_of(plan)
    before = state.x - plan.step * state.x_t
    energies = [
        _nonlinear_energy(plan, law, np.diff(x, axis=1) * plan.segment[INVERSE_SPACING])
        for x in (state.x, before)
    ]
    length = float(np.sum(plan.segment[SPACING]))
    extra = np.zeros(MOTOR_LOST + 1)
    extra[STORED] = 0.5 * sum(energies)
    extra[SHIFT] = -0.5 * plan.pretension * plan.slack_strain * length
    return extra


def _nonlinear_energy(plan: Plan, law: CableLaw, gradients: Array) -> float:
    """Elastic energy beyond that of the linear law, V [J]."""
    u_x, v_x, w_x = gradients
    quadratic = 0.5 * (law.stiffness * u_x**2 + law.pretension * (v_x**2 + w_x**2))
    return float(np.sum(plan.segment[SPACING] * (law.energy_density(u_x, v_x, w_x) - quadratic)))
