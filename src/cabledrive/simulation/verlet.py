"""Stoermer-Verlet on the staggered conservative chain: the default method."""

from dataclasses import dataclass
from typing import ClassVar, final

from cabledrive.mechanics.cable_law import Array
from cabledrive.simulation.method import Method
from cabledrive.simulation.own_law import march_own
from cabledrive.simulation.plan import OWN, Plan
from cabledrive.simulation.state import State
from cabledrive.simulation.workspace import Workspace


@final
@dataclass(frozen=True, slots=True)
class StoermerVerlet(Method):
    r"""Leapfrog on segments that carry tension between nodes that carry mass.

    Strains are taken on the segments, half-way between the nodes; the rims have the inertia of their pulley
    and the half cells of cable on both sides. Order 2 in space and time; symplectic without damping, so that
    the energy error stays bounded; a damping is taken at the mean of the velocities before and after, which
    dissipates whatever the step.
    """

    name: ClassVar[str] = "verlet"

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
        if plan.law == OWN:
            assert self.law is not None  # given with the run, see `cabledrive.simulation.case`
            return march_own(plan, self.law, state, work, torque, forces, every, rows, fields)
        from cabledrive.simulation.kernels.verlet import march

        return march(plan, state, work, torque, forces, every, rows, fields)
