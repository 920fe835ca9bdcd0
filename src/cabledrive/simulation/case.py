"""Everything that is decided before the first step of a run, and how that of a loop or a line is read."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from hashlib import sha256
from typing import Any

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.cable_laws import cable_law
from cabledrive.mechanics.mesh import SHAFTS, mesh_of, turns_of
from cabledrive.mechanics.network.motion import ACROSS, ALONG, OUT_OF_PLANE, gravity
from cabledrive.mechanics.rest import rest_state
from cabledrive.parameters.cable import Cable
from cabledrive.parameters.drive import SENSE, Drive
from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.route.drive import Machine
from cabledrive.parameters.route.two_pulleys import NAMES, as_machine, two_pulleys
from cabledrive.simulation import plan as at
from cabledrive.simulation.channels import (
    AXIAL,
    CHANNELS,
    COLUMN,
    TALLIES,
    WEIGHT_ENERGY,
    WIDTH,
    displacements,
)
from cabledrive.simulation.error_estimate import estimated_errors
from cabledrive.simulation.methods import check_method, largest_stable_step, time_grid
from cabledrive.simulation.network.case import (
    NetworkCase,
    check_routes,
    motor_torques,
    reached,
    routed_channels,
)
from cabledrive.simulation.network.mesh import network_plan, passed_words, rest_of
from cabledrive.simulation.own_law import law_fingerprint
from cabledrive.simulation.plan import new_state
from cabledrive.simulation.prepared import Outcome, RopeRun
from cabledrive.simulation.result import SimulationResult, neglected
from cabledrive.simulation.signals import CarriageForce, Function, Signal, checked_forces
from cabledrive.simulation.start import PLANES, Recording, Scheme, Start, at_start


@dataclass(frozen=True, kw_only=True, eq=False)
class LoopCase(RopeRun):
    """A run of a loop or a line that has not begun."""

    machine: Drive

    def columns(self, found: Array) -> Array:
        """The columns of a loop or a line, from what the kernels record; the half cells at rims are cable."""
        plan, mesh, spans, n = self.plan, self.mesh, len(self.mesh.pieces), len(self.mesh.names)
        middle, turns = 5 * spans + 3 * len(plan.probe), turns_of(mesh)
        edges = np.cumsum([3, TALLIES, 1, n, n])
        energies, tallies, balance, q, q_t, torque = np.split(found[:, middle:], edges, axis=1)
        rows, place = np.zeros((len(found), self.width)), COLUMN["drive_angle"]
        rows[:, place : place + 6] = np.hstack([(q - self.rest.turned) @ turns.T, q_t @ turns.T])
        rows[:, COLUMN["torque"]] = torque[:, 0]
        names = ("mean_tension", "least_tension", "axial_energy", "transverse_energy", "strain_energy")
        for k, name in enumerate(names):
            rows[:, COLUMN[f"{name}_upper"] + np.arange(spans)] = found[:, k * spans : (k + 1) * spans]
        for span in range(spans):
            for axis in range(3):
                moves = 0.5 * (q_t @ mesh.ends[span, :, axis].T) ** 2 @ mesh.half[span]
                rows[:, AXIAL + span + 2 * (axis > 0)] += moves
        bodies = np.pad(mesh.network.masses.matrix, (0, len(mesh.wraps)))
        shafts, inertias = COLUMN["drive_energy"], np.diag(turns @ bodies @ turns.T)
        apart = (1.0, 1.0, 1.0 * (SHAFTS[2] in mesh.names))  # a rotor on a rigid joint is the pulley's
        rows[:, shafts : shafts + 3] = 0.5 * inertias * apart * (q_t @ turns.T) ** 2
        weight = q @ plan.rest
        rows[:, COLUMN["joint_energy"]] = energies[:, 2] + weight
        rows[:, WEIGHT_ENERGY] = energies[:, 0] - weight - self.straight_energy
        rows[:, WEIGHT_ENERGY + 1 : WIDTH] = np.hstack([tallies, balance])
        rows[:, WIDTH:] = found[:, 5 * spans : middle]
        return rows

    def result(self, outcome: Outcome) -> SimulationResult:
        """Result of the run, as far as it went."""
        rows, mesh, scheme, state = outcome.rows, self.mesh, self.scheme, outcome.state
        outcome = outcome._replace(fields=outcome.fields - self.rest.counted)
        columns = {"load_angle": COLUMN["load_angle"], "upper_midpoint": WIDTH + 2}
        reach, handled = reached(state), 0.0
        turned = np.sort((reach - self.rest.turned) @ turns_of(mesh).T, axis=0)
        if len(rows):  # what it started with above the energy at rest, and the work done on it
            start = (
                float(np.sum(rows[0, AXIAL : WEIGHT_ENERGY + 1])) + self.straight_energy - self.rest.energy
            )
            work = rows[:, COLUMN["torque_work"]] + rows[:, COLUMN["force_work"]]
            handled = max(start, 0.0) + float(np.max(work, initial=0.0))
        return SimulationResult(
            **self.common(outcome),
            extremes=dict(
                zip(("drive_angle", "load_angle", "motor_angle"), map(tuple, turned.T.tolist()), strict=True)
            ),
            error_estimate=estimated_errors(self, outcome, columns),
            energy_handled=handled,
            assumptions=(
                *neglected([self.machine.cable], self.machine.motors),
                *(
                    f"{name}: {low:.3g} to {high:.3g} m"
                    for name, (low, high) in zip(mesh.names, reach.T, strict=True)
                    if name.startswith("slip") and low < high
                ),
            ),
            doubts=tuple(passed_words(mesh, np.abs(reach).max(axis=0))),
            provenance=self.provenance(
                {
                    "smoothing_speed": scheme.smoothing_speed if scheme.friction == "smoothed" else None,
                    "segments": len(mesh.positions[0]) - 1,
                },
                duration=self.grid.steps * self.grid.step,
                torque=self.torques[0].fingerprint,
                torque_offset=float(self.holding[0]),
            ),
        )

    @cached_property
    def straight_energy(self) -> float:
        """Energy of the weight of the straight cable, and of what turns pulleys, above that at rest [J]."""
        lifted = np.sum(self.plan.node[at.WEIGHT_U : at.WEIGHT_W + 1] * self.rest.counted[::2])
        return -float(lifted + self.plan.rest @ self.rest.turned)


def released_torque(drive: Drive) -> float:
    """Torque that holds a loop or a line at rest and is not given to a run [N m]: no spring has it."""
    sprung = any(motor.holding_stiffness for motor in drive.motors)
    return 0.0 if sprung or drive.drive_pulley.fixed else rest_state(drive).holding_torque


def case_of(
    drive: Machine,
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
    loop, machine = two_pulleys(drive), as_machine(drive)
    mesh = mesh_of(drive, scheme.segments)
    if loop is None:
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
    pushes = checked_forces(drive, forces, duration, grid.step)
    rest, holding, nodes = rest_of(mesh, laws, gravity(machine)), 0.0, list[tuple[int, int]]()
    if loop is not None:
        holding = released_torque(loop)
        given = rest.given - holding * SENSE * np.array([name == NAMES[0] for name in mesh.names])
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
    common: dict[str, Any] = {
        "machine": loop or machine,
        "scheme": scheme,
        "recording": recording,
        "grid": grid,
        "laws": laws,
        "mesh": mesh,
        "rest": rest,
        "settings": settings,
        "start": new_state(plan, x, x_t, q, q_t),
    }
    points = [f"the middle of {span}" for span in mesh.pieces]
    points += [f"{place:g} m of {span}" for span, place in recording.probes]
    if loop is not None:
        channels = (*CHANNELS, *displacements(points))
        offset = np.array([sum(motor.offset_torque for motor in loop.motors)])
        common |= {"torques": torques, "forces": pushes, "holding": offset, "channels": channels}
        return LoopCase(plan=plan, **common)
    ways = dict(zip(PLANES, (ALONG, OUT_OF_PLANE, ACROSS), strict=True))
    pushed = [f"{mesh.network.motion.carriage_name(own.carriage)} {ways[own.plane]}" for own in forces]
    units = np.eye(len(mesh.names))[[mesh.names.index(name) for name in pushed]]
    return NetworkCase(
        plan=plan._replace(motor=np.vstack([plan.motor, units])),
        torques=(*torques, *pushes),
        forces=(),
        holding=np.zeros(len(torques) + len(pushes)),
        channels=routed_channels(mesh.names, mesh.driven, mesh.pieces, pushed, points),
        **common,
    )
