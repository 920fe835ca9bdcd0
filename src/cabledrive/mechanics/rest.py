r"""The drive at rest: the tension of every stretch under weights, carriages, slope and a steady torque.

Between two joints the cable is an elastic catenary. With the force :math:`\mathbf F(s)` along (x) and across
(y, downwards) the line of the pulleys,

.. math:: \mathbf F' = -\rho_0\,\mathbf g, \qquad
          \mathbf r' = \frac{\mathbf F}{EA} + \frac{\mathbf F}{|\mathbf F|}.

`cabledrive.mechanics.rest_forces` solves it.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from cabledrive.mechanics.rest_forces import PANELS, WEIGHTS, Statics, quadrature_points
from cabledrive.parameters import Drive
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.fields import described, meaning


@described
@dataclass(frozen=True, slots=True, kw_only=True)
class RestingStretch:
    """One piece of cable between neighbouring joints, at rest."""

    span: str = meaning('one of "upper", "lower"')
    start: float = meaning("unstretched position from the pulley where the span starts [m]")
    end: float = meaning("the same of its end [m]")
    force: tuple[float, float] = meaning(
        "force at the start, along and across (downwards) the line of the pulleys [N]"
    )
    load: tuple[float, float] = meaning("weight per unstretched length, along and across [N/m]")
    axial_rigidity: float = meaning("EA [N]")

    def force_at(self, positions: Array) -> Array:
        """Force along and across, by the part ahead on the part behind.

        Parameters
        ----------
        positions : ndarray, shape (p,)
            Unstretched positions [m].

        Returns
        -------
        ndarray, shape (2, p)
            [N].
        """
        below = np.asarray(positions, dtype=float) - self.start
        return np.array(self.force)[:, None] - np.outer(self.load, below)

    def tension_at(self, positions: Array) -> Array:
        """Tension of the cable; negative where a cable without load across would have to push.

        Parameters
        ----------
        positions : ndarray, shape (p,)
            Unstretched positions [m].

        Returns
        -------
        ndarray, shape (p,)
            [N].
        """
        along, across = self.force_at(positions)
        if self.force[1] == 0.0 == self.load[1]:
            return np.asarray(along)
        return np.hypot(along, across)

    @property
    def length(self) -> float:
        """Unstretched length [m]."""
        return self.end - self.start

    @property
    def tensions(self) -> tuple[float, float]:
        """Tension at start and end [N]."""
        first, last = self.tension_at(np.array([self.start, self.end]))
        return float(first), float(last)

    @property
    def lowest_tension(self) -> float:
        """Lowest tension on the stretch [N]."""
        load = np.array(self.load)
        weight = float(load @ load)
        turn = float(load @ np.array(self.force)) / weight if weight else 0.0
        return float(self.tension_at(self.start + np.clip([0.0, turn, self.length], 0.0, self.length)).min())

    @property
    def mean_tension(self) -> float:
        """Mean tension over the unstretched length [N]."""
        return float(self.tension_at(self._points()).reshape(PANELS, -1).mean(axis=0) @ WEIGHTS) / 2.0

    @property
    def gradient(self) -> float:
        """Mean rise of the tension per unstretched metre [N/m]."""
        first, last = self.tensions
        return (last - first) / self.length

    @property
    def travel_time(self) -> float:
        """Time that a transverse wave takes from end to end [s]; infinite where the stretch is slack."""
        tension = self.tension_at(self._points())
        if tension.min() <= 0.0:
            return float("inf")
        slowness = np.sqrt(1.0 / tension + 1.0 / self.axial_rigidity)
        return self.length * float(slowness.reshape(PANELS, -1).mean(axis=0) @ WEIGHTS) / 2.0

    def _points(self) -> Array:
        return self.start + self.length * quadrature_points()


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
@dataclass(frozen=True, slots=True, kw_only=True)
class RestState:
    """A drive at rest."""

    sections: tuple[RestingSection, ...] = meaning("upper span first, in order of position")
    holding_torque: float = meaning(
        "torque on the drive pulley that balances it [N m]; without the standing torque of a line's "
        "pretension"
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

    Exact for a cable of Hooke's law: what `cabledrive.mechanics.statics.equilibrium` with the exact law tends
    to with growing number of segments. Friction is left out. Each span of a loop keeps the unstretched
    length that the pretension of the straight drive gave it, but for what the load pulley lets over; a free
    pulley at the end of a line keeps its standing torque.

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
    return _kept_state(drive, at_torque)


@lru_cache(maxsize=64)
def _kept_state(drive: Drive, at_torque: float) -> RestState:
    statics = Statics(drive, at_torque)
    return _state(drive, statics, statics.solve())


def _state(drive: Drive, statics: Statics, start: Array) -> RestState:
    """Name what was found."""
    parts: dict[int, list[RestingStretch]] = {}
    for piece, force in zip(statics.pieces, start.tolist(), strict=True):
        stretch = RestingStretch(
            span=drive.spans[piece.span],
            start=piece.start,
            end=piece.end,
            force=(force[0], force[1]),
            load=(float(piece.load[0]), float(piece.load[1])),
            axial_rigidity=drive.cable.axial_rigidity,
        )
        parts.setdefault(piece.section, []).append(stretch)
    sections = tuple(
        RestingSection(span=part[0].span, stretches=tuple(part), sag=_sag(part)) for part in parts.values()
    )
    first = start[[piece.start == 0.0 for piece in statics.pieces], 0]
    behind = first[1] - statics.fall[1] if first.size > 1 else drive.cable.pretension
    torque = -float(first[0] - behind) * drive.drive_pulley.radius
    return RestState(sections=sections, holding_torque=torque)


def _sag(stretches: list[RestingStretch]) -> float:
    """Largest distance of a section from the line of the pulleys, among points of quadrature and joints."""
    fallen, deepest = 0.0, 0.0
    for stretch in stretches:
        if stretch.force[1] == 0.0 == stretch.load[1]:
            return 0.0
        places = stretch.start + stretch.length * np.linspace(0.0, 1.0, 33)
        along, across = stretch.force_at(places)
        slope = across * (1.0 / stretch.axial_rigidity + 1.0 / np.hypot(along, across))
        width = stretch.length / 32.0
        steps = width * (slope[:-1:2] + 4.0 * slope[1::2] + slope[2::2]) / 3.0
        deep = fallen + np.concatenate(([0.0], np.cumsum(steps)))
        fallen, deepest = float(deep[-1]), max(deepest, float(np.abs(deep).max()))
    return deepest


def irvine_parameter(stiffness: float, tension: float, mean_squared_shear: float) -> float:
    r"""Irvine's parameter: how much the sag stiffens the string, for any distribution of weight.

    .. math:: \lambda^2 = \frac{12\,K\,\overline{V^2}}{T^3}

    With q alone, :math:`\overline{V^2} = (q l)^2/12`, this is the usual :math:`(q l/T)^2\,K/T`. A string
    is straight while it is far below 1; at :math:`4\pi^2` the first symmetric mode in the plane of sag has
    risen to the frequency of the first antisymmetric one.

    ``stiffness``: force per strain K of the string [N]; ``tension``: along it, T [N];
    ``mean_squared_shear``: mean of the squared transverse force V [N^2].

    References
    ----------
    .. [1] H. M. Irvine, *Cable Structures*, MIT Press, 1981, chapters 2 and 3.
    """
    return 12.0 * stiffness * mean_squared_shear / tension**3
