"""Everything that is decided before the first step of a run of a network."""

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from cabledrive.mechanics.cable_law import Array, CableLaw
from cabledrive.mechanics.cable_laws import cable_law
from cabledrive.mechanics.network import Network, network_of
from cabledrive.mechanics.sources import digest_with_imports
from cabledrive.mechanics.tension_only import taut_law
from cabledrive.parameters.cable import Cable
from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.hashing import content_hash
from cabledrive.parameters.route import RoutedDrive
from cabledrive.parameters.version import __version__
from cabledrive.simulation.case import Recording
from cabledrive.simulation.channels import Channel
from cabledrive.simulation.network.channels import channels_of
from cabledrive.simulation.network.mesh import NetworkMesh, network_mesh
from cabledrive.simulation.network.plan import NetworkPlan, network_plan
from cabledrive.simulation.network.rubbing import rubbing_of
from cabledrive.simulation.network.start import NetworkStart, placed
from cabledrive.simulation.network.state import NetworkState, new_network_state
from cabledrive.simulation.network.wraps import wraps_of
from cabledrive.simulation.scheme import Scheme
from cabledrive.simulation.signals import Function, Signal, check_lasts, signal_of
from cabledrive.simulation.step_size import TimeGrid, check_resolved, time_grid

if TYPE_CHECKING:
    from cabledrive.simulation.network.stepper import NetworkStepper


@dataclass(frozen=True, kw_only=True, eq=False)
class NetworkCase:
    """A run that has not begun."""

    network: Network
    scheme: Scheme
    recording: Recording
    mesh: NetworkMesh
    laws: list[CableLaw]  # of each piece
    grid: TimeGrid
    plan: NetworkPlan
    torques: tuple[Signal, ...]  # of each motor, beyond what holds the machine at rest
    x: Array  # (3, nodes)
    x_t: Array  # (3, nodes)
    q: Array  # (n,): at t = 0, as all four
    q_t: Array  # (n,)

    @cached_property
    def channels(self) -> tuple[Channel, ...]:
        """Columns of a record."""
        return channels_of(self.mesh, self.mesh.driven)

    @property
    def width(self) -> int:
        """Numbers per record."""
        return len(self.channels)

    @property
    def nodes(self) -> int:
        """Nodes of all pieces."""
        return self.mesh.size

    @property
    def field_records(self) -> int:
        """Whole fields that are kept: none of a network."""
        return 0

    @cached_property
    def fingerprint(self) -> dict[str, Any]:
        """What a resumed run must have in common with the interrupted one; plain data."""
        start = b"".join(array.tobytes() for array in (self.x, self.x_t, self.q, self.q_t))
        content = {
            "cabledrive": __version__,
            "drive_hash": content_hash(self.network.drive),
            "scheme": asdict(replace(self.scheme, model=taut_law(self.laws[0]).name)),
            "recording": asdict(self.recording),
            "grid": asdict(self.grid),
            "torque": [signal.fingerprint for signal in self.torques],
            "start": sha256(start).hexdigest(),
            "sources": digest_with_imports(Path(__file__)),
        }
        plain: dict[str, Any] = json.loads(json.dumps(content))
        return plain

    def stepper(self) -> "NetworkStepper":
        """What takes the steps."""
        from cabledrive.simulation.network.stepper import NetworkStepper

        return NetworkStepper(self)

    def torque(self, first: int, steps: int) -> Array:
        """Torques at the times of some steps, shape (steps, motors) [N m]."""
        time = np.arange(first, first + steps, dtype=np.float64) * self.grid.step
        columns = [signal.at(time) for signal in self.torques]
        return np.stack(columns, axis=1) if columns else np.zeros((steps, 0))

    def first_state(self) -> NetworkState:
        """State before the first step: velocities half a step before the start."""
        node, body = forces_of(self.mesh, self.laws, self.x, self.q, self.torque(0, 1)[0])
        half = 0.5 * self.grid.step
        mass = np.repeat(
            self.mesh.density * self.mesh.spacing, self.mesh.nodes[:, 1] - self.mesh.nodes[:, 0] + 1
        )
        x_t = self.x_t - half * node / mass
        q_t = self.q_t - half * np.linalg.solve(self.mesh.mass, body - self.mesh.damping @ self.q_t)
        put_ends(self.mesh, q_t, x_t)
        return new_network_state(self.plan, self.x, x_t, self.q, q_t)


def forces_of(
    mesh: NetworkMesh, laws: list[CableLaw], x: Array, q: Array, torque: Array
) -> tuple[Array, Array]:
    """Forces of one rope on its nodes, zero at ends, shape (3, nodes), and on the coordinates, shape (n,)."""
    node, body = np.zeros_like(x), mesh.motor.T @ torque - mesh.stiffness @ q
    for k, ((first, last), law) in enumerate(zip(mesh.nodes, laws, strict=True)):
        p = np.stack(law.excess_components(*(np.diff(x[:, first : last + 1], axis=1) / mesh.spacing[k])))
        node[:, first + 1 : last] = np.diff(p, axis=1)
        body += mesh.ropes[k] * (p[:, 0] @ mesh.ends[k, 0] - p[:, -1] @ mesh.ends[k, 1])
    return node, body


