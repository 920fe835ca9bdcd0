"""An explicit scheme whose energy changes by work and losses alone, whatever the step."""

from dataclasses import dataclass
from typing import ClassVar, final

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.compiled import numba_at_hand
from cabledrive.parameters.errors import InputRefused
from cabledrive.simulation.method import Method, refuse_own_law
from cabledrive.simulation.plan import KERNEL_LAWS, Plan
from cabledrive.simulation.readable.energy_conserving import extra_at_start
from cabledrive.simulation.state import State
from cabledrive.simulation.workspace import Workspace


@final
@dataclass(frozen=True, slots=True)
class EnergyConserving(Method):
    r"""Scalar auxiliary variable on the chain of `StoermerVerlet`.

    The linear part of the cable is marched by leapfrog. The rest of its energy is represented by one number
    that is marched along, and the nonlinear forces are scaled by it so that the energy budget closes to
    round-off at every step, see `cabledrive.simulation.readable.energy_conserving`. Order 2 in space and
    time.

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

    def march(
        self,
        plan: Plan,
        state: State,
        work: Workspace,
        torque: Array,
        forces: Array,
        every: int,
        rows: Array,
        fields: Array,
    ) -> int:
        """Take a step for each entry of `torque`, see `Method.march`.

        ``plan``, ``state``, ``work``, ``torque``, ``forces``, ``every``, ``rows``, ``fields``: see
        `Method.march`.
        Returns see `Method.march`.
        """
        if numba_at_hand():
            from cabledrive.simulation.kernels.energy_conserving import march
        else:
            from cabledrive.simulation.readable.energy_conserving import march_reference as march
        return march(plan, state, work, torque, forces, every, rows, fields)
