"""Everything that is decided before the first step of a run of a network."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from hashlib import sha256
from typing import Any

import numpy as np

from cabledrive.mechanics.cable_law import Array, CableLaw
from cabledrive.mechanics.cable_laws import cable_law, taut_law
from cabledrive.mechanics.network import Network, network_of
from cabledrive.parameters.cable import Cable
from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.fields import described, meaning
from cabledrive.parameters.route import RoutedDrive
from cabledrive.simulation.channels import Channel
from cabledrive.simulation.methods import TimeGrid, check_resolved, time_grid
from cabledrive.simulation.network.mesh import NetworkMesh, network_mesh, wraps_of
from cabledrive.simulation.network.plan import (
    EVENTS,
    MOST_EVENTS,
    STEPS,
    NetworkPlan,
    NetworkState,
    NetworkWorkspace,
    network_plan,
    new_network_state,
    new_network_workspace,
)
from cabledrive.simulation.plan import SLACK
from cabledrive.simulation.prepared import PreparedRun
from cabledrive.simulation.signals import Function, Signal, check_lasts, signal_of
from cabledrive.simulation.start import PLANES, Pluck, Recording, Scheme, named_shape


@described
@dataclass(frozen=True, kw_only=True, eq=False)
class NetworkStart:
    """Where a machine with routes is at t = 0."""

    plucks: tuple[Pluck, ...] = meaning("displacements of spans, called by their names; planes u, v, w", ())
    places: Mapping[str, float] = meaning(
        'coordinates such as "head.x" or a pulley, from rest [m], [rad]; ropes follow linearly', factory=dict
    )
    speeds: Mapping[str, float] = meaning("the same of their speeds [m/s], [rad/s]", factory=dict)


def placed(
    mesh: NetworkMesh, given: Mapping[str, float], what: str, plucks: tuple[Pluck, ...]
) -> tuple[Array, Array]:
    """Displacements or velocities of nodes and coordinates; ropes follow their ends linearly."""
    q, x = np.zeros(len(mesh.names)), np.zeros((3, mesh.size))
    for name, value in given.items():
        if name not in mesh.names:
            raise InputRefused(f'start: {what} of "{str(name)[:60]}": take one of {", ".join(mesh.names)}')
        if not np.isfinite(value):
            raise InputRefused(f"start: {what} of {name} = {value} must be finite")
        q[mesh.names.index(name)] = value
    for k, (first, last) in enumerate(mesh.nodes):
        share = mesh.position(k) / mesh.length[k]
        ends = [mesh.ends[k, side] @ q for side in range(2)]
        x[:, first : last + 1] = ends[0][:, None] + (ends[1] - ends[0])[:, None] * share
    for pluck in plucks:
        if pluck.span not in mesh.pieces:
            raise InputRefused(f'pluck: "{pluck.span[:60]}" is no span: take one of {"; ".join(mesh.pieces)}')
        k = mesh.pieces.index(pluck.span)
        first, last = mesh.nodes[k]
        x[PLANES.index(pluck.plane), first : last + 1] += _shape(pluck, mesh.position(k))
    return x, q


def _shape(pluck: Pluck, x: Array) -> Array:
    """Profile of a pluck along one piece, zero at its ends."""
    if not abs(pluck.height) < x[-1]:
        raise InputRefused(f"pluck: {pluck.height:.6g} m is longer than its span of {x[-1]:.6g} m: lower it")
    if isinstance(pluck.shape, str):
        return pluck.height * named_shape(pluck.shape, x, 0.0, pluck.place * x[-1], x[-1])
    values = pluck.shape(x) if callable(pluck.shape) else pluck.shape
    profile = np.asarray(values, dtype=np.float64)
    if not callable(pluck.shape):
        profile = np.interp(x / x[-1], np.linspace(0.0, 1.0, profile.size), profile)
    profile = pluck.height * profile
    if profile.shape != x.shape or not np.isfinite(profile).all() or abs(profile[[0, -1]]).max() > 1e-12:
        raise InputRefused("pluck: the profile must be finite, and zero at both ends of its span")
    return np.asarray(profile)


def channels_of(mesh: NetworkMesh, motors: tuple[str, ...]) -> tuple[Channel, ...]:
    """Columns of a record, in order."""
    units = ["m" if slides(name) else "rad" for name in mesh.names]
    found = [Channel(name, unit, f"place of {name}") for name, unit in zip(mesh.names, units, strict=True)]
    found += [
        Channel(f"speed of {name}", f"{unit}/s", f"speed of {name}")
        for name, unit in zip(mesh.names, units, strict=True)
    ]
    found += [Channel(f"torque on {name}", "N m", f"torque of the motor of {name}") for name in motors]
    found += [Channel(f"mean tension, {one}", "N", f"tension of {one}, mean along it") for one in mesh.pieces]
    found += [Channel(f"least tension, {one}", "N", f"least tension of {one}") for one in mesh.pieces]
    found += [
        Channel(f"{plane} at the middle of {one}", "m", f"displacement {plane} at the middle of {one}")
        for one in mesh.pieces
        for plane in PLANES
    ]
    return (
        *found,
        Channel("rope_energy", "J", "kinetic energy of the ropes"),
        Channel("body_energy", "J", "kinetic energy of bodies, pulleys and motors"),
        Channel("strain_energy", "J", "elastic energy of the ropes above that at rest"),
        Channel("spring_energy", "J", "energy of springs and of turning bodies above that at rest"),
        Channel("torque_work", "J", "work of the torques since the start"),
        Channel("transverse_loss", "J", "energy lost to transverse damping since the start"),
        Channel("axial_loss", "J", "energy lost to axial damping of the ropes since the start"),
        Channel("viscous_loss", "J", "energy lost to bearings, bodies and joints since the start"),
        Channel("coulomb_loss", "J", "energy lost to Coulomb friction and slipping ropes since the start"),
        Channel(
            "balance", "J", "energy of the method, plus losses, minus work: constant if the budget closes"
        ),
    )


def slides(name: str) -> bool:
    """Whether a coordinate is a length."""
    return name.endswith((".x", ".y", " along", " across", " out of plane")) or name.startswith("slip at ")


@dataclass(frozen=True, kw_only=True, eq=False)
class NetworkCase(PreparedRun):
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
    def machine(self) -> RoutedDrive:
        """The drive of the run."""
        return self.network.drive

    @property
    def nodes(self) -> int:
        """Nodes of all pieces."""
        return self.mesh.size

    @property
    def law_name(self) -> str:
        """Name of the cable law."""
        return taut_law(self.laws[0]).name

    @property
    def settings(self) -> dict[str, Any]:
        """Torques and start."""
        start = b"".join(array.tobytes() for array in (self.x, self.x_t, self.q, self.q_t))
        return {
            "torque": [signal.fingerprint for signal in self.torques],
            "start": sha256(start).hexdigest(),
        }

    @cached_property
    def work(self) -> NetworkWorkspace:
        """Work space of the steps."""
        return new_network_workspace(self.plan)

    def integrate(
        self, state: NetworkState, inputs: list[Array], every: int, rows: Array, fields: Array
    ) -> int:
        """Take the steps, the first of every ``every`` recorded; why they end."""
        from cabledrive.simulation.network.kernels import integrate_network

        return int(integrate_network(self.plan, state, self.work, inputs[0], every, rows))

    def why(self, code: int, state: NetworkState, before: NetworkState, inputs: tuple[Array, ...]) -> str:
        """Why steps ended early, in one line."""
        if code != SLACK:
            return f"diverged at t = {state.counts[STEPS] * self.grid.step:.6g} s: lower the input"
        step, piece, tension = state.events[min(int(state.counts[EVENTS]), MOST_EVENTS) - 1]
        return (
            f"span {self.mesh.pieces[int(piece)]} goes slack at t = {step * self.grid.step:.6g} s "
            f"({tension:.3g} N): raise pretension, lower the input or allow slack"
        )

    def inputs(self, first: int, steps: int) -> tuple[Array]:
        """Torques at the times of some steps, shape (steps, motors) [N m]."""
        time = np.arange(first, first + steps, dtype=np.float64) * self.grid.step
        columns = [signal.at(time) for signal in self.torques]
        return (np.stack(columns, axis=1) if columns else np.zeros((steps, 0)),)

    def first_state(self) -> NetworkState:
        """State before the first step: velocities half a step before the start."""
        node, body = forces_of(self.mesh, self.laws, self.x, self.q, self.inputs(0, 1)[0][0])
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
    """Check and prepare a run; arguments as of `simulate`."""
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
    x, q = placed(mesh, start.places, "places", start.plucks)
    x_t, q_t = placed(mesh, start.speeds, "speeds", ())
    return NetworkCase(
        network=network,
        scheme=scheme,
        recording=recording,
        mesh=mesh,
        laws=laws,
        grid=grid,
        plan=network_plan(network, wraps, mesh, laws, step=grid.step, stop_when_slack=scheme.slack == "stop"),
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
