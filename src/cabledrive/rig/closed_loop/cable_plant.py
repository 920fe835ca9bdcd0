"""The ropes of a machine between its motors and a load as the plant of a sampled controller, compiled.

Plants at random are the machine of an axis whose lumped chain is another one.
"""

from dataclasses import dataclass, replace
from math import exp, isfinite, pi
from typing import Any, NamedTuple

import numpy as np

from cabledrive.mechanics.compiled import njit_in_place
from cabledrive.mechanics.holding import released
from cabledrive.mechanics.network.motion import ALONG
from cabledrive.modal import natural_frequencies
from cabledrive.modal.tuning import first_modes
from cabledrive.parameters import Drive, InputRefused, Machine
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.lumped_chain import LumpedChain
from cabledrive.reduction.network_axis import as_axis, held_motion, motor_turn
from cabledrive.reduction.quality import distributed, machine_like
from cabledrive.rig.closed_loop.chain_kernels import DIVERGED, WENT_SLACK, LoopState, RigNumbers, decide
from cabledrive.rig.closed_loop.loop_kernels import loop_over
from cabledrive.rig.laws.controllers import load_gear, plant_chain
from cabledrive.rig.setting import RigOptions, current_rate
from cabledrive.simulation import Recording, Scheme, Start
from cabledrive.simulation.case import RopeRun, case_of
from cabledrive.simulation.channels import width_of
from cabledrive.simulation.coordinates import dot
from cabledrive.simulation.kernels import integrate
from cabledrive.simulation.network.mesh import passed_words
from cabledrive.simulation.plan import PRETENSION, Plan, State, Workspace, new_state, new_workspace

HANGS = 0.01  # share of the pretension below which a span hangs from its ends: it sags rather than pushes


class CableNumbers(NamedTuple):
    """What the loop needs to know of the cable beside its plan."""

    turns: Array  # (shafts, n): angles of motor, drive, load by the coordinates, all at the first shaft
    steps: int  # steps of the cable per sample
    rate: float  # bandwidth of the torque loop [rad/s]; 0: none
    offset: float  # constant torque of the motor [N m]
    rest: Array  # (n,): what acts on the coordinates whatever the load is pushed by [N], [N m]
    zeros: Array  # (shafts,): angles at the start [rad]
    middle: Array  # (2,): largest v and w at the start, either way [m]


