"""Everything that is decided before the first step of a run."""

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from hashlib import sha256
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from cabledrive.mechanics.cable_law import Array, CableLaw
from cabledrive.mechanics.cable_laws import cable_law
from cabledrive.mechanics.compiled import why_plain
from cabledrive.mechanics.mesh import Mesh, mesh_of
from cabledrive.mechanics.sources import digest_with_imports
from cabledrive.mechanics.tension_only import taut_law
from cabledrive.parameters.drive import Drive
from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.hashing import content_hash
from cabledrive.parameters.version import __version__
from cabledrive.simulation.channels import WIDTH
from cabledrive.simulation.methods import Method, method_named
from cabledrive.simulation.own_law import law_fingerprint, why_interpreted
from cabledrive.simulation.plan import OWN, Plan, State, half_step_before, new_state, plan_of
from cabledrive.simulation.scheme import Scheme
from cabledrive.simulation.signals import Function, Signal, check_lasts, signal_of
from cabledrive.simulation.start import (
    PLANES,
    Start,
    place_at_start,
    velocity_at_start,
)
from cabledrive.simulation.step_size import TimeGrid, check_resolved, largest_stable_step, time_grid

if TYPE_CHECKING:
    from cabledrive.simulation.loop_steps import LoopStepper


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
        from cabledrive.simulation.loop_steps import LoopStepper

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
