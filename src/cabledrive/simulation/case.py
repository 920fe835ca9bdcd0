"""Everything that is decided before the first step of a run, and its steps chunk by chunk."""

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from hashlib import sha256
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np

from cabledrive.mechanics.cable_law import Array, CableLaw
from cabledrive.mechanics.cable_laws import cable_law, taut_law
from cabledrive.mechanics.compiled import why_plain
from cabledrive.mechanics.mesh import Mesh, mesh_of
from cabledrive.mechanics.sources import digest_with_imports
from cabledrive.parameters.drive import Drive
from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.schema import content_hash
from cabledrive.parameters.version import __version__
from cabledrive.simulation.channels import WIDTH
from cabledrive.simulation.methods import (
    Method,
    TimeGrid,
    check_resolved,
    largest_stable_step,
    method_named,
    time_grid,
)
from cabledrive.simulation.own_law import law_fingerprint, stiffness_over_limit, why_interpreted
from cabledrive.simulation.plan import (
    DONE,
    OWN,
    SLACK,
    STEPS,
    TOO_STIFF,
    Plan,
    State,
    Workspace,
    copy_state,
    half_step_before,
    new_state,
    new_workspace,
    plan_of,
    set_state,
)
from cabledrive.simulation.signals import Function, Signal, check_lasts, signal_of
from cabledrive.simulation.start import PLANES, Scheme, Start, place_at_start, velocity_at_start


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CarriageForce:
    """A force on a carriage.

    Attributes
    ----------
    signal : Signal, float or callable
        The force [N].
    carriage : int, default 0
        Which carriage, in the order of the drive file.
    plane : {"u", "v", "w"}, default "u"
        Along the span, or across it.
    """

    signal: Signal | float | Function
    carriage: int = 0
    plane: str = "u"


@dataclass(frozen=True, slots=True, kw_only=True)
class Recording:
    """What is kept of a run.

    Attributes
    ----------
    rate : float, default 10000.0
        Least number of records per second [Hz].
    probes : tuple of (str, float)
        Points to record beside the midpoints: span, and distance from its start along the pretensioned cable
        [m].
    fields : int, default 0
        Keep the displacements of all nodes at every so many records; 0: not at all.
    """

    rate: float = 10_000.0
    probes: tuple[tuple[str, float], ...] = ()
    fields: int = 0

    def __post_init__(self) -> None:
        if isinstance(self.fields, bool) or not isinstance(self.fields, int) or self.fields < 0:
            raise InputRefused(f"fields = {self.fields!r} must be a whole number of records, or 0: give one")


@dataclass(frozen=True, kw_only=True, eq=False)
class Case:
    """A run that has not begun."""

    drive: Drive
    scheme: Scheme
    recording: Recording
    mesh: Mesh
    law: CableLaw
    grid: TimeGrid
    plan: Plan
    method: Method
    torque: Signal  # torque, without the motor's constant offset
    offset: float  # the motor's offset torque [N m]
    forces: tuple[Signal, ...]
    displacement: Array  # (3, nodes): at t = 0 [m]
    rotor: float
    velocity: Array  # (3, nodes): at t = 0 [m/s]

    @property
    def width(self) -> int:
        """Numbers per record."""
        return WIDTH + 3 * self.plan.probe.shape[0]

    @property
    def nodes(self) -> int:
        """Nodes of the cable."""
        return self.mesh.nodes

    @property
    def field_records(self) -> int:
        """Whole fields that are kept."""
        return 0 if self.recording.fields == 0 else self.grid.records // self.recording.fields + 1

    @property
    def law_name(self) -> str:
        """Name of the cable law."""
        return taut_law(self.law).name

    @cached_property
    def interpreted(self) -> str | None:
        """Why the steps are not compiled, in one line; None if they are."""
        if self.plan.law == OWN:
            return why_interpreted(self.plan, self.law)
        return why_plain()

    @cached_property
    def fingerprint(self) -> dict[str, Any]:
        """What a resumed run must have in common with the interrupted one; plain data."""
        start = sha256(self.displacement.tobytes() + self.velocity.tobytes()).hexdigest()
        content = {
            "cabledrive": __version__,
            "drive_hash": content_hash(self.drive),
            "scheme": asdict(replace(self.scheme, model=self.law_name)),
            "law": law_fingerprint(self.law),
            "recording": asdict(self.recording),
            "grid": asdict(self.grid),
            "torque": self.torque.fingerprint,
            "forces": [signal.fingerprint for signal in self.forces],
            "force_places": self.plan.force.tolist(),
            "start": start,
            "sources": digest_with_imports(Path(__file__)),
        }
        plain: dict[str, Any] = json.loads(json.dumps(content))
        return plain

    def inputs(self, first_step: int, steps: int) -> tuple[Array, Array]:
        """Torque, (steps,), with the motor's offset [N m], and forces, (steps, forces) [N], of some steps."""
        time: Array = np.arange(first_step, first_step + steps, dtype=np.float64) * self.grid.step
        forces = np.zeros((steps, len(self.forces)))
        for number, signal in enumerate(self.forces):
            forces[:, number] = signal.at(time)
        return self.torque.at(time) + self.offset, forces

    def first_state(self) -> State:
        """State before the first step."""
        rotor, speed = self.rotor, float(self.velocity[0, 0])
        torque, forces = self.inputs(0, 1)
        before, motor_speed = half_step_before(
            self.plan, self.displacement, self.velocity, (rotor, speed), float(torque[0]), forces[0], self.law
        )
        state = new_state(self.displacement, before, (rotor, motor_speed))
        return state._replace(extra=self.method.extra(self.plan, state))

    def stepper(self) -> "LoopStepper":
        """What takes the steps."""
        return LoopStepper(self)


