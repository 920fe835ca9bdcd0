"""The exact loop as referee of the alarm: how far a standing floor really grows along a motion."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cabledrive.parameters import Drive, InputRefused
from cabledrive.reduction.autoparametric import autoparametric_model
from cabledrive.reduction.transverse_sections import TransverseMode
from cabledrive.simulation import Recording, Scheme
from cabledrive.simulation.case import Case, case_of
from cabledrive.simulation.channels import probe_columns
from cabledrive.simulation.method import DONE
from cabledrive.simulation.state import State, copy_state
from cabledrive.simulation.workspace import new_workspace
from cabledrive.studies.planned_motion import PlannedMotion

Array = NDArray[np.float64]

W = 2
"""Row of the vertical displacement."""

RECORDS_PER_PERIOD = 16
PHASES = (0.25 * np.pi, 0.75 * np.pi)


def without_weight_and_friction(drive: Drive) -> Drive:
    """The drive without gravity, Coulomb friction and offset torque, which the alarm leaves out as well.

    Parameters
    ----------
    drive : Drive

    Returns
    -------
    Drive
    """
    return replace(
        drive,
        layout=replace(drive.layout, gravity=0.0),
        pulley=tuple(replace(pulley, coulomb_friction=0.0) for pulley in drive.pulley),
        motor=drive.motor and replace(drive.motor, coulomb_friction=0.0, offset_torque=0.0),
    )


def exact_largest(
    drive: Drive,
    motion: PlannedMotion,
    number: int,
    starts: Sequence[float],
    floor: float,
    *,
    segments: int = 60,
) -> tuple[Array, bool]:
    """Largest amplitude of every section when the floor stands at an instant, by the exact loop.

    The loop first moves along the motion with its spans exactly straight; at each start the floor is put on
    it, in one section after the other, a third of it in the others, in two phases.

    Parameters
    ----------
    drive : Drive
        Of `without_weight_and_friction`; its carriages are guided.
    motion : PlannedMotion
        Its pretension and carriages stand still: the loop is cut for one pretension.
    number : int
        Number of the transverse mode of every section.
    starts : sequence of float
        [s].
    floor : float
        [m].
    segments : int, default 60
        Per span.

    Returns
    -------
    largest : ndarray, shape (sections,)
        [m].
    slack : bool
        Whether a run ended because a span lost its tension.

    Raises
    ------
    InputRefused
        If the motion changes the pretension or moves a carriage.
    """
    held = (motion.pretension, motion.carriage, motion.load_torque)
    if any(values is not None for values in held):
        raise InputRefused("motion: pretension, carriage and load_torque must stand still on the exact loop")
    model = autoparametric_model(drive, number=number)
    stretch = 1.0 + drive.cable.prestrain
    frequency = float(model.transverse.max()) / (2 * np.pi)
    case = case_of(
        drive,
        float(motion.time[-1]),
        torque=lambda t: np.interp(t, motion.time, motion.torque),
        scheme=Scheme(segments=segments),
        recording=Recording(
            rate=RECORDS_PER_PERIOD * frequency,
            probes=tuple((mode.span, _antinode(mode, stretch)) for mode in model.modes),
        ),
    )
    shapes = [_shape(case, mode, stretch) for mode in model.modes]
    largest, slack = np.zeros(len(shapes)), False
    for start, state in _states_at(case, starts):
        for first in range(len(shapes)):
            for phase in PHASES:
                share = [floor if k == first else floor / 3.0 for k in range(len(shapes))]
                place = np.cos(phase) * np.sum([f * s for f, s in zip(share, shapes, strict=True)], axis=0)
                speed = [f * w * s for f, w, s in zip(share, model.transverse, shapes, strict=True)]
                fresh = copy_state(state)
                fresh.x[W] += place
                fresh.x_t[W] += np.sin(phase) * np.sum(speed, axis=0)
                seen, ended = _march(case, fresh, start, case.grid.records * case.grid.every)
                largest[first] = max(largest[first], float(seen[:, first].max(initial=0.0)))
                slack = slack or ended
    return largest, slack


def _antinode(mode: TransverseMode, stretch: float) -> float:
    first, last = (stretch * end for end in mode.section)
    return first + (last - first) / (2 * mode.number)


def _shape(case: Case, mode: TransverseMode, stretch: float) -> Array:
    """Sine of one section on all nodes."""
    first, last = (stretch * end for end in mode.section)
    nodes = case.mesh.span_nodes(mode.span)
    x = case.mesh.position[case.mesh.spans.index(mode.span)]
    wave = np.sin(mode.number * np.pi * (x - first) / (last - first))
    total = np.zeros(case.mesh.nodes)
    total[nodes] = np.where((x > first + 1e-9) & (x < last - 1e-9), wave, 0.0)
    return total


def _states_at(case: Case, starts: Sequence[float]) -> list[tuple[int, State]]:
    """The loop with straight spans at some instants, each at a record."""
    interval, every = case.grid.interval, case.grid.every
    state, done, found = case.first_state(), 0, []
    for start in sorted(starts):
        step = min(int(start / interval), case.grid.records - 1) * every
        _, ended = _march(case, state, done, step)
        if ended:
            break
        done = step
        found.append((step, copy_state(state)))
    return found


def _march(case: Case, state: State, first: int, last: int) -> tuple[Array, bool]:
    """Steps from one to another in place; sizes of w at the probes, and whether a span went slack."""
    steps = last - first
    rows = np.zeros((-(-steps // case.grid.every), case.width))
    if steps == 0:
        return rows[:, :0], False
    torque, forces = case.inputs(first, steps)
    work, none = new_workspace(case.plan), np.zeros((0, 3, case.mesh.nodes))
    code = case.method.march(case.plan, state, work, torque, forces, case.grid.every, rows, none)
    midpoints, probes = len(case.mesh.spans), case.plan.probe.shape[0]
    columns = [probe_columns(k).start + W for k in range(midpoints, probes)]
    return np.abs(rows[:, columns]), code != DONE
