"""The dissertation's node-centred scheme, corrected: for comparison with it."""

from dataclasses import dataclass
from typing import ClassVar, final

from cabledrive.mechanics.cable_law import Array
from cabledrive.parameters.errors import InputRefused
from cabledrive.simulation.method import Method, refuse_own_law
from cabledrive.simulation.plan import Plan
from cabledrive.simulation.state import State
from cabledrive.simulation.workspace import Workspace


@final
@dataclass(frozen=True, slots=True)
class NodeCentred(Method):
    """Central differences of the equations of motion written out at the nodes.

    Order 2 in space and time like `StoermerVerlet`, but not conservative: first differences reach over two
    segments, so that the chain has no energy of its own, and its budget closes only as well as the mesh is
    fine.
    """

    name: ClassVar[str] = "node-centred"

    def check(self, plan: Plan) -> None:
        """Refuse what the scheme has no equation for, see `Method.check`.

        Raises `InputRefused` for an own law, carriages, axial damping, forces on carriages, and a cable that
        goes slack.
        """
        refuse_own_law(plan, self.name)
        beyond = {
            "carriages or unequal segments": not plan.uniform and plan.axial_damping == 0.0,
            "axial damping": plan.axial_damping > 0.0,
            "slack of a tension-only cable": plan.tension_only,
        }
        for what, asked in beyond.items():
            if asked:
                raise InputRefused(f'method = "{self.name}" does not know {what}: use "verlet"')

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
        from cabledrive.simulation.kernels.node_centred import march

        return march(plan, state, work, torque, forces, every, rows, fields)