def case_of(
    drive: Drive,
    duration: float,
    *,
    torque: Signal | float | Function = 0.0,
    forces: Sequence[CarriageForce] = (),
    start: Start | None = None,
    scheme: Scheme | None = None,
    recording: Recording | None = None,
) -> Case:
    """Check and prepare a run of some duration [s]; what cannot be run is refused.

    ``torque``: of the motor, on the drive pulley where there is none [N m].
    """
    start, scheme, recording = start or Start(), scheme or Scheme(), recording or Recording()
    mesh = mesh_of(drive, scheme.segments)
    law = cable_law(drive.cable, scheme.model, tension_only=scheme.slack == "tension-only")
    method = replace(method_named(scheme.method), law=law)
    largest = largest_stable_step(mesh, law)
    grid = time_grid(
        duration, largest, step=scheme.step, cfl=scheme.cfl, rate=recording.rate, nodes=mesh.nodes
    )
    signal = signal_of(torque, "torque")
    check_lasts(signal, duration, "torque")
    check_resolved(signal, grid.step)
    pushes = tuple(signal_of(force.signal, f"force on carriage {force.carriage}") for force in forces)
    for force, push in zip(forces, pushes, strict=True):
        check_lasts(push, duration, f"force on carriage {force.carriage}")
    plan = plan_of(
        mesh,
        law,
        step=grid.step,
        transverse_damping=drive.cable.transverse_damping,
        axial_damping=drive.cable.axial_damping,
        smoothing_speed=scheme.smoothing_speed if scheme.friction == "smoothed" else 0.0,
        stop_when_slack=scheme.slack == "stop",
        probes=_checked_probes(mesh, recording),
        forces=tuple(_place(drive, mesh, force) for force in forces),
    )
    method.check(plan)
    displacement, rotor = place_at_start(mesh, law, start)
    return Case(
        drive=drive,
        scheme=scheme,
        recording=recording,
        mesh=mesh,
        law=law,
        grid=grid,
        plan=plan,
        method=method,
        torque=signal,
        offset=drive.motor.offset_torque if drive.motor else 0.0,
        forces=pushes,
        displacement=displacement,
        rotor=rotor,
        velocity=velocity_at_start(mesh, start),
    )


def _place(drive: Drive, mesh: Mesh, force: CarriageForce) -> tuple[int, int]:
    """Node and axis of a force."""
    count = len(drive.carriage)
    if not 0 <= force.carriage < count:
        raise InputRefused(f"force on carriage {force.carriage}, but the drive has {count}, numbered from 0")
    if force.plane not in PLANES:
        raise InputRefused(f'force: plane = "{force.plane}" is not one of its values: write u, v or w')
    if force.plane != "u" and drive.carriage[force.carriage].guided:
        raise InputRefused(
            f"force along {force.plane} on carriage {force.carriage}, which is guided: push along u"
        )
    return int(mesh.carriage_node[force.carriage]), PLANES.index(force.plane)


def _checked_probes(mesh: Mesh, recording: Recording) -> tuple[tuple[str, float], ...]:
    for span, place in recording.probes:
        if span not in mesh.spans:
            raise InputRefused(f"probe: there is no {span} span: write {' or '.join(mesh.spans)}")
        length = float(mesh.position[0, -1])
        if not (isfinite(place) and 0.0 <= place <= length):
            raise InputRefused(
                f"probe at {place} m of the {span} span, which is {length:.6g} m long: move it"
            )
    return recording.probes


