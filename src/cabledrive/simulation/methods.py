"""The methods by name: what each refuses, what it starts with, and the steps it takes."""

from dataclasses import dataclass

import numpy as np

from cabledrive.mechanics.cable_law import Array, CableLaw
from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.fields import nearest
from cabledrive.simulation.own_law import compiled_law, slack_of, stiffness_over_limit
from cabledrive.simulation.plan import (
    DONE,
    ENERGY,
    INVERSE_SPACING,
    KERNEL_LAWS,
    MOTOR_LOST,
    NOT_FINITE,
    OWN,
    SHIFT,
    SLACK,
    SPACING,
    STEPS,
    STORED,
    TENSION,
    TOO_STIFF,
    Plan,
    State,
    Workspace,
    law_of,
)

NONE = np.zeros(0)
NAMES = ("verlet", "node-centred", "energy-conserving")


@dataclass(frozen=True, slots=True, kw_only=True)
class Method:
    """A way to integrate the cable in time.

    "verlet": leapfrog on segments that carry tension between nodes that carry mass, symplectic without
    damping. "node-centred": central differences of the equations at the nodes, for comparison with the
    dissertation. "energy-conserving": a scalar auxiliary variable on the chain of "verlet", whose energy
    changes by work and losses alone, whatever the step. All of order 2 in space and time.

    ``law``: cable law of the run; None: that of the plan.
    """

    name: str = "verlet"
    law: CableLaw | None = None

    def check(self, plan: Plan) -> None:
        """Refuse what the method has no equation for, with what to take instead."""
        law = KERNEL_LAWS[plan.law] if plan.law != OWN else None
        table: dict[str, dict[str, object]] = {
            "node-centred": {
                "carriages or unequal segments": not plan.uniform and plan.axial_damping == 0.0,
                "axial damping": plan.axial_damping > 0.0,
                "slack of a tension-only cable": plan.tension_only,
            },
            "energy-conserving": {
                f'model = "{law and law.name}", which has no potential energy': law and not law.has_potential,
                'slack = "tension-only", whose energy has no lower bound': plan.tension_only,
            },
        }
        refused = table.get(self.name, {})
        if law is None and refused:
            raise InputRefused(f'method = "{self.name}" does not know laws of one\'s own: use "verlet"')
        for what, asked in refused.items():
            if asked:
                instead = 'model = "weak-consistent"' if what.startswith("model") else '"verlet"'
                raise InputRefused(f'method = "{self.name}" does not know {what}: use {instead}')

    def extra(self, plan: Plan, state: State) -> Array:
        """Energy half a step before the start, a shift C, and losses, (6,) [J], [m]; else of size 0."""
        if self.name != "energy-conserving":
            return np.zeros(0)
        law, extra = law_of(plan), np.zeros(MOTOR_LOST + 1)
        for x in (state.x, state.x - plan.step * state.x_t):
            u_x, v_x, w_x = np.diff(x, axis=1) * plan.segment[INVERSE_SPACING]
            quadratic = 0.5 * (law.stiffness * u_x**2 + law.pretension * (v_x**2 + w_x**2))
            extra[STORED] += 0.5 * plan.segment[SPACING] @ (law.energy_density(u_x, v_x, w_x) - quadratic)
        extra[SHIFT] = -0.5 * plan.pretension * plan.slack_strain * float(np.sum(plan.segment[SPACING]))
        return extra

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

        ``torque``, (steps,) [N m]; ``forces``, (steps, forces) [N]; ``every``: the first of so many steps is
        recorded; ``rows`` and ``fields``, (records, 3, nodes): get the records. Returns DONE; SLACK before a
        step that slack is to stop; NOT_FINITE after the record in which the energy is not finite; TOO_STIFF
        before the step of a record at which an own law has grown too stiff for the step.
        """
        from cabledrive.simulation.kernels import integrate

        centred = work.mean if self.name == "node-centred" else None
        extra = state.extra if self.name == "energy-conserving" else None
        given = plan, state, work
        if plan.law != OWN or self.law is None:
            law_of(plan)
            quick = {"verlet": plan.axial_damping == 0.0, "energy-conserving": plan.uniform}
            if plan.law == 0 and quick.get(self.name):
                return _taut_or_any(extra, given, torque, forces, every, rows, fields)
            return int(
                integrate(None, NONE, centred, extra, False, *given, torque, forces, every, rows, fields)
            )
        formula = compiled_law(plan, self.law)
        law, numbers = (None, NONE) if isinstance(formula, str) else formula
        j = 0
        while j < torque.size:  # at records and where a segment is slack the law itself is asked
            recording = j % every == 0
            if recording and stiffness_over_limit(plan, self.law, state.x).max() > 1.0 + 1e-6:
                return TOO_STIFF
            if _ask(self.law, plan, state, work, recording) and plan.stop_when_slack:
                return SLACK
            end, row = j + 1 if law is None else min(torque.size, j - j % every + every), j // every
            begun, records = int(state.counts[STEPS]), (rows[row : row + 1], fields[row : row + 1])
            inputs = torque[j:end], forces[j:end], every if recording else 0
            if integrate(law, numbers, None, None, True, *given, *inputs, *records) == NOT_FINITE:
                return NOT_FINITE
            j += int(state.counts[STEPS]) - begun
        return DONE


def _taut_or_any(
    extra: Array | None,
    given: tuple[Plan, State, Workspace],
    torque: Array,
    forces: Array,
    every: int,
    rows: Array,
    fields: Array,
) -> int:
    """Steps of the exact law: one pass while all is taut, else one record's worth of the long loop."""
    from cabledrive.simulation.energy_equal_segments import integrate_equal_segments
    from cabledrive.simulation.kernels import integrate
    from cabledrive.simulation.taut import integrate_taut, rows_of

    lines, j = rows_of(given[1]), 0
    while j < torque.size:
        if extra is None:
            j, finite = integrate_taut(*given, torque, forces, every, rows, fields, j, *lines)
        else:
            j, finite = integrate_equal_segments(*given, torque, every, rows, fields, j, *lines)
        if j >= torque.size or not finite:
            return DONE if finite else NOT_FINITE
        stop = min(torque.size, j - j % every + every)
        here, row = slice(j, stop), slice(j // every, j // every + 1)
        inputs = torque[here], forces[here], every if j % every == 0 else 0
        if code := int(integrate(None, NONE, None, extra, False, *given, *inputs, rows[row], fields[row])):
            return code
        j = stop
    return DONE


def _ask(law: CableLaw, plan: Plan, state: State, work: Workspace, recording: bool) -> bool:
    """What the law gives for the step to come, into the work space; whether a span is slack."""
    gradients = np.diff(state.x, axis=1) * plan.segment[INVERSE_SPACING]
    work.p[:] = np.stack(np.broadcast_arrays(*law.excess_components(*gradients)))
    if plan.axial_damping > 0.0:
        work.direction[:] = np.stack(np.broadcast_arrays(*law.strain_gradient(*gradients)))
    if recording:
        work.q[TENSION], work.q[ENERGY] = law.tension(*gradients), law.energy_density(*gradients)
    return slack_of(plan, law, state, gradients)


METHODS = {name: Method(name=name) for name in NAMES}


def method_named(name: str) -> Method:
    """Method of a name; others are refused."""
    if name not in METHODS:
        raise InputRefused(f'method = "{name}" is not one of its values{nearest(name, METHODS)}')
    return METHODS[name]
