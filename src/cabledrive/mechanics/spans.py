"""From the drive to its chains: what moves along the cable, and what moves across it."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from cabledrive.mechanics.chain import HOLDING_SPRING, MOTOR_JOINT, Chain, LabelledChain, Pendant, Stretch
from cabledrive.mechanics.holding import (
    DRIVE_PULLEY,
    HELD,
    HOLDING,
    LOAD_PULLEY,
    MOTOR,
    PULLEYS,
    carriage_joint,
    held_joints,
    joint_stiffness,
    motor_condition,
)
from cabledrive.mechanics.rest import RestingSection, RestState, rest_state
from cabledrive.parameters import Carriage, Drive, NotComputed


def longitudinal_chains(
    drive: Drive, *, motor: str | None = None, hold: Sequence[str] = ()
) -> tuple[LabelledChain, ...]:
    """Chains that carry the longitudinal motion of a drive.

    Pulleys enter with J / r^2, carriages with their mass; a rigidly joined motor adds to its pulley, one
    behind a flexible joint hangs on the drive pulley as spring and mass. Force balance at the joints is that
    of Eqs. (3.9), (3.16), (3.22), (3.37), with EA per unstretched metre. A holding stiffness is a spring from
    the rotor to the ground; the joint of a held rotor is one from the drive pulley to the ground.

    Parameters
    ----------
    drive : Drive
    motor : {"free", "held", "holding"}, optional
        How the rotor is held, see `motor_condition`.
    hold : sequence of str, optional
        Pulleys and carriages that are held as well, see `held_joints`.

    Returns
    -------
    tuple of LabelledChain
        With R = EA; one chain, or several where held joints part the cable.

    Raises
    ------
    InputRefused
        If `motor` or a name in `hold` does not fit the drive.
    """
    condition, held = motor_condition(drive, motor), held_joints(drive, hold)
    held |= {name for name, pulley in zip(PULLEYS, drive.pulley, strict=True) if pulley.fixed}
    if condition == HELD and joint_stiffness(drive) is None:
        held |= {DRIVE_PULLEY}
    pieces = [pair for span in drive.spans for pair in pairwise(_span(drive, span))]
    starts = [number for number, (joint, _) in enumerate(pieces) if joint.name in held]
    if drive.kind == "line":
        bounds = sorted({0, *starts, len(pieces)})
        runs = [pieces[first:last] for first, last in pairwise(bounds)]
    elif starts:
        around = pieces[starts[0] :] + pieces[: starts[0]]
        bounds = [start - starts[0] for start in starts] + [len(pieces)]
        runs = [around[first:last] for first, last in pairwise(bounds)]
    else:
        return (_longitudinal(drive, pieces, condition, closed=True),)
    with_drive = next(
        (number for number, run in enumerate(runs) if DRIVE_PULLEY in {j.name for pair in run for j in pair}),
        0,
    )
    return tuple(
        _longitudinal(drive, run, condition, held=held, driven=number == with_drive)
        for number, run in enumerate(runs)
    )


def transverse_chains(drive: Drive, *, rest: RestState | None = None) -> tuple[LabelledChain, ...]:
    r"""Strings that carry the transverse motion: each span, cut where a guided carriage holds it.

    Each piece between two joints obeys Eq. (3.27). A section at rest under its own tension T(s) becomes the
    uniform string on which a wave takes as long from end to end,
    :math:`\sqrt{\rho_0/R}\,l = \int\sqrt{\rho_0(1/T + 1/EA)}\,ds`.

    Parameters
    ----------
    drive : Drive
    rest : RestState, optional
        Where the tension of each section is taken from; the pretension of the straight drive if not given.

    Returns
    -------
    tuple of LabelledChain
        Upper span first, in order of position, with R = T0 / (1 + eps0) or that of the tension at rest; each
        stands for both planes.

    Raises
    ------
    NotComputed
        If a section hangs slack at rest.
    """
    chains: list[LabelledChain] = []
    for span in drive.spans:
        joints = _span(drive, span)
        held = [0, *(i for i, joint in enumerate(joints) if joint.held_across), len(joints) - 1]
        for a, b in pairwise(held):
            rigidity = drive.cable.pretension / (1.0 + drive.cable.prestrain)
            if rest is not None:
                rigidity = _uniform_rigidity(drive, rest.sections[len(chains)])
            chains.append(_transverse(rigidity, drive, joints[a : b + 1]))
    return tuple(chains)


def strings_at_rest(drive: Drive, *, at_torque: float = 0.0) -> tuple[LabelledChain, ...]:
    """Strings under the tension that weights, carriages, slope and a steady torque leave each section.

    Parameters
    ----------
    drive : Drive
    at_torque : float, default 0.0
        Steady torque on the drive pulley, as in `rest_state` [N m].

    Returns
    -------
    tuple of LabelledChain
        As `transverse_chains`.

    Raises
    ------
    NotComputed
        If no state of rest is found, or a section hangs slack there.
    """
    return transverse_chains(drive, rest=rest_state(drive, at_torque=at_torque))


def _uniform_rigidity(drive: Drive, section: RestingSection) -> float:
    if section.lowest_tension <= 0.0:
        raise NotComputed(
            f"the {section.span} span hangs slack at rest between {section.start:.4g} m and "
            f"{section.end:.4g} m (lowest tension {section.lowest_tension:.4g} N): raise cable.pretension"
        )
    time = sum(stretch.travel_time for stretch in section.stretches)
    if all(stretch.load == (0.0, 0.0) for stretch in section.stretches) and len(section.stretches) == 1:
        tension = section.stretches[0].force[
            0
        ]  # to the last digit what the formula of the straight drive gives
        return tension / (1.0 + tension / drive.cable.axial_rigidity)
    return ((section.end - section.start) / time) ** 2


@dataclass(frozen=True, slots=True, kw_only=True)
class _Joint:
    name: str
    span: str
    position: float
    mass: float
    held_across: bool = False


def _span(drive: Drive, span: str) -> list[_Joint]:
    """Joints of one span in order, both pulleys included."""
    numbers = {id(carriage): number for number, carriage in enumerate(drive.carriage)}

    def carried(carriage: Carriage) -> _Joint:
        name = carriage_joint(numbers[id(carriage)])
        return _Joint(
            name=name, span=span, position=carriage.position, mass=carriage.mass, held_across=carriage.guided
        )

    ends = [(DRIVE_PULLEY, _drive_mass(drive)), (LOAD_PULLEY, drive.load_pulley.rim_mass)]
    if span == "lower":
        ends.reverse()
    start, end = (
        _Joint(name=name, span=span, position=position, mass=mass)
        for (name, mass), position in zip(ends, (0.0, drive.span_length), strict=True)
    )
    return [start, *map(carried, drive.carriages_on(span)), end]


def _drive_mass(drive: Drive) -> float:
    """Inertia at the drive pulley's rim, with a rigidly joined motor."""
    motor = drive.motor
    rigid = motor is not None and motor.joint_stiffness is None
    added = motor.inertia / drive.drive_pulley.radius**2 if motor is not None and rigid else 0.0
    return drive.drive_pulley.rim_mass + added