class LoopStepper:
    """Takes the steps of a loop or a line; see `cabledrive.simulation.records`."""

    def __init__(self, case: Case) -> None:
        self.case = case
        self._work = new_workspace(case.plan)

    def chunk(self, state: State, done: int, count: int) -> tuple[Array, Array, str | None]:
        """Steps of some records; returns what was recorded and why it is less than asked for, if so."""
        case, work = self.case, self._work
        every, steps = case.grid.every, count * case.grid.every
        rows = np.zeros((count, case.width))
        fields = np.zeros((count if case.recording.fields else 0, 3, case.mesh.nodes))
        before = copy_state(state)
        torque, forces = case.inputs(done * every, steps)
        bad = np.flatnonzero(~(np.isfinite(torque) & np.isfinite(forces).all(axis=1)))
        if bad.size:
            steps = int(bad[0])
        code = case.method.integrate(
            case.plan, state, work, torque[:steps], forces[:steps], every, rows, fields
        )
        taken = int(state.counts[STEPS]) - done * every
        whole = -(-taken // every)
        stopped = None
        if code == SLACK:
            stopped = slack_line(case, state)
        elif code == TOO_STIFF:
            stopped = _too_stiff_line(case, state)
        elif code != DONE:
            whole -= 1
            set_state(state, before)
            stopped = _not_finite_line(case, state, work, torque, forces)
        elif bad.size:
            stopped = (
                f"the torque or a force is not finite at t = {(done * every + steps) * case.grid.step:.6g} s"
            )
        if case.recording.fields:
            fields = fields[:whole][-done % case.recording.fields :: case.recording.fields]
        return rows[:whole], fields, stopped

    def last(self, state: State) -> tuple[Array, Array, str | None]:
        """The record at the end of the run, of a step beyond it that is taken back but for the extremes."""
        case, work, stopped = self.case, self._work, None
        beyond = copy_state(state)
        rows = np.zeros((1, case.width))
        keeps_field = case.recording.fields and case.grid.records % case.recording.fields == 0
        fields = np.zeros((1 if keeps_field else 0, 3, case.mesh.nodes))
        torque, forces = case.inputs(case.grid.steps, 1)
        code = case.method.integrate(case.plan, beyond, work, torque, forces, 1, rows, fields)
        for mine, theirs in ((state.extremes, beyond.extremes), (state.events, beyond.events)):
            mine[...] = theirs
        state.counts[1:] = beyond.counts[1:]
        if code == SLACK:
            stopped = slack_line(case, state)
        elif code == TOO_STIFF:
            stopped = _too_stiff_line(case, state)
        elif code != DONE:
            stopped = _not_finite_line(case, state, work, torque, forces)
        return rows, fields, stopped


def slack_line(case: Case, state: State) -> str:
    """One line about the span that went slack last."""
    step, span, segment, tension = state.events[min(int(state.counts[1]), len(state.events)) - 1]
    place = case.mesh.position[int(span), int(segment) : int(segment) + 2].mean()
    return (
        f"the {case.mesh.spans[int(span)]} span goes slack at t = {step * case.grid.step:.6g} s, "
        f"x = {place:.4g} m ({tension:.3g} N): raise cable.pretension, lower the input or allow slack"
    )


def _too_stiff_line(case: Case, state: State) -> str:
    """One line about the segment that is too stiff for the step."""
    over = stiffness_over_limit(case.plan, case.law, state.x)
    span, segment = divmod(int(np.argmax(over)), case.mesh.segments)
    return (
        f"the law {case.law_name} is too stiff for the step of {case.grid.step:.4g} s at "
        f"t = {state.counts[STEPS] * case.grid.step:.6g} s in the {case.mesh.spans[span]} span at "
        f"{case.mesh.position[span, segment]:.4g} m: give a step of at most "
        f"{case.grid.step / np.sqrt(over.max()):.4g} s"
    )


def _not_finite_line(case: Case, state: State, work: Workspace, torque: Array, forces: Array) -> str:
    """Repeat the chunk step by step up to the first energy that is not finite."""
    rows, no_fields = np.zeros((1, case.width)), np.zeros((0, 3, case.mesh.nodes))
    for j in range(torque.size):
        inputs = torque[j : j + 1], forces[j : j + 1]
        if case.method.integrate(case.plan, state, work, *inputs, 1, rows, no_fields) != DONE:
            break
    size = np.max(np.abs(state.x), axis=0)
    farthest = int(np.argmax(np.where(np.isfinite(size), size, np.inf)))
    span, segment = divmod(min(farthest, case.mesh.spacing.size - 1), case.mesh.segments)
    time_there = state.counts[STEPS] * case.grid.step
    return (
        f"diverged: the energy is not finite from t = {time_there:.6g} s on, the motion largest in the "
        f"{case.mesh.spans[span]} span at {case.mesh.position[span, segment]:.4g} m: lower cfl or the input"
    )
