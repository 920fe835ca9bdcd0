r"""The methods by name, the largest stable step, and the grid of times a run takes.

Leapfrog is stable up to :math:`\omega_{max} \Delta t = 2` with the highest frequency of the chain. For a
uniform cable that is :math:`c_u \Delta t = \Delta x`, a CFL number of 1: Eq. (2.31) with the wave speed that
stands under (2.15).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil, isfinite, sqrt

import numpy as np

from cabledrive.mechanics.cable_law import Array, CableLaw
from cabledrive.mechanics.mesh import Mesh
from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.fields import nearest
from cabledrive.simulation import damped as of
from cabledrive.simulation import plan as at
from cabledrive.simulation.own_law import compiled_law, slack_of, stiffness_over_limit
from cabledrive.simulation.plan import Plan, State, Workspace
from cabledrive.simulation.start import Scheme

NONE = np.zeros(0)
NAMES = ("verlet", "node-centred", "energy-conserving")


def check_method(name: str, plan: Plan) -> None:
    """Refuse an unknown method, and what a method has no equation for, with what to take instead.

    "verlet": leapfrog on segments that carry tension between nodes that carry mass, symplectic without
    damping. "node-centred": central differences of the equations at the nodes, for comparison with the
    dissertation. "energy-conserving": a scalar auxiliary variable on the chain of "verlet", whose energy
    changes by work and losses alone, whatever the step. All of order 2 in space and time.
    """
    if name not in NAMES:
        raise InputRefused(f'method = "{name}" is not one of its values{nearest(name, NAMES)}')
    law, like = at.KERNEL_LAWS[plan.law] if plan.law != at.OWN else None, plan.piece[:, : at.SLACK_STRAIN]
    table: dict[str, dict[str, object]] = {
        "node-centred": {
            "carriages": plan.stop.size > 0,
            "axial damping": plan.axial != of.UNDAMPED,
            "slack of a tension-only cable": plan.tension_only,
        },
        "energy-conserving": {
            f'model = "{law and law.name}", which has no potential energy': law and not law.has_potential,
            'slack = "tension-only", whose energy has no lower bound': plan.tension_only,
            "ropes that slip on pulleys (capstan_friction)": bool((plan.wrap[:, 0] >= 0).any()),
        },
    }
    refused = table.get(name, {})
    if law is None and (np.ptp(like, axis=0) > 1e-12 * like[0]).any():
        raise InputRefused("laws of one's own are for ropes of one kind and tension: take a packaged law")
    if law is None and refused:
        raise InputRefused(f'method = "{name}" does not know laws of one\'s own: use "verlet"')
    for what, asked in refused.items():
        if asked:
            instead = 'model = "weak-consistent"' if what.startswith("model") else '"verlet"'
            raise InputRefused(f'method = "{name}" does not know {what}: use {instead}')


def auxiliary(plan: Plan, laws: Sequence[CableLaw], state: State) -> Array:
    """Of "energy-conserving": energy half a step before the start, a shift C, losses, (3 + n,) [J], [m]."""
    extra, spacing = np.zeros(at.PLACES_LOST + state.q.size), plan.segment[at.SPACING]
    for law, piece, (first, last) in zip(laws, plan.piece, plan.nodes, strict=True):
        h = spacing[first:last] * piece[at.ROPES]
        for x in (state.x, state.x - plan.step * state.x_t):
            u_x, v_x, w_x = np.diff(x[:, first : last + 1], axis=1) / spacing[first:last]
            quadratic = 0.5 * (law.stiffness * u_x**2 + law.pretension * (v_x**2 + w_x**2))
            extra[at.STORED] += 0.5 * h @ (law.energy_density(u_x, v_x, w_x) - quadratic)
        extra[at.SHIFT] -= 0.5 * piece[at.PRETENSION] * piece[at.SLACK_STRAIN] * float(np.sum(h))
    return extra


Given = tuple[Plan, State, Workspace]


def integrate_steps(
    method: str,
    given: Given,
    inputs: tuple[Array, Array],
    every: int,
    records: tuple[Array, Array],
    law: CableLaw | None = None,
) -> int:
    """Take a step for each input, writing into the state.

    ``inputs``: torques, (steps, motors) [N m], and forces, (steps, forces) [N]; ``every``: the first of so
    many steps is recorded; ``records``: rows, and fields, (records, 3, nodes), get them; ``law``: cable law
    where it is one's own. Returns DONE; SLACK before a step that slack is to stop; NOT_FINITE after the
    record in which the energy is not finite; TOO_STIFF before the step of a record at which an own law has
    grown too stiff for the step.
    """
    from cabledrive.simulation.kernels import integrate

    (plan, state, work), (torque, forces), (rows, fields) = given, inputs, records
    if plan.law != at.OWN or law is None:
        if plan.law not in range(len(at.KERNEL_LAWS)):
            raise ValueError(f"no kernel knows the cable law with number {plan.law}")
        fused = plan.axial == of.AS_STRAIGHT or (plan.axial == of.UNDAMPED and plan.run.size)
        if plan.law == at.EXACT and method == "verlet" and fused:
            return _taut_or_any(given, torque, forces, every, rows, fields)
        centred = NONE if method == "node-centred" else None
        extra = state.extra if method == "energy-conserving" else None
        return int(integrate(None, NONE, centred, extra, False, *given, *inputs, every, *records))
    formula = compiled_law(plan, law)
    compiled, numbers = (None, NONE) if isinstance(formula, str) else formula
    j = 0
    while j < len(torque):  # at records and where a segment is slack the law itself is asked
        recording = j % every == 0
        if recording and stiffness_over_limit(plan, law, state.x).max() > 1.0 + 1e-6:
            return at.TOO_STIFF
        if _ask(law, plan, state, work, recording) and plan.stop_when_slack:
            return at.SLACK
        end, row = j + 1 if compiled is None else min(len(torque), j - j % every + every), j // every
        begun, kept = int(state.counts[at.STEPS]), (rows[row : row + 1], fields[row : row + 1])
        here = torque[j:end], forces[j:end], every if recording else 0
        if integrate(compiled, numbers, None, None, True, *given, *here, *kept) == at.NOT_FINITE:
            return at.NOT_FINITE
        j += int(state.counts[at.STEPS]) - begun
    return at.DONE


def _taut_or_any(given: Given, torque: Array, forces: Array, every: int, rows: Array, fields: Array) -> int:
    """Steps of the exact law: one pass while all is taut, else one record's worth of the long loop."""
    from cabledrive.simulation.kernels import integrate
    from cabledrive.simulation.taut import integrate_taut, rows_of

    lines, j = rows_of(given[0], given[1]), 0
    damper = given[0].damper if given[0].axial == of.AS_STRAIGHT else None
    while j < len(torque):
        row = j // every
        inputs, record = (torque[j:], forces[j:]), (every, rows[row:], fields[row:])
        taken, finite = integrate_taut(*given, inputs, record, lines, damper)
        j += taken
        if j >= len(torque) or not finite:
            return at.DONE if finite else at.NOT_FINITE
        stop, row = min(len(torque), j + every), j // every  # it stands at a record
        here = torque[j:stop], forces[j:stop], every
        kept = rows[row : row + 1], fields[row : row + 1]
        if code := int(integrate(None, NONE, None, None, False, *given, *here, *kept)):
            return code
        j = stop
    return at.DONE


