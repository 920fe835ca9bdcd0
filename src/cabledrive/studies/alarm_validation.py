"""How far the cable of the full nonlinear model moves along a planned motion, from equilibrium and from a floor."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cabledrive.parameters import Drive, InputRefused
from cabledrive.simulation import Recording, Scheme, Start
from cabledrive.simulation.case import Case, case_of
from cabledrive.simulation.channels import probe_columns
from cabledrive.simulation.method import DONE
from cabledrive.simulation.state import State, copy_state
from cabledrive.simulation.workspace import new_workspace
from cabledrive.studies.planned_motion import PlannedMotion

Array = NDArray[np.float64]

V, W = 1, 2
POINTS = 9
"""Watched points of each stretch; none is a node of all modes that matter."""

RECORDS_PER_PERIOD = 14


@dataclass(frozen=True, slots=True, kw_only=True)
class TrueMotion:
    """Largest displacements of the full model along a motion.

    Attributes
    ----------
    driven : float
        From equilibrium, by the motion alone [m].
    grown : float
        From equilibrium with the floor put on it, what the floor's other modes add taken off [m].
    slack : bool
        Whether a run ended because a span lost its tension.
    """

    driven: float
    grown: float
    slack: bool

    @property
    def largest(self) -> float:
        """The larger of both [m]."""
        return max(self.driven, self.grown)


def true_motion(
    drive: Drive,
    motion: PlannedMotion,
    *,
    floor: float,
    modes: int,
    highest: float,
    rng: np.random.Generator,
    starts: Sequence[float] = (0.0, 0.4),
    segments: int = 100,
) -> TrueMotion:
    """Largest transverse displacement of the full nonlinear model along a motion.

    The run starts at equilibrium with the drive pulley held. At some instants every stretch gets the floor in
    each of its lowest sines and both planes, with random phases, and again a quarter of a turn later.

    Parameters
    ----------
    drive : Drive
    motion : PlannedMotion
        Its pretension, carriages and load torque stand still.
    floor : float
        [m].
    modes : int
        Number of sines of each stretch that get the floor.
    highest : float
        Highest frequency of interest, for the records and the floor's speeds [Hz].
    rng : Generator
        Of the phases.
    starts : sequence of float, default (0.0, 0.4)
        Instants as shares of the motion.
    segments : int, default 100
        Per span.

    Returns
    -------
    TrueMotion

    Raises
    ------
    InputRefused
        If the motion changes pretension, carriages or load torque: the model is cut for one.
    """
    if motion.changes:
        raise InputRefused("motion: pretension, carriage and load_torque must stand still on the full model")
    stretches = _stretches(drive)
    probes = tuple(
        (span, start + (end - start) * place)
        for span, start, end in stretches
        for place in (np.arange(POINTS) + 0.87) / (POINTS + 0.8)
    )
    case = case_of(
        drive,
        float(motion.time[-1]),
        torque=lambda t: np.interp(t, motion.time, motion.torque),
        start=Start(from_equilibrium=True, hold="drive"),
        scheme=Scheme(segments=segments),
        recording=Recording(rate=RECORDS_PER_PERIOD * highest, probes=probes),
    )
    rest = case.first_state().x.copy()
    end = case.grid.records
    states, driven, slack = _through(case, rest, sorted(int(share * end) for share in starts))
    grown = 0.0
    for record, state in states:
        for turn in (0.0, 0.5 * np.pi):
            placed, speed, size = _floor(case, stretches, floor, modes, highest, np.random.default_rng(int(rng.integers(2**32))), turn)
            fresh = copy_state(state)
            fresh.x[V:] += placed
            fresh.x_t[V:] += speed
            largest, ended = _advance(case, fresh, record, end, rest)
            grown = max(grown, largest - size + floor)
            slack = slack or ended
    return TrueMotion(driven=driven, grown=grown, slack=slack)


def _stretches(drive: Drive) -> list[tuple[str, float, float]]:
    """Span and pretensioned ends of every part between neighbouring supports."""
    stretch, found = 1.0 + drive.cable.prestrain, []
    for span in drive.spans:
        held = [c.position * stretch for c in drive.carriages_on(span) if c.guided]
        ends = [0.0, *held, drive.pulley_distance]
        found += [(span, a, b) for a, b in zip(ends[:-1], ends[1:], strict=True)]
    return found


def _floor(
    case: Case,
    stretches: list[tuple[str, float, float]],
    floor: float,
    modes: int,
    highest: float,
    rng: np.random.Generator,
    turn: float,
) -> tuple[Array, Array, float]:
    """Displacement and speed of the floor, planes v and w, and its largest possible size at a point."""
    mesh = case.mesh
    place, speed = np.zeros((2, mesh.nodes)), np.zeros((2, mesh.nodes))
    law_speed = np.sqrt(case.law.pretension / mesh.density)
    for span, start, end in stretches:
        nodes = np.arange(mesh.nodes)[mesh.span_nodes(span)]
        x = mesh.position[mesh.spans.index(span)]
        inside = (x > start + 1e-9) & (x < end - 1e-9) & mesh.sways[nodes]
        for m in range(1, modes + 1):
            kappa = m * np.pi / (end - start)
            shape = np.sin(kappa * (x[inside] - start))
            for plane in range(2):
                phase = rng.uniform(0, 2 * np.pi) + turn
                place[plane, nodes[inside]] += floor * np.cos(phase) * shape
                speed[plane, nodes[inside]] -= floor * np.sin(phase) * kappa * law_speed * shape
    return place, speed, modes * floor


def _through(case: Case, rest: Array, records: list[int]) -> tuple[list[tuple[int, State]], float, bool]:
    """The motion without a floor: states at some records, its largest displacement, whether it went slack."""
    state, done, largest, found = case.first_state(), 0, 0.0, []
    for record in records:
        size, ended = _advance(case, state, done, record, rest)
        largest = max(largest, size)
        if ended:
            return found, largest, True
        done = record
        found.append((record, copy_state(state)))
    size, ended = _advance(case, state, done, case.grid.records, rest)
    return found, max(largest, size), ended


def _advance(case: Case, state: State, first: int, last: int, rest: Array) -> tuple[float, bool]:
    """Move the state in place from record to record; largest displacement at the probes, whether it went slack."""
    if last <= first:
        return 0.0, False
    every = case.grid.every
    rows = np.zeros((last - first, case.width))
    torque, forces = case.inputs(first * every, (last - first) * every)
    work, none = new_workspace(case.plan), np.zeros((0, 3, case.mesh.nodes))
    code = case.method.march(case.plan, state, work, torque, forces, every, rows, none)
    midpoints, probes = len(case.mesh.spans), case.plan.probe.shape[0]
    largest = 0.0
    for k in range(midpoints, probes):
        node, share = int(case.plan.probe[k, 0]), case.plan.probe[k, 1]
        for axis in (V, W):
            level = (1.0 - share) * rest[axis, node] + share * rest[axis, node + 1]
            column = rows[:, probe_columns(k).start + axis]
            moved = np.abs(column[column != 0.0] - level) if axis == W else np.abs(column)
            largest = max(largest, float(moved.max(initial=0.0)))
    return largest, code != DONE
