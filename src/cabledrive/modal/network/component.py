r"""Independent parts of a network: coordinates that no rope, mass or spring ties to the others.

Links whose ends both rest carry waves between held ends, whose frequencies are known,
:math:`\omega_n = n\pi/\tau`; so do the motions of parallel ropes against each other.
"""

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.network.assembly import Network
from cabledrive.mechanics.network.motion import Array
from cabledrive.modal.network.cutting import segments_of
from cabledrive.modal.network.elastic_links import ElasticLink, slope_columns
from cabledrive.modal.network.segments import Segments, octave

_ZERO = 1e-12
_ROWS = ("start", "end", "mass_rows", "spring_rows")


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
    elastic : tuple of ElasticLink
        Heavy strings and tensioned beams that it holds besides.
    segments : tuple of Segments
        These, cut for a range of frequencies; their joints are the last coordinates of all rows.
    known_cuts : dict
        Rows of the parts by which links are cut, kept by `cut_component`.
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
    elastic: tuple[ElasticLink, ...] = ()
    segments: tuple[Segments, ...] = ()
    known_cuts: dict[bytes, tuple[Array, Array]] = field(default_factory=dict, init=False, repr=False)

    @property
    def size(self) -> int:
        """Number of coordinates, slopes and joints of segments included."""
        return self.start.shape[1]

    @cached_property
    def moving(self) -> bool:
        """Whether a rope of it runs."""
        return bool(self.lag.any())

    @cached_property
    def longest(self) -> float:
        """Longest travel time of a link [s]; 0 without links."""
        times = [link.element.travel_time for link in self.elastic]
        return float(max([self.time.max(initial=0.0), *times]))

    def octaves(self, omega: float) -> tuple[int, ...]:
        """Which segments of its heavy strings and beams serve up to a frequency; ``omega`` [rad/s]."""
        return tuple(octave(link, omega) for link in self.elastic)

    def segmented(self, octaves: tuple[int, ...]) -> "Component":
        """The component with its heavy strings and beams cut into segments."""
        size, found = self.size, []
        kinds: dict[tuple[bool, int], list[int]] = {}
        for number, link in enumerate(self.elastic):
            kinds.setdefault((link.hangs, link.unknowns), []).append(number)
        for _, own in sorted(kinds.items()):
            links = [self.elastic[i] for i in own]
            segments, size = segments_of(links, [octaves[i] for i in own], size)
            found.append(segments)
        for segments in found:
            segments.local.resize(segments.local.shape[0], size)
        more = size - self.size
        rows: dict[str, Any] = {name: np.pad(getattr(self, name), ((0, 0), (0, more))) for name in _ROWS}
        return replace(self, **rows, geometric=np.pad(self.geometric, (0, more)), segments=tuple(found))


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


@dataclass(frozen=True, eq=False, kw_only=True)
class HeldElement:
    """A heavy string or tensioned beam between ends that rest.

    Attributes
    ----------
    component : Component
        Its joints alone.
    links : tuple of (int, int)
        Links of the network that have its modes, and how many ropes of each.
    """

    component: Component
    links: tuple[tuple[int, int], ...]


def components_of(
    network: Network, elastic: dict[int, ElasticLink]
) -> tuple[list[Component], list[HeldWaves], list[HeldElement]]:
    """Independent parts of a network, its waves between ends at rest, its elements between ends at rest.

    ``elastic``: its heavy strings, beams and hanging ropes by the number of their link.
    """
    moved = np.any(network.start, axis=1) | np.any(network.end, axis=1)
    for number, link in elastic.items():
        moved[number] = link.rows.any()
    covered = {other for link in elastic.values() for other in link.covers}
    held: list[HeldWaves] = []
    resting: dict[tuple[int, bool], list[tuple[int, int]]] = {}
    for number, own in enumerate(moved):
        count = int(network.ropes[number]) - int(own)
        if count and number in elastic:
            alike = int(network.piece[number]), elastic[number].hangs
            resting.setdefault(alike, []).append((number, count))
        elif count and number not in covered:
            held.append(HeldWaves(link=number, time=float(network.time[number]), count=count))
    coupled = [link for number, link in elastic.items() if moved[number]]
    strings = np.array([i for i in np.flatnonzero(moved) if i not in covered], dtype=np.intp)
    groups = _groups(network, strings, coupled)
    wide = {name: _wide(getattr(network, name), slope_columns(network)) for name in _ROWS}
    return (
        [_component(network, wide, columns, strings, coupled) for columns in groups],
        held,
        [held_element(elastic[links[0][0]], tuple(links)) for links in resting.values()],
    )