def _ask(law: CableLaw, plan: Plan, state: State, work: Workspace, recording: bool) -> bool:
    """What the law gives for the step to come, into the work space; whether a span is slack."""
    gradients = np.diff(state.x, axis=1) * plan.segment[at.INVERSE_SPACING]
    work.p[:] = np.stack(np.broadcast_arrays(*law.excess_components(*gradients)))
    if plan.axial != of.UNDAMPED:
        work.direction[:] = np.stack(np.broadcast_arrays(*law.strain_gradient(*gradients)))
    if recording:
        work.damp[at.TENSION], work.damp[at.ENERGY] = law.tension(*gradients), law.energy_density(*gradients)
    return slack_of(plan, law, state, gradients)


MOST_STEPS = 10**12
MOST_NODE_STEPS = 1e14
"""Steps times nodes: about a week of one core."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TimeGrid:
    """Steps and records of a run."""

    step: float  # time step [s]
    largest_step: float  # largest stable step [s]
    every: int  # steps per record
    records: int  # recording intervals; the run ends with one more record

    @property
    def steps(self) -> int:
        """Steps of the whole run."""
        return self.every * self.records

    @property
    def interval(self) -> float:
        """Time from record to record [s]."""
        return self.step * self.every


def largest_stable_step(mesh: Mesh, laws: Sequence[CableLaw]) -> float:
    r"""Largest step for which leapfrog is stable, Eq. (2.31) at a CFL number of 1; ``laws``: of each piece.

    The squares of the frequencies of ropes and springs are the eigenvalues of
    :math:`S^{1/2} D M^{-1} D^T S^{1/2}` over segments, whose ends move with nodes or coordinates, and
    springs; the row sums of its moduli bound them from above, sharply for a uniform cable. Bodies that turn
    under the forces at rest add at most their own. A cable that may go slack is a chain of springs with a
    kink, on which leapfrog is resonantly unstable where the shortest period takes few steps: there a quarter
    of that, a dozen steps per shortest period.

    Returns step [s].
    """
    from scipy.linalg import eigh

    stiffness, springs = mesh.ropes * [law.largest_stiffness() for law in laws], mesh.network.springs
    roots = [np.sqrt(k / mesh.spacing[a:b]) for k, (a, b) in zip(stiffness, mesh.nodes, strict=True)]
    rows = mesh.ends.reshape(6 * len(roots), -1)
    rows = np.vstack([rows, np.pad(springs.dense, ((0, 0), (0, len(mesh.wraps))))])
    beside = np.concatenate([*(own[[0, 0, 0, -1, -1, -1]] for own in roots), np.sqrt(springs.values)])
    sums = np.abs(rows @ np.linalg.solve(mesh.mass, rows.T)) @ beside
    outer, mass = sums[: 6 * len(roots)].reshape(-1, 2, 3).max(axis=2), mesh.cells + mesh.carried
    square = float(np.max((beside * sums)[6 * len(roots) :], initial=0.0))
    for root, ropes, (start, end), (first, last) in zip(roots, mesh.ropes, outer, mesh.nodes, strict=True):
        inner = (root[1:] + root[:-1]) / (ropes * mass[first + 1 : last])
        on_nodes = np.concatenate([[start], inner, [end]])
        square = max(square, float(np.max(root * (on_nodes[1:] + on_nodes[:-1]))))
    if mesh.network.turning:
        turning = np.pad(mesh.network.geometric, (0, len(mesh.wraps)))
        square += max(float(eigh(turning, mesh.mass, eigvals_only=True)[-1]), 0.0)
    return float((0.25 if laws[0].tension_only else 1.0) * 2.0 / sqrt(square))


def time_grid(duration: float, largest_step: float, scheme: Scheme, rate: float, nodes: int = 1) -> TimeGrid:
    """Steps and records of a run, the last record exactly at its end.

    ``duration``: length of the run [s]; ``largest_step``: largest stable step [s]; ``rate``: least number of
    records per second [Hz]; ``nodes``: of the divided cable.
    Raises `InputRefused` if the run has no end, the step is not stable, or the run takes too many steps.
    """
    step = scheme.step
    if not (isfinite(duration) and duration > 0.0):
        raise InputRefused(f"duration = {duration} s must be above 0 and finite: give the length of the run")
    if not (isfinite(rate) and rate > 0.0):
        raise InputRefused(f"rate = {rate} Hz must be above 0 and finite: give the records per second")
    if step is not None and step > largest_step * (1.0 + 1e-12):
        raise InputRefused(
            f"step = {step:.6g} s is not stable: at most {largest_step:.6g} s (CFL 1), or fewer segments"
        )
    wanted = min(scheme.cfl * largest_step if step is None else step, duration)
    most = min(MOST_STEPS, MOST_NODE_STEPS / nodes)
    if duration / wanted > most:
        said = f"duration = {duration:.6g} s takes {duration / wanted:.3g} steps of {wanted:.3g} s"
        raise InputRefused(f"{said}, at most {most:.3g} are taken: shorten the run or use fewer segments")
    records = max(1, ceil(duration * rate * (1.0 - 1e-12)))
    interval = duration / records
    every = max(1, ceil(interval / wanted * (1.0 - 1e-12)))
    return TimeGrid(step=interval / every, largest_step=largest_step, every=every, records=records)
