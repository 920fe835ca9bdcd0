"""The distributed cable loop with its motor joint as the plant of a sampled controller."""

from dataclasses import dataclass, replace
from math import pi

import numpy as np

from cabledrive.mechanics.holding import released
from cabledrive.modal import modes, natural_frequencies
from cabledrive.parameters import Drive, InputRefused, Lumped
from cabledrive.parameters.route.two_pulleys import require_own_spans
from cabledrive.reduction.lumped_chain import LumpedChain
from cabledrive.reduction.quality import with_measured_stiffness
from cabledrive.rig.closed_loop.cable_kernels import CableNumbers, CableRun
from cabledrive.rig.closed_loop.loop_numbers import Array, LoopState
from cabledrive.rig.disturbances import current_rate
from cabledrive.rig.setting import RigOptions
from cabledrive.simulation import Recording, Scheme, Start
from cabledrive.simulation.case import Case, case_of
from cabledrive.simulation.plan import State, new_state, new_workspace


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CablePlant:
    """The cable as it will be integrated, from sample to sample."""

    drive: Drive  # with the stiffness and damping that the distributed cable has
    case: Case  # one record per sample
    numbers: CableNumbers
    start: Array  # displacements and velocities of the nodes and the motor at rest, one after the other


def cable_plant(
    drive: Drive, chain: LumpedChain, interval: float, options: RigOptions, *, measured: bool = True
) -> CablePlant:
    """Make the cable of a drive ready at rest; ``measured``: its EA and damping are those of ``[lumped]``."""
    require_own_spans(drive, "the distributed cable as plant")
    if options.jitter > 0.0:
        raise InputRefused(
            f"jitter = {options.jitter:.4g} s is not followed with the distributed cable, whose steps divide "
            "a sample: leave it out, or take a plant of few inertias"
        )
    if drive.motor is not None and drive.motor.backlash > 0.0:
        raise InputRefused(
            f"motor.backlash = {drive.motor.backlash:.4g} rad is not followed with the distributed cable: "
            "set it to 0, or take --plant model-4"
        )
    free = released(drive)
    own = with_measured_stiffness(free) if measured and not options.as_printed else free
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
    return CablePlant(
        drive=own,
        case=case,
        numbers=_numbers(case, chain, current_rate(drive), state),
        start=np.concatenate((state.x.ravel(), state.x_t.ravel(), state.motor)),
    )


def _numbers(case: Case, chain: LumpedChain, rate: float, state: State) -> CableNumbers:
    radius = case.drive.drive_pulley.radius
    rims = case.mesh.rims
    first = [state.motor[0]] if case.mesh.joint is not None else []
    return CableNumbers(
        shafts=chain.size,
        radius=radius,
        steps=case.grid.every,
        rate=rate,
        offset=case.offset,
        weight=float(case.plan.node[7, rims[1]]),
        zeros=np.array([*first, *state.x[0, list(rims)]]) / radius,
        middle=np.max(np.abs(state.x[1:, :]), axis=1),
    )


def cable_run(cable: CablePlant, state: LoopState, tensions: Array) -> CableRun:
    """The cable with its nodes in the state of a loop; ``tensions``, shape (samples or 0, 2), gets [N]."""
    case, nodes = cable.case, cable.case.mesh.nodes
    kept, every = state.x[2 * cable.numbers.shafts + 1 :], cable.case.grid.every
    fresh = new_state(np.zeros((3, nodes)), np.zeros((3, nodes)), (0.0, 0.0))
    moving = fresh._replace(
        x=kept[: 3 * nodes].reshape(3, nodes),
        x_t=kept[3 * nodes : 6 * nodes].reshape(3, nodes),
        motor=kept[6 * nodes :],
    )
    space = (np.zeros((1, case.width)), np.zeros(every), np.zeros((every, 0)), np.zeros((0, 3, nodes)))
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
    return with_measured_stiffness(replace(drive, pulley=(first, load), motor=motor, lumped=lumped))


def cable_words(cable: CablePlant, score: dict[str, float]) -> dict[str, object]:
    """Resolution, stiffness, damping and modes of the cable, spillover, sway, nearness to 1:2 resonance."""
    drive, case = cable.drive, cable.case
    radius, length = drive.drive_pulley.radius, drive.span_length
    pulley = float(natural_frequencies(drive, count=1)[0])
    across = min(m.frequency for m in modes(drive, count=1).modes if m.kind == "transverse")
    ratio = across / pulley
    return {
        "segments": case.mesh.segments,
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
    }