def _groups(network: Network, links: NDArray[np.intp], elastic: list[ElasticLink]) -> list[NDArray[np.intp]]:
    """Columns that some row couples, group by group, in order of their first column."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    n = slope_columns(network)
    either = np.abs(network.start[links]) + np.abs(network.end[links])
    rows = np.vstack(
        (either, np.abs(network.mass_rows), np.abs(network.spring_rows), np.abs(network.geometric))
    )
    rows = np.vstack((_wide(rows, n), *(np.abs(link.rows).sum(axis=0, keepdims=True) for link in elastic)))
    ties = coo_array(rows.T @ rows)
    _, label = connected_components(ties, directed=False)
    named = len(network.motion.names)
    groups = [np.flatnonzero(label == group) for group in np.unique(label)] if n else []
    # A slope that no beam has is no coordinate.
    return [group for group in groups if group[0] < named or rows[:, group].any()]


def _wide(rows: Array, columns: int) -> Array:
    """Rows with zeros for the slopes of carriages."""
    return np.pad(rows, ((0, 0), (0, columns - rows.shape[1])))


def _component(
    network: Network,
    rows: dict[str, Array],
    columns: NDArray[np.intp],
    strings: NDArray[np.intp],
    elastic: list[ElasticLink],
) -> Component:
    """The part with some columns; ``rows``: those of the network by name, slopes of carriages included."""
    wide = {name: own[:, columns] for name, own in rows.items()}
    own = np.any(wide["start"], axis=1) | np.any(wide["end"], axis=1)
    links = strings[own[strings]]
    masses = np.flatnonzero(np.any(wide["mass_rows"], axis=1))
    springs = np.flatnonzero(np.any(wide["spring_rows"], axis=1))
    more = slope_columns(network) - network.geometric.shape[0]
    component = Component(
        columns=columns,
        links=links,
        start=wide["start"][links],
        end=wide["end"][links],
        impedance=network.ropes[links] * network.impedance[links],
        time=network.time[links],
        lag=network.lag[links],
        mass=network.mass[masses],
        mass_rows=wide["mass_rows"][masses],
        spring=network.spring[springs],
        spring_rows=wide["spring_rows"][springs],
        geometric=_square(network.geometric, columns),
        rigid_body_modes=0,
        elastic=tuple(
            replace(link, rows=link.rows[:, columns]) for link in elastic if link.rows[:, columns].any()
        ),
    )
    names = (*network.motion.names, *(f"slope {number}" for number in range(more)))
    return replace(component, rigid_body_modes=_rigid(component, [names[i] for i in columns]))


def _square(matrix: Array, columns: NDArray[np.intp]) -> Array:
    """Rows and columns of a matrix, zeros where it has none."""
    own = columns < matrix.shape[0]
    out = np.zeros((columns.size, columns.size))
    out[np.ix_(own, own)] = matrix[np.ix_(columns[own], columns[own])]
    return out


def held_element(link: ElasticLink, links: tuple[tuple[int, int], ...]) -> HeldElement:
    """One rope between ends at rest; ``links``: links of the network that have its modes, ropes of each."""
    none, rows = np.zeros(0), np.zeros((0, 0))
    component = Component(
        columns=np.zeros(0, dtype=np.intp),
        links=np.zeros(0, dtype=np.intp),
        start=rows,
        end=rows,
        impedance=none,
        time=none,
        lag=none,
        mass=none,
        mass_rows=rows,
        spring=none,
        spring_rows=rows,
        geometric=rows,
        rigid_body_modes=0,
        elastic=(replace(link, ropes=1, rows=np.zeros((2 * link.unknowns, 0))),),
    )
    return HeldElement(component=component, links=links)


def _rigid(component: Component, names: list[str]) -> int:
    """Dimension of the motions that strain nothing.

    Raises `InputRefused` where the state of rest is unstable.
    """
    from cabledrive.parameters.errors import InputRefused

    stiffness, diagonal = _static_stiffness(component)
    scale = 1.0 / np.sqrt(diagonal)
    values, shapes = np.linalg.eigh(scale[:, None] * stiffness * scale)
    if values[0] < -_ZERO * len(names):
        worst = int(np.argmax(np.abs(shapes[:, 0])))
        raise InputRefused(
            f"{names[worst]}: its rest position is unstable, the forces at rest push it away (stiffness "
            f"{values[0] / scale[worst] ** 2:.4g}, must not be negative): "
            "move it off its "
            "dead point, or give it stiffness"
        )
    return int(np.sum(values < _ZERO * len(names)))


def _static_stiffness(own: Component) -> tuple[Array, Array]:
    """Stiffness at rest, and the size of the stiffnesses that meet in each coordinate, all as positive."""
    stretch, link = own.start - own.end, own.impedance / own.time
    matrix = (stretch.T * link) @ stretch + (own.spring_rows.T * own.spring) @ own.spring_rows + own.geometric
    size = link @ (own.start**2 + own.end**2) + own.spring @ own.spring_rows**2
    size = size + np.abs(np.diag(own.geometric))
    for elastic in own.elastic:
        rows, block = elastic.rows, elastic.rest_stiffness()
        matrix = matrix + rows.T @ block @ rows
        size = size + np.diag(block) @ rows**2
    return matrix, size