class CableRun(NamedTuple):
    """The cable while it moves: plan, nodes, which look into the state of the loop, and work space."""

    plan: Plan
    cable: State
    work: Workspace
    numbers: CableNumbers
    tensions: Array  # (samples or 0, pieces): gets the mean ones [N]
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
    x, n, cable, score, turns = s.x, c.numbers.zeros.size, c.cable, s.summary, c.numbers.turns
    for shaft in range(n):
        x[shaft] = dot(turns[shaft], cable.q) - c.numbers.zeros[shaft]
        x[n + shaft] = dot(turns[shaft], cable.q_t)
    s.discrete[0] = x[n] != 0.0
    if not isfinite(x[n - 1]) or abs(x[n - 1]) > gone:
        return DIVERGED
    u = cable.x
    score[7] = max(score[7], abs(x[n - 2] - x[n - 1]))
    for span in range(c.plan.nodes.shape[0]):
        start, end = c.plan.nodes[span, 0], c.plan.nodes[span, 1]
        middle = 0.5 * (u[0, (start + end) // 2] + u[0, (start + end + 1) // 2])
        score[11] = max(score[11], abs(middle - 0.5 * (u[0, start] + u[0, end])))
    for axis in range(1, 3):
        for i in range(u.shape[1]):
            score[12] = max(score[12], abs(u[axis, i]) - c.numbers.middle[axis - 1])
    return 0


@njit_in_place
def move_cable(c: CableRun, rig: RigNumbers, k: int, s: LoopState) -> int:
    """Move the cable to the next sample; why the run ends after it, 0 where it goes on."""
    x, n, plan, numbers, row = s.x, c.numbers.zeros.size, c.plan, c.numbers, c.row
    x[2 * n] = act(c, rig, s.controller.commands, x[2 * n], numbers.offset + rig.forces[k, 0])
    for i in range(numbers.rest.size):
        plan.rest[i] = numbers.rest[i] + rig.forces[k, 1] * numbers.turns[n - 1, i]
    given = plan, c.cable, c.work, c.torques, c.forces, numbers.steps, row, c.fields
    code = integrate(None, numbers.zeros, None, None, False, *given)
    slack = 0.0
    for span in range(plan.nodes.shape[0]):
        if c.tensions.shape[0] > 0:
            c.tensions[k, span] = row[0, span]
        if row[0, span] < HANGS * plan.piece[span, PRETENSION]:
            slack = 1.0
    if slack > 0.0:
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

    drive: Drive  # as it is controlled
    machine: Machine  # with the stiffness and damping that its ropes have
    case: RopeRun  # one record per sample
    numbers: CableNumbers
    start: Array  # displacements and velocities of the nodes and the coordinates at rest, in a row


def cable_plant(
    drive: Drive,
    chain: LumpedChain,
    interval: float,
    options: RigOptions,
    machine: Machine | None = None,
) -> CablePlant:
    """Make the ropes of an axis ready at rest; ``machine``: by default that of the drive."""
    if options.jitter > 0.0:
        raise InputRefused(
            f"jitter = {options.jitter:.4g} s is not followed with the distributed cable, whose steps divide "
            "a sample: leave it out, or take a plant of few inertias"
        )
    if drive.motor is not None and drive.motor.backlash > 0.0:
        said = f"motor.backlash = {drive.motor.backlash:.4g} rad is not followed with the distributed cable"
        raise InputRefused(f"{said}: set it to 0, or take a lumped plant")
    if machine is None and drive.chain_of:  # its numbers may have changed since the file was read
        machine = axis_like(drive, chain)
    machine = released(machine or (drive.machine if options.as_printed else distributed(drive)))
    case = case_of(
        machine,
        interval,
        start=Start(from_equilibrium=True, hold="drive"),
        scheme=Scheme(
            segments=options.segments,
            slack="stop" if options.forbid_slack else "tension-only",
            friction="smoothed" if options.smooth_friction else "stick-slip",
            smoothing_speed=1.0 / 50.0,
        ),
        recording=Recording(rate=1.0 / interval),
    )
    state, axis, network = case.first_state(), drive.axis, case.mesh.network
    rows = [motor_turn(network, axis.words["motors"])]
    if chain.size > 2:
        rows.append(motor_turn(network, axis.words["motors"], rotors=False))
    rows.append(load_gear(drive) / axis.per_angle * network.motion.dense(axis.load)[0])
    turns = np.zeros((chain.size, len(state.q)))
    turns[:, : len(rows[0])] = rows
    # One torque for all motors: each gives the same share.
    case = replace(case, plan=case.plan._replace(motor=turns[:1]))
    numbers = CableNumbers(
        turns=turns,
        steps=case.grid.every,
        rate=current_rate(drive),
        offset=chain.offsets[0],
        rest=case.plan.rest.copy(),
        zeros=turns @ state.q,
        middle=np.max(np.abs(state.x[1:, :]), axis=1),
    )
    return CablePlant(
        drive=drive,
        machine=machine,
        case=case,
        numbers=numbers,
        start=np.concatenate((state.x.ravel(), state.x_t.ravel(), state.q, state.q_t)),
    )


def cable_run(cable: CablePlant, state: LoopState, tensions: Array) -> CableRun:
    """The cable with its nodes in the state of a loop; ``tensions``, (samples or 0, pieces), gets [N]."""
    case, nodes = cable.case, cable.case.nodes
    kept, every = state.x[2 * len(cable.numbers.zeros) + 1 :], cable.case.grid.every
    x, x_t, q, q_t = np.split(kept, np.cumsum([3 * nodes, 3 * nodes, len(case.mesh.names)]))
    fresh = new_state(case.plan, np.zeros((3, nodes)), np.zeros((3, nodes)), q, q_t)
    moving = fresh._replace(x=x.reshape(3, nodes), x_t=x_t.reshape(3, nodes), q=q, q_t=q_t)
    row, fields = np.zeros((1, width_of(case.plan))), np.zeros((0, 3, nodes))
    space = row, np.zeros((every, 1)), np.zeros((every, 0)), fields
    return CableRun(case.plan, moving, new_workspace(case.plan), cable.numbers, tensions, *space)


def cable_words(cable: CablePlant, score: dict[str, float], angle: float) -> dict[str, object]:
    """Resolution and modes of the ropes, spillover, sway, nearness to 1:2; ``angle``: largest [rad]."""
    drive, case, mesh = cable.drive, cable.case, cable.case.mesh
    n, ends = len(mesh.network.motion.names), cable.numbers.turns[[0, -1]]
    motion = held_motion(mesh.network, ends[:, :n], np.zeros(n), np.ones(2))  # without strain
    turned = np.abs(angle * load_gear(drive) * np.pad(motion, (0, ends.shape[1] - n)))
    longest = int(np.argmax(mesh.length))
    rigidity = float(mesh.rigidity[longest])
    stretch = 1.0 + float(mesh.tension[longest]) / rigidity
    length, density = mesh.parts[longest][0].where.length / stretch, float(mesh.density[longest]) * stretch
    known = drive.axis.words.get("frequencies_hz")  # not the modes of another axis
    along = known[0] if known else float(natural_frequencies(cable.machine, count=1)[0])
    lowest = [mode.frequency for mode in first_modes(mesh.network)[1].values()]
    across = min(lowest, key=lambda frequency: abs(frequency / along - 0.5))
    ratio = across / along
    return {
        "segments": int(np.diff(mesh.nodes).max()),
        "step": case.grid.step,
        "steps_per_sample": case.grid.every,
        "stiffness": rigidity / length,
        "axial_damping": mesh.parts[longest][0].rope.axial_damping,
        "span_mode_hz": float(np.sqrt(rigidity / density) / (2.0 * length)),
        "spillover_deg": score["aside"] / drive.drive_pulley.radius * 180.0 / pi,
        "sway": score["swing"],
        "pulley_mode_hz": along,
        "transverse_mode_hz": across,
        "frequency_ratio": ratio,
        "one_to_two": "coupled" if abs(ratio - 0.5) < 0.05 else "far from it",
        "passed": list(passed_words(mesh, turned)),
    }


def axis_like(drive: Drive, chain: LumpedChain) -> Machine:
    """The machine of an axis whose lumped chain is the one given; of routes to first order."""
    return _routes_like(drive, chain) if drive.chain_of else machine_like(drive, chain)


_ROUND_OFF = 1e-9


def _routes_like(drive: Drive, chain: LumpedChain) -> Machine:
    """Ropes and joints are scaled; load and motors, by their share, get what there is more of the rest.

    What motors have not to give of less friction is taken from all that rubs before the load.
    """
    axis, machine = drive.axis, drive.axis.machine
    usual, gain, motors = plant_chain(as_axis(machine, axis.load), None), abs(axis.gain), len(machine.motor)
    more = {}
    for name in ("inertias", "viscous", "coulomb"):
        now, before = np.array([getattr(chain, name), getattr(usual, name)])
        more[name] = np.where(np.abs(now - before) > _ROUND_OFF * before.max(), now - before, 0.0).tolist()

    def factor(name: str, place: int) -> float:
        now, before = (getattr(own, name)[place] for own in (chain, usual))
        return float(now / before) if before > 0.0 else 1.0

    def scaled(part: Any, **by: float) -> Any:
        """A part with some of its numbers that many times what they are; those that it lacks stay away."""
        own = {name: getattr(part, name, None) for name in by}
        return replace(part, **{name: by[name] * value for name, value in own.items() if value is not None})

    def kept(name: str, key: str) -> float:
        """Factor of friction that motors cannot make less by themselves."""
        least = min(getattr(own, key) for own in machine.motor) + more[name][0] / motors
        return 1.0 if least >= 0.0 else factor(name, 0)

    friction = {name: kept(name, f"{name}_friction") for name in ("viscous", "coulomb")}
    rubs = {"viscous_friction": friction["viscous"], "damping": friction["viscous"]}
    rubs |= {"coulomb_friction": friction["coulomb"]}

    def loaded(part: Any, name: str, mass: str, viscous: str = "") -> Any:
        if name != axis.load.removesuffix(f" {ALONG}").split(".")[0]:
            return scaled(part, **rubs)
        own = {mass: getattr(part, mass) + more["inertias"][-1] / gain**2}
        if viscous:
            own |= {viscous: chain.viscous[-1] / gain**2, "coulomb_friction": chain.coulomb[-1] / gain}
        elif max(abs(more["viscous"][-1]), abs(more["coulomb"][-1])) > 0.0:
            raise InputRefused(f"{axis.load}: a carriage has no friction to vary: make it a body")
        return replace(part, **own)

    def driving(motor: Any) -> Any:
        own = {"inertia": motor.inertia + more["inertias"][0] / motors}
        for name, by in friction.items():
            now = getattr(motor, f"{name}_friction")
            own[f"{name}_friction"] = by * now + (more[name][0] / motors if by == 1.0 else 0.0)
        return replace(scaled(motor, **joint), **own)

    between = more["inertias"][1] / motors if chain.size > 2 else 0.0
    pulleys = list(machine.pulley)
    for number in machine.driven:
        pulleys[number] = replace(pulleys[number], inertia=pulleys[number].inertia + between)
    stiffer = factor("stiffness", -1)
    rope = {"given_rigidity": stiffer, "youngs_modulus": stiffer, "axial_damping": factor("damping", -1)}
    joint = {f"joint_{name}": factor(name, 0) for name in ("stiffness", "damping") if chain.size > 2}
    names = [own.name or f"carriage {number}" for number, own in enumerate(machine.carriage)]
    return replace(
        machine,
        cable=machine.cable and scaled(machine.cable, **rope),
        route=tuple(scaled(own, **rope) for own in machine.route),
        body=tuple(
            loaded(own, own.name, "inertia" if own.pivot else "mass", "damping") for own in machine.body
        ),
        pulley=tuple(loaded(own, own.name, "inertia", "viscous_friction") for own in pulleys),
        carriage=tuple(map(loaded, machine.carriage, names, ["mass"] * len(names))),
        motor=tuple(map(driving, machine.motor)),
    )
