"""The distributed cable loop with its motor joint as the plant of a sampled controller, compiled."""

from dataclasses import dataclass, replace
from math import exp, isfinite, pi
from typing import NamedTuple

import numpy as np

from cabledrive.mechanics.compiled import njit_in_place
from cabledrive.mechanics.holding import released
from cabledrive.modal import modes, natural_frequencies
from cabledrive.parameters import Drive, InputRefused, Lumped
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.route.two_pulleys import NAMES, SENSE, require_two_pulleys
from cabledrive.reduction.lumped_chain import LumpedChain
from cabledrive.reduction.quality import distributed
from cabledrive.rig.closed_loop.chain_kernels import (
    DIVERGED,
    WENT_SLACK,
    LoopState,
    RigNumbers,
    decide,
)
from cabledrive.rig.closed_loop.loop_kernels import loop_over
from cabledrive.rig.setting import RigOptions, current_rate
from cabledrive.simulation import Recording, Scheme, Start
from cabledrive.simulation.case import case_of
from cabledrive.simulation.channels import width_of
from cabledrive.simulation.kernels import integrate
from cabledrive.simulation.network.mesh import passed_words
from cabledrive.simulation.plan import PRETENSION, Plan, State, Workspace, new_state, new_workspace
from cabledrive.simulation.prepared import RopeRun

HANGS = 0.01  # share of the pretension below which a span hangs from its ends: it sags rather than pushes


class CableNumbers(NamedTuple):
    """What the loop needs to know of the cable beside its plan."""

    shafts: int  # Motor, drive, load; the last two where the joint is rigid
    turns: Array  # (shafts,): angle, of the load times its radius over the drive's, per coordinate
    steps: int  # steps of the cable per sample
    rate: float  # bandwidth of the torque loop [rad/s]; 0: none
    offset: float  # constant torque of the motor [N m]
    weight: float  # of the cable at the load's rim, on its coordinate [N m]
    zeros: Array  # (shafts,): angles at the start [rad]
    middle: Array  # (2,): largest v and w at the start, either way [m]


class CableRun(NamedTuple):
    """The cable while it moves: plan, nodes, which look into the state of the loop, and work space."""

    plan: Plan
    cable: State
    work: Workspace
    numbers: CableNumbers
    tensions: Array  # (samples or 0, 2): gets the mean ones of the spans [N]
    # row, torques, forces, fields: (1, columns), (steps, 1), (steps, 0), (0, 3, nodes): of the integration
    row: Array
    torques: Array
    forces: Array
    fields: Array


@njit_in_place
def act(c: CableRun, rig: RigNumbers, commands: Array, shaft: float, push: float) -> float:
    """Write the torque on the motor at each step of a sample; returns that of the torque loop at its end.

    The older command acts until the delay has passed; a step spreads its torque half a step to both sides.
    """
    numbers, torques, older, newer = c.numbers, c.torques, commands[0], commands[1]
    step = rig.interval / numbers.steps
    keep = exp(-numbers.rate * step)
    for j in range(numbers.steps):
        if numbers.rate > 0.0:
            torques[j, 0] = shaft
            share = min(max(rig.late_part / step - j, 0.0), 1.0)
            shaft = keep * shaft + (1.0 - keep) * (share * older + (1.0 - share) * newer)
        else:
            share = min(max(rig.late_part / step - j + 0.5, 0.0), 1.0)
            torques[j, 0] = share * older + (1.0 - share) * newer
            shaft = newer
        torques[j, 0] += push
    return shaft


