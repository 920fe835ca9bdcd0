"""Stoermer-Verlet on the staggered conservative chain: the default method."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import ClassVar, final

from cabledrive.simulation.method import Method
from cabledrive.simulation.own_law import integrate_own
from cabledrive.simulation.plan import OWN, Plan


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

    def kernel(self, plan: Plan) -> Callable[..., int]:
        """What takes the steps, see `Method.kernel`."""
        if plan.law == OWN:
            assert self.law is not None  # given with the run, see `cabledrive.simulation.case`
            return partial(integrate_own, self.law)
        from cabledrive.simulation.kernels.verlet import integrate

        return integrate