def _longitudinal(
    drive: Drive,
    pieces: list[tuple[_Joint, _Joint]],
    condition: str,
    *,
    closed: bool = False,
    held: frozenset[str] = frozenset(),
    driven: bool = True,
) -> LabelledChain:
    """Chain of neighbouring pieces of cable, with what holds the rotor if it is on this one (`driven`)."""
    joints = [first for first, _ in pieces] + ([] if closed else [pieces[-1][1]])
    stretches = tuple(Stretch(span=a.span, start=a.position, end=b.position) for a, b in pieces)
    names = [joint.name for joint in joints]
    chain = Chain(
        rigidity=drive.cable.axial_rigidity,
        density=drive.cable.mass_per_length,
        lengths=np.array([stretch.end - stretch.start for stretch in stretches]),
        masses=np.array([joint.mass for joint in joints]),
        closed=closed,
        fixed=(False, False) if closed else (names[0] in held, names[-1] in held),
    )
    if driven and DRIVE_PULLEY in names:
        return _with_motor(drive, chain, tuple(names), stretches, condition)
    return LabelledChain(chain=chain, joints=tuple(names), stretches=stretches)


def _with_motor(
    drive: Drive, chain: Chain, names: tuple[str, ...], stretches: tuple[Stretch, ...], condition: str
) -> LabelledChain:
    """The motor behind its joint as spring and mass at the rim; what holds it as springs to the ground."""
    joint, holding, square = joint_stiffness(drive), 0.0, drive.drive_pulley.radius**2
    place, ground = names.index(DRIVE_PULLEY), ""
    if condition == HOLDING:
        assert drive.motor is not None
        assert drive.motor.holding_stiffness is not None
        holding, ground = drive.motor.holding_stiffness / square, HOLDING_SPRING
    if joint is not None and condition != HELD:
        assert drive.motor is not None
        chain = replace(
            chain,
            pendants=(
                Pendant(
                    stiffness=joint / square,
                    mass=drive.motor.inertia / square,
                    joint=place,
                    ground=holding,
                ),
            ),
        )
        return LabelledChain(chain=chain, joints=(*names, MOTOR), stretches=stretches, ground=ground)
    if joint is not None:
        holding, ground = joint / square, MOTOR_JOINT
    if holding:
        grounds = np.zeros(chain.masses.size)
        grounds[place] = holding
        chain = replace(chain, grounds=grounds)
    return LabelledChain(chain=chain, joints=names, stretches=stretches, ground=ground)


def _transverse(rigidity: float, drive: Drive, joints: list[_Joint]) -> LabelledChain:
    pairs = pairwise(joints)
    stretches = tuple(Stretch(span=a.span, start=a.position, end=b.position) for a, b in pairs)
    chain = Chain(
        rigidity=rigidity,
        density=drive.cable.mass_per_length,
        lengths=np.array([stretch.end - stretch.start for stretch in stretches]),
        masses=np.array([joint.mass for joint in joints]),
        fixed=(True, True),
    )
    return LabelledChain(chain=chain, joints=tuple(joint.name for joint in joints), stretches=stretches)
