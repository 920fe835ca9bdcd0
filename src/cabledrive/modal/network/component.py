r"""Independent parts of a network: coordinates that no rope, mass or spring ties to the others.

Links whose ends both rest carry waves between held ends, whose frequencies are known,
:math:`\omega_n = n\pi/\tau`; so do the motions of parallel ropes against each other.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.network.assembly import Network
from cabledrive.mechanics.network.motion import Array

_ZERO = 1e-12


@dataclass(frozen=True, eq=False, kw_only=True)
class Component:
    """Coordinates tied together, with the links, masses and springs that tie them.

    Attributes
    ----------
    columns : ndarray of int, shape (n,)
        Coordinates of the network that it holds.
    links : ndarray of int, shape (m,)
        Links of the network that it holds.
    start, end : ndarray, shape (m, n)
        Rows of both ends of each link.
    impedance : ndarray, shape (m,)
        Of all parallel ropes [kg/s].
    time, lag : ndarray, shape (m,)
        Travel time and lag [s].
    mass, mass_rows, spring, spring_rows, geometric : ndarray
        As in `cabledrive.mechanics.network.Network`.
    rigid_body_modes : int
        Motions that strain nothing.
    """

    columns: NDArray[np.intp]
    links: NDArray[np.intp]
    start: Array
    end: Array
    impedance: Array
    time: Array
    lag: Array
    mass: Array
    mass_rows: Array
    spring: Array
    spring_rows: Array
    geometric: Array
    rigid_body_modes: int

    @cached_property
    def moving(self) -> bool:
        """Whether a rope of it runs."""
        return bool(self.lag.any())

    @cached_property
    def longest(self) -> float:
        """Longest travel time of a link [s]; 0 without links."""
        return float(self.time.max(initial=0.0))


@dataclass(frozen=True, slots=True, kw_only=True)
class HeldWaves:
    """Waves of one link between ends that rest: harmonics of one frequency.

    Attributes
    ----------
    link : int
        Number of the link in the network.
    time : float
        Travel time [s].
    count : int
        Ropes that have them: all, or all but one where the ends move.
    """

    link: int
    time: float
    count: int

    def below(self, omega: float) -> int:
        """How many modes lie below a frequency; ``omega`` [rad/s]."""
        return self.count * int(np.floor(omega * self.time / np.pi))


def components_of(network: Network) -> tuple[list[Component], list[HeldWaves]]:
    """Independent parts of a network, and the waves between ends at rest."""
    moved = np.any(network.start, axis=1) | np.any(network.end, axis=1)
    held = []
    for link, own in enumerate(moved):
        count = int(network.ropes[link]) - int(own)
        if count:
            held.append(HeldWaves(link=link, time=float(network.time[link]), count=count))
    groups = _groups(network, np.flatnonzero(moved))
    return [_component(network, columns) for columns in groups], held


def _groups(network: Network, links: NDArray[np.intp]) -> list[NDArray[np.intp]]:
    """Columns that some row couples, group by group, in order of their first column."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    n = len(network.motion.names)
    either = np.abs(network.start[links]) + np.abs(network.end[links])
    rows = np.vstack(
        (either, np.abs(network.mass_rows), np.abs(network.spring_rows), np.abs(network.geometric))
    )
    ties = coo_array(rows.T @ rows)
    _, label = connected_components(ties, directed=False)
    return [np.flatnonzero(label == group) for group in np.unique(label)] if n else []


def _component(network: Network, columns: NDArray[np.intp]) -> Component:
    start, end = network.start[:, columns], network.end[:, columns]
    links = np.flatnonzero(np.any(start, axis=1) | np.any(end, axis=1))
    masses = np.flatnonzero(np.any(network.mass_rows[:, columns], axis=1))
    springs = np.flatnonzero(np.any(network.spring_rows[:, columns], axis=1))
    square = np.ix_(columns, columns)
    return Component(
        columns=columns,
        links=links,
        start=start[links],
        end=end[links],
        impedance=network.ropes[links] * network.impedance[links],
        time=network.time[links],
        lag=network.lag[links],
        mass=network.mass[masses],
        mass_rows=network.mass_rows[np.ix_(masses, columns)],
        spring=network.spring[springs],
        spring_rows=network.spring_rows[np.ix_(springs, columns)],
        geometric=network.geometric[square],
        rigid_body_modes=_rigid(network, columns),
    )


def _rigid(network: Network, columns: NDArray[np.intp]) -> int:
    """Dimension of the motions that strain nothing.

    Raises `InputRefused` where the state of rest is unstable.
    """
    from cabledrive.parameters.errors import InputRefused

    square = np.ix_(columns, columns)
    stiffness = network.static_stiffness[square]
    scale = 1.0 / np.sqrt(_stiff_diagonal(network, columns))
    values, shapes = np.linalg.eigh(scale[:, None] * stiffness * scale)
    if values[0] < -_ZERO * columns.size:
        worst = network.motion.names[int(columns[np.argmax(np.abs(shapes[:, 0]))])]
        raise InputRefused(
            f"{worst}: its rest position is unstable, the forces at rest push it away (stiffness "
            f"{values[0] / scale[np.argmax(np.abs(shapes[:, 0]))] ** 2:.4g}, must not be negative): "
            "move it off its "
            "dead point, or give it stiffness"
        )
    return int(np.sum(values < _ZERO * columns.size))


def _stiff_diagonal(network: Network, columns: NDArray[np.intp]) -> Array:
    """Size of the stiffnesses that meet in each coordinate, all counted as positive."""
    link = network.ropes * network.impedance / network.time
    parts = link @ (network.start[:, columns] ** 2 + network.end[:, columns] ** 2)
    parts = parts + network.spring @ network.spring_rows[:, columns] ** 2
    return np.asarray(parts + np.abs(np.diag(network.geometric))[columns])
