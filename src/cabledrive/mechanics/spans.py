"""From the drive to its chains: what moves along the cable, and what moves across it."""

from dataclasses import replace
from itertools import pairwise
from math import sqrt
from typing import NamedTuple

import numpy as np

from cabledrive.mechanics.chain import HOLDING_SPRING, Chain, LabelledChain, Pendant, Stretch
from cabledrive.mechanics.holding import DRIVE_PULLEY, LOAD_PULLEY, MOTOR, PULLEYS, span_stiffness
from cabledrive.mechanics.rest import RestState
from cabledrive.parameters import Drive, NotComputed


def longitudinal_chains(drive: Drive) -> tuple[LabelledChain, ...]:
    """Chains that carry the longitudinal motion of a drive: one, or two where fixed pulleys part the cable.

    Pulleys enter with J / r^2, carriages with their mass; a rigidly joined motor adds to its pulley, one
    behind a flexible joint hangs on the drive pulley as spring and mass. Force balance at the joints is that
    of Eqs. (3.9), (3.16), (3.22), (3.37), with EA per unstretched metre. A holding stiffness is a spring from
    the rotor to the ground.
    """
    held = frozenset(name for name, pulley in zip(PULLEYS, drive.pulley, strict=True) if pulley.fixed)
    pieces = [pair for span in drive.spans for pair in pairwise(_span(drive, span))]
    starts = [number for number, (joint, _) in enumerate(pieces) if joint.name in held]
    if not drive.closed:
        bounds = sorted({0, *starts, len(pieces)})
        runs = [pieces[first:last] for first, last in pairwise(bounds)]
    elif starts:
        around = pieces[starts[0] :] + pieces[: starts[0]]
        bounds = [start - starts[0] for start in starts] + [len(pieces)]
        runs = [around[first:last] for first, last in pairwise(bounds)]
    else:
        return (_longitudinal(drive, pieces, closed=True),)
    with_drive = next(
        (number for number, run in enumerate(runs) if DRIVE_PULLEY in {j.name for pair in run for j in pair}),
        0,
    )
    return tuple(
        _longitudinal(drive, run, held=held, driven=number == with_drive) for number, run in enumerate(runs)
    )


def rigid_mass(drive: Drive) -> float:
    """Mass at the rim of everything that moves when a drive without held parts turns [kg]."""
    (labelled,) = longitudinal_chains(drive)
    chain = labelled.chain
    return float(chain.masses.sum() + sum(own.mass for own in chain.pendants) + chain.cable_mass)


def lumped_cable_mode(drive: Drive) -> float | None:
    r"""Lowest frequency of pulleys and carriages on a cable without mass, the motor joint taken as rigid.

    The lowest eigenvalue above the rigid motion of the masses on springs k L / l between neighbours; k of a
    span is that of ``[lumped]`` where given, else EA/L; the rotor's holding stiffness is one to the ground.
    On a bare drive it is too high, to first order in the mass :math:`m_c` of the cable by

    .. math:: \frac{m_c}{6\mu}\Big(1 - \frac{3\mu}{m_1 + m_2}\Big), \qquad
              \mu = \frac{m_1 m_2}{m_1 + m_2}, \quad m_i = J_i/r_i^2 . \qquad \text{Eq. (M.7)}

    Returns angular frequency [rad/s]; None if nothing can move.
    """
    from scipy.linalg import eigvals_banded

    if drive.motor is not None:
        drive = replace(drive, motor=replace(drive.motor, joint_stiffness=None))
    found = []
    for chain in (own.chain for own in longitudinal_chains(drive)):
        size, k = chain.masses.size, span_stiffness(drive) * drive.span_length / chain.lengths
        a, b = np.arange(k.size), (np.arange(k.size) + 1) % size
        stiffness = chain.ground_springs + np.bincount(a, k, size) + np.bincount(b, k, size)
        free = np.arange(int(chain.fixed[0]), size - int(chain.fixed[1]))
        if free.size <= (rigid := chain.rigid_body_modes):
            continue
        # a ring from both ends: no link spans more than two places of the band
        place = np.full(size, -1)
        place[free] = np.minimum(2 * (free - free[0]), 2 * (free[-1] - free) + 1)
        linked, root = (place[a] >= 0) & (place[b] >= 0), np.sqrt(chain.masses)
        ends = np.sort([place[a[linked]], place[b[linked]]], axis=0)
        band = np.zeros((3, free.size))
        band[0, place[free]] = stiffness[free] / root[free] ** 2
        np.add.at(band, (ends[1] - ends[0], ends[0]), -(k / (root[a] * root[b]))[linked])
        square = eigvals_banded(band, lower=True, select="i", select_range=(rigid, rigid))[0]
        found.append(sqrt(max(float(square), 0.0)))
    return min(found, default=None)


