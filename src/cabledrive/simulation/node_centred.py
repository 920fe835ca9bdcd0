"""The dissertation's node-centred scheme, corrected: for comparison with it."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar, final

from cabledrive.parameters.errors import InputRefused
from cabledrive.simulation.method import Method, refuse_own_law
from cabledrive.simulation.plan import Plan


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

    def kernel(self, plan: Plan) -> Callable[..., int]:
        """What takes the steps, see `Method.kernel`."""
        from cabledrive.simulation.kernels.node_centred import integrate

        return integrate
