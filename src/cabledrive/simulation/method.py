"""What every method of integrating the cable in time offers; the run around it is the same for all."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

from cabledrive.mechanics.cable_law import Array, CableLaw
from cabledrive.mechanics.mesh import Mesh
from cabledrive.parameters.errors import InputRefused
from cabledrive.simulation.plan import OWN, Plan
from cabledrive.simulation.state import State
from cabledrive.simulation.step_size import largest_stable_step
from cabledrive.simulation.workspace import Workspace

DONE, SLACK, NOT_FINITE, TOO_STIFF = range(4)


@dataclass(frozen=True, slots=True)
class Method(ABC):
    """A way to integrate the cable in time.

    A method keeps displacements at the times of steps and velocities half a step before them in a `State`,
    and whatever else it needs in ``State.extra``. It records through `cabledrive.simulation.kernels.observe`,
    and counts works and losses so that the balance of its record closes as well as the method allows.

    ``law``: cable law of the run; None: that of the plan.
    """

    name: ClassVar[str]

    law: CableLaw | None = None

    def integrate(
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
        """Take a step for each entry of `torque`, writing into `state`.

        ``state``: changed in place; at the end that after the last step; ``torque``, shape (steps,): torque
        at the time of each step [N m]; ``forces``, shape (steps, number of forces): forces at the time of
        each step [N]; ``every``: steps per record: the first of every `every` steps is recorded; ``rows``,
        shape (records, columns): gets the records, see `cabledrive.simulation.channels`; ``fields``, shape
        (records, 3, nodes): gets the displacements of all nodes.
        Returns DONE; SLACK if a span is slack at the start of a step and that is to stop the run, before the
        step; NOT_FINITE after the record in which the energy is not finite; TOO_STIFF before the step of a
        record at which an own law has grown too stiff for the step.
        """
        return self.kernel(plan)(plan, state, work, torque, forces, every, rows, fields)

    @abstractmethod
    def kernel(self, plan: Plan) -> Callable[..., int]:
        """What takes the steps of `integrate`; kernels are imported when it is first asked for."""

    def check(self, plan: Plan) -> None:
        """Refuse what the method cannot do.

        Raises `InputRefused` if the drive or an option is beyond the method.
        """
        del plan

    def largest_step(self, mesh: Mesh, law: CableLaw) -> float:
        """Largest stable step.

        Returns step [s].
        """
        return largest_stable_step(mesh, law)

    def extra(self, plan: Plan, state: State) -> Array | None:
        """Numbers the method keeps from step to step beside displacements and velocities.

        ``state``: the state at the start.
        Returns their values at the start; None if there are none.
        """
        del plan, state
        return None


def refuse_own_law(plan: Plan, method: str) -> None:
    """Refuse a law for which a method has no equations.

    Raises `InputRefused` if the law is none of the kernels'.
    """
    if plan.law == OWN:
        raise InputRefused(f'method = "{method}" does not know laws of one\'s own: use "verlet"')