def transverse_chains(drive: Drive, *, rest: RestState | None = None) -> tuple[LabelledChain, ...]:
    r"""Strings that carry the transverse motion in both planes: each span, cut at guided carriages.

    Each piece between two joints obeys Eq. (3.27), with :math:`R = T_0/(1+\varepsilon_0)`, upper span first.
    A section under its own tension T(s) at ``rest`` becomes the uniform string on which a wave takes as long
    from end to end, :math:`\sqrt{\rho_0/R}\,l = \int\sqrt{\rho_0(1/T + 1/EA)}\,ds`.
    Raises `NotComputed` if a section hangs slack at rest.
    """
    chains: list[LabelledChain] = []
    for span in drive.spans:
        joints = _span(drive, span)
        for a, b in pairwise(i for i, joint in enumerate(joints) if joint.held_across):
            rigidity = drive.cable.pretension / (1.0 + drive.cable.prestrain)
            if rest is not None:
                section = rest.sections[len(chains)]
                if section.lowest_tension <= 0.0:
                    raise NotComputed(
                        f"the {section.span} span hangs slack at rest between {section.start:.4g} m and "
                        f"{section.end:.4g} m (lowest tension {section.lowest_tension:.4g} N): raise "
                        "cable.pretension"
                    )
                time = sum(stretch.travel_time for stretch in section.stretches)
                rigidity = ((joints[b].position - joints[a].position) / time) ** 2
            own = joints[a : b + 1]
            chains.append(_chain(drive, rigidity, own, list(pairwise(own))))
    return tuple(chains)


class _Joint(NamedTuple):
    name: str
    span: str
    position: float
    mass: float
    held_across: bool


def _span(drive: Drive, span: str) -> list[_Joint]:
    """Joints of one span in order, both pulleys included, the drive pulley with a rigidly joined motor."""
    motor, first = drive.motor, drive.drive_pulley
    rigid = motor is not None and motor.joint_stiffness is None
    added = motor.inertia / first.radius**2 if motor is not None and rigid else 0.0
    ends = [(DRIVE_PULLEY, first.rim_mass + added), (LOAD_PULLEY, drive.load_pulley.rim_mass)]
    (start, near), (end, far) = ends if span == "upper" else ends[::-1]
    numbers = {id(carriage): number for number, carriage in enumerate(drive.carriage)}
    carried = [
        _Joint(f"carriage {numbers[id(own)]}", span, own.position, own.mass, own.guided)
        for own in drive.carriages_on(span)
    ]
    return [_Joint(start, span, 0.0, near, True), *carried, _Joint(end, span, drive.span_length, far, True)]


def _longitudinal(
    drive: Drive,
    pieces: list[tuple[_Joint, _Joint]],
    *,
    closed: bool = False,
    held: frozenset[str] = frozenset(),
    driven: bool = True,
) -> LabelledChain:
    """Chain of neighbouring pieces of cable, with the motor if it is on this one (``driven``)."""
    joints = [first for first, _ in pieces] + ([] if closed else [pieces[-1][1]])
    names = tuple(joint.name for joint in joints)
    fixed = (False, False) if closed else (names[0] in held, names[-1] in held)
    labelled = _chain(drive, drive.cable.axial_rigidity, joints, pieces, closed=closed, fixed=fixed)
    motor, square = drive.motor, drive.drive_pulley.radius**2
    if not driven or DRIVE_PULLEY not in names or motor is None:
        return labelled
    place, joint = names.index(DRIVE_PULLEY), motor.joint_stiffness
    holding = (motor.holding_stiffness or 0.0) / square
    ground = HOLDING_SPRING if holding else ""
    if joint is not None:
        mass = motor.inertia / square
        pendant = Pendant(stiffness=joint / square, mass=mass, joint=place, ground=holding)
        chain = replace(labelled.chain, pendants=(pendant,))
        return replace(labelled, chain=chain, joints=(*names, MOTOR), ground=ground)
    if holding:
        grounds = np.zeros(len(joints))
        grounds[place] = holding
        labelled = replace(labelled, chain=replace(labelled.chain, grounds=grounds))
    return replace(labelled, ground=ground)


def _chain(
    drive: Drive,
    rigidity: float,
    joints: list[_Joint],
    pieces: list[tuple[_Joint, _Joint]],
    *,
    closed: bool = False,
    fixed: tuple[bool, bool] = (True, True),
) -> LabelledChain:
    stretches = tuple(Stretch(span=a.span, start=a.position, end=b.position) for a, b in pieces)
    chain = Chain(
        rigidity=rigidity,
        density=drive.cable.mass_per_length,
        lengths=np.array([stretch.end - stretch.start for stretch in stretches]),
        masses=np.array([joint.mass for joint in joints]),
        closed=closed,
        fixed=fixed,
    )
    return LabelledChain(chain=chain, joints=tuple(joint.name for joint in joints), stretches=stretches)