@njit_in_place
def cable_ends(c: CableRun, gone: float, s: LoopState) -> int:
    """Look at the cable at a sample; why the run ends here, 0 where it goes on.

    Angles of the shafts go into the state, and their speeds half a step of the cable before; largest twist,
    how far the middle of a span is from the mean of its ends, and sway into the score.
    """
    x, n, cable, score, far = s.x, c.numbers.shafts, c.cable, s.summary, c.plan.nodes[0, 1]
    for shaft in range(n):
        rim = 2 if shaft < n - 2 else shaft - n + 2
        x[shaft] = cable.q[rim] * c.numbers.turns[shaft] - c.numbers.zeros[shaft]
        x[n + shaft] = cable.q_t[rim] * c.numbers.turns[shaft]
    s.discrete[0] = x[n] != 0.0
    if not isfinite(x[n - 1]) or abs(x[n - 1]) > gone:
        return DIVERGED
    u = cable.x
    score[7] = max(score[7], abs(x[n - 2] - x[n - 1]))
    for span in range(c.plan.nodes.shape[0]):
        start = span * far
        middle = 0.5 * (u[0, start + far // 2] + u[0, start + (far + 1) // 2])
        score[11] = max(score[11], abs(middle - 0.5 * (u[0, start] + u[0, start + far])))
    for axis in range(1, 3):
        for i in range(u.shape[1]):
            score[12] = max(score[12], abs(u[axis, i]) - c.numbers.middle[axis - 1])
    return 0


@njit_in_place
def move_cable(c: CableRun, rig: RigNumbers, k: int, s: LoopState) -> int:
    """Move the cable to the next sample; why the run ends after it, 0 where it goes on."""
    x, n, plan, numbers, row = s.x, c.numbers.shafts, c.plan, c.numbers, c.row
    x[2 * n] = act(c, rig, s.controller.commands, x[2 * n], numbers.offset + rig.forces[k, 0])
    plan.rest[1] = numbers.weight + rig.forces[k, 1] * numbers.turns[n - 1]
    given = plan, c.cable, c.work, c.torques, c.forces, numbers.steps, row, c.fields
    code = integrate(None, numbers.zeros, None, None, False, *given)
    plan.rest[1] = numbers.weight
    if c.tensions.shape[0] > 0:
        for span in range(plan.nodes.shape[0]):
            c.tensions[k, span] = row[0, span]
    least = HANGS * plan.piece[0, PRETENSION]
    if row[0, 0] < least or row[0, plan.nodes.shape[0] - 1] < least:
        s.summary[9] += 1.0
        if plan.stop_when_slack:
            code = 1
    if code == 0:
        return 0
    return WENT_SLACK if code == 1 else DIVERGED


run_cable = njit_in_place(loop_over(cable_ends, decide, move_cable))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CablePlant:
    """The cable as it will be integrated, from sample to sample."""

    drive: Drive  # with the stiffness and damping that the distributed cable has
    case: RopeRun  # one record per sample
    numbers: CableNumbers
    start: Array  # displacements and velocities of the nodes and the coordinates at rest, in a row


def cable_plant(
    drive: Drive, chain: LumpedChain, interval: float, options: RigOptions, *, measured: bool = True
) -> CablePlant:
    """Make the cable of a drive ready at rest; ``measured``: its EA and damping are those of ``[lumped]``."""
    require_two_pulleys(drive, "the distributed cable as plant")
    if options.jitter > 0.0:
        raise InputRefused(
            f"jitter = {options.jitter:.4g} s is not followed with the distributed cable, whose steps divide "
            "a sample: leave it out, or take a plant of few inertias"
        )
    if drive.motor is not None and drive.motor.backlash > 0.0:
        said = f"motor.backlash = {drive.motor.backlash:.4g} rad is not followed with the distributed cable"
        raise InputRefused(f"{said}: set it to 0, or take --plant model-4")
    free = released(drive)
    own = distributed(free) if measured and not options.as_printed else free
    case = case_of(
        own,
        interval,
        start=Start(from_equilibrium=True),
        scheme=Scheme(
            segments=options.segments,
            slack="stop" if options.forbid_slack else "tension-only",
            friction="smoothed" if options.smooth_friction else "stick-slip",
            smoothing_speed=1.0 / 50.0,
        ),
        recording=Recording(rate=1.0 / interval),
    )
    state = case.first_state()
    radii = [pulley.radius / own.drive_pulley.radius for pulley in own.pulley]
    turns = SENSE * np.array([1.0] * (chain.size - 2) + radii)
    numbers = CableNumbers(
        shafts=chain.size,
        turns=turns,
        steps=case.grid.every,
        rate=current_rate(drive),
        offset=float(case.holding[0]),
        weight=float(case.plan.rest[1]),
        zeros=turns * np.append(state.q[2:], state.q[:2]),
        middle=np.max(np.abs(state.x[1:, :]), axis=1),
    )
    return CablePlant(
        drive=own,
        case=case,
        numbers=numbers,
        start=np.concatenate((state.x.ravel(), state.x_t.ravel(), state.q, state.q_t)),
    )


def cable_run(cable: CablePlant, state: LoopState, tensions: Array) -> CableRun:
    """The cable with its nodes in the state of a loop; ``tensions``, shape (samples or 0, 2), gets [N]."""
    case, nodes = cable.case, cable.case.nodes
    kept, every = state.x[2 * cable.numbers.shafts + 1 :], cable.case.grid.every
    x, x_t, q, q_t = np.split(kept, np.cumsum([3 * nodes, 3 * nodes, len(case.mesh.names)]))
    fresh = new_state(case.plan, np.zeros((3, nodes)), np.zeros((3, nodes)), q, q_t)
    moving = fresh._replace(x=x.reshape(3, nodes), x_t=x_t.reshape(3, nodes), q=q, q_t=q_t)
    row, fields = np.zeros((1, width_of(case.plan))), np.zeros((0, 3, nodes))
    space = row, np.zeros((every, 1)), np.zeros((every, 0)), fields
    return CableRun(case.plan, moving, new_workspace(case.plan), cable.numbers, tensions, *space)


def drive_like(drive: Drive, chain: LumpedChain) -> Drive:
    """A drive whose lumped chain is the one given, its cable's stiffness and damping those of its EA."""
    first, second = drive.pulley
    gear, spans = second.radius / first.radius, len(drive.spans)
    load = replace(
        second,
        inertia=chain.inertias[-1] * gear**2,
        viscous_friction=chain.viscous[-1] * gear**2,
        coulomb_friction=chain.coulomb[-1] * gear,
    )
    motor = drive.motor
    if motor is not None:
        rigid = motor.joint_stiffness is None
        own = replace(
            motor,
            inertia=chain.inertias[0] - (first.inertia if rigid else 0.0),
            viscous_friction=chain.viscous[0] - (first.viscous_friction if rigid else 0.0),
            coulomb_friction=chain.coulomb[0] - (first.coulomb_friction if rigid else 0.0),
            offset_torque=chain.offsets[0],
        )
        if not rigid:
            own = replace(own, joint_stiffness=chain.stiffness[0], joint_damping=chain.damping[0])
            first = replace(first, inertia=chain.inertias[1])
        motor = own
    else:
        first = replace(first, inertia=chain.inertias[0])
    lumped = Lumped(
        cable_stiffness=chain.stiffness[-1] / (spans * first.radius**2),
        cable_damping=chain.damping[-1] / (spans * first.radius),
    )
    return distributed(replace(drive, pulley=(first, load), motor=motor, lumped=lumped))


def cable_words(cable: CablePlant, score: dict[str, float], angle: float) -> dict[str, object]:
    """Resolution, stiffness, damping and modes of the cable, spillover, sway, nearness to 1:2 resonance.

    ``angle``: largest of the load pulley [rad].
    """
    drive, case = cable.drive, cable.case
    turns = dict(zip(NAMES, (drive.load_pulley.radius / drive.drive_pulley.radius, 1.0), strict=True))
    passed = passed_words(
        case.mesh, abs(angle) * np.array([turns.get(name, 0.0) for name in case.mesh.names])
    )
    radius, length = drive.drive_pulley.radius, drive.span_length
    pulley = float(natural_frequencies(drive, count=1)[0])
    across = min(m.frequency for m in modes(drive, count=1).modes if m.kind == "transverse")
    ratio = across / pulley
    return {
        "segments": len(case.mesh.positions[0]) - 1,
        "step": case.grid.step,
        "steps_per_sample": case.grid.every,
        "stiffness": drive.cable.axial_rigidity / length,
        "axial_damping": drive.cable.axial_damping,
        "span_mode_hz": float(
            np.sqrt(drive.cable.axial_rigidity / drive.cable.mass_per_length) / (2.0 * length)
        ),
        "spillover_deg": score["aside"] / radius * 180.0 / pi,
        "sway": score["swing"],
        "pulley_mode_hz": pulley,
        "transverse_mode_hz": across,
        "frequency_ratio": ratio,
        "one_to_two": "coupled" if abs(ratio - 0.5) < 0.05 else "far from it",
        "passed": list(passed),
    }
