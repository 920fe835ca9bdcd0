r"""The drive at rest: the tension of every stretch under weights, carriages, slope and a steady torque.

Between two joints the cable is an elastic catenary. With the force :math:`\mathbf F(s)` along (x) and across
(y, downwards) the line of the pulleys,

.. math:: \mathbf F' = -\rho_0\,\mathbf g, \qquad
          \mathbf r' = \frac{\mathbf F}{EA} + \frac{\mathbf F}{|\mathbf F|}.

`cabledrive.mechanics.network.rest_forces` solves it.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from cabledrive.answers.figures import figure
from cabledrive.answers.result import Result
from cabledrive.mechanics.network.motion import gravity
from cabledrive.mechanics.network.rest_forces import RestingStretch
from cabledrive.mechanics.network.statics import Statics, statics_of
from cabledrive.parameters import Drive, InputRefused, Machine
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.fields import described, meaning


@described
@dataclass(frozen=True, slots=True, kw_only=True)
class RestingSection:
    """Cable between two points held across, pulleys or guided carriages, with what hangs between them."""

    span: str = meaning('its name, "upper" or "lower" of a loop')
    stretches: tuple[RestingStretch, ...] = meaning("in order")
    sag: float = meaning("largest distance from the line of the pulleys [m]")

    @property
    def start(self) -> float:
        """Unstretched position of the first held point [m]."""
        return self.stretches[0].start

    @property
    def end(self) -> float:
        """Unstretched position of the last held point [m]."""
        return self.stretches[-1].end

    @property
    def lowest_tension(self) -> float:
        """Lowest tension on the section [N]."""
        return min(stretch.lowest_tension for stretch in self.stretches)

    @property
    def sag_ratio(self) -> float:
        """Largest distance from the line of the pulleys over the unstretched length [-]."""
        return self.sag / (self.end - self.start)


@described
@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class RestState(Result):
    """A drive at rest."""

    _table, _columns = "sections", "span start end lowest_tension sag"
    sections: tuple[RestingSection, ...] = meaning("span by span, in order of position")
    holding_torque: float = figure(
        "N m",
        "torque on the first pulley with a motor that balances it, of a line of two pulleys without the "
        "standing torque of its pretension; 0 without a pulley",
        "At rest",
    )

    @property
    def stretches(self) -> tuple[RestingStretch, ...]:
        """All stretches, span by span, in order of position."""
        return tuple(stretch for section in self.sections for stretch in section.stretches)

    @property
    def lowest_tension(self) -> float:
        """Lowest tension on the cable [N]; zero or less means that a span hangs slack at rest."""
        return min(section.lowest_tension for section in self.sections)


def rest_state(drive: Machine | Drive, *, at_torque: float = 0.0) -> RestState:
    """Tension of every stretch at rest, the drive pulley held, Eq. (M.10); the load pulley free unless fixed.

    Exact for a cable of Hooke's law: what the divided cable tends to with growing number of segments.
    Friction is left out. Each span of a loop keeps the unstretched length that the pretension of the straight
    drive gave it, but for what the load pulley lets over; a free pulley at the end of a line keeps its
    standing torque.

    Parameters
    ----------
    drive : Machine or Drive
    at_torque : float, default 0.0
        Of two pulleys: steady torque on the drive pulley on top of what holds the weights, taken up at the
        load pulley [N m]; positive relieves the upper span.

    Returns
    -------
    RestState

    Raises
    ------
    InputRefused
        If a machine with routes cannot be at rest, or a torque is asked for without two pulleys.
    NotComputed
        If no state of rest is found.
    """
    return _kept_state(drive.machine, at_torque)


def statics_under(machine: Machine, at_torque: float = 0.0) -> Statics:
    """A machine at rest; ``at_torque``: as of `rest_state`, refused of any other than two pulleys [N m]."""
    pushes = bool(machine.called)
    if not at_torque:
        return statics_of(machine, pushes=pushes)
    if not machine.called:
        raise InputRefused("at_torque needs a load pulley that takes it up: give a body the load [N] instead")
    first, last = machine.pulley
    if not last.fixed:
        return statics_of(machine, torques={1: at_torque * last.radius / first.radius}, pushes=pushes)
    # the drive pulley turns until its torque is that of rest and the given one
    torque = -float(statics_of(machine, pushes=pushes).torques[0]) - at_torque
    return statics_of(machine, held=(), torques={0: torque}, pushes=pushes)


@lru_cache(maxsize=64)
def _kept_state(machine: Machine, at_torque: float) -> RestState:
    statics = statics_under(machine, at_torque)
    torque = -machine.sense * float(sum(statics.torques[i] for i in machine.turned[:1]))
    if machine.angles:  # of two pulleys: in their sense, a line without what stands there
        rope, closed = machine.ropes[0], machine.route[0].closed
        torque += 0.0 if closed else machine.pulley[0].radius * (rope.pretension or 0.0)
    return RestState(
        sections=tuple(
            own for i in range(len(statics.stretches)) for own in _sections(machine, i, statics.stretches[i])
        ),
        holding_torque=torque,
    )


def _sections(machine: Machine, number: int, pieces: Sequence[RestingStretch]) -> Iterator[RestingSection]:
    """What hangs between held places of a span, its force across and load counted downwards."""
    span = machine.free_spans[number]
    down, rope = 1.0 if np.dot(span.across, gravity(machine)) >= 0.0 else -1.0, machine.ropes[span.route]
    riding = sorted((at, i) for i, (on, at) in enumerate(machine.carriage_places) if on == number)
    own, start = list[RestingStretch](), pieces[0].start
    for piece, rides in zip(pieces, (*riding, None), strict=True):
        tension = rope.pretension or piece.mean_tension
        end = piece.end if rides is None else rides[0] / (1.0 + tension / rope.axial_rigidity)
        (along, across), (weight, load) = piece.force, piece.load
        force, load_down = (along, down * across + 0.0), (weight, down * load + 0.0)
        own.append(replace(piece, start=start, end=end, force=force, load=load_down))
        start = end
        if rides is None or machine.carriage[rides[1]].guided:
            sag = 0.0 if any(one.straight for one in own) else float(np.abs(sag_of(own)[1]).max())
            yield RestingSection(span=span.name, stretches=tuple(own), sag=sag)
            own = []


POINTS = 65


def sag_of(stretches: Sequence[RestingStretch]) -> tuple[Array, Array]:
    """Unstretched positions on stretches in order, and what lies across the line of their ends there [m]."""
    places, depths, depth = list[Array](), list[Array](), 0.0
    for stretch in stretches:
        fine = np.linspace(stretch.start, stretch.end, 2 * POINTS - 1)
        along, across = stretch.force_at(fine)
        slope = across * (1.0 / stretch.axial_rigidity + 1.0 / np.hypot(along, across))
        step = (fine[2] - fine[0]) / 6.0  # of Simpson's rule
        parts = (slope[:-2:2] + 4.0 * slope[1::2] + slope[2::2]) * step
        places.append(fine[::2])
        depths.append(depth + np.concatenate(([0.0], np.cumsum(parts))))
        depth = float(depths[-1][-1])
    at, across = np.concatenate(places), np.concatenate(depths)
    return at, across - depth * (at - at[0]) / (at[-1] - at[0])
