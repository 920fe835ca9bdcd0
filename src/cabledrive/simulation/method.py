"""What every method of marching the cable in time offers; the run around it is the same for all."""

from abc import ABC, abstractmethod
from typing import ClassVar

from cabledrive.mechanics.cable_law import Array, CableLaw
from cabledrive.mechanics.mesh import Mesh
from cabledrive.simulation.plan import Plan
from cabledrive.simulation.state import State
from cabledrive.simulation.step_size import largest_stable_step
from cabledrive.simulation.workspace import Workspace

DONE, SLACK, NOT_FINITE = range(3)


class Method(ABC):
    """A way to march the cable in time.

    A method keeps displacements at the times of steps and velocities half a step before them in a `State`,
    and whatever else it needs in ``State.extra``. It records through `cabledrive.simulation.kernels.observe`,
    and counts works and losses so that the balance of its record closes as well as the method allows.
    """

    name: ClassVar[str]

    @abstractmethod
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
        """Take a step for each entry of `torque`, writing into `state`.

        ``state``: changed in place; at the end that after the last step; ``torque``, shape (steps,): torque
        at the time of each step [N m]; ``forces``, shape (steps, number of forces): forces at the time of
        each step [N]; ``every``: steps per record: the first of every `every` steps is recorded; ``rows``,
        shape (records, columns): gets the records, see `cabledrive.simulation.channels`; ``fields``, shape
        (records, 3, nodes): gets the displacements of all nodes.
        Returns DONE; SLACK if a span is slack at the start of a step and that is to stop the run, before the
        step; NOT_FINITE after the record in which the energy is not finite.
        """

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
