"""Everything that is decided before the first step of a run of a network."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.network.statics import unheld_words
from cabledrive.modal.ranges import ALLOWED, sag_words
from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.route import RoutedDrive
from cabledrive.simulation.channels import (
    AXIAL_LOSS,
    COULOMB_LOSS,
    JOINT_LOSS,
    TALLIES,
    TORQUE_WORK,
    TRANSVERSE_LOSS,
    VISCOUS_LOSS,
    Channel,
    displacements,
)
from cabledrive.simulation.error_estimate import estimated_errors
from cabledrive.simulation.network.mesh import passed_words
from cabledrive.simulation.prepared import Outcome, PreparedRun, RopeRun
from cabledrive.simulation.result import SimulationResult, neglected
from cabledrive.simulation.signals import Function, Signal, checked_signal
from cabledrive.simulation.start import OF_LOOPS, Recording, Scheme, Start


def routed_channels(
    names: tuple[str, ...],
    motors: tuple[str, ...],
    spans: tuple[str, ...],
    pushed: Sequence[str] = (),
    points: Sequence[str] = (),
    travels: bool = False,
) -> tuple[Channel, ...]:
    """Columns of a record; coordinates with forces, points of spans, whether lengths follow the bodies."""
    pose, damped = (" from the pose of the file", " with its damping") if travels else ("", "")
    both = [(name, "m" if slides(name) else "rad") for name in names]
    found = [Channel(name, unit, f"place of {name}{pose}") for name, unit in both]
    found += [Channel(f"speed of {name}", f"{unit}/s", f"speed of {name}") for name, unit in both]
    found += [Channel(f"torque on {name}", "N m", f"torque of the motor of {name}") for name in motors]
    found += [Channel(f"force on {name}", "N", f"force on {name}") for name in pushed]
    mean = [(one, f"tension of {one}{damped}, mean along it") for one in spans]
    found += [Channel(f"mean tension, {one}", "N", words) for one, words in mean]
    found += [Channel(f"least tension, {one}", "N", f"least tension of {one}{damped}") for one in spans]
    if travels:
        found += [Channel(f"free length, {one}", "m", f"free length of {one}") for one in spans]
    found += displacements(points)
    energies = _TRAVELLING if travels else _STANDING
    return (*found, *(Channel(name, "J", words) for name, words in energies))


_SINCE = "since the start"
_STANDING = (
    ("rope_energy", "kinetic energy of the ropes"),
    ("body_energy", "kinetic energy of bodies, pulleys and motors"),
    ("strain_energy", "energy of the ropes above that at rest, elastic and of their weight"),
    ("spring_energy", "energy of springs and of turning bodies above that at rest"),
    ("torque_work", f"work of the torques, and of forces on carriages, {_SINCE}"),
    ("transverse_loss", f"energy lost to transverse damping {_SINCE}"),
    ("axial_loss", f"energy lost to axial damping of the ropes {_SINCE}"),
    ("viscous_loss", f"energy lost to bearings, bodies and joints {_SINCE}"),
    ("coulomb_loss", f"energy lost to Coulomb friction and slipping ropes {_SINCE}"),
    ("balance", "energy of the method, plus losses, minus work: constant if the budget closes"),
)
_TRAVELLING = (
    ("rope_energy", "kinetic energy of the ropes in their spans"),
    ("body_energy", "kinetic energy of bodies, pulleys and motors, of drums with their rope"),
    ("strain_energy", "elastic energy of the ropes in their spans"),
    ("spring_energy", "energy of springs, weights and loads above that at rest"),
    ("torque_work", f"work of the torques {_SINCE}"),
    ("weight_work", f"work of the ropes' weight {_SINCE}"),
    ("axial_loss", f"energy lost to axial damping of the ropes {_SINCE}"),
    ("viscous_loss", f"energy lost to bearings, bodies and joints {_SINCE}"),
    ("coulomb_loss", f"energy lost to Coulomb friction {_SINCE}"),
    ("creep_loss", f"energy lost where rope creeps on pulleys, {_SINCE}"),
    ("wound_energy", f"energy that rope took onto rims and drums {_SINCE}"),
    ("balance", "energies plus losses minus works: constant if the budget closes"),
)


def slides(name: str) -> bool:
    """Whether a coordinate is a length."""
    return name.endswith((".x", ".y", " along", " across", " out of plane")) or name.startswith("slip at ")


@dataclass(frozen=True, kw_only=True, eq=False)
class NetworkCase(RopeRun):
    """A run of a machine with routes that has not begun; torques: beyond what holds it at rest."""

    def columns(self, found: Array) -> Array:
        """The columns of a machine with routes, from what the kernels record."""
        pieces, n = len(self.plan.nodes), len(self.mesh.names)
        edges = np.cumsum(
            [pieces, pieces, 2 * pieces, pieces, 3 * len(self.plan.probe), 1, 1, 1, TALLIES, 1, 2 * n]
        )
        parts = np.split(found, edges, axis=1)
        mean, least, ropes, strain, middle, weights, bodies, springs, *parts = parts
        tallies, balance, places, torque = parts
        # the constant forces that hold the ropes' ends at rest are theirs
        ends = -(places[:, :n] @ self.rest.given)[:, None]
        tallies[:, VISCOUS_LOSS] += tallies[:, JOINT_LOSS]
        lost = tallies[:, [TORQUE_WORK, TRANSVERSE_LOSS, AXIAL_LOSS, VISCOUS_LOSS, COULOMB_LOSS]]
        ropes, strain = (own.sum(axis=1, keepdims=True) for own in (ropes, strain))
        strain, springs = strain + weights + ends - self.rest.energy, springs - ends
        return np.hstack([places, torque, mean, least, middle, ropes, bodies, strain, springs, lost, balance])

    def result(self, outcome: Outcome) -> SimulationResult:
        """Result of the run, as far as it went."""
        mesh, state, rows = self.mesh, outcome.state, outcome.rows
        outcome = outcome._replace(fields=outcome.fields - self.rest.x)
        columns = {channel.name: k for k, channel in enumerate(self.channels)}
        energies = rows[:1, columns["rope_energy"] : columns["rope_energy"] + 4].sum() if len(rows) else 0.0
        work = float(np.max(rows[:, columns["torque_work"]], initial=0.0))
        # Turning a pulley passes rope on: only bodies count.
        quantities = [*mesh.names, *(f"w at the middle of {span}" for span in mesh.pieces)]
        bodies = [n for n, name in enumerate(mesh.names) if "." in name and not name.startswith("slip at ")]
        reach = np.abs(reached(state)).max(axis=0)
        along = np.einsum("kaxn,n->kax", np.abs(mesh.ends[:, :, [0, 2]][..., bodies]), reach[bodies])
        return SimulationResult(
            **common_of_routes(self, outcome, mesh.names),
            energy_handled=max(float(energies), 0.0) + work,
            error_estimate=estimated_errors(self, outcome, {name: columns[name] for name in quantities}),
            largest_motion=float((along.max(axis=(1, 2)) / mesh.length).max(initial=0.0)),
            assumptions=_ASSUMPTIONS + left_out(mesh.network.drive),
            doubts=(
                *unheld_words(mesh.network.motion, mesh.network.statics),
                *(sag_words(mesh.network, least=ALLOWED) if self.law_name == "linear" else ()),
                *passed_words(mesh, reach),
            ),
            provenance=self.provenance(
                {"motor": mesh.network.motion.motor}, torque=[signal.fingerprint for signal in self.torques]
            ),
        )


_ASSUMPTIONS = (
    "motion about the state of rest: wraps and directions of spans stay those at rest",
    "ropes hang, and leave their pulleys where they do at rest",
    "torque: beyond what holds the machine at rest",
)


def reached(state: Any) -> Array:
    """Least and largest place of each coordinate, (2, n); 0 where no step was taken."""
    return np.where(np.isfinite(state.extremes), state.extremes, 0.0)


def common_of_routes(case: PreparedRun, outcome: Outcome, names: tuple[str, ...]) -> dict[str, Any]:
    """What results of machines with routes hold alike; ``names``: of the coordinates."""
    extremes = reached(outcome.state).T.tolist()
    return case.common(outcome) | {"extremes": dict(zip(names, map(tuple, extremes), strict=True))}


def left_out(drive: RoutedDrive) -> tuple[str, ...]:
    """What the drive states and the run does not have."""
    names = [motor.pulley or "the first pulley" for motor in drive.motor if motor.offset_torque != 0.0]
    given = (f"motor.offset_torque of {', '.join(names)} is left out",) if names else ()
    return (*given, *neglected(drive.ropes, drive.motors))


def never_simulated(drive: RoutedDrive) -> list[tuple[Any, str]]:
    """What no run of a machine with routes has: whether it is there, and what to do."""
    running = next((data.name for data in drive.route if data.speed), "")
    return [
        (running, f'route "{running}" runs (speed), and only ropes at rest are simulated: set it to 0'),
        (any(own.backlash for own in drive.motor), "motor.backlash is not simulated on routes: set it to 0"),
    ]


def check_routes(drive: RoutedDrive, scheme: Scheme, recording: Recording, start: Start) -> None:
    """Refuse what no run of a machine with routes has."""
    for refused, why in (
        (
            scheme.friction == "smoothed"
            and any(own.coulomb_friction and own.pivot is None for own in drive.body),
            "friction of bodies that slide is set-valued: leave smoothed friction out",
        ),
        (
            any(getattr(start, name) for name in OF_LOOPS),
            'angles at the start are for loops and lines: give "places" and "speeds"',
        ),
        *never_simulated(drive),
    ):
        if refused:
            raise InputRefused(f'kind = "route": {why}')


def motor_torques(
    names: tuple[str, ...],
    torque: Mapping[str, Signal | float | Function] | Signal | float | Function,
    duration: float,
    step: float,
) -> tuple[Signal, ...]:
    """Torque of each motor by the name of its pulley; one torque is that of the first."""
    given = torque if isinstance(torque, Mapping) else ({names[0]: torque} if names else {})
    if not names and not isinstance(torque, Mapping) and torque != 0.0:
        raise InputRefused('kind = "route": there is no [[pulley]] on which a torque could act: add one')
    for name in given:
        if name not in names:
            raise InputRefused(f'torque on "{str(name)[:60]}": the motors are {", ".join(names) or "none"}')
    return tuple(checked_signal(given.get(name, 0.0), f"torque on {name}", duration, step) for name in names)