def put_ends(mesh: NetworkMesh, q: Array, x: Array) -> None:
    """Ends of all pieces where the coordinates put them, into x."""
    for k, nodes in enumerate(mesh.nodes):
        x[:, nodes] = np.stack([mesh.ends[k, side] @ q for side in range(2)], axis=1)


def network_case(
    drive: RoutedDrive,
    duration: float,
    *,
    torque: Mapping[str, Signal | float | Function] | Signal | float | Function = 0.0,
    start: NetworkStart | None = None,
    scheme: Scheme | None = None,
    recording: Recording | None = None,
) -> NetworkCase:
    """Check and prepare a run; arguments as of `simulate_network`."""
    start, scheme, recording = start or NetworkStart(), scheme or Scheme(), recording or Recording()
    _check(drive, scheme, recording)
    network = network_of(drive)
    wraps = wraps_of(network)
    mesh = network_mesh(network, wraps, scheme.segments)
    slack = scheme.slack == "tension-only"
    laws = [
        cable_law(_cable(t, ea), scheme.model, tension_only=slack)
        for t, ea in zip(mesh.tension, mesh.rigidity, strict=True)
    ]
    largest = largest_network_step(mesh, laws)
    grid = time_grid(
        duration, largest, step=scheme.step, cfl=scheme.cfl, rate=recording.rate, nodes=mesh.size
    )
    torques = motor_torques(mesh.driven, torque, duration)
    for signal in torques:
        check_resolved(signal, grid.step)
    rubbing = rubbing_of(network, wraps, mesh.tension)
    x, q = placed(mesh, start.places, "places", start.plucks)
    x_t, q_t = placed(mesh, start.speeds, "speeds", ())
    return NetworkCase(
        network=network,
        scheme=scheme,
        recording=recording,
        mesh=mesh,
        laws=laws,
        grid=grid,
        plan=network_plan(mesh, laws, rubbing, step=grid.step, stop_when_slack=scheme.slack == "stop"),
        torques=torques,
        x=x,
        x_t=x_t,
        q=q,
        q_t=q_t,
    )


def _cable(tension: float, rigidity: float) -> Cable:
    """Tension and rigidity, as laws take them."""
    return Cable(given_rigidity=float(rigidity), mass_per_length=1.0, pretension=float(tension))


def largest_network_step(mesh: NetworkMesh, laws: list[CableLaw]) -> float:
    r"""Largest stable step [s], :math:`2/\sqrt{\omega_r^2 + \omega_s^2}`.

    A segment with half its mass at each end vibrates at most with :math:`\omega_r = 2c/h`, which bounds every
    assembly of segments; springs and turning bodies add at most their own :math:`\omega_s` on the masses.
    """
    from scipy.linalg import eigh

    stiffness = np.array([law.largest_stiffness() for law in laws])
    ropes = 4.0 * np.max(stiffness / mesh.density / mesh.spacing**2)
    springs = (
        max(float(eigh(mesh.stiffness, mesh.mass, eigvals_only=True)[-1]), 0.0) if len(mesh.mass) else 0.0
    )
    share = 0.25 if laws[0].tension_only else 1.0
    return float(share * 2.0 / np.sqrt(ropes + springs))


def _check(drive: RoutedDrive, scheme: Scheme, recording: Recording) -> None:
    route = 'kind = "route": '
    if scheme.method != "verlet":
        raise InputRefused(f'{route}method = "{scheme.method}" is for loops and lines: take "verlet"')
    if scheme.friction != "stick-slip":
        raise InputRefused(f"{route}friction is set-valued on routes: leave smoothed friction out")
    if recording.fields or recording.probes:
        raise InputRefused(f"{route}whole fields and probes are not kept of routes: leave them out")
    for data, rope in zip(drive.route, drive.ropes, strict=True):
        if data.speed:
            raise InputRefused(f'{route}route "{data.name}" runs (speed); only ropes at rest are simulated')
        if rope.axial_damping and scheme.slack == "tension-only":
            raise InputRefused(
                f'{route}a rope that goes slack with axial_damping (route "{data.name}") is not simulated: '
                "set axial_damping to 0, or leave --tension-only out"
            )
    if any(motor.backlash for motor in drive.motor):
        raise InputRefused(f"{route}motor.backlash is not simulated on routes: set it to 0")


def motor_torques(
    names: tuple[str, ...],
    torque: Mapping[str, Signal | float | Function] | Signal | float | Function,
    duration: float,
) -> tuple[Signal, ...]:
    """Torque of each motor by the name of its pulley; one torque is that of the first."""
    given = torque if isinstance(torque, Mapping) else ({names[0]: torque} if names else {})
    if not names and not isinstance(torque, Mapping) and torque != 0.0:
        raise InputRefused('kind = "route": there is no [[pulley]] on which a torque could act: add one')
    for name in given:
        if name not in names:
            raise InputRefused(f'torque on "{str(name)[:60]}": the motors are {", ".join(names) or "none"}')
    signals = tuple(signal_of(given.get(name, 0.0), f"torque on {name}") for name in names)
    for signal, name in zip(signals, names, strict=True):
        check_lasts(signal, duration, f"torque on {name}")
    return signals
