"""Everything that is decided before the first step of a run of ropes, and how it is read."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from hashlib import sha256
from math import log2
from typing import Any

import numpy as np

from cabledrive.mechanics.cable_law import Array, CableLaw
from cabledrive.mechanics.cable_laws import cable_law, taut_law
from cabledrive.mechanics.compiled import why_plain
from cabledrive.mechanics.mesh import Mesh, mesh_of
from cabledrive.mechanics.network.motion import ACROSS, ALONG, OUT_OF_PLANE, gravity
from cabledrive.mechanics.network.statics import unheld_words
from cabledrive.modal.ranges import ALLOWED, sag_words
from cabledrive.parameters import Machine
from cabledrive.parameters.cable import Cable
from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.route.two_pulleys import NAMES
from cabledrive.simulation import plan as at
from cabledrive.simulation.channels import (
    AXIAL_LOSS,
    COULOMB_LOSS,
    FORCE_WORK,
    JOINT_LOSS,
    TALLIES,
    TORQUE_WORK,
    TRANSVERSE_LOSS,
    VISCOUS_LOSS,
    channels_of,
    width_of,
)
from cabledrive.simulation.keeping import Records
from cabledrive.simulation.methods import (
    auxiliary,
    check_method,
    integrate_steps,
    largest_stable_step,
    time_grid,
)
from cabledrive.simulation.network.mesh import Rest, network_plan, passed_words, rest_of
from cabledrive.simulation.own_law import law_fingerprint, stiffness_over_limit, why_interpreted
from cabledrive.simulation.plan import Plan, State, Workspace, copy_state, new_state, new_workspace
from cabledrive.simulation.prepared import Outcome, PreparedRun, extremes_of, half_step_before, reached
from cabledrive.simulation.result import SimulationResult, SlackEvent, neglected
from cabledrive.simulation.run import integrate_run
from cabledrive.simulation.signals import (
    CarriageForce,
    Function,
    Signal,
    checked_forces,
    motor_torques,
    offsets_of,
)
from cabledrive.simulation.start import PLANES, Recording, Scheme, Start, at_start, check_routes


@dataclass(frozen=True, kw_only=True, eq=False)
class RopeRun(PreparedRun):
    """A run of ropes between coordinates, as the kernels take it, that has not begun."""

    plan: Plan
    mesh: Mesh
    laws: list[CableLaw]  # of each piece
    rest: Rest
    forces: tuple[Signal, ...]  # on nodes
    start: State  # displacements and velocities at t = 0
    coarser: Callable[[Scheme], "RopeRun"] | None = None
    """The same run with another scheme, where its discretisation error is to be estimated."""

    @property
    def nodes(self) -> int:
        """Nodes of all ropes."""
        return int(self.plan.node.shape[1])

    @cached_property
    def interpreted(self) -> str | None:
        """Why the steps are not compiled, in one line; None if they are."""
        return why_interpreted(self.plan, self.laws[0]) if self.plan.law == at.OWN else why_plain()

    @property
    def law_name(self) -> str:  # type: ignore[override]
        """Name of the cable law."""
        return taut_law(self.laws[0]).name

    @cached_property
    def work(self) -> Workspace:
        """Work space of the steps."""
        return new_workspace(self.plan)

    def inputs(self, first: int, steps: int) -> tuple[Array, ...]:
        """Torques, (steps, motors) [N m], and forces, (steps, forces) [N]."""
        return (*super().inputs(first, steps), self.at_steps(self.forces, first, steps))

    def first_state(self) -> State:
        """State before the first step: velocities half a step before the start."""
        (torque, *_), (forces, *_) = self.inputs(0, 1)
        state = half_step_before(self.plan, self.laws, copy_state(self.start), torque, forces)
        if self.scheme.method != "energy-conserving":
            return state
        return state._replace(extra=auxiliary(self.plan, self.laws, state))

    def integrate(self, state: State, inputs: list[Array], every: int, rows: Array, fields: Array) -> int:
        """Take the steps, the first of every ``every`` recorded; why they end."""
        found = np.zeros((len(rows), width_of(self.plan)))
        given, (torque, forces), law = (self.plan, state, self.work), inputs, self.laws[0]
        code = integrate_steps(self.scheme.method, given, (torque, forces), every, (found, fields), law)
        with np.errstate(all="ignore"):  # of a run that diverged
            rows[:] = self.columns(found)
        return code

    @property
    def energy_at_rest(self) -> float:
        """What the ropes store at rest [J]."""
        mesh = self.mesh
        stretched = 0.5 * mesh.ropes * mesh.tension**2 / mesh.rigidity * mesh.length
        return float(np.sum(stretched)) + abs(float(self.rest.energy))

    def slack_events(self, state: State) -> tuple[SlackEvent, ...]:
        """Where and when spans went slack up to a state, in order, the first thousand times."""
        events = []
        for step, piece, segment, tension in state.events[: state.counts[at.EVENTS]].tolist():
            span, middle = int(piece), slice(int(segment), int(segment) + 2)
            place, name = float(self.mesh.positions[span][middle].mean()), self.mesh.pieces[span]
            when = float(step * self.grid.step)
            events.append(SlackEvent(time=when, span=name, position=place, tension=tension))
        return tuple(events)

    def why(self, code: int, state: State) -> str:
        """Why steps ended early, in one line."""
        if code == at.TOO_STIFF:
            return self._too_stiff(state)
        if code != at.SLACK:
            when = state.counts[at.STEPS] * self.grid.step
            return f"diverged: the energy is not finite from t = {when:.6g} s on: lower cfl or the input"
        event = self.slack_events(state)[-1]
        said = f"the {event.span} span goes slack at t = {event.time:.6g} s, x = {event.position:.4g} m"
        return f"{said} ({event.tension:.3g} N): raise the pretension, lower the input or allow slack"

    def _too_stiff(self, state: State) -> str:
        mesh, over = self.mesh, stiffness_over_limit(self.plan, self.laws[0], state.x)
        stiffest = int(np.argmax(over))
        span = int(np.searchsorted(mesh.nodes[:, 0], stiffest, side="right")) - 1
        segment = stiffest - mesh.nodes[span, 0]
        return (
            f"the law {self.law_name} is too stiff for the step of {self.grid.step:.4g} s at "
            f"t = {state.counts[at.STEPS] * self.grid.step:.6g} s in the {mesh.pieces[span]} span at "
            f"{mesh.positions[span][segment]:.4g} m: give a step of at most "
            f"{self.grid.step / np.sqrt(over.max()):.4g} s"
        )

    def columns(self, found: Array) -> Array:
        """The columns of a record from what the kernels record."""
        plan, pieces, n = self.plan, len(self.plan.nodes), len(self.mesh.names)
        widths = [pieces, pieces, 2 * pieces, pieces, 3 * len(plan.probe), 1, 1, 1, TALLIES, 1, n, n]
        parts = np.split(found, np.cumsum(widths), axis=1)
        mean, least, ropes, strain, points, weights, bodies, springs, tallies, balance, q, q_t, torque = parts
        turns = self.mesh.turns.T
        places = np.hstack([(q - self.rest.turned) @ turns, q_t @ turns])
        # the constant forces that hold the ropes' ends at rest are theirs
        ends = -(q @ plan.rest)[:, None]
        tallies[:, TORQUE_WORK] += tallies[:, FORCE_WORK]
        tallies[:, VISCOUS_LOSS] += tallies[:, JOINT_LOSS]
        tallies = tallies[:, [TORQUE_WORK, TRANSVERSE_LOSS, AXIAL_LOSS, VISCOUS_LOSS, COULOMB_LOSS]]
        ropes, strain = (own.sum(axis=1, keepdims=True) for own in (ropes, strain))
        strain, springs = strain + weights + ends - self.rest.energy, springs - ends
        return np.hstack(
            [places, torque, mean, least, points, ropes, bodies, strain, springs, tallies, balance]
        )

    def result(self, outcome: Outcome) -> SimulationResult:
        """Result of the run, as far as it went."""
        mesh, rows, scheme = self.mesh, outcome.rows, self.scheme
        outcome = outcome._replace(fields=outcome.fields - self.rest.counted)
        columns = {channel.name: k for k, channel in enumerate(self.channels)}
        energies = rows[:1, columns["rope_energy"] : columns["rope_energy"] + 4].sum() if len(rows) else 0.0
        work = float(np.max(rows[:, columns["torque_work"]], initial=0.0))
        quantities = [*mesh.shown, *(f"w at the middle of {span}" for span in mesh.pieces)]
        # Turning a pulley passes rope on: only bodies count.
        bodies = [n for n, name in enumerate(mesh.names) if "." in name and not name.startswith("slip at ")]
        reach = reached(outcome.state)
        most = np.abs(reach).max(axis=0)
        along = np.einsum("kaxn,n->kax", np.abs(mesh.ends[:, :, [0, 2]][..., bodies]), most[bodies])
        middles = zip(mesh.pieces, (0.5 * mesh.length).tolist(), strict=True)
        return SimulationResult(
            **self.common(outcome),
            spans=mesh.pieces,
            positions=tuple(mesh.positions),
            probes=(*middles, *self.recording.probes),
            midpoint_peaks=dict(zip(mesh.pieces, outcome.state.peaks[:, 1].tolist(), strict=True)),
            slack_events=self.slack_events(outcome.state),
            energy_at_rest=self.energy_at_rest,
            resting=self.rest.x - self.rest.counted,
            extremes=extremes_of(mesh.shown, (reach - self.rest.turned) @ mesh.turns.T),
            energy_handled=max(float(energies), 0.0) + work,
            error_estimate=estimated_errors(self, outcome, {name: columns[name] for name in quantities}),
            largest_motion=float((along.max(axis=(1, 2)) / mesh.length).max(initial=0.0)),
            assumptions=(
                *_ASSUMPTIONS[: 2 if mesh.whole else 3],
                *neglected(mesh.network.drive.ropes, mesh.network.drive.motor),
            ),
            doubts=(
                *(() if mesh.whole else unheld_words(mesh.network.motion, mesh.network.statics)),
                *(sag_words(mesh.network, least=ALLOWED) if self.law_name == "linear" else ()),
                *passed_words(mesh, most),
            ),
            provenance=self.provenance(
                {
                    "smoothing_speed": scheme.smoothing_speed if scheme.friction == "smoothed" else None,
                    "motor": mesh.network.motion.motor,
                },
                torque=[signal.fingerprint for signal in self.torques],
                torque_offset=self.holding.tolist(),
            ),
        )


_ASSUMPTIONS = (
    "motion about the state of rest: wraps and directions of spans stay those at rest",
    "ropes hang, and leave their pulleys where they do at rest",
    "torque: beyond what holds the machine at rest",
)


def released_torque(mesh: Mesh) -> float:
    """Torque that holds a loop or a line at rest and is not given to a run [N m]: no spring has it."""
    drive = mesh.network.drive
    if drive.pulley[0].fixed or any(motor.holding_stiffness for motor in drive.motor):
        return 0.0
    standing = 0.0 if drive.route[0].closed else drive.pulley[0].radius * (drive.ropes[0].pretension or 0.0)
    return float(mesh.network.statics.torques[0]) + standing


def case_of(
    machine: Machine,
    duration: float,
    *,
    torque: Mapping[str, Signal | float | Function] | Signal | float | Function = 0.0,
    forces: Sequence[CarriageForce] = (),
    start: Start | None = None,
    scheme: Scheme | None = None,
    recording: Recording | None = None,
) -> RopeRun:
    """Check and prepare a run; what cannot be run is refused. Arguments as of `simulate`."""
    start, scheme, recording = start or Start(), scheme or Scheme(), recording or Recording()
    mesh = mesh_of(machine, scheme.segments)
    if not mesh.whole:
        check_routes(machine, scheme, recording, start)
    elif start.places or start.speeds:
        raise InputRefused('start: places and speeds are for machines of kind "route": give angles')
    cables = (
        Cable(given_rigidity=float(rigidity), mass_per_length=1.0, pretension=float(tension))
        for tension, rigidity in zip(mesh.tension, mesh.rigidity, strict=True)
    )
    laws = [cable_law(one, scheme.model, tension_only=scheme.slack == "tension-only") for one in cables]
    grid = time_grid(duration, largest_stable_step(mesh, laws), scheme, recording.rate, mesh.size)
    torques = motor_torques(mesh.driven, torque, duration, grid.step)
    pushes = checked_forces(machine, forces, duration, grid.step)
    rest, holding, nodes = rest_of(mesh, laws, gravity(machine)), 0.0, list[tuple[int, int]]()
    if mesh.whole:
        holding = released_torque(mesh)
        given = rest.given - holding * machine.sense * np.array([name == NAMES[0] for name in mesh.names])
        rest = rest._replace(given=given)
        nodes = [(int(mesh.carriages[own.carriage]), PLANES.index(own.plane)) for own in forces]
    plan = network_plan(mesh, laws, rest, recording.probes, grid.step, scheme, nodes)
    check_method(scheme.method, plan)
    x, x_t, q, q_t = at_start(mesh, laws, rest, start, holding)
    settings = {
        "law": law_fingerprint(laws[0]),
        "torque": [signal.fingerprint for signal in torques],
        "forces": [push.fingerprint for push in pushes],
        "force_places": plan.force.tolist(),
        "start": sha256(b"".join(own.tobytes() for own in (x, x_t, q, q_t))).hexdigest(),
    }
    points = [f"the middle of {span}" for span in mesh.pieces]
    points += [f"{place:g} m of {span}" for span, place in recording.probes]
    pushed, offsets = list[str](), np.multiply(machine.sense, offsets_of(machine))
    if not mesh.whole:  # carriages are coordinates
        ways = dict(zip(PLANES, (ALONG, OUT_OF_PLANE, ACROSS), strict=True))
        pushed = [f"{mesh.network.motion.carriage_name(own.carriage)} {ways[own.plane]}" for own in forces]
        units = np.eye(len(mesh.names))[[mesh.names.index(name) for name in pushed]]
        plan, torques, pushes = plan._replace(motor=np.vstack([plan.motor, units])), (*torques, *pushes), ()
    return RopeRun(
        machine=machine,
        scheme=scheme,
        recording=recording,
        grid=grid,
        torques=torques,
        holding=np.append(offsets, np.zeros(len(pushed))),
        channels=channels_of(mesh.shown, mesh.driven, mesh.pieces, pushed, points),
        settings=settings,
        plan=plan,
        mesh=mesh,
        laws=laws,
        rest=rest,
        forces=pushes,
        start=new_state(plan, x, x_t, q, q_t),
    )


ORDER_AT_LEAST, ORDER_AT_MOST = 0.5, 2.0
STILL = 1e-14
"""Size up to which a motion is rounding [m], [rad]."""


def estimated_errors(case: RopeRun, outcome: Outcome, columns: dict[str, int]) -> dict[str, Any] | None:
    r"""Discretisation error of some columns of the records by Richardson's extrapolation, where asked for.

    With the differences :math:`D_1 = |x_n - x_{n/2}|` and :math:`D_2 = |x_{n/2} - x_{n/4}|`, largest over the
    records, the order seen is :math:`p = \log_2(D_2/D_1)`, and the error of :math:`x_n` about
    :math:`D_1/(2^p - 1)`. The order is taken as at most 2 and at least 1/2, below which the runs do not
    converge yet.

    Returns segments of the runs compared, and the estimates by the names in ``columns``, as plain data.
    """
    if case.coarser is None or outcome.stopped is not None:
        return None
    counts = tuple(case.scheme.segments // n for n in (1, 2, 4))
    coarser = [case.coarser(replace(case.scheme, segments=n, step=None)) for n in counts[1:]]
    runs = [outcome.rows, *(integrate_run(own, Records(own)).rows for own in coarser)]
    whole = min(len(run) for run in runs)
    found = {name: _estimate(*(run[:whole, k] for run in runs)) for name, k in columns.items()}
    return {"segments": list(counts), **found}


def _estimate(fine: Array, middle: Array, coarse: Array) -> dict[str, float | None]:
    """Largest error estimated, the same over the largest size; the order seen, where differences fall."""
    first = float(np.max(np.abs(fine - middle), initial=0.0))
    second = float(np.max(np.abs(middle - coarse), initial=0.0))
    size = float(np.max(np.abs(fine), initial=0.0))
    seen = log2(second / first) if first > 0.0 and second > 0.0 else None
    order = min(max(seen or ORDER_AT_LEAST, ORDER_AT_LEAST), ORDER_AT_MOST)
    error = first / (2.0**order - 1.0)
    converges = seen is not None and seen > ORDER_AT_LEAST
    relative = error / size if size > STILL else 0.0
    return {"error": error, "relative": relative, "order": seen if converges else None}
