"""From the drive to its chains: what moves along the cable, and what moves across it."""

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.chain import Chain
from cabledrive.mechanics.rest_state import RestingSection, RestState, rest_state
from cabledrive.parameters import Carriage, Drive, NotComputed

DRIVE_PULLEY = "drive pulley"
LOAD_PULLEY = "load pulley"
MOTOR = "motor"


@dataclass(frozen=True, slots=True, kw_only=True)
class Stretch:
    """A piece of a span between two neighbouring joints.

    Attributes
    ----------
    span : {"upper", "lower"}
    start, end : float
        Unstretched positions from the pulley where the span starts [m].
    """

    span: str
    start: float
    end: float


@dataclass(frozen=True, eq=False, kw_only=True)
class LabelledChain:
    """A chain whose joints and segments know what they are on the machine.

    Attributes
    ----------
    chain : Chain
    joints : tuple of str
        "drive pulley", "load pulley", "carriage 3" (its number in the file); last "motor", if it has a joint.
    stretches : tuple of Stretch
        One for each segment.
    """

    chain: Chain
    joints: tuple[str, ...]
    stretches: tuple[Stretch, ...]

    @cached_property
    def carriages(self) -> NDArray[np.intp]:
        """Which of the joints are carriages."""
        carried = [number for number, name in enumerate(self.joints) if name.startswith("carriage")]
        return np.array(carried, dtype=np.intp)


def longitudinal_chains(drive: Drive) -> tuple[LabelledChain, ...]:
    """Chains that carry the longitudinal motion of a drive.

    Pulleys enter with J / r^2, carriages with their mass; a rigidly joined motor adds to its pulley, one
    behind a flexible joint hangs on the drive pulley as spring and mass. Force balance at the joints is that
    of Eqs. (3.9), (3.16), (3.22), (3.37), with EA per unstretched metre.

    Parameters
    ----------
    drive : Drive

    Returns
    -------
    tuple of LabelledChain
        With R = EA; one chain, or two where both pulleys of a loop are held.
    """
    upper, lower = [_span(drive, span) for span in ("upper", "lower")]
    first, second = drive.drive_pulley.fixed, drive.load_pulley.fixed
    if drive.kind == "line":
        return (_longitudinal(drive, [upper], fixed=(first, second)),)
    if first and second:
        return tuple(_longitudinal(drive, [span], fixed=(True, True)) for span in (upper, lower))
    if first or second:
        return (_longitudinal(drive, [upper, lower] if first else [lower, upper], fixed=(True, True)),)
    return (_longitudinal(drive, [upper, lower], closed=True),)


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
        name = f"carriage {numbers[id(carriage)]}"
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


def _pendant(drive: Drive) -> tuple[float, float] | None:
    """The motor behind its flexible joint, as spring and mass at the rim."""
    motor = drive.motor
    if motor is None or motor.joint_stiffness is None:
        return None
    radius = drive.drive_pulley.radius
    return motor.joint_stiffness / radius**2, motor.inertia / radius**2


def _longitudinal(
    drive: Drive,
    spans: list[list[_Joint]],
    *,
    closed: bool = False,
    fixed: tuple[bool, bool] = (False, False),
) -> LabelledChain:
    joints = spans[0] + [joint for span in spans[1:] for joint in span[1:]]
    stretches = tuple(stretch for span in spans for stretch in _stretches(span))
    if closed:
        joints = joints[:-1]
    names = [joint.name for joint in joints]
    pendant = _pendant(drive) if DRIVE_PULLEY in names else None
    chain = Chain(
        rigidity=drive.cable.axial_rigidity,
        density=drive.cable.mass_per_length,
        lengths=np.array([stretch.end - stretch.start for stretch in stretches]),
        masses=np.array([joint.mass for joint in joints]),
        closed=closed,
        fixed=fixed,
        pendant=pendant,
        pendant_joint=names.index(DRIVE_PULLEY) if pendant else 0,
    )
    return LabelledChain(
        chain=chain, joints=(*names, MOTOR) if pendant else tuple(names), stretches=stretches
    )


def _transverse(rigidity: float, drive: Drive, joints: list[_Joint]) -> LabelledChain:
    stretches = _stretches(joints)
    chain = Chain(
        rigidity=rigidity,
        density=drive.cable.mass_per_length,
        lengths=np.array([stretch.end - stretch.start for stretch in stretches]),
        masses=np.array([joint.mass for joint in joints]),
        fixed=(True, True),
    )
    return LabelledChain(chain=chain, joints=tuple(joint.name for joint in joints), stretches=stretches)


def _stretches(joints: list[_Joint]) -> tuple[Stretch, ...]:
    pairs = pairwise(joints)
    return tuple(Stretch(span=a.span, start=a.position, end=b.position) for a, b in pairs)
