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
from cabledrive.mechanics.network.rest_forces import RestingStretch
from cabledrive.mechanics.network.statics import Statics, statics_of
from cabledrive.parameters import Drive, InputRefused
from cabledrive.parameters.fields import described, meaning
from cabledrive.parameters.route import RoutedDrive
from cabledrive.parameters.route.two_pulleys import require_two_pulleys


@described
@dataclass(frozen=True, slots=True, kw_only=True)
class RestingSection:
    """Cable between two points held across, pulleys or guided carriages, with what hangs between them."""

    span: str = meaning('one of "upper", "lower"')
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
    sections: tuple[RestingSection, ...] = meaning("upper span first, in order of position")
    holding_torque: float = figure(
        "N m",
        "torque on the drive pulley that balances it, without the standing torque of a line's pretension",
        "At rest",
    )

    @property
    def stretches(self) -> tuple[RestingStretch, ...]:
        """All stretches, upper span first, in order of position."""
        return tuple(stretch for section in self.sections for stretch in section.stretches)

    @property
    def lowest_tension(self) -> float:
        """Lowest tension on the cable [N]; zero or less means that a span hangs slack at rest."""
        return min(section.lowest_tension for section in self.sections)


def rest_state(drive: Drive, *, at_torque: float = 0.0) -> RestState:
    """Tension of every stretch at rest, the drive pulley held, Eq. (M.10); the load pulley free unless fixed.

    Exact for a cable of Hooke's law: what the divided cable tends to with growing number of segments.
    Friction is left out. Each span of a loop keeps the unstretched length that the pretension of the straight
    drive gave it, but for what the load pulley lets over; a free pulley at the end of a line keeps its
    standing torque.

    Parameters
    ----------
    drive : Drive
    at_torque : float, default 0.0
        Steady torque on the drive pulley on top of what holds the weights, taken up at the load pulley [N m];
        positive relieves the upper span.

    Returns
    -------
    RestState

    Raises
    ------
    NotComputed
        If no state of rest is found.
    """
    return _kept_state(require_two_pulleys(drive, "`rest_state`"), at_torque)


def statics_under(machine: RoutedDrive, at_torque: float = 0.0) -> Statics:
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
def _kept_state(drive: Drive, at_torque: float) -> RestState:
    statics, first = statics_under(drive.machine, at_torque), drive.drive_pulley
    both = zip(drive.spans, statics.stretches, strict=True)
    torque = float(statics.torques[0]) + (not drive.closed) * first.radius * drive.cable.pretension
    return RestState(
        sections=tuple(own for span, pieces in both for own in _sections(drive, span, pieces)),
        holding_torque=torque,
    )


def _sections(drive: Drive, span: str, pieces: Sequence[RestingStretch]) -> Iterator[RestingSection]:
    """What hangs between held places of a span; across the span of a machine is upwards on the upper one."""
    down, own, start = -1.0 if span == "upper" else 1.0, list[RestingStretch](), pieces[0].start
    for piece, carriage in zip(pieces, (*drive.carriages_on(span), None), strict=True):
        end = piece.end if carriage is None else carriage.position
        (along, across), (weight, load) = piece.force, piece.load
        force, load_down = (along, down * across + 0.0), (weight, down * load + 0.0)
        own.append(replace(piece, start=start, end=end, force=force, load=load_down))
        start = end
        if carriage is None or carriage.guided:
            yield RestingSection(span=span, stretches=tuple(own), sag=_sag(own))
            own = []


def _sag(stretches: list[RestingStretch]) -> float:
    """Largest distance of a section from the line of the pulleys, among points of quadrature and joints."""
    fallen, deepest = 0.0, 0.0
    for stretch in stretches:
        if stretch.straight:
            return 0.0
        places = stretch.start + stretch.length * np.linspace(0.0, 1.0, 33)
        along, across = stretch.force_at(places)
        slope = across * (1.0 / stretch.axial_rigidity + 1.0 / np.hypot(along, across))
        width = stretch.length / 32.0
        steps = width * (slope[:-1:2] + 4.0 * slope[1::2] + slope[2::2]) / 3.0
        deep = fallen + np.concatenate(([0.0], np.cumsum(steps)))
        fallen, deepest = float(deep[-1]), max(deepest, float(np.abs(deep).max()))
    return deepest
